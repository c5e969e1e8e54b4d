#include "roomwise/recording/odometry_file.h"

#include <array>
#include <sstream>

#include "roomwise/base/file.h"
#include "roomwise/base/in_context.h"
#include "roomwise/recording/data_lines.h"

namespace roomwise::recording {
namespace {

constexpr std::string_view kUpMark = "# up ";

Expected<Eigen::Vector3d> parse_up(std::string_view numbers) {
  const auto lines = data_lines(numbers);
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  const bool has_three = lines.size() == 1 && lines[0].words.size() == 3;
  for (int i = 0; has_three && i < 3; ++i) {
    const auto value = parse_number<double>(lines[0].words[static_cast<std::size_t>(i)]);
    if (!value)
      return fail("'{}' is not a finite number", lines[0].words[static_cast<std::size_t>(i)]);
    up[i] = *value;
  }
  constexpr double kRounding = 0.01;
  if (!(std::abs(up.norm() - 1) < kRounding)) {
    return fail("'{}' is no direction; expected three numbers of length 1, such as 0 0 1", numbers);
  }
  return up.normalized();
}

}  // namespace

Expected<Odometry> read_odometry(const std::filesystem::path& path) {
  Odometry odometry;
  ROOMWISE_TRY(odometry.poses, read_trajectory(path));
  ROOMWISE_TRY(const std::string text, read_text_file(path));
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (!line.starts_with(kUpMark)) continue;
    if (line.ends_with('\r')) line.pop_back();
    ROOMWISE_TRY(odometry.up, in_context(fmt::format("{}:{}", path.string(), number),
                                         parse_up(std::string_view(line).substr(kUpMark.size()))));
  }
  return odometry;
}

std::string up_line(const Eigen::Vector3d& up) {
  return fmt::format("{}{} {} {}\n", kUpMark, up.x(), up.y(), up.z());
}

Expected<void> write_odometry(const std::filesystem::path& path, const Odometry& odometry,
                              std::string_view what) {
  std::string head = fmt::format("# {}\n", what);
  if (odometry.up) head += up_line(*odometry.up);
  return write_file(path, head + trajectory_text(odometry.poses));
}

}  // namespace roomwise::recording
