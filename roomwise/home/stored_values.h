#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <concepts>
#include <cstring>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/base/file.h"
#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/home/database.h"

// How values of the library stand in columns (schema.cpp says the same for people). Private to
// home/.
namespace roomwise::home {

// What read(row), a value or Expected<value>, makes of each row of the answer, in its order. A map
// is collected from pairs.
template <typename Container, typename Read, typename... Values>
[[nodiscard]] Expected<Container> collect(const Database& database, std::string_view sql,
                                          const Read& read, const Values&... values) {
  Container all;
  const auto take = [&](const Statement& row) -> Expected<void> {
    using Result = std::invoke_result_t<Read, const Statement&>;
    if constexpr (std::convertible_to<Result, typename Container::value_type>) {
      all.insert(all.end(), read(row));
    } else {
      ROOMWISE_TRY(auto one, read(row));
      all.insert(all.end(), std::move(one));
    }
    return {};
  };
  ROOMWISE_RETURN_IF_ERROR(database.for_each(sql, take, values...));
  return all;
}

// tx_m, ty_m, tz_m, qx, qy, qz, qw.
using PoseNumbers = std::array<double, 7>;

inline PoseNumbers to_numbers(const geometry::RigidTransform& pose) {
  const Eigen::Vector3d& t = pose.translation;
  const Eigen::Quaterniond& q = pose.rotation;
  return {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()};
}

// The pose in the seven columns from `first` on. Not normalised anew: it comes back as it was.
inline geometry::RigidTransform pose_column(const Statement& row, int first) {
  const PoseNumbers n = row.columns<7>(first);
  return {Eigen::Quaterniond(n[6], n[3], n[4], n[5]), Eigen::Vector3d(n[0], n[1], n[2])};
}

static_assert(std::endian::native == std::endian::little, "float blobs are little-endian");

inline Bytes to_blob(std::span<const float> values) {
  Bytes bytes(values.size_bytes());
  if (!values.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

inline std::vector<float> to_floats(std::span<const std::uint8_t> bytes) {
  std::vector<float> values(bytes.size() / sizeof(float));
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), values.size() * sizeof(float));
  return values;
}

// A JSON array. `owner` is what the labels are of, for people.
inline Expected<std::string> labels_to_json(const std::string& owner,
                                            const std::vector<std::string>& labels) {
  try {
    return nlohmann::json(labels).dump();
  } catch (const nlohmann::json::exception&) {
    return fail("{}: a label is not UTF-8 text", owner);
  }
}

inline Expected<std::vector<std::string>> labels_column(const Statement& row, int column,
                                                        const std::string& file,
                                                        const std::string& owner) {
  const auto json = nlohmann::json::parse(row.column<std::string>(column), nullptr, false);
  if (json.is_array() && std::ranges::all_of(json, [](const auto& v) { return v.is_string(); }))
    return json.get<std::vector<std::string>>();
  return fail("{}: is damaged: the labels of {} are not a list of texts; put back a copy of it",
              file, owner);
}

}  // namespace roomwise::home
