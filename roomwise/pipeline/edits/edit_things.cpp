#include "roomwise/pipeline/edits/edit_things.h"

#include <algorithm>

#include "roomwise/objects/kinds/kinds.h"

namespace roomwise::pipeline {
namespace {

// Fails where it is not among the home's things any more, since somebody else changed it meanwhile.
Expected<void> check_is_there(const home::Home& home, const HomeThing& thing) {
  ROOMWISE_TRY(const HomeThings now, find_home_things(home));
  const bool is_there = std::ranges::any_of(now.things, [&](const HomeThing& one) {
    return one.added_by_edit == thing.added_by_edit && one.name == thing.name &&
           one.visit == thing.visit && one.keyframe_id == thing.keyframe_id &&
           one.picture_box.left == thing.picture_box.left &&
           one.picture_box.top == thing.picture_box.top &&
           one.box_keyframe.center() == thing.box_keyframe.center();
  });
  if (is_there) return {};
  return fail("the home has no such {} any more; look at it anew", thing.name);
}

// What a change about a thing begins with.
StoredEdit edit_of(EditKind kind, const EditAuthor& author, const HomeThing& thing) {
  StoredEdit edit{.made_s = author.time_s, .made_by = author.name, .kind = kind};
  edit.change.old_name = thing.name;
  edit.places.push_back(place_of(thing));
  edit.places.back().name = thing.found_as;
  if (thing.added_by_edit != 0) edit.change.thing = thing.added_by_edit;
  return edit;
}

Expected<home::EditPlace> place_for(const home::Home& home, const ThingTarget& where,
                                    const Eigen::Vector3d& size_m) {
  if (!where.middle_world.allFinite()) return fail("the place is not made of finite numbers");
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  return place_in(keyframes, 0, {{Eigen::Quaterniond::Identity(), where.middle_world}, size_m});
}

}  // namespace

Expected<home::EditId> add_thing(home::Home& home, const EditAuthor& author,
                                 const std::string& name, const ThingTarget& where,
                                 const std::string& note) {
  ROOMWISE_RETURN_IF_ERROR(validate_spoken_name(name));
  ROOMWISE_RETURN_IF_ERROR(validate_note(note));
  StoredEdit edit{.made_s = author.time_s, .made_by = author.name, .kind = EditKind::kAddThing};
  edit.change.name = name;
  edit.change.note = note;
  edit.change.room = where.room;
  ROOMWISE_TRY(home::EditPlace place, place_for(home, where, objects::usual_size_m(name)));
  edit.places.push_back(std::move(place));
  return home.add_edit(edit.row());
}

Expected<home::EditId> rename_thing(home::Home& home, const EditAuthor& author,
                                    const HomeThing& thing, const std::string& name) {
  ROOMWISE_RETURN_IF_ERROR(validate_spoken_name(name));
  ROOMWISE_RETURN_IF_ERROR(check_is_there(home, thing));
  // The same name again says that it is one for certain.
  if (thing.name == name && thing.is_confirmed) return fail("it is called '{}' already", name);
  StoredEdit edit = edit_of(EditKind::kRenameThing, author, thing);
  edit.change.name = name;
  return home.add_edit(edit.row());
}

Expected<home::EditId> note_thing(home::Home& home, const EditAuthor& author,
                                  const HomeThing& thing, const std::string& note) {
  ROOMWISE_RETURN_IF_ERROR(validate_note(note));
  ROOMWISE_RETURN_IF_ERROR(check_is_there(home, thing));
  if (thing.note == note) {
    return note.empty() ? fail("the {} has no note to take away", thing.name)
                        : fail("the {} has this note already", thing.name);
  }
  StoredEdit edit = edit_of(EditKind::kNote, author, thing);
  edit.change.note = note;
  return home.add_edit(edit.row());
}

Expected<home::EditId> move_thing(home::Home& home, const EditAuthor& author,
                                  const HomeThing& thing, const ThingTarget& where) {
  ROOMWISE_RETURN_IF_ERROR(check_is_there(home, thing));
  StoredEdit edit = edit_of(EditKind::kMoveThing, author, thing);
  ROOMWISE_TRY(home::EditPlace place, place_for(home, where, thing.box_keyframe.size_m));
  // It stands as it stood: turned alike.
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  const auto& from = keyframes[thing.keyframe_id].pose.world_from_keyframe.rotation;
  const auto& to = keyframes[*place.keyframe].pose.world_from_keyframe.rotation;
  place.box_keyframe.world_from_box.rotation =
      to.conjugate() * from * thing.box_keyframe.world_from_box.rotation;
  edit.places.push_back(std::move(place));
  edit.change.room = where.room;
  return home.add_edit(edit.row());
}

Expected<home::EditId> merge_things(home::Home& home, const EditAuthor& author,
                                    const HomeThing& kept, const HomeThing& twin) {
  ROOMWISE_RETURN_IF_ERROR(check_is_there(home, kept));
  ROOMWISE_RETURN_IF_ERROR(check_is_there(home, twin));
  StoredEdit edit = edit_of(EditKind::kMergeThings, author, kept);
  const StoredEdit other = edit_of(EditKind::kMergeThings, author, twin);
  const bool is_same = kept.added_by_edit == twin.added_by_edit &&
                       kept.keyframe_id == twin.keyframe_id &&
                       kept.box_keyframe.center() == twin.box_keyframe.center();
  if (is_same) return fail("the {} cannot be its own double", kept.name);
  edit.change.name = twin.name;
  edit.change.double_of = other.change.thing;
  edit.places.push_back(other.places[0]);
  return home.add_edit(edit.row());
}

Expected<home::EditId> remove_thing(home::Home& home, const EditAuthor& author,
                                    const HomeThing& thing) {
  ROOMWISE_RETURN_IF_ERROR(check_is_there(home, thing));
  return home.add_edit(edit_of(EditKind::kRemoveThing, author, thing).row());
}

}  // namespace roomwise::pipeline
