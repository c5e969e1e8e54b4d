#pragma once

#include <vector>

#include "roomwise/base/thread_pool.h"
#include "roomwise/rooms/recognition/room_retrieval.h"

namespace roomwise::rooms {

// Pictures and their variants, as RoomGallery takes them.
struct RetrievalSamples {
  Eigen::MatrixXf rows;      // root features, one a row: each picture, followed by its variants
  std::vector<int> room;     // of each row
  std::vector<int> picture;  // of each row, from 0 without gaps
  std::vector<int> fold;     // of each row: the round in which it is held out
};

struct LearnedRetrieval {
  RoomRetrieval retrieval;
  std::vector<std::size_t> correct;  // of each room: pictures named rightly while held out
  std::size_t held_out = 0;          // pictures tested so
};

// Remembers all pictures. In each round the pictures of one fold are compared with those of the
// others alone; how similar they are is what the calibration is found from. Variants are remembered
// and not tested. Every fold must leave pictures of every room. The same bits at any number of
// threads of `pool`.
[[nodiscard]] LearnedRetrieval learn_retrieval(const RetrievalSamples& samples, int rooms,
                                               int folds, ThreadPool& pool);

}  // namespace roomwise::rooms
