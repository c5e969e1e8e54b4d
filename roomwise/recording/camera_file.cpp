#include "roomwise/recording/camera_file.h"

#include <array>
#include <span>

#include "roomwise/base/file.h"
#include "roomwise/recording/data_lines.h"

namespace roomwise::recording {
namespace {

constexpr std::string_view kCameraLayout =
    "fx fy cx cy width height depth_units_per_metre [k1 k2 p1 p2 k3]";
constexpr std::array<std::string_view, 12> kCameraNames{
    "fx", "fy", "cx", "cy", "width", "height", "depth_units_per_metre",
    "k1", "k2", "p1", "p2", "k3"};
constexpr std::size_t kWithoutLens = 7;

// The camera that one line of words describes.
Expected<geometry::PinholeCamera> parse_camera(std::span<const std::string_view> words) {
  const std::size_t expected = words.size() <= kWithoutLens ? kWithoutLens : kCameraNames.size();
  if (words.size() > expected) {
    return fail("'{}' is one value too many; expected {}", words[expected], kCameraLayout);
  }
  if (words.size() < expected) {
    return fail("the value of {} is missing; expected {}", kCameraNames[words.size()],
                kCameraLayout);
  }
  std::array<double, kCameraNames.size()> values{};
  for (std::size_t i = 0; i < words.size(); ++i) {
    const auto value = parse_number<double>(words[i]);
    if (!value)
      return fail("{} = '{}' is not a number; expected {}", kCameraNames[i], words[i],
                  kCameraLayout);
    values[i] = *value;
  }
  for (const std::size_t size : {std::size_t{4}, std::size_t{5}}) {
    if (!parse_number<int>(words[size])) {
      return fail("{} = '{}' is not a whole number of pixels", kCameraNames[size], words[size]);
    }
  }
  geometry::PinholeCamera camera;
  camera.fx = values[0];
  camera.fy = values[1];
  camera.cx = values[2];
  camera.cy = values[3];
  camera.width = static_cast<int>(values[4]);
  camera.height = static_cast<int>(values[5]);
  camera.depth_units_per_metre = values[6];
  camera.distortion = {values[7], values[8], values[9], values[10], values[11]};
  ROOMWISE_RETURN_IF_ERROR(camera.validate());
  return camera;
}

}  // namespace

Expected<geometry::PinholeCamera> read_camera(const std::filesystem::path& path) {
  ROOMWISE_TRY(const std::string text, read_text_file(path));
  const auto lines = data_lines(text);
  if (lines.empty()) return fail("{}: holds no camera; expected {}", path.string(), kCameraLayout);
  if (lines.size() > 1) {
    return fail("{}:{}: is a second line of values; expected one line {}", path.string(),
                lines[1].number, kCameraLayout);
  }
  auto camera = parse_camera(lines[0].words);
  if (!camera) {
    return Unexpected(std::move(camera).error().with_context(
        fmt::format("{}:{}", path.string(), lines[0].number)));
  }
  return camera;
}

Expected<void> write_camera(const std::filesystem::path& path,
                            const geometry::PinholeCamera& camera) {
  const geometry::LensDistortion& lens = camera.distortion;
  const bool has_lens = !lens.is_none();
  std::string text = "# fx fy cx cy width height depth_units_per_metre";
  text += has_lens ? " k1 k2 p1 p2 k3\n" : "\n";
  text += fmt::format("{} {} {} {} {} {} {}", camera.fx, camera.fy, camera.cx, camera.cy,
                      camera.width, camera.height, camera.depth_units_per_metre);
  if (has_lens) {
    text += fmt::format(" {} {} {} {} {}", lens.k1, lens.k2, lens.p1, lens.p2, lens.k3);
  }
  return write_file(path, text + "\n");
}

Expected<geometry::PinholeCamera> resolve_camera(const std::string& preset_or_file) {
  if (auto preset = geometry::camera_preset(preset_or_file)) return preset;
  std::error_code ignored;
  if (std::filesystem::exists(preset_or_file, ignored)) return read_camera(preset_or_file);
  return fail(
      "'{}' is neither a camera preset (fr1, fr2, fr3, kinect-v1, xtion) nor a camera file that is "
      "there",
      preset_or_file);
}

}  // namespace roomwise::recording
