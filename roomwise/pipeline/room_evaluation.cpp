#include "roomwise/pipeline/room_evaluation.h"

#include <algorithm>

#include "roomwise/image/codec.h"
#include "roomwise/pipeline/predict_pictures.h"
#include "roomwise/pipeline/room_learning.h"

namespace roomwise::pipeline {
namespace {

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

bool is_learned(const std::string& room, const std::vector<std::string>& learned) {
  return std::ranges::count(learned, room) > 0;
}

Expected<void> check_not_empty(const std::vector<LabelledPicture>& pictures) {
  if (pictures.empty())
    return fail("no picture is left to evaluate: check --rooms, --visits and --margin");
  return {};
}

struct Pair {
  std::size_t first = 0;
  std::size_t second = 0;
};

std::vector<Pair> pairs_of(const std::vector<LabelledPicture>& pictures, std::size_t step) {
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i + step < pictures.size(); ++i) {
    if (pictures[i].sequence == pictures[i + step].sequence) pairs.push_back({i, i + step});
  }
  return pairs;
}

}  // namespace

Expected<std::vector<LabelledPicture>> select_frames(const recording::ImageList& colors,
                                                     const recording::RoomLabels& labels,
                                                     const FrameSelection& selection,
                                                     const std::vector<std::string>& learned) {
  ROOMWISE_CHECK_OK(selection.rooms.check_against(labels));
  for (const std::string& room : selection.rooms.rooms) {
    if (!is_learned(room, learned)) return fail("the room '{}' was never learned", room);
  }
  std::vector<LabelledPicture> pictures;
  for (std::size_t r = 0; r < labels.ranges().size(); ++r) {
    const recording::RoomRange& range = labels.ranges()[r];
    if (!selection.rooms.contains(range) || !is_learned(range.room, learned)) continue;
    if (range.last_frame >= colors.size()) {
      return fail(
          "the labels name frame {}, but the recording has {} colour images; are they of another "
          "recording?",
          range.last_frame, colors.size());
    }
    for (std::uint64_t frame = range.first_frame; frame <= range.last_frame; ++frame) {
      if (labels.frames_to_boundary(frame) < selection.margin) continue;
      pictures.push_back({[&colors, frame] { return colors.read_color(frame); }, range.room, r});
    }
  }
  ROOMWISE_CHECK_OK(check_not_empty(pictures));
  return pictures;
}

Expected<std::vector<LabelledPicture>> select_photos(const std::filesystem::path& folder,
                                                     const std::vector<std::string>& learned) {
  ROOMWISE_TRY(const std::vector<RoomPhoto> photos, list_room_photos(folder));
  std::vector<LabelledPicture> pictures;
  for (const RoomPhoto& photo : photos) {
    if (!is_learned(photo.room, learned)) continue;
    const bool same_room = !pictures.empty() && pictures.back().room == photo.room;
    const std::size_t sequence =
        pictures.empty() ? 0 : pictures.back().sequence + (same_room ? 0 : 1);
    pictures.push_back(
        {[path = photo.path] { return image::read_color(path); }, photo.room, sequence});
  }
  ROOMWISE_CHECK_OK(check_not_empty(pictures));
  return pictures;
}

Expected<RoomEvaluation> evaluate_rooms(const std::vector<LabelledPicture>& pictures,
                                        const RoomRecognizer& recognizer, std::size_t pair_step,
                                        RunContext& run) {
  if (pair_step == 0) return fail("the two pictures of a pair must be at least 1 apart");
  const auto read = [&](std::size_t i) { return pictures[i].read(); };
  ROOMWISE_TRY(const auto seen, predict_pictures(pictures.size(), read, recognizer.features(),
                                                 "recognising rooms", run));
  std::vector<rooms::RoomScore> best;
  for (const TimedPrediction& one : seen) {
    ROOMWISE_TRY(const auto scores, recognizer.scores(one.prediction));
    best.push_back(scores.front());
  }

  RoomEvaluation result;
  std::vector<double> single_ms;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    result.single.confusion.add(pictures[i].room, best[i].room);
    ++result.single.reasons[std::string(to_string(rooms::Reason::kSingleFrame))];
    single_ms.push_back(seen[i].ms);
  }
  result.single.median_ms = median(single_ms);

  // Objects are looked for only where the two pictures differ.
  const std::vector<Pair> pairs = pairs_of(pictures, pair_step);
  std::vector<std::size_t> wanted;
  for (const Pair& pair : pairs) {
    if (best[pair.first].room != best[pair.second].room) wanted.push_back(pair.second);
  }
  std::map<std::size_t, TimedPrediction> named;
  if (recognizer.naming() != nullptr && !wanted.empty()) {
    ROOMWISE_TRY(const auto predictions,
                 predict_pictures(
                     wanted.size(), [&](std::size_t i) { return pictures[wanted[i]].read(); },
                     *recognizer.naming(), "looking for objects", run));
    for (std::size_t i = 0; i < wanted.size(); ++i) named[wanted[i]] = predictions[i];
  }
  std::vector<double> pair_ms;
  for (const Pair& pair : pairs) {
    double ms = seen[pair.first].ms + seen[pair.second].ms;
    const auto see_names = [&]() -> Expected<network::Prediction> {
      ms += named.at(pair.second).ms;
      return named.at(pair.second).prediction;
    };
    ROOMWISE_TRY(const rooms::RoomAnswer answer,
                 recognizer.decide(best[pair.first], best[pair.second], see_names));
    result.pair.confusion.add(pictures[pair.second].room, answer.room);
    ++result.pair.reasons[std::string(to_string(answer.reason))];
    pair_ms.push_back(ms);
  }
  result.pair.median_ms = median(pair_ms);
  return result;
}

}  // namespace roomwise::pipeline
