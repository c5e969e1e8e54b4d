#pragma once

#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/home/home.h"

// What people changed by hand, as values. A home keeps each change as a row (home::Edit) beside
// what programs find: those of things and borders are laid over what is found whenever it is read
// (find_home_things(), find_room_layout()), so that nothing overwrites them; those of names of
// rooms are what the home's own tables say, and the row has what stood there before.
namespace roomwise::pipeline {

enum class EditKind {
  // Of things.
  kAddThing,
  kRenameThing,
  kNote,
  kMoveThing,
  kMergeThings,
  kRemoveThing,
  // Of rooms.
  kRenameRoom,
  kRoomType,
  kNameFrames,
  kRemoveRoom,
  kTakeWalk,  // a walk is not shown any more, and forgotten when the home is closed
  kJoinRooms,
  kDivideRoom,
  kMoveBorder,
  kDrawRoom,
  kAddDoor,
};
// As home::Edit::what: "add thing", "rename thing", ...
[[nodiscard]] std::string_view to_string(EditKind kind);
[[nodiscard]] bool is_of_thing(EditKind kind);
[[nodiscard]] bool is_of_room(EditKind kind);

// As home::Edit::what of places that people mark (edits/marked_spots.h): kept with the changes,
// and none of them.
inline constexpr std::string_view kSpotRow = "spot";

// Of a kind those members that it needs; the others are empty.
struct EditChange {
  std::string name = {};  // a thing's new name; what it was called before is `old_name`
  std::string old_name = {};
  std::string note = {};        // empty: there is none any more
  std::string room = {};        // that is changed, added or moved to
  std::string other_room = {};  // beside it: joined to it, cut off it, on the border's other side
  std::string type = {};        // of the room, from now on
  // Things that people added, by the change that did; others are known by their place.
  std::optional<home::EditId> thing = std::nullopt, double_of = std::nullopt;
  std::optional<home::RecordingId> walk = std::nullopt;  // that is taken away
};

// A row of the home, read.
struct StoredEdit {
  home::EditId id = 0;
  std::int64_t made_s = 0;
  std::string made_by = {};
  EditKind kind = EditKind::kNote;
  EditChange change = {};
  std::vector<home::EditPlace> places = {};
  std::string before = "{}";

  [[nodiscard]] home::Edit row() const;
};

// As they were made, without spots. Fails where one is damaged, or another version of Roomwise made
// it.
[[nodiscard]] Expected<std::vector<StoredEdit>> stored_edits(const home::Home& home);

// Walks that are taken away. `edits`: of the home.
[[nodiscard]] std::set<home::RecordingId> walks_taken_away(std::span<const StoredEdit> edits);
// The home's walks but those: what is shown, written for others and learned from.
[[nodiscard]] Expected<std::vector<home::StoredRecording>> walks_that_stay(const home::Home& home);

// Of a change of rooms, as StoredEdit::before: which frames were in which room before it, of the
// walks where it changed that.
[[nodiscard]] Expected<std::map<home::RecordingId, std::vector<recording::RoomRange>>>
ranges_before(const std::string& before);

// Calls a change's rooms as changes after it do: those that renamed or joined them.
void apply_later_room_names(std::span<const StoredEdit> later, EditChange& change);

// Fails, saying why, where a name is empty or too long, or has signs that nobody can speak.
[[nodiscard]] Expected<void> validate_spoken_name(std::string_view name);
[[nodiscard]] Expected<void> validate_note(std::string_view note);

// Where a thing is, as programs found it.
[[nodiscard]] home::EditPlace place_of(const objects::Instance& found);
// The same for a box in the world of a component of the map: it hangs on the key-frame that is
// nearest to its middle. Fails where the component has none.
[[nodiscard]] Expected<home::EditPlace> place_in(std::span<const home::Keyframe> keyframes,
                                                 std::uint64_t component,
                                                 const geometry::OrientedBox& box_world);
// Where that is in the world of its component now; absent where its walk was forgotten. `keyframes`
// of the home, which lie by id.
[[nodiscard]] std::optional<geometry::OrientedBox> box_world(
    const home::EditPlace& place, std::span<const home::Keyframe> keyframes);

// Before a walk is taken out of the home: hangs places that hang on its key-frames on others of the
// same component; where there are none they lose their place. The walk's name, and the rooms' names
// that its frames had before, go from changes, too.
[[nodiscard]] Expected<void> take_edits_off(home::Home& home, home::RecordingId walk);

}  // namespace roomwise::pipeline
