// The part of Home that stores what people changed by hand.

#include "roomwise/home/home.h"
#include "roomwise/home/schema.h"
#include "roomwise/home/stored_instances.h"

namespace roomwise::home {
namespace {

bool is_finite(const EditPlace& place) {
  return place.box_keyframe.world_from_box.is_finite() && place.box_keyframe.size_m.allFinite();
}

Expected<void> insert_place(Database& database, EditId id, std::size_t number,
                            const EditPlace& place) {
  if (!is_finite(place)) {
    return fail("{}: place {} of a change is not finite", database.file(), number);
  }
  return database.add(
      "edit_places (edit_id, place, name, keyframe_id, left_px, top_px, right_px, bottom_px, tx_m, "
      "ty_m, tz_m, qx, qy, qz, qw, width_m, depth_m, height_m)",
      id, number, place.name, place.keyframe, to_numbers(place.picture_box),
      home::to_numbers(place.box_keyframe.world_from_box), to_numbers(place.box_keyframe.size_m));
}

}  // namespace

Expected<EditId> Home::add_edit(const Edit& edit) {
  EditId id = 0;
  ROOMWISE_RETURN_IF_ERROR(atomically([&]() -> Expected<void> {
    ROOMWISE_TRY(id, database_.insert("edits (made_s, made_by, what, change, before)", edit.made_s,
                                      edit.made_by, edit.what, edit.change, edit.before));
    for (std::size_t i = 0; i < edit.places.size(); ++i) {
      ROOMWISE_RETURN_IF_ERROR(insert_place(database_, id, i, edit.places[i]));
    }
    return {};
  }));
  return id;
}

Expected<std::vector<Edit>> Home::edits() const {
  ROOMWISE_TRY(const bool has_any, has_table(database_, "edit_places"));
  if (!has_any) return std::vector<Edit>{};
  ROOMWISE_TRY(auto edits, collect<std::vector<Edit>>(
                               database_,
                               "SELECT edit_id, made_s, made_by, what, change, before FROM edits "
                               "ORDER BY edit_id",
                               [](const Statement& row) {
                                 return Edit{.id = row.column<EditId>(0),
                                             .made_s = row.column<std::int64_t>(1),
                                             .made_by = row.column<std::string>(2),
                                             .what = row.column<std::string>(3),
                                             .change = row.column<std::string>(4),
                                             .before = row.column<std::string>(5),
                                             .places = {}};
                               }));
  for (Edit& edit : edits) {
    ROOMWISE_RETURN_IF_ERROR(database_.for_each(
        "SELECT name, keyframe_id, left_px, top_px, right_px, bottom_px, tx_m, ty_m, tz_m, qx, qy, "
        "qz, qw, width_m, depth_m, height_m FROM edit_places WHERE edit_id = ? ORDER BY place",
        [&](const Statement& row) -> Expected<void> {
          edit.places.push_back({row.column<std::string>(0),
                                 row.column<std::optional<KeyframeId>>(1),
                                 box_column(row, 2),
                                 {pose_column(row, 6), vector_column(row, 13)}});
          if (is_finite(edit.places.back())) return {};
          return fail("{}: is damaged: a place of change {} is not finite; put back a copy of it",
                      file(), edit.id);
        },
        edit.id));
  }
  return edits;
}

Expected<void> Home::remove_edit(EditId id) {
  ROOMWISE_RETURN_IF_ERROR(database_.run("DELETE FROM edits WHERE edit_id = ?", id));
  if (sqlite3_changes(database_.handle()) > 0) return {};
  return fail("{}: has no change {}", file(), id);
}

Expected<void> Home::replace_edit(const Edit& edit) {
  return atomically([&]() -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(
        database_.run("UPDATE edits SET change = ?, before = ? WHERE edit_id = ?", edit.change,
                      edit.before, edit.id));
    if (sqlite3_changes(database_.handle()) == 0) {
      return fail("{}: has no change {}", file(), edit.id);
    }
    ROOMWISE_RETURN_IF_ERROR(database_.run("DELETE FROM edit_places WHERE edit_id = ?", edit.id));
    for (std::size_t i = 0; i < edit.places.size(); ++i) {
      ROOMWISE_RETURN_IF_ERROR(insert_place(database_, edit.id, i, edit.places[i]));
    }
    return {};
  });
}

}  // namespace roomwise::home
