#include "roomwise/fusion/octomap_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <sstream>
#include <tuple>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/fusion/surface_mesh.h"
#include "roomwise/fusion/testing/test_scenes.h"

namespace roomwise::fusion {
namespace {

using roomwise::testing::ScratchFolder;
using Cells = std::map<std::tuple<int, int, int>, bool>;  // occupied

// A reader of the format, written from its description and not from the writer.
class BtReader {
 public:
  explicit BtReader(const std::string& file) {
    std::istringstream lines(file);
    std::string line;
    std::getline(lines, line);
    EXPECT_EQ(line, "# Octomap OcTree binary file");
    while (std::getline(lines, line) && line != "data") {
      if (line.starts_with("#")) continue;
      const std::size_t space = line.find(' ');
      fields[line.substr(0, space)] = line.substr(space + 1);
    }
    data_ = file.substr(static_cast<std::size_t>(lines.tellg()));
    if (!data_.empty()) read_node(-32768, -32768, -32768, 65536);
    EXPECT_EQ(place_, data_.size());
  }
  std::map<std::string, std::string> fields;
  Cells cells;
  std::size_t nodes = 0;

 private:
  void read_node(int x, int y, int z, int side) {
    ++nodes;
    ASSERT_LE(place_ + 2, data_.size());
    const unsigned low = static_cast<unsigned char>(data_[place_]);
    const unsigned high = static_cast<unsigned char>(data_[place_ + 1]);
    place_ += 2;
    for (int child = 0; child < 8; ++child) {
      const unsigned code = (child < 4 ? low >> 2 * child : high >> 2 * (child - 4)) & 3U;
      const int half = side / 2;
      const int cx = x + (child & 1 ? half : 0), cy = y + (child & 2 ? half : 0),
                cz = z + (child & 4 ? half : 0);
      if (code == 3) read_node(cx, cy, cz, half);
      if (code == 1 || code == 2) add(cx, cy, cz, half, code == 2);
    }
  }
  void add(int x, int y, int z, int side, bool is_occupied) {
    ++nodes;
    for (int i = 0; i < side * side * side; ++i) {
      cells[{x + i % side, y + i / side % side, z + i / side / side}] = is_occupied;
    }
  }
  std::string data_;
  std::size_t place_ = 0;
};

BtReader round_trip(const std::vector<OccupancyCell>& cells, double cell_m) {
  const ScratchFolder folder;
  EXPECT_OK(write_octomap(folder / "map.bt", cells, cell_m));
  return BtReader(read_text_file(folder / "map.bt").value());
}

Cells as_map(const std::vector<OccupancyCell>& cells) {
  Cells map;
  for (const auto& [cell, is_occupied] : cells) map[{cell.x(), cell.y(), cell.z()}] = is_occupied;
  return map;
}

TEST(OctomapFile, GivesEveryCellBack) {
  RandomStream random(8);
  Cells some;
  for (int i = 0; i < 3000; ++i) {
    const auto place = [&] { return static_cast<int>(random.index(30)) - 17; };
    some[{place(), place(), place()}] = random.index(3) == 0;
  }
  std::vector<OccupancyCell> cells;
  for (const auto& [place, is_occupied] : some) {
    const auto [x, y, z] = place;
    cells.push_back({{x, y, z}, is_occupied});
  }
  const BtReader read = round_trip(cells, 0.05);
  EXPECT_EQ(read.cells, some);
  EXPECT_EQ(read.fields.at("id"), "OcTree");
  EXPECT_EQ(read.fields.at("res"), "0.05");
  EXPECT_EQ(read.fields.at("size"), std::to_string(read.nodes));
}

TEST(OctomapFile, EightLikeCellsAreOne) {
  std::vector<OccupancyCell> cells;
  for (int i = 0; i < 64; ++i) cells.push_back({{i % 4, i / 4 % 4, i / 16}, false});
  const BtReader read = round_trip(cells, 0.1);
  EXPECT_EQ(read.cells, as_map(cells));
  EXPECT_EQ(read.nodes, 15U) << "a root, and one node a level down to the cube of 4 cells";
}

TEST(OctomapFile, OfNothingIsATreeWithoutNodes) {
  const BtReader read = round_trip({}, 0.1);
  EXPECT_EQ(read.fields.at("size"), "0");
  EXPECT_TRUE(read.cells.empty());
}

TEST(OctomapFile, RefusesWhatTheFormatCannotHold) {
  const ScratchFolder folder;
  const std::vector<OccupancyCell> far{{{40'000, 0, 0}, true}};
  EXPECT_ERROR(write_octomap(folder / "map.bt", far, 0.05), "map.bt");
  EXPECT_FALSE(std::filesystem::exists(folder / "map.bt"));
  EXPECT_ERROR(write_octomap(folder / "missing" / "map.bt", {}, 0.05), "map.bt");
}

TEST(OccupancyCells, AreOccupiedOnTheSurfaceFreeBeforeItAndUnknownBehind) {
  using testing::Vector3d;
  ThreadPool pool(2);
  const auto cameras = {testing::looking_at({-1, 0.1, 0.5}, {1, 0.1, 0.5})};
  TsdfVolume field = testing::fuse({testing::half_space(-Vector3d::UnitX(), -1.02)}, cameras, pool);
  const PiecewiseMesh mesh = extract_mesh(field, MeshOptions{}, pool).value();
  const geometry::RigidTransform gravity_from_world{Eigen::Quaterniond::Identity(), {0.3, 0, 0}};
  const auto cells = occupancy_cells(field, mesh, gravity_from_world, 0.05, pool).value();
  const Cells found = as_map(cells);
  EXPECT_EQ(found.size(), cells.size()) << "each once";
  const auto at = [&](double x_m) {
    const auto cell = found.find({static_cast<int>(std::floor((x_m + 0.3) / 0.05)), 2, 10});
    return cell == found.end() ? "unknown" : cell->second ? "occupied" : "free";
  };
  EXPECT_STREQ(at(0.5), "free");
  EXPECT_STREQ(at(0.9), "free");
  EXPECT_STREQ(at(1.02), "occupied");
  EXPECT_STREQ(at(1.12), "unknown");
  EXPECT_STREQ(at(-1.2), "unknown") << "behind the camera";
}

}  // namespace
}  // namespace roomwise::fusion
