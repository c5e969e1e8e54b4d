#include "roomwise/recording/v4l2/rgbd_calibration.h"

#include <Eigen/LU>
#include <array>
#include <map>
#include <span>

#include "roomwise/base/file.h"
#include "roomwise/recording/data_lines.h"
#include "roomwise/recording/phone/json_file.h"

namespace roomwise::recording {
namespace {

constexpr std::string_view kColor = "color", kDepth = "depth", kUnits = "depth_units_per_metre",
                           kColorFromDepth = "color_from_depth";

// The numbers after the names of the file's lines.
class CalibrationLines {
 public:
  [[nodiscard]] static Expected<CalibrationLines> read(const std::filesystem::path& path) {
    CalibrationLines lines;
    lines.path_ = path.string();
    ROOMWISE_TRY(const std::string text, read_text_file(path));
    for (const DataLine& line : data_lines(text)) ROOMWISE_RETURN_IF_ERROR(lines.add(line));
    return lines;
  }

  [[nodiscard]] bool has(std::string_view name) const { return lines_.contains(name); }
  // Those of a line, which must be `count`, or `or_count`.
  [[nodiscard]] Expected<std::span<const double>> numbers(std::string_view name, std::size_t count,
                                                          std::size_t or_count) const {
    const auto found = lines_.find(name);
    if (found == lines_.end()) return fail("{}: has no line '{}'", path_, name);
    const std::vector<double>& numbers = found->second.numbers;
    if (numbers.size() == count || numbers.size() == or_count) return std::span(numbers);
    return fail("{}: '{}' has {} numbers, expected {}{}", line_of(name), name, numbers.size(),
                count, or_count == count ? "" : fmt::format(" or {}", or_count));
  }
  [[nodiscard]] std::string line_of(std::string_view name) const {
    return fmt::format("{}:{}", path_, lines_.find(name)->second.line_number);
  }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  struct Line {
    std::size_t line_number = 0;  // in the file, from 1
    std::vector<double> numbers;
  };
  [[nodiscard]] Expected<void> add(const DataLine& line) {
    const std::string name(line.words[0]);
    const auto fails = [&](const std::string& why) {
      return fail("{}:{}: {}", path_, line.number, why);
    };
    constexpr std::array kNames{kColor, kDepth, kUnits, kColorFromDepth};
    if (std::ranges::find(kNames, name) == kNames.end()) {
      return fails(fmt::format("'{}' is not known; expected {}", name, fmt::join(kNames, ", ")));
    }
    Line read{line.number, {}};
    for (const std::string_view word : std::span(line.words).subspan(1)) {
      const auto number = parse_number<double>(word);
      if (!number) return fails(fmt::format("'{}' is not a number", word));
      read.numbers.push_back(*number);
    }
    if (!lines_.emplace(name, std::move(read)).second) {
      return fails(fmt::format("'{}' is there twice", name));
    }
    return {};
  }

  std::string path_;
  std::map<std::string, Line, std::less<>> lines_;
};

Expected<geometry::PinholeCamera> camera_named(const CalibrationLines& lines, std::string_view name,
                                               double depth_units_per_metre) {
  constexpr std::size_t kWithoutLens = 6, kWithLens = 11;
  ROOMWISE_TRY(const auto n, lines.numbers(name, kWithoutLens, kWithLens));
  constexpr double kMaxSide_px = 65'535;
  for (const double side : {n[4], n[5]}) {
    if (side >= 1 && side <= kMaxSide_px && side == std::floor(side)) continue;
    return fail("{}: '{}' has the size {}x{}; expected whole numbers of pixels",
                lines.line_of(name), name, n[4], n[5]);
  }
  geometry::PinholeCamera camera;
  std::tie(camera.fx, camera.fy, camera.cx, camera.cy) = std::tuple(n[0], n[1], n[2], n[3]);
  camera.width = static_cast<int>(n[4]);
  camera.height = static_cast<int>(n[5]);
  if (n.size() == kWithLens) camera.distortion = {n[6], n[7], n[8], n[9], n[10]};
  camera.depth_units_per_metre = depth_units_per_metre;
  if (auto valid = camera.validate(); !valid) {
    return Unexpected(std::move(valid).error().with_context(lines.line_of(name)));
  }
  return camera;
}

Expected<geometry::RigidTransform> color_from_depth_of(const CalibrationLines& lines) {
  constexpr std::size_t kRows = 12;
  ROOMWISE_TRY(const auto rows, lines.numbers(kColorFromDepth, kRows, kRows));
  auto color_from_depth = pose_of_rows(rows);
  if (!color_from_depth) {
    return fail("{}: '{}' has no rotation in its first three columns",
                lines.line_of(kColorFromDepth), kColorFromDepth);
  }
  // Two cameras of one device; more than a metre is millimetres.
  constexpr double kMaxBaseline_m = 1;
  if (color_from_depth->distance_m() > kMaxBaseline_m) {
    return fail("{}: '{}' puts the cameras {:.2f} m apart; give its last column in metres",
                lines.line_of(kColorFromDepth), kColorFromDepth, color_from_depth->distance_m());
  }
  return color_from_depth;
}

}  // namespace

Expected<RgbdCalibration> read_rgbd_calibration(const std::filesystem::path& path) {
  ROOMWISE_TRY(const CalibrationLines lines, CalibrationLines::read(path));
  ROOMWISE_TRY(const auto units, lines.numbers(kUnits, 1, 1));
  RgbdCalibration calibration;
  ROOMWISE_TRY(calibration.color, camera_named(lines, kColor, units[0]));
  if (lines.has(kDepth) != lines.has(kColorFromDepth)) {
    return fail("{}: has '{}' but not '{}'; give both, or neither where depth is registered",
                lines.path(), lines.has(kDepth) ? kDepth : kColorFromDepth,
                lines.has(kDepth) ? kColorFromDepth : kDepth);
  }
  if (lines.has(kDepth)) {
    ROOMWISE_TRY(calibration.depth, camera_named(lines, kDepth, units[0]));
    ROOMWISE_TRY(calibration.color_from_depth, color_from_depth_of(lines));
  }
  return calibration;
}

}  // namespace roomwise::recording
