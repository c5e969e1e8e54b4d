#include "roomwise/rooms/learning/room_learner.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <optional>

#include "roomwise/rooms/learning/retrieval_learner.h"

namespace roomwise::rooms {
namespace {

// Of the gradient in the held-out test, where only the highest probability counts.
constexpr double kHeldOutTolerance = 1e-4;

// The pictures and their variants as both ways of RoomClassifier take them.
struct TrainingSet {
  std::vector<std::string> rooms;     // by name; a label is an index of it
  Eigen::MatrixXf unit_length;        // one a row, as RetrievalSamples has them
  RetrievalSamples retrieval;         // with the label of each row, and the fold that holds it out
  std::vector<std::size_t> pictures;  // the rows that are no variants

  [[nodiscard]] int classes() const { return static_cast<int>(rooms.size()); }
  [[nodiscard]] std::size_t label(std::size_t row) const {
    return static_cast<std::size_t>(retrieval.room[row]);
  }
};

Expected<void> check_features(std::span<const float> features, std::size_t expected,
                              const std::string& whose) {
  if (features.empty() || features.size() != expected) {
    return fail("{} has {} features, the first has {}; take all from the same network", whose,
                features.size(), expected);
  }
  if (!std::ranges::all_of(features, [](float value) { return std::isfinite(value); })) {
    return fail("{} has features that are not finite", whose);
  }
  return {};
}

Expected<void> check_samples(std::span<const RoomSample> samples) {
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const RoomSample& sample = samples[i];
    if (sample.room.empty()) return fail("picture {} names no room", i);
    const std::string whose = fmt::format("picture {} ({})", i, sample.room);
    const std::size_t expected = samples.front().features.size();
    ROOMWISE_RETURN_IF_ERROR(check_features(sample.features, expected, whose));
    for (const auto& variant : sample.variants) {
      ROOMWISE_RETURN_IF_ERROR(check_features(variant, expected, "a variant of " + whose));
    }
  }
  return {};
}

Expected<std::vector<std::string>> rooms_of(std::span<const RoomSample> samples,
                                            const LearningOptions& options) {
  std::map<std::string, std::size_t> pictures;
  for (const RoomSample& sample : samples) ++pictures[sample.room];
  if (pictures.size() < 2) {
    return fail("there are pictures of {}; telling rooms apart takes at least two rooms",
                pictures.empty() ? "no room" : pictures.begin()->first + " alone");
  }
  std::vector<std::string> rooms;
  for (const auto& [room, count] : pictures) {
    if (count < options.min_pictures) {
      return fail("room \"{}\" has {} pictures; learning takes at least {} of each room", room,
                  count, options.min_pictures);
    }
    rooms.push_back(room);
  }
  return rooms;
}

using Stays = std::map<std::uint64_t, std::vector<std::size_t>>;  // the samples of each

// Cuts the samples of every stay into blocks, one a fold. A stay with fewer samples than folds
// begins at another fold than the stay before it, so that the folds fill evenly.
void hold_out_blocks(const Stays& stays, int folds, std::vector<int>& fold_of) {
  const auto fold_count = static_cast<std::size_t>(folds);
  std::size_t first_fold = 0;
  for (const auto& [stay, indices] : stays) {
    const std::size_t blocks = std::min(fold_count, indices.size());
    for (std::size_t i = 0; i < indices.size(); ++i) {
      const std::size_t block = i * blocks / indices.size();
      fold_of[indices[i]] = static_cast<int>((first_fold + block) % fold_count);
    }
    first_fold += blocks;
  }
}

std::size_t count_of(const Stays& stays) {
  std::size_t count = 0;
  for (const auto& [stay, indices] : stays) count += indices.size();
  return count;
}

// Whether enough is left to learn the room from, whichever of the walks is held out.
bool can_hold_out_walks(const std::map<std::uint64_t, Stays>& walks, std::size_t min_pictures) {
  std::size_t all = 0, largest = 0;
  for (const auto& [walk, stays] : walks) {
    all += count_of(stays);
    largest = std::max(largest, count_of(stays));
  }
  return all - largest >= min_pictures;
}

// By sample: the fold that holds it out.
std::vector<int> folds_of(std::span<const RoomSample> samples, const LearningOptions& options) {
  std::map<std::string, std::map<std::uint64_t, Stays>> walks_of_room;
  for (std::size_t i = 0; i < samples.size(); ++i)
    walks_of_room[samples[i].room][samples[i].walk][samples[i].stay].push_back(i);
  std::vector<int> fold_of(samples.size(), 0);
  for (const auto& [room, walks] : walks_of_room) {
    if (!can_hold_out_walks(walks, options.min_pictures)) {
      Stays of_all;
      for (const auto& [walk, stays] : walks)
        for (const auto& [stay, indices] : stays) of_all.emplace(of_all.size(), indices);
      hold_out_blocks(of_all, options.folds, fold_of);
      continue;
    }
    int fold = 0;
    for (const auto& [walk, stays] : walks) {
      for (const auto& [stay, indices] : stays)
        for (const std::size_t i : indices) fold_of[i] = fold;
      fold = (fold + 1) % options.folds;
    }
  }
  return fold_of;
}

TrainingSet make_training_set(std::span<const RoomSample> samples, std::vector<std::string> rooms,
                              const LearningOptions& options) {
  TrainingSet set;
  set.rooms = std::move(rooms);
  std::size_t rows = samples.size();
  for (const RoomSample& sample : samples) rows += sample.variants.size();
  RetrievalSamples& retrieval = set.retrieval;
  set.unit_length.resize(static_cast<Eigen::Index>(rows),
                         static_cast<Eigen::Index>(samples.front().features.size()));
  retrieval.rows.resize(set.unit_length.rows(), set.unit_length.cols());
  const std::vector<int> fold_of = folds_of(samples, options);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto room = std::ranges::lower_bound(set.rooms, samples[i].room);
    const auto add = [&](std::span<const float> features) {
      const auto row = static_cast<Eigen::Index>(retrieval.room.size());
      set.unit_length.row(row) = unit_length(features);
      retrieval.rows.row(row) = root_features(features);
      retrieval.room.push_back(static_cast<int>(room - set.rooms.begin()));
      retrieval.picture.push_back(static_cast<int>(i));
      retrieval.fold.push_back(fold_of[i]);
    };
    set.pictures.push_back(retrieval.room.size());
    add(samples[i].features);
    for (const auto& variant : samples[i].variants) add(variant);
  }
  return set;
}

// What the held-out test of one weight decay gave.
struct HeldOutTest {
  double weight_decay = 0;
  std::vector<std::size_t> correct;  // of each room
  std::size_t tested = 0;

  [[nodiscard]] double precision() const {
    const auto total = std::accumulate(correct.begin(), correct.end(), std::size_t{0});
    return static_cast<double>(total) / static_cast<double>(tested);
  }
  // Of the precision. One more right and one more wrong answer than there were keep it from being
  // zero where a few pictures are all right (Laplace's rule of succession).
  [[nodiscard]] double standard_error() const {
    const double n = static_cast<double>(tested) + 2;
    const double p = (precision() * static_cast<double>(tested) + 1) / n;
    return std::sqrt(p * (1 - p) / n);
  }
};

// One test for each weight decay, the strongest first.
Expected<std::vector<HeldOutTest>> held_out_tests(const TrainingSet& set,
                                                  const LearningOptions& options,
                                                  ThreadPool& pool) {
  std::vector<double> decays = options.weight_decays;
  std::ranges::sort(decays, std::greater());
  std::vector<Expected<std::vector<SoftmaxRegression>>> of_fold(
      static_cast<std::size_t>(options.folds));
  pool.parallel_for(of_fold.size(), [&](std::size_t fold) {
    std::vector<int> labels = set.retrieval.room;
    for (std::size_t i = 0; i < labels.size(); ++i) {
      const bool is_held_out = set.retrieval.fold[i] == static_cast<int>(fold);
      if (is_held_out) labels[i] = SoftmaxRegression::kHeldOut;
    }
    of_fold[fold] = SoftmaxRegression::train_path(set.unit_length, labels, set.classes(), decays,
                                                  {.gradient_tolerance = kHeldOutTolerance});
  });
  for (const auto& regressions : of_fold) ROOMWISE_RETURN_IF_ERROR(regressions);
  std::vector<HeldOutTest> tests;
  for (std::size_t i = 0; i < decays.size(); ++i) {
    HeldOutTest& test = tests.emplace_back();
    test.weight_decay = decays[i];
    test.correct.assign(set.rooms.size(), 0);
    test.tested = set.pictures.size();
    for (const std::size_t picture : set.pictures) {
      const auto& regressions = *of_fold[static_cast<std::size_t>(set.retrieval.fold[picture])];
      Eigen::Index best = 0;
      regressions[i]
          .probabilities(set.unit_length.row(static_cast<Eigen::Index>(picture)))
          .maxCoeff(&best);
      const std::size_t label = set.label(picture);
      if (static_cast<std::size_t>(best) == label) ++test.correct[label];
    }
  }
  return tests;
}

// The strongest weight decay whose precision is within a standard error of the best one (the
// one-standard-error rule of Breiman et al., Classification and Regression Trees, 1984): where the
// test cannot tell two apart, the simpler classifier fares better on another day.
const HeldOutTest& choose(std::span<const HeldOutTest> strongest_first) {
  const HeldOutTest& best = *std::ranges::max_element(strongest_first, {}, &HeldOutTest::precision);
  const double enough = best.precision() - best.standard_error();
  return *std::ranges::find_if(strongest_first,
                               [&](const HeldOutTest& test) { return test.precision() >= enough; });
}

LearningReport make_report(const TrainingSet& set, const HeldOutTest& test,
                           const LearnedRetrieval& retrieval, const LearningOptions& options) {
  LearningReport report;
  std::vector<std::size_t> pictures(set.rooms.size(), 0);
  for (const std::size_t picture : set.pictures) ++pictures[set.label(picture)];
  for (std::size_t room = 0; room < set.rooms.size(); ++room) {
    report.rooms.push_back(
        {set.rooms[room], pictures[room], retrieval.correct[room], test.correct[room]});
    report.held_out_correct += retrieval.correct[room];
    if (pictures[room] < options.comfortable_pictures) {
      report.warnings.push_back(
          fmt::format("room \"{}\" has only {} pictures; a slower walk through it, or more "
                      "photos of it, make surer answers",
                      set.rooms[room], pictures[room]));
    }
  }
  report.held_out = test.tested;
  report.paper_held_out_precision = test.precision();
  report.calibration = retrieval.retrieval.calibration;
  report.weight_decay = test.weight_decay;
  return report;
}

}  // namespace

Expected<void> LearningOptions::validate() const {
  if (folds < 2) return fail("folds is {}; expected at least 2", folds);
  if (weight_decays.empty()) return fail("weight_decays is empty; expected at least one");
  for (const double decay : weight_decays) {
    if (!(decay > 0 && std::isfinite(decay))) {
      return fail("weight_decays holds {}; expected values over 0", decay);
    }
  }
  if (min_pictures < static_cast<std::size_t>(folds)) {
    return fail("min_pictures is {}; expected at least folds ({}), so that every round has some",
                min_pictures, folds);
  }
  return {};
}

Expected<LearnedRooms> learn_rooms(std::span<const RoomSample> samples,
                                   const NetworkIdentity& network, const LearningOptions& options,
                                   ThreadPool* pool) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  ROOMWISE_RETURN_IF_ERROR(check_samples(samples));
  ROOMWISE_TRY(std::vector<std::string> rooms, rooms_of(samples, options));
  const TrainingSet set = make_training_set(samples, std::move(rooms), options);
  std::optional<ThreadPool> own_pool;
  if (pool == nullptr) pool = &own_pool.emplace(1);
  ROOMWISE_TRY(const auto tests, held_out_tests(set, options, *pool));
  const HeldOutTest& chosen = choose(tests);
  ROOMWISE_TRY(auto regression,
               SoftmaxRegression::train(set.unit_length, set.retrieval.room, set.classes(),
                                        {.weight_decay = chosen.weight_decay}));
  LearnedRetrieval retrieval = learn_retrieval(set.retrieval, set.classes(), options.folds, *pool);
  LearningReport report = make_report(set, chosen, retrieval, options);
  report.min_probability = RoomModel::of(network.name).min_probability;
  return LearnedRooms{
      RoomClassifier(network, set.rooms, std::move(regression), std::move(retrieval.retrieval)),
      std::move(report)};
}

}  // namespace roomwise::rooms
