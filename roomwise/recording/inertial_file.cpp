#include "roomwise/recording/inertial_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "roomwise/base/file.h"
#include "roomwise/base/in_context.h"
#include "roomwise/recording/data_lines.h"

namespace roomwise::recording {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using geometry::InertialSample;
using geometry::kGravity_m_s2;

// A file and what its lines hold.
struct InertialLayout {
  const char* file;
  std::string_view layout;
  bool tells_turns;
};
constexpr InertialLayout kImu{"imu.txt", "timestamp wx wy wz ax ay az", true};
constexpr InertialLayout kAccelerometer{"accelerometer.txt", "timestamp ax ay az", false};
const Quaterniond kCameraFromKinect(0, 0, 0, 1);  // half a turn about z
constexpr std::string_view kRotationMark = "# camera_from_imu ";
// Sensors of phones measure 2,000 degrees a second at most; who writes degrees is above it soon.
constexpr double kFastest_rad_s = 35;
// By how much of gravity the median force may differ: a sensor's offset and somebody who walks.
constexpr double kTolerance = 0.2;

double median_force(const std::vector<InertialSample>& samples) {
  std::vector<double> lengths;
  for (const InertialSample& one : samples) lengths.push_back(one.force_m_s2.norm());
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::ranges::nth_element(lengths, middle);
  return *middle;
}

// Rather than up or aside, all in all: some sensors tell what gravity pulls at, not what holds
// them.
bool points_down(const std::vector<InertialSample>& samples) {
  Vector3d sum = Vector3d::Zero();
  for (const InertialSample& one : samples) sum += one.force_m_s2;
  return sum.y() > std::hypot(sum.x(), sum.z());
}

Expected<Quaterniond> parse_rotation(std::string_view numbers) {
  const auto lines = data_lines(numbers);
  Quaterniond rotation(0, 0, 0, 0);
  const bool has_four = lines.size() == 1 && lines[0].words.size() == 4;
  for (int i = 0; has_four && i < 4; ++i) {
    rotation.coeffs()[i] =
        parse_number<double>(lines[0].words[static_cast<std::size_t>(i)]).value_or(0);
  }
  constexpr double kRounding = 0.01;
  if (!(std::abs(rotation.norm() - 1) < kRounding)) {
    return fail("'{}' is no rotation; expected qx qy qz qw of length 1, such as 0 0 0 1", numbers);
  }
  return rotation.normalized();
}

Expected<InertialSample> parse_sample(const DataLine& line, const InertialLayout& layout) {
  constexpr std::array<std::string_view, 6> kNames{"wx", "wy", "wz", "ax", "ay", "az"};
  const std::size_t first = layout.tells_turns ? 0 : 3;
  if (line.words.size() != 1 + kNames.size() - first)
    return fail("{} values, expected {}", line.words.size(), layout.layout);
  InertialSample sample;
  ROOMWISE_TRY(sample.timestamp_ns, parse_timestamp(line.words[0]));
  for (std::size_t i = first; i < kNames.size(); ++i) {
    const std::string_view word = line.words[1 + i - first];
    const auto value = parse_number<double>(word);
    if (!value)
      return fail("{} = '{}' is not a finite number; expected {}", kNames.at(i), word,
                  layout.layout);
    (i < 3 ? sample.turning_rad_s : sample.force_m_s2)[static_cast<Eigen::Index>(i % 3)] = *value;
  }
  return sample;
}

// How the camera's frame is turned to the sensor's.
Expected<Quaterniond> find_rotation(std::string_view text, const InertialLayout& layout) {
  if (!layout.tells_turns) return kCameraFromKinect;
  Quaterniond camera_from_imu = Quaterniond::Identity();
  std::istringstream lines{std::string(text)};
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (!line.starts_with(kRotationMark)) continue;
    if (line.ends_with('\r')) line.pop_back();
    ROOMWISE_TRY(camera_from_imu,
                 in_context(fmt::format("line {}", number),
                            parse_rotation(std::string_view(line).substr(kRotationMark.size()))));
  }
  return camera_from_imu;
}

Expected<geometry::InertialTrack> read(const std::filesystem::path& path,
                                       const InertialLayout& layout,
                                       std::vector<std::string>& notes) {
  ROOMWISE_TRY(const std::string text, read_text_file(path));
  ROOMWISE_TRY(const Quaterniond camera_from_imu, find_rotation(text, layout));
  InertialSamples samples(layout.file, layout.tells_turns);
  for (const DataLine& line : data_lines(text)) {
    if (!line.complete) continue;  // a file that was cut off may end within a number
    const std::string place = fmt::format("line {}", line.number);
    auto sample = parse_sample(line, layout);
    if (!sample) {
      samples.leave_out(fmt::format("{}: {}", place, sample.error().message));
      continue;
    }
    sample->turning_rad_s = camera_from_imu * sample->turning_rad_s;
    sample->force_m_s2 = camera_from_imu * sample->force_m_s2;
    samples.add(*sample, place);
  }
  return std::move(samples).finish(notes);
}

}  // namespace

void InertialSamples::add(const InertialSample& sample, const std::string& place) {
  if (!sample.turning_rad_s.allFinite() || !sample.force_m_s2.allFinite()) {
    leave_out(place + ": a number is not finite");
  } else if (!samples_.empty() && sample.timestamp_ns <= samples_.back().timestamp_ns) {
    leave_out(fmt::format("{}: the time {} does not increase", place,
                          format_timestamp(sample.timestamp_ns)));
  } else {
    samples_.push_back(sample);
  }
}

void InertialSamples::leave_out(const std::string& why) {
  if (left_out_++ == 0) why_ = why;
}

geometry::InertialTrack InertialSamples::finish(std::vector<std::string>& notes) && {
  if (left_out_ > 0) {
    notes.push_back(fmt::format("{}: {} samples of the inertial sensor are left out; the first: {}",
                                name_, left_out_, why_));
  }
  if (samples_.empty()) {
    notes.push_back(fmt::format("{}: holds no sample of an inertial sensor", name_));
    return {};
  }
  double median = median_force(samples_);
  if (std::abs(median - 1) < kTolerance) {
    notes.push_back(fmt::format("{}: forces are {:.2f} at rest: taken for g", name_, median));
    for (InertialSample& one : samples_) one.force_m_s2 *= kGravity_m_s2;
    median *= kGravity_m_s2;
  }
  if (!(std::abs(median - kGravity_m_s2) < kTolerance * kGravity_m_s2)) {
    notes.push_back(fmt::format(
        "{}: forces are {:.3g} m/s^2 in the median, gravity is 9.8: the inertial sensor is left "
        "out; write m/s^2 or g, with gravity",
        name_, median));
    return {};
  }
  if (points_down(samples_)) {
    notes.push_back(fmt::format(
        "{}: forces point down in the pictures, where at rest they must point up: the inertial "
        "sensor is left out; turn their sign, or the pictures of a camera that was upside down",
        name_));
    return {};
  }
  const auto too_fast = std::ranges::find_if(samples_, [](const InertialSample& one) {
    return one.turning_rad_s.norm() > kFastest_rad_s;
  });
  if (too_fast != samples_.end()) {
    notes.push_back(fmt::format(
        "{}: turns by {:.0f} rad/s, more than sensors measure: turns are left out; are they in "
        "degrees?",
        name_, too_fast->turning_rad_s.norm()));
    tells_turns_ = false;
  }
  return {std::move(samples_), tells_turns_};
}

geometry::InertialTrack read_inertial(const std::filesystem::path& folder,
                                      std::vector<std::string>& notes) {
  std::error_code ignored;
  for (const InertialLayout& layout : {kImu, kAccelerometer}) {
    if (!std::filesystem::exists(folder / layout.file, ignored)) continue;
    auto track = read(folder / layout.file, layout, notes);
    if (track) return *std::move(track);
    notes.push_back(
        fmt::format("{}: {}: the inertial sensor is left out", layout.file, track.error().message));
    return {};
  }
  return {};
}

Expected<void> write_inertial(const std::filesystem::path& folder,
                              const geometry::InertialTrack& track, std::string_view what) {
  const InertialLayout& layout = track.tells_turns() ? kImu : kAccelerometer;
  std::string text = fmt::format("# {}\n# {}\n", what, layout.layout);
  for (const InertialSample& one : track.samples()) {
    text += format_timestamp(one.timestamp_ns);
    const Vector3d& w = one.turning_rad_s;
    if (layout.tells_turns) text += fmt::format(" {:.7g} {:.7g} {:.7g}", w.x(), w.y(), w.z());
    const Vector3d a =
        layout.tells_turns ? one.force_m_s2 : kCameraFromKinect.conjugate() * one.force_m_s2;
    text += fmt::format(" {:.7g} {:.7g} {:.7g}\n", a.x(), a.y(), a.z());
  }
  return write_file(folder / layout.file, text);
}

}  // namespace roomwise::recording
