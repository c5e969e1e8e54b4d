#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/base/thread_pool.h"
#include "roomwise/rooms/recognition/room_classifier.h"

namespace roomwise::rooms {

// A picture of a known room.
struct RoomSample {
  std::vector<float> features;  // as the network gives them
  std::string room;
  // The walk it was taken on, and which stay in the room on that. The samples of one room, walk
  // and stay stand in the order of time: neighbours show nearly the same.
  std::uint64_t walk = 0;
  std::uint64_t stay = 0;
  // The same of varied pictures of it (network/augmentation.h). They are learned from beside the
  // picture, and held out with it; the held-out test looks at the picture itself alone.
  std::vector<std::vector<float>> variants = {};
};

struct LearningOptions {
  // Rounds of the held-out test: each holds out another 1/folds of every room.
  int folds = 5;
  // The weight decays that the held-out test chooses from (SoftmaxOptions::weight_decay).
  std::vector<double> weight_decays = {3e-5, 1e-4, 3e-4, 1e-3};
  std::size_t min_pictures = 5;           // a room with fewer is an error
  std::size_t comfortable_pictures = 20;  // a room with fewer gives a warning

  [[nodiscard]] Expected<void> validate() const;
};

struct LearningReport {
  struct RoomCount {
    std::string room;
    std::size_t pictures = 0;
    // Of its pictures, each held out once: named rightly by the nearest
    // neighbours, and by the paper's regression.
    std::size_t held_out_correct = 0;
    std::size_t paper_held_out_correct = 0;

    friend bool operator==(const RoomCount&, const RoomCount&) = default;
  };
  std::vector<RoomCount> rooms;      // by name
  std::size_t held_out = 0;          // pictures tested while held out
  std::size_t held_out_correct = 0;  // by the nearest neighbours
  double paper_held_out_precision = 0;
  double weight_decay = 0;  // the chosen one of the paper's regression
  RoomCalibration calibration;
  double min_probability = 0;  // from which on a room is named (RoomModel)

  [[nodiscard]] double held_out_precision() const {
    return held_out == 0 ? 0
                         : static_cast<double>(held_out_correct) / static_cast<double>(held_out);
  }
  std::vector<std::string> warnings;
};

struct LearnedRooms {
  RoomClassifier classifier;
  LearningReport report;
};

// Learns to tell the rooms of a home apart, in both ways of RoomClassifier. Rooms weigh the same
// however many pictures each has.
//
// The held-out test: of a room that several walks show, each round holds out the pictures of other
// walks, so that it knows what another day looks like, where enough are left without them. Else the
// pictures of a stay in a room are cut into `folds` blocks that follow each other, and in each
// round one block of every room is held out (not single pictures, whose neighbours on the walk are
// nearly the same and would make the test too easy). Of the weight decays whose precision on what
// was held out is within one standard error of the best, the strongest is chosen, and the
// classifier then learns from every picture. In the same rounds held-out pictures are compared with
// the others: what their similarity means, and from where on an answer is given, is found from that
// (retrieval_learner.h).
//
// Rooms are sorted by name, so that the order of the samples' rooms does not count. Fails where
// there are fewer than two rooms, a room has fewer than min_pictures, or features differ in
// number or are not finite. The same bits at any number of threads of `pool`, which may be absent.
[[nodiscard]] Expected<LearnedRooms> learn_rooms(std::span<const RoomSample> samples,
                                                 const NetworkIdentity& network,
                                                 const LearningOptions& options = {},
                                                 ThreadPool* pool = nullptr);

}  // namespace roomwise::rooms
