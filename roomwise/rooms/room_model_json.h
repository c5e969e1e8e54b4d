#pragma once

#include <string_view>

namespace roomwise::rooms {

// recognition/room_model.json, compiled in so that a program knows it wherever it stands.
extern const std::string_view kRoomModelJson;

}  // namespace roomwise::rooms
