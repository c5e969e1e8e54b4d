// The part of Home that stores where in key-frames things are, and what they are together.

#include <algorithm>
#include <array>
#include <cmath>

#include "roomwise/home/home.h"
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

}  // namespace

Expected<FinderId> Home::add_region_finder(const RegionFinderRecord& finder) {
  ROOMWISE_TRY(const auto stored, region_finders());
  for (const auto& [id, other] : stored) {
    if (other.fingerprint != finder.fingerprint) continue;
    if (other.labels != finder.labels) {
      return fail(
          "{}: knows the finder {} by other labels; give it as it was when the home was made",
          file(), finder.name);
    }
    if (other.name != finder.name) {
      ROOMWISE_RETURN_IF_ERROR(
          database_.run("UPDATE region_finders SET name = ? WHERE fingerprint = ?", finder.name,
                        finder.fingerprint));
    }
    return id;
  }
  ROOMWISE_TRY(const std::string labels, labels_to_json("finder " + finder.name, finder.labels));
  return database_.insert("region_finders (name, fingerprint, labels)", finder.name,
                          finder.fingerprint, labels);
}

Expected<std::map<FinderId, RegionFinderRecord>> Home::region_finders() const {
  return collect<std::map<FinderId, RegionFinderRecord>>(
      database_, "SELECT finder_id, name, fingerprint, labels FROM region_finders",
      [&](const Statement& row) -> Expected<std::pair<FinderId, RegionFinderRecord>> {
        const auto name = row.column<std::string>(1);
        ROOMWISE_TRY(auto labels, labels_column(row, 3, file(), "finder " + name));
        return std::pair(row.column<FinderId>(0),
                         RegionFinderRecord{name, row.column<std::string>(2), std::move(labels)});
      });
}

Expected<void> Home::put_detections(KeyframeId keyframe, FinderId finder,
                                    const objects::KeyframeDetections& look) {
  return atomically([&]() -> Expected<void> {
    ROOMWISE_TRY(const Bytes depth, encrypt_if_protected(keyframe, PictureKind::kCoarseDepth,
                                                         depth_to_blob(look.coarse_depth)));
    ROOMWISE_RETURN_IF_ERROR(database_.put("keyframe_depths (keyframe_id, width_px, depth)",
                                           keyframe, look.coarse_depth.width(), depth));
    ROOMWISE_RETURN_IF_ERROR(
        database_.put("keyframe_finders (keyframe_id, finder_id)", keyframe, finder));
    ROOMWISE_RETURN_IF_ERROR(
        database_.run("DELETE FROM keyframe_detections WHERE keyframe_id = ? AND finder_id = ?",
                      keyframe, finder));
    for (std::size_t i = 0; i < look.detections.size(); ++i) {
      const objects::Detection& region = look.detections[i];
      ROOMWISE_RETURN_IF_ERROR(database_.add(
          "keyframe_detections (keyframe_id, finder_id, place, label, score, left_px, top_px, "
          "right_px, bottom_px, share, measured, points)",
          keyframe, finder, i, region.label, static_cast<double>(region.score),
          to_numbers(region.box), static_cast<double>(region.surface.share),
          static_cast<double>(region.surface.measured), points_to_blob(region.surface.points)));
    }
    return {};
  });
}

Expected<std::map<KeyframeId, objects::KeyframeDetections>> Home::detections(
    FinderId finder) const {
  std::map<KeyframeId, objects::KeyframeDetections> looks;
  const auto read_depth = [&](const Statement& row) -> Expected<void> {
    const auto id = row.column<KeyframeId>(0);
    ROOMWISE_TRY(const Bytes plain,
                 decrypt_if_sealed(id, PictureKind::kCoarseDepth, row.column<Bytes>(2)));
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
  ROOMWISE_RETURN_IF_ERROR(database_.for_each(
      "SELECT keyframe_id, width_px, depth FROM keyframe_depths JOIN keyframe_finders "
      "USING (keyframe_id) WHERE finder_id = ?",
      read_depth, finder));
  ROOMWISE_RETURN_IF_ERROR(database_.for_each(
      "SELECT keyframe_id, label, score, left_px, top_px, right_px, bottom_px, share, measured, "
      "points FROM keyframe_detections WHERE finder_id = ? ORDER BY keyframe_id, place",
      [&](const Statement& row) -> Expected<void> {
        const auto id = row.column<KeyframeId>(0);
        objects::Detection& region = looks[id].detections.emplace_back();
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
  return collect<std::set<KeyframeId>>(
      database_, "SELECT keyframe_id FROM keyframe_finders WHERE finder_id = ?",
      [](const Statement& row) { return row.column<KeyframeId>(0); }, finder);
}

Expected<void> Home::replace_instances(std::span<const objects::Instance> instances) {
  return atomically([&]() -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(database_.run("DELETE FROM instances"));
    for (const objects::Instance& instance : instances) {
      if (!is_finite(instance)) {
        return fail("{}: the box of instance '{}' is not finite", file(), instance.name);
      }
      ROOMWISE_TRY(
          const auto id,
          database_.insert("instances (" ROOMWISE_INSTANCE_COLUMNS ", points)",
                           instance_columns(instance), points_to_blob(instance.surface_keyframe)));
      for (const auto& [name, share] : instance.names) {
        ROOMWISE_RETURN_IF_ERROR(
            database_.add("instance_names (instance_id, name, share)", id, name, share));
      }
    }
    return {};
  });
}

Expected<std::vector<objects::Instance>> Home::instances() const {
  std::vector<objects::Instance> instances;
  std::map<std::int64_t, std::size_t> place;
  ROOMWISE_RETURN_IF_ERROR(database_.for_each(
      "SELECT instance_id, points, " ROOMWISE_INSTANCE_COLUMNS
      " FROM instances ORDER BY instance_id",
      [&](const Statement& row) -> Expected<void> {
        place[row.column<std::int64_t>(0)] = instances.size();
        objects::Instance& instance = instances.emplace_back(read_instance(row, 2));
        auto points = blob_to_points(row.column<Bytes>(1));
        if (!points || !is_finite(instance)) {
          return fail(
              "{}: is damaged: the box or the surface of instance '{}' is not made of finite "
              "numbers; put back a copy of it",
              file(), instance.name);
        }
        instance.surface_keyframe = *std::move(points);
        return {};
      }));
  ROOMWISE_RETURN_IF_ERROR(database_.for_each(
      "SELECT instance_id, name, share FROM instance_names", [&](const Statement& row) {
        instances[place.at(row.column<std::int64_t>(0))].names[row.column<std::string>(1)] =
            row.column<double>(2);
      }));
  return instances;
}

}  // namespace roomwise::home
