// The part of Home that stores where in key-frames things are, and what they are together.

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "roomwise/home/home.h"
#include "roomwise/home/schema.h"
#include "roomwise/home/stored_instances.h"

namespace roomwise::home {
namespace {

Bytes depth_to_blob(const image::DepthImage& depth) {
  Bytes bytes(depth.pixels().size_bytes());
  if (!bytes.empty()) std::memcpy(bytes.data(), depth.pixels().data(), bytes.size());
  return bytes;
}

// Absent where the numbers do not fill whole rows.
std::optional<image::DepthImage> blob_to_depth(const Bytes& bytes, int width) {
  const std::size_t row_bytes =
      sizeof(std::uint16_t) * static_cast<std::size_t>(std::max(width, 1));
  if (width < 1 || bytes.size() % row_bytes != 0) return std::nullopt;
  image::DepthImage depth(width, static_cast<int>(bytes.size() / row_bytes));
  if (!bytes.empty()) std::memcpy(depth.pixels().data(), bytes.data(), bytes.size());
  return depth;
}

// An older home that is open for reading only has none of these tables.
Expected<bool> has_tables(const Database& database) {
  ROOMWISE_TRY(const int version, database.get<int>("PRAGMA user_version"));
  return version >= kInstancesVersion;
}

}  // namespace

Expected<FinderId> Home::add_region_finder(const RegionFinderRecord& finder) {
  ROOMWISE_TRY(const auto stored, region_finders());
  for (const auto& [id, other] : stored) {
    if (other.fingerprint != finder.fingerprint) continue;
    if (other == finder) return id;
    return fail(
        "{}: knows the finder {} by another name or other labels (as {}); give it as it was when "
        "the home was made",
        file(), finder.name, other.name);
  }
  std::string labels;
  try {
    labels = nlohmann::json(finder.labels).dump();
  } catch (const nlohmann::json::exception&) {
    return fail("finder {}: a label is not UTF-8 text", finder.name);
  }
  return database_.insert("INSERT INTO region_finders (name, fingerprint, labels) VALUES (?, ?, ?)",
                          finder.name, finder.fingerprint, labels);
}

Expected<std::map<FinderId, RegionFinderRecord>> Home::region_finders() const {
  std::map<FinderId, RegionFinderRecord> finders;
  ROOMWISE_TRY(const bool has, has_tables(database_));
  if (!has) return finders;
  const auto read = [&](const Statement& row) -> Expected<void> {
    RegionFinderRecord& finder = finders[row.column<FinderId>(0)];
    finder.name = row.column<std::string>(1);
    finder.fingerprint = row.column<std::string>(2);
    const auto json = nlohmann::json::parse(row.column<std::string>(3), nullptr, false);
    const bool are_texts =
        json.is_array() && std::ranges::all_of(json, [](const auto& v) { return v.is_string(); });
    if (!are_texts) {
      return fail(
          "{}: is damaged: the labels of finder {} are not a list of texts; put back a copy of it",
          file(), finder.name);
    }
    finder.labels = json.get<std::vector<std::string>>();
    return {};
  };
  ROOMWISE_CHECK_OK(
      database_.for_each("SELECT finder_id, name, fingerprint, labels FROM region_finders", read));
  return finders;
}

Expected<void> Home::put_detections(KeyframeId keyframe, FinderId finder,
                                    const objects::KeyframeDetections& look) {
  return atomically([&]() -> Expected<void> {
    ROOMWISE_TRY(const Bytes depth, stored_picture(keyframe, PictureKind::kCoarseDepth,
                                                   depth_to_blob(look.coarse_depth)));
    ROOMWISE_CHECK_OK(database_.run(
        "INSERT OR REPLACE INTO keyframe_depths (keyframe_id, width_px, depth) VALUES (?, ?, ?)",
        keyframe, look.coarse_depth.width(), depth));
    ROOMWISE_CHECK_OK(database_.run(
        "INSERT OR REPLACE INTO keyframe_looks (keyframe_id, finder_id) VALUES (?, ?)", keyframe,
        finder));
    ROOMWISE_CHECK_OK(database_.run(
        "DELETE FROM keyframe_regions WHERE keyframe_id = ? AND finder_id = ?", keyframe, finder));
    for (std::size_t i = 0; i < look.regions.size(); ++i) {
      const objects::Region& region = look.regions[i];
      ROOMWISE_CHECK_OK(database_.run(
          "INSERT INTO keyframe_regions (keyframe_id, finder_id, region, label, score, left_px, "
          "top_px, right_px, bottom_px, share, measured, points) "
          "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
          keyframe, finder, i, region.label, static_cast<double>(region.score),
          to_numbers(region.box), static_cast<double>(region.surface.share),
          static_cast<double>(region.surface.measured), points_to_blob(region.surface.points)));
    }
    return {};
  });
}

Expected<std::map<KeyframeId, objects::KeyframeDetections>> Home::looks(FinderId finder) const {
  std::map<KeyframeId, objects::KeyframeDetections> looks;
  ROOMWISE_TRY(const bool has, has_tables(database_));
  if (!has) return looks;
  const auto read_depth = [&](const Statement& row) -> Expected<void> {
    const auto id = row.column<KeyframeId>(0);
    ROOMWISE_TRY(const Bytes plain,
                 plain_picture(id, PictureKind::kCoarseDepth, row.column<Bytes>(2)));
    auto depth = blob_to_depth(plain, row.column<int>(1));
    if (!depth) {
      return fail(
          "{}: is damaged: the small depth image of key-frame {} has no whole rows; put "
          "back a copy of it",
          file(), id);
    }
    looks[id].coarse_depth = *std::move(depth);
    return {};
  };
  ROOMWISE_CHECK_OK(database_.for_each(
      "SELECT keyframe_id, width_px, depth FROM keyframe_depths JOIN keyframe_looks "
      "USING (keyframe_id) WHERE finder_id = ?",
      read_depth, finder));
  ROOMWISE_CHECK_OK(database_.for_each(
      "SELECT keyframe_id, label, score, left_px, top_px, right_px, bottom_px, share, measured, "
      "points FROM keyframe_regions WHERE finder_id = ? ORDER BY keyframe_id, region",
      [&](const Statement& row) -> Expected<void> {
        const auto id = row.column<KeyframeId>(0);
        objects::Region& region = looks[id].regions.emplace_back();
        region.label = row.column<std::string>(1);
        region.score = static_cast<float>(row.column<double>(2));
        region.box = box_column(row, 3);
        region.surface.share = static_cast<float>(row.column<double>(7));
        region.surface.measured = static_cast<float>(row.column<double>(8));
        auto points = blob_to_points(row.column<Bytes>(9));
        const std::array numbers{region.score,           region.box.left,   region.box.top,
                                 region.box.right,       region.box.bottom, region.surface.share,
                                 region.surface.measured};
        if (!points ||
            !std::ranges::all_of(numbers, [](float number) { return std::isfinite(number); })) {
          return fail(
              "{}: is damaged: a region of key-frame {} is not made of finite numbers; put back a "
              "copy of it",
              file(), id);
        }
        region.surface.points = *std::move(points);
        return {};
      },
      finder));
  return looks;
}

Expected<std::set<KeyframeId>> Home::looked_at(FinderId finder) const {
  std::set<KeyframeId> keyframes;
  ROOMWISE_CHECK_OK(database_.for_each(
      "SELECT keyframe_id FROM keyframe_looks WHERE finder_id = ?",
      [&](const Statement& row) { keyframes.insert(row.column<KeyframeId>(0)); }, finder));
  return keyframes;
}

Expected<void> Home::replace_instances(std::span<const objects::Instance> instances) {
  return atomically([&]() -> Expected<void> {
    ROOMWISE_CHECK_OK(database_.run("DELETE FROM instances"));
    for (const objects::Instance& instance : instances) {
      const geometry::OrientedBox& box = instance.box_keyframe;
      if (!is_finite(instance)) {
        return fail("{}: the box of instance '{}' is not finite", file(), instance.name);
      }
      ROOMWISE_TRY(
          const auto id,
          database_.insert("INSERT INTO instances (" ROOMWISE_INSTANCE_COLUMNS ") VALUES "
                           "(?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
                           instance.name, instance.probability, instance.observations,
                           instance.expected, instance.keyframe_id,
                           to_numbers(instance.picture_box), home::to_numbers(box.world_from_box),
                           to_numbers(box.size_m), to_numbers(instance.sigma_m)));
      if (instance.visit != 0) {
        ROOMWISE_CHECK_OK(database_.run(
            "INSERT INTO instance_visits (instance_id, visit_id, points) VALUES (?, ?, ?)", id,
            instance.visit, points_to_blob(instance.surface_keyframe)));
      }
      for (const auto& [name, share] : instance.names) {
        ROOMWISE_CHECK_OK(
            database_.run("INSERT INTO instance_names (instance_id, name, share) VALUES (?, ?, ?)",
                          id, name, share));
      }
    }
    return {};
  });
}

Expected<std::vector<objects::Instance>> Home::instances() const {
  std::vector<objects::Instance> instances;
  ROOMWISE_TRY(const bool has, has_tables(database_));
  if (!has) return instances;
  std::map<std::int64_t, std::size_t> place;
  ROOMWISE_CHECK_OK(database_.for_each(
      "SELECT instance_id, " ROOMWISE_INSTANCE_COLUMNS " FROM instances ORDER BY instance_id",
      [&](const Statement& row) -> Expected<void> {
        place[row.column<std::int64_t>(0)] = instances.size();
        const objects::Instance& instance = instances.emplace_back(read_instance(row, 1));
        if (!is_finite(instance)) {
          return fail(
              "{}: is damaged: the box of instance '{}' is not finite; put back a copy of it",
              file(), instance.name);
        }
        return {};
      }));
  ROOMWISE_CHECK_OK(database_.for_each(
      "SELECT instance_id, name, share FROM instance_names", [&](const Statement& row) {
        instances[place.at(row.column<std::int64_t>(0))].names[row.column<std::string>(1)] =
            row.column<double>(2);
      }));
  ROOMWISE_TRY(const int version, database_.get<int>("PRAGMA user_version"));
  if (version < kVisitsVersion) return instances;
  ROOMWISE_CHECK_OK(database_.for_each(
      "SELECT instance_id, visit_id, points FROM instance_visits",
      [&](const Statement& row) -> Expected<void> {
        objects::Instance& instance = instances[place.at(row.column<std::int64_t>(0))];
        instance.visit = row.column<VisitId>(1);
        auto points = blob_to_points(row.column<Bytes>(2));
        if (!points) {
          return fail(
              "{}: is damaged: the surface of instance '{}' is not made of finite numbers; put "
              "back a copy of it",
              file(), instance.name);
        }
        instance.surface_keyframe = *std::move(points);
        return {};
      }));
  return instances;
}

}  // namespace roomwise::home
