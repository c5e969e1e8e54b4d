#include "roomwise/fusion/octomap_file.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "roomwise/base/file.h"

namespace roomwise::fusion {
namespace {

constexpr int kDepth = 16;
constexpr int kHalfKeys = 1 << (kDepth - 1);

// A cell in the order of the tree: the bits of its x, y and z, interleaved, x lowest.
struct Leaf {
  std::uint64_t code = 0;
  bool is_occupied = false;
};

std::uint64_t interleaved(const Eigen::Vector3i& cell) {
  std::uint64_t code = 0;
  for (int bit = 0; bit < kDepth; ++bit) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto value = static_cast<std::uint64_t>(cell[axis] + kHalfKeys);
      code |= (value >> bit & 1U) << (3 * bit + axis);
    }
  }
  return code;
}

// Two bits of a child, as the file has them.
enum ChildCode : unsigned { kUnknown = 0, kFree = 1, kOccupied = 2, kInner = 3 };

// Writes nodes depth first and counts them.
class TreeWriter {
 public:
  // What the node of `leaves` at a height over the cells is; where it is an inner node, itself and
  // all below it are appended.
  ChildCode write(std::span<const Leaf> leaves, int height) {
    if (leaves.empty()) return kUnknown;
    if (height == 0) return leaves.front().is_occupied ? kOccupied : kFree;
    const std::size_t place = bytes.size();
    bytes.append(2, '\0');
    unsigned children = 0;
    std::array<int, 4> count{};
    for (std::uint64_t child = 0; child < 8; ++child) {
      const auto end = std::ranges::partition_point(leaves, [&](const Leaf& leaf) {
        return (leaf.code >> (3 * (height - 1)) & 7U) <= child;
      });
      const auto in_child = static_cast<std::size_t>(end - leaves.begin());
      const ChildCode code = write(leaves.first(in_child), height - 1);
      leaves = leaves.subspan(in_child);
      children |= code << (2 * child);
      ++count[code];
    }
    if (count[kFree] == 8 || count[kOccupied] == 8) {  // nothing was appended below it
      bytes.resize(place);
      return count[kFree] == 8 ? kFree : kOccupied;
    }
    bytes[place] = static_cast<char>(children & 0xFFU);
    bytes[place + 1] = static_cast<char>(children >> 8 & 0xFFU);
    nodes += 1 + static_cast<std::size_t>(count[kFree] + count[kOccupied]);
    return kInner;
  }

  std::string bytes;
  std::size_t nodes = 0;
};

}  // namespace

Expected<void> write_octomap(const std::filesystem::path& path,
                             std::span<const OccupancyCell> cells, double cell_m) {
  std::vector<Leaf> leaves;
  leaves.reserve(cells.size());
  for (const OccupancyCell& cell : cells) {
    if ((cell.cell.array() < -kHalfKeys).any() || (cell.cell.array() >= kHalfKeys).any()) {
      return fail("{}: the map reaches farther than {} cells of {} m, which an OctoMap cannot hold",
                  path.string(), kHalfKeys, cell_m);
    }
    leaves.push_back({interleaved(cell.cell), cell.is_occupied});
  }
  std::ranges::sort(leaves, {}, &Leaf::code);
  TreeWriter tree;
  tree.write(leaves, kDepth);
  return write_file(path, fmt::format("# Octomap OcTree binary file\n"
                                      "# z points up, lengths in metres\n"
                                      "id OcTree\n"
                                      "size {}\n"
                                      "res {}\n"
                                      "data\n",
                                      tree.nodes, cell_m) +
                              tree.bytes);
}

}  // namespace roomwise::fusion
