#include "roomwise/rooms/learning/retrieval_learner.h"

namespace roomwise::rooms {
namespace {

// Of what is not in `fold`.
RoomGallery memory_without(const RetrievalSamples& samples, int rooms, int fold) {
  std::vector<Eigen::Index> rows;
  std::vector<int> room;
  std::vector<int> picture;
  int last = -1;
  int pictures = 0;
  for (std::size_t i = 0; i < samples.room.size(); ++i) {
    if (samples.fold[i] == fold) continue;
    if (samples.picture[i] != last) ++pictures;
    last = samples.picture[i];
    rows.push_back(static_cast<Eigen::Index>(i));
    room.push_back(samples.room[i]);
    picture.push_back(pictures - 1);
  }
  return RoomGallery(samples.rows(rows, Eigen::all), std::move(room), std::move(picture), rooms);
}

// The pictures of a fold, compared with those of the others.
std::vector<HeldOutPicture> test_fold(const RetrievalSamples& samples, int rooms, int fold) {
  const RoomGallery memory = memory_without(samples, rooms, fold);
  std::vector<HeldOutPicture> tested;
  for (std::size_t i = 0; i < samples.room.size(); ++i) {
    const bool is_variant = i > 0 && samples.picture[i] == samples.picture[i - 1];
    if (samples.fold[i] != fold || is_variant) continue;
    tested.push_back(
        {memory.compare(samples.rows.row(static_cast<Eigen::Index>(i))), samples.room[i]});
  }
  return tested;
}

}  // namespace

LearnedRetrieval learn_retrieval(const RetrievalSamples& samples, int rooms, int folds,
                                 ThreadPool& pool) {
  std::vector<std::vector<HeldOutPicture>> of_fold(static_cast<std::size_t>(folds));
  pool.parallel_for(of_fold.size(), [&](std::size_t fold) {
    of_fold[fold] = test_fold(samples, rooms, static_cast<int>(fold));
  });
  std::vector<HeldOutPicture> held_out;
  for (const auto& pictures : of_fold) {
    held_out.insert(held_out.end(), pictures.begin(), pictures.end());
  }

  LearnedRetrieval learned;
  learned.retrieval.gallery = RoomGallery(samples.rows, samples.room, samples.picture, rooms);
  learned.retrieval.calibration = calibrate(held_out);
  learned.held_out = held_out.size();
  learned.correct.assign(static_cast<std::size_t>(rooms), 0);
  for (const HeldOutPicture& picture : held_out) {
    Eigen::Index best = 0;
    picture.similarity.of_rooms.maxCoeff(&best);
    if (best == picture.room) ++learned.correct[static_cast<std::size_t>(best)];
  }
  return learned;
}

}  // namespace roomwise::rooms
