#include "roomwise/fusion/floor_map_file.h"

#include "roomwise/base/file.h"

namespace roomwise::fusion {
namespace {

// The values that map_saver writes. As shares of black they lie on the right side of both
// thresholds: 0.004, 1, and 0.196 between them.
constexpr char kFreePixel = static_cast<char>(254);
constexpr char kOccupiedPixel = 0;
constexpr char kUnknownPixel = static_cast<char>(205);
constexpr double kFreeBelow = 0.15, kOccupiedAbove = 0.65;

char pixel_of(FloorCell cell) {
  if (cell == FloorCell::kFree) return kFreePixel;
  return cell == FloorCell::kOccupied ? kOccupiedPixel : kUnknownPixel;
}

// A name in double quotes, as YAML has it.
std::string quoted(const std::string& name) {
  std::string text = "\"";
  for (const char c : name) {
    if (c == '"' || c == '\\') text += '\\';
    text += c;
  }
  return text + "\"";
}

}  // namespace

std::filesystem::path floor_map_picture(const std::filesystem::path& yaml_path) {
  return std::filesystem::path(yaml_path).replace_extension(".pgm");
}

Expected<void> write_floor_map(const std::filesystem::path& yaml_path, const FloorGrid& grid) {
  const std::filesystem::path picture_path = floor_map_picture(yaml_path);
  std::string picture = fmt::format("P5\n{} {}\n255\n", grid.columns(), grid.rows());
  for (int row = grid.rows() - 1; row >= 0; --row) {
    for (int column = 0; column < grid.columns(); ++column) {
      picture += pixel_of(grid.at(column, row));
    }
  }
  ROOMWISE_RETURN_IF_ERROR(write_file(picture_path, picture));
  return write_file(
      yaml_path, fmt::format("image: {}\n"
                             "mode: trinary\n"
                             "resolution: {:.6f}\n"
                             "origin: [{:.6f}, {:.6f}, 0.0]\n"
                             "negate: 0\n"
                             "occupied_thresh: {}\n"
                             "free_thresh: {}\n",
                             quoted(picture_path.filename().string()), grid.cell_m(),
                             grid.origin_m().x(), grid.origin_m().y(), kOccupiedAbove, kFreeBelow));
}

}  // namespace roomwise::fusion
