#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "command.h"
#include "roomwise/pipeline/objects/home_things.h"
#include "roomwise/pipeline/rooms/home_layout.h"
#include "roomwise/pipeline/stored/stored_rooms.h"

namespace roomwise::app {

// What the home says about where its things stand.
struct ThingPlaces {
  std::map<home::KeyframeId, home::Keyframe> keyframes;
  std::map<home::KeyframeId, std::vector<rooms::RoomScore>> rooms;
  pipeline::KeyframeRooms named_rooms;
  std::optional<pipeline::HomeLayout> layout;  // where the rooms lie, where that is known

  [[nodiscard]] static Expected<ThingPlaces> read(const home::Home& home);
  // A home whose pictures are protected may not tell it, which is noted; its things are told all
  // the same.
  [[nodiscard]] Expected<void> find_layout(const home::Home& home, Context& context);

  // By what was recognised in that key-frame; empty: not known.
  [[nodiscard]] std::string room_of(home::KeyframeId keyframe) const;
  // That it stands in, as exports have it; else that from which it is seen best.
  [[nodiscard]] std::string room_of(const pipeline::HomeThing& thing) const;
};

}  // namespace roomwise::app
