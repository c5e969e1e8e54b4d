// The part of Home that stores later visits and what they found changed.

#include "roomwise/home/home.h"
#include "roomwise/home/stored_instances.h"
#include "roomwise/home/stored_values.h"

namespace roomwise::home {
namespace {

std::string to_text(PastReason reason) {
  return reason == PastReason::kRemoved ? "removed" : "moved";
}

}  // namespace

Expected<VisitId> Home::apply_changes(const HomeChanges& changes) {
  VisitId visit = 0;
  ROOMWISE_RETURN_IF_ERROR(atomically([&]() -> Expected<void> {
    const Visit& v = changes.visit;
    ROOMWISE_TRY(
        visit,
        database_.insert(
            "visits (name, folder, first_timestamp_ns, last_timestamp_ns, frames, placed)", v.name,
            v.folder, v.first_timestamp_ns, v.last_timestamp_ns, v.frames, v.placed));
    std::vector<objects::Instance> instances = changes.kept;
    for (const objects::Instance& one : changes.arrived) {
      instances.push_back(one);
      instances.back().visit = visit;
    }
    ROOMWISE_RETURN_IF_ERROR(replace_instances(instances));
    for (const PastInstance& past : changes.past) {
      const objects::Instance& one = past.instance;
      if (!is_finite(one)) {
        return fail("{}: the box of past instance '{}' is not finite", file(), one.name);
      }
      ROOMWISE_RETURN_IF_ERROR(database_.add("past_instances (" ROOMWISE_INSTANCE_COLUMNS
                                             ", reason, first_seen_ns, last_seen_ns, noticed_by)",
                                             instance_columns(one), to_text(past.reason),
                                             past.first_seen_ns, past.last_seen_ns, visit));
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
    ROOMWISE_RETURN_IF_ERROR(database_.run("DELETE FROM visit_pictures"));
    for (const VisitPicture& one : pictures) {
      ROOMWISE_RETURN_IF_ERROR(
          database_.add("visit_pictures (visit_id, keyframe_id, timestamp_ns, picture_digest, "
                        "room, network_fingerprint, features)",
                        one.visit, one.keyframe, one.timestamp_ns, one.picture_digest, one.room,
                        one.network_fingerprint, to_blob(one.features)));
    }
    return {};
  });
}

Expected<std::vector<VisitPicture>> Home::visit_pictures() const {
  return collect<std::vector<VisitPicture>>(
      database_,
      "SELECT visit_id, keyframe_id, timestamp_ns, picture_digest, room, network_fingerprint, "
      "features FROM visit_pictures ORDER BY picture_id",
      [](const Statement& row) {
        return VisitPicture{row.column<VisitId>(0),         row.column<KeyframeId>(1),
                            row.column<TimestampNs>(2),     row.column<std::string>(3),
                            row.column<std::string>(4),     row.column<std::string>(5),
                            to_floats(row.column<Bytes>(6))};
      });
}

Expected<std::map<VisitId, Visit>> Home::visits() const {
  return collect<std::map<VisitId, Visit>>(
      database_,
      "SELECT visit_id, name, folder, first_timestamp_ns, last_timestamp_ns, frames, placed "
      "FROM visits",
      [](const Statement& row) {
        return std::pair(row.column<VisitId>(0),
                         Visit{.name = row.column<std::string>(1),
                               .folder = row.column<std::string>(2),
                               .first_timestamp_ns = row.column<TimestampNs>(3),
                               .last_timestamp_ns = row.column<TimestampNs>(4),
                               .frames = row.column<std::uint64_t>(5),
                               .placed = row.column<std::uint64_t>(6)});
      });
}

Expected<std::vector<PastInstance>> Home::past_instances() const {
  return collect<std::vector<PastInstance>>(
      database_,
      "SELECT " ROOMWISE_INSTANCE_COLUMNS
      ", reason, first_seen_ns, last_seen_ns, noticed_by FROM past_instances ORDER BY past_id",
      [&](const Statement& row) -> Expected<PastInstance> {
        objects::Instance instance = read_instance(row, 0);
        if (!is_finite(instance)) {
          return fail(
              "{}: is damaged: the box of past instance '{}' is not finite; put back a copy of it",
              file(), instance.name);
        }
        constexpr int kNext = kInstanceColumns;
        return PastInstance{.instance = std::move(instance),
                            .reason = row.column<std::string>(kNext) == "removed"
                                          ? PastReason::kRemoved
                                          : PastReason::kMoved,
                            .first_seen_ns = row.column<TimestampNs>(kNext + 1),
                            .last_seen_ns = row.column<TimestampNs>(kNext + 2),
                            .noticed_by = row.column<VisitId>(kNext + 3)};
      });
}

}  // namespace roomwise::home
