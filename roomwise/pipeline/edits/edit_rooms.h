#pragma once

#include <Eigen/Core>
#include <array>
#include <set>
#include <string>
#include <vector>

#include "roomwise/home/home.h"
#include "roomwise/pipeline/edits/edit_things.h"
#include "roomwise/pipeline/mapping/home_floor.h"

// What people change of rooms. Each is kept as a row of its own and can be undone (undo_edit.h).
// All fail, changing nothing, where a name cannot be one of a room, or the change would change
// nothing. Points are on the plan (fusion/storeys.h), m.
namespace roomwise::pipeline {

// A room goes on with its type, what was learned of it and what was said of it.
[[nodiscard]] Expected<home::EditId> rename_room(home::Home& home, const EditAuthor& author,
                                                 const std::string& room,
                                                 const std::string& new_name);
// Any word is a type.
[[nodiscard]] Expected<home::EditId> set_room_type(home::Home& home, const EditAuthor& author,
                                                   const std::string& room,
                                                   const std::string& type);
// Counts the stays in each room, in the order of frames.
void number_stays(std::vector<recording::RoomRange>& ranges);
// Names the rooms of a walk's frames, as name_rooms() does. A room whose frames are all called
// otherwise now, by one new name, is renamed; one that is left without frames goes from the list,
// but for those to `keep`. Where a walk was named alike before, nothing is changed.
[[nodiscard]] Expected<void> name_frames(home::Home& home, const EditAuthor& author,
                                         home::RecordingId walk,
                                         const recording::RoomLabels& labels,
                                         const std::set<std::string>& keep = {});
// What was learned of it stays until the rooms are learned anew or forget_removed_rooms(), but
// nothing is recognised by it.
[[nodiscard]] Expected<home::EditId> remove_room(home::Home& home, const EditAuthor& author,
                                                 const std::string& room);
// The second is the first's from now on. The rooms must be learned anew.
[[nodiscard]] Expected<home::EditId> join_rooms(home::Home& home, const EditAuthor& author,
                                                const std::string& kept, const std::string& joined);

// A line on the floor, from where one looks along it.
struct FloorLine {
  Eigen::Vector2d from_plan = Eigen::Vector2d::Zero(), to_plan = Eigen::Vector2d::Zero();
};

// Of the room's floor, and of the frames taken on it, what lies left of the line is `new_room`'s.
// Fails where nothing of its floor lies left of it, or everything.
[[nodiscard]] Expected<home::EditId> divide_room(home::Home& home, const EditAuthor& author,
                                                 const HomeFloor& floor, const std::string& room,
                                                 const FloorLine& line,
                                                 const std::string& new_room);
// Of the floor of both rooms, what lies left of the line is `left`'s, the rest `right`'s. Fails
// where one of them is left without floor, or no floor changes hands.
[[nodiscard]] Expected<home::EditId> move_border(home::Home& home, const EditAuthor& author,
                                                 const HomeFloor& floor, const std::string& left,
                                                 const std::string& right, const FloorLine& line);
// The floor inside the outline, three corners or more, is the room's, which may be new. Fails where
// it holds no floor of another room.
[[nodiscard]] Expected<home::EditId> draw_room(home::Home& home, const EditAuthor& author,
                                               const HomeFloor& floor, const std::string& room,
                                               const std::vector<Eigen::Vector2d>& outline_plan);
// One gets from one room to the other there.
[[nodiscard]] Expected<home::EditId> add_door(home::Home& home, const EditAuthor& author,
                                              const HomeFloor& floor,
                                              const std::array<std::string, 2>& rooms,
                                              const Eigen::Vector2d& middle_plan);

}  // namespace roomwise::pipeline
