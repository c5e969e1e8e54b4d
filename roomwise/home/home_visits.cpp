// The part of Home that stores later visits and what they found changed.

#include "roomwise/home/home.h"
#include "roomwise/home/schema.h"
#include "roomwise/home/stored_instances.h"
#include "roomwise/home/stored_values.h"

namespace roomwise::home {
namespace {

// An older home that is open for reading only has none of these tables.
Expected<bool> has_visits(const Database& database) {
  ROOMWISE_TRY(const int version, database.get<int>("PRAGMA user_version"));
  return version >= kVisitsVersion;
}

std::string to_text(PastReason reason) {
  return reason == PastReason::kRemoved ? "gone" : "moved";
}

}  // namespace

Expected<VisitId> Home::apply_changes(const HomeChanges& changes) {
  VisitId visit = 0;
  ROOMWISE_CHECK_OK(atomically([&]() -> Expected<void> {
    const Visit& v = changes.visit;
    ROOMWISE_TRY(visit,
                 database_.insert("INSERT INTO visits (name, folder, first_timestamp_ns, "
                                  "last_timestamp_ns, frames, placed) VALUES (?, ?, ?, ?, ?, ?)",
                                  v.name, v.folder, v.first_timestamp_ns, v.last_timestamp_ns,
                                  v.frames, v.placed));
    std::vector<objects::Instance> instances = changes.kept;
    for (const objects::Instance& one : changes.arrived) {
      instances.push_back(one);
      instances.back().visit = visit;
    }
    ROOMWISE_CHECK_OK(replace_instances(instances));
    for (const PastInstance& past : changes.past) {
      const objects::Instance& one = past.instance;
      if (!is_finite(one)) {
        return fail("{}: the box of past instance '{}' is not finite", file(), one.name);
      }
      std::optional<VisitId> brought_by;
      if (one.visit != 0) brought_by = one.visit;
      ROOMWISE_CHECK_OK(database_.run(
          "INSERT INTO past_instances (" ROOMWISE_INSTANCE_COLUMNS
          ", reason, first_seen_ns, last_seen_ns, noticed_by, brought_by) VALUES "
          "(?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
          one.name, one.probability, one.observations, one.expected, one.keyframe_id,
          to_numbers(one.picture_box), to_numbers(one.box_keyframe.world_from_box),
          to_numbers(one.box_keyframe.size_m), to_numbers(one.sigma_m), to_text(past.reason),
          past.first_seen_ns, past.last_seen_ns, visit, brought_by));
    }
    if (!changes.pictures) return {};
    std::vector<VisitPicture> pictures = *changes.pictures;
    for (VisitPicture& picture : pictures) {
      if (picture.visit == 0) picture.visit = visit;
    }
    return replace_visit_pictures(pictures);
  }));
  return visit;
}

Expected<void> Home::replace_visit_pictures(std::span<const VisitPicture> pictures) {
  return atomically([&]() -> Expected<void> {
    ROOMWISE_CHECK_OK(database_.run("DELETE FROM visit_pictures"));
    for (const VisitPicture& one : pictures) {
      ROOMWISE_CHECK_OK(database_.run(
          "INSERT INTO visit_pictures (visit_id, keyframe_id, timestamp_ns, picture_digest, room, "
          "network_fingerprint, features) VALUES (?, ?, ?, ?, ?, ?, ?)",
          one.visit, one.keyframe, one.timestamp_ns, one.picture_digest, one.room,
          one.network_fingerprint, to_blob(one.features)));
    }
    return {};
  });
}

Expected<std::vector<VisitPicture>> Home::visit_pictures() const {
  std::vector<VisitPicture> pictures;
  // An older home that is open for reading only has no such table.
  ROOMWISE_TRY(const int version, database_.get<int>("PRAGMA user_version"));
  if (version < kVisitPicturesVersion) return pictures;
  ROOMWISE_CHECK_OK(database_.for_each(
      "SELECT visit_id, keyframe_id, timestamp_ns, picture_digest, room, network_fingerprint, "
      "features FROM visit_pictures ORDER BY picture_id",
      [&](const Statement& row) {
        pictures.push_back({row.column<VisitId>(0), row.column<KeyframeId>(1),
                            row.column<TimestampNs>(2), row.column<std::string>(3),
                            row.column<std::string>(4), row.column<std::string>(5),
                            to_floats(row.column<Bytes>(6))});
      }));
  return pictures;
}

Expected<std::map<VisitId, Visit>> Home::visits() const {
  std::map<VisitId, Visit> visits;
  ROOMWISE_TRY(const bool has, has_visits(database_));
  if (!has) return visits;
  ROOMWISE_CHECK_OK(database_.for_each(
      "SELECT visit_id, name, folder, first_timestamp_ns, last_timestamp_ns, frames, placed "
      "FROM visits",
      [&](const Statement& row) {
        visits[row.column<VisitId>(0)] = {.name = row.column<std::string>(1),
                                          .folder = row.column<std::string>(2),
                                          .first_timestamp_ns = row.column<TimestampNs>(3),
                                          .last_timestamp_ns = row.column<TimestampNs>(4),
                                          .frames = row.column<std::uint64_t>(5),
                                          .placed = row.column<std::uint64_t>(6)};
      }));
  return visits;
}

Expected<std::vector<PastInstance>> Home::past_instances() const {
  std::vector<PastInstance> past;
  ROOMWISE_TRY(const bool has, has_visits(database_));
  if (!has) return past;
  ROOMWISE_CHECK_OK(database_.for_each(
      "SELECT " ROOMWISE_INSTANCE_COLUMNS
      ", reason, first_seen_ns, last_seen_ns, noticed_by, brought_by FROM past_instances "
      "ORDER BY past_id",
      [&](const Statement& row) -> Expected<void> {
        PastInstance& one = past.emplace_back();
        one.instance = read_instance(row, 0);
        if (!is_finite(one.instance)) {
          return fail(
              "{}: is damaged: the box of past instance '{}' is not finite; put back a copy of it",
              file(), one.instance.name);
        }
        const int next = kInstanceColumns;
        one.reason =
            row.column<std::string>(next) == "gone" ? PastReason::kRemoved : PastReason::kMoved;
        one.first_seen_ns = row.column<TimestampNs>(next + 1);
        one.last_seen_ns = row.column<TimestampNs>(next + 2);
        one.noticed_by = row.column<VisitId>(next + 3);
        one.instance.visit = row.column<std::optional<VisitId>>(next + 4).value_or(0);
        return {};
      }));
  return past;
}

}  // namespace roomwise::home
