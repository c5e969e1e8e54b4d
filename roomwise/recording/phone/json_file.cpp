#include "roomwise/recording/phone/json_file.h"

#include <cmath>

#include "roomwise/base/file.h"
#include "roomwise/base/in_context.h"
#include "roomwise/recording/personal_files.h"

namespace roomwise::recording {

using nlohmann::json;

namespace {

Expected<json> read_json_file(const std::filesystem::path& path) {
  constexpr std::uintmax_t kMaxBytes = 1 << 20;
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  if (!error && size > kMaxBytes) {
    return fail("{}: has {} bytes, more than the {} that such a file may have", path.string(), size,
                kMaxBytes);
  }
  ROOMWISE_TRY(const std::string text, read_text_file(path));
  json parsed = json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!parsed.is_object()) {
    return fail("{}: is no JSON object; is it cut off? Copy the recording again", path.string());
  }
  return parsed;
}

}  // namespace

Expected<double> number_of(const json& object, const char* key) {
  const auto value = object.find(key);
  if (value == object.end()) return fail("'{}' is missing", key);
  if (!value->is_number() || !std::isfinite(value->get<double>())) {
    return fail("'{}' is no finite number", key);
  }
  return value->get<double>();
}

Expected<std::vector<double>> numbers_of(const json& object, const char* key, std::size_t count) {
  const auto value = object.find(key);
  if (value == object.end()) return fail("'{}' is missing", key);
  std::vector<double> numbers;
  if (!value->is_array() || value->size() != count) {
    return fail("'{}' is no list of {} numbers", key, count);
  }
  for (const json& one : *value) {
    if (!one.is_number() || !std::isfinite(one.get<double>())) {
      return fail("'{}' holds something that is no finite number", key);
    }
    numbers.push_back(one.get<double>());
  }
  return numbers;
}

Expected<geometry::RigidTransform> pose_of_rows(std::span<const double> rows) {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d translation;
  for (int row = 0; row < 3; ++row) {
    const auto values = rows.subspan(static_cast<std::size_t>(4 * row), 4);
    rotation.row(row) << values[0], values[1], values[2];
    translation[row] = values[3];
  }
  constexpr double kRounding = 0.01;
  const double off = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm();
  if (!(off < kRounding) || rotation.determinant() < 0) return fail("the pose is no rotation");
  return geometry::RigidTransform::from_matrix(rotation, translation);
}

Expected<geometry::RigidTransform> pose_of_arkit(std::span<const double> rows) {
  ROOMWISE_TRY(const auto world_from_arkit, pose_of_rows(rows));
  const geometry::RigidTransform arkit_from_camera{{0, 1, 0, 0}, Eigen::Vector3d::Zero()};
  return world_from_arkit * arkit_from_camera;
}

Expected<FrameFacts> read_frame_facts(const std::filesystem::path& path,
                                      Expected<FrameFacts> (*facts_of)(const json&)) {
  ROOMWISE_TRY(const json object, read_json_file(path));
  ROOMWISE_TRY(FrameFacts facts, in_context(path.string(), facts_of(object)));
  facts.personal = personal_data_of_json(object);
  return facts;
}

Expected<TimestampNs> timestamp_of(double seconds) {
  return parse_timestamp(fmt::format("{:.9f}", seconds));
}

}  // namespace roomwise::recording
