#pragma once

#include <string>
#include <vector>

#include "roomwise/rooms/recognition/room_decision.h"
#include "roomwise/rooms/recognition/room_filter.h"

namespace roomwise::rooms {

// Says the room picture by picture while a person walks: what RoomFilter believes, and whether the
// last seconds' pictures are familiar at all.
class RoomStream {
 public:
  RoomStream(const RoomTopology& topology, const RoomModel& model,
             const RoomFilterOptions& options = {})
      : filter_(topology, options), model_(model) {}

  // A picture, taken `elapsed_s` after the one before. Its probabilities are in the order of the
  // topology's rooms.
  [[nodiscard]] RoomDecision update(const PictureEvidence& picture, double elapsed_s);

 private:
  RoomFilter filter_;
  RoomModel model_;
  double familiarity_ = 0;
  bool has_seen_ = false;
};

}  // namespace roomwise::rooms
