#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "roomwise/home/home.h"
#include "roomwise/pipeline/rooms/home_layout.h"
#include "roomwise/rooms/concepts/room_objects.h"
#include "roomwise/rooms/concepts/room_type.h"

// What stands in a home's rooms, and what that tells of them.
namespace roomwise::pipeline {

// By the key-frames that the rooms were learned from, and where there are none by all that show a
// named room: what a network that names things sees in them (its three best labels). With what was
// claimed. `naming_network`: its fingerprint, since the relations hold for what the same network
// says; absent: the newest that has looked at the home. Only what was claimed where it did not.
[[nodiscard]] Expected<rooms::RoomObjects> room_objects(
    const home::Home& home, const std::optional<std::string>& naming_network = {});

// What somebody said of objects and rooms, stored in the home.
[[nodiscard]] Expected<std::vector<rooms::ObjectClaim>> object_claims(const home::Home& home);
[[nodiscard]] Expected<void> store_object_claims(home::Home& home,
                                                 const std::vector<rooms::ObjectClaim>& claims);
// What was said of a room goes with it: to its new name, or away where there is none.
[[nodiscard]] Expected<void> move_object_claims(home::Home& home, const std::string& room,
                                                const std::optional<std::string>& new_name);

// The things of each named room (room_of_thing()). A room without any is there, too. `layout`:
// absent where it is not known where the rooms lie.
[[nodiscard]] Expected<std::map<std::string, rooms::RoomContents>> room_contents(
    const home::Home& home, const std::optional<HomeLayout>& layout);

// What type each room is by its things, the most probable first. The home's other rooms whose type
// the concepts know are examples.
[[nodiscard]] Expected<std::map<std::string, std::vector<rooms::TypePosterior>>>
classify_room_types(const home::Home& home, const std::optional<HomeLayout>& layout);

}  // namespace roomwise::pipeline
