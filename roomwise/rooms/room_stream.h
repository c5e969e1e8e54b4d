#pragma once

#include <string>
#include <vector>

#include "roomwise/rooms/room_decision.h"
#include "roomwise/rooms/room_filter.h"

namespace roomwise::rooms {

// Says the room picture by picture while a person walks: what RoomFilter believes, and whether this
// is the home at all. That is believed in the same way: one is in one of the learned rooms, or
// elsewhere, and stays so for some minutes; a picture that shows only a bare wall does not take one
// out of the home in which one was a second ago, and one that looks like its hall not into it.
class RoomStream {
 public:
  RoomStream(const RoomTopology& topology, const RoomCalibration& calibration,
             const RoomFilterOptions& options = {})
      : filter_(topology, options), calibration_(calibration), options_(options) {}

  // A picture, taken `elapsed_s` after the one before. Its probabilities are in the order of the
  // topology's rooms. RoomDecision::known is as well as one picture would have to be known to say
  // as much as all so far.
  [[nodiscard]] RoomDecision see(const PictureEvidence& picture, double elapsed_s);

 private:
  void believe(const PictureEvidence& picture, double elapsed_s);

  RoomFilter filter_;
  RoomCalibration calibration_;
  RoomFilterOptions options_;
  // The logarithm of the odds that this is one of the learned rooms; 0 where a picture's would be
  // that is as well known as RoomCalibration::known_from.
  double log_odds_ = 0;
  bool has_seen_ = false;
};

}  // namespace roomwise::rooms
