#include "roomwise/rooms/room_learner.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>

namespace roomwise::rooms {
namespace {

// The pictures as the regression takes them.
struct TrainingSet {
  std::vector<std::string> rooms;  // by name; a label is an index of it
  Eigen::MatrixXf samples;         // one a row
  std::vector<int> labels;
  std::vector<int> folds;  // the round that holds the sample out

  [[nodiscard]] int classes() const { return static_cast<int>(rooms.size()); }
};

Expected<void> check_samples(std::span<const RoomSample> samples) {
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const RoomSample& sample = samples[i];
    if (sample.room.empty()) return fail("picture {} names no room", i);
    if (sample.features.empty() || sample.features.size() != samples.front().features.size()) {
      return fail(
          "picture {} ({}) has {} features, the first has {}; take all from the same network", i,
          sample.room, sample.features.size(), samples.front().features.size());
    }
    if (!std::ranges::all_of(sample.features, [](float value) { return std::isfinite(value); })) {
      return fail("picture {} ({}) has features that are not finite", i, sample.room);
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
    if (count < options.least_pictures) {
      return fail("room \"{}\" has {} pictures; learning takes at least {} of each room", room,
                  count, options.least_pictures);
    }
    rooms.push_back(room);
  }
  return rooms;
}

// Cuts the samples of every room and group into blocks, one a fold. A group with fewer samples than
// folds begins at another fold than the group before it, so that the folds fill evenly.
std::vector<int> block_folds(std::span<const RoomSample> samples, int folds) {
  std::map<std::string, std::map<std::uint64_t, std::vector<std::size_t>>> members;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    members[samples[i].room][samples[i].group].push_back(i);
  }
  std::vector<int> fold_of(samples.size(), 0);
  const auto fold_count = static_cast<std::size_t>(folds);
  for (const auto& [room, groups] : members) {
    std::size_t first_fold = 0;
    for (const auto& [group, indices] : groups) {
      const std::size_t blocks = std::min(fold_count, indices.size());
      for (std::size_t i = 0; i < indices.size(); ++i) {
        const std::size_t block = i * blocks / indices.size();
        fold_of[indices[i]] = static_cast<int>((first_fold + block) % fold_count);
      }
      first_fold += blocks;
    }
  }
  return fold_of;
}

TrainingSet make_training_set(std::span<const RoomSample> samples, std::vector<std::string> rooms,
                              int folds) {
  TrainingSet set;
  set.rooms = std::move(rooms);
  set.samples.resize(static_cast<Eigen::Index>(samples.size()),
                     static_cast<Eigen::Index>(samples.front().features.size()));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    set.samples.row(static_cast<Eigen::Index>(i)) = unit_length(samples[i].features);
    const auto room = std::ranges::lower_bound(set.rooms, samples[i].room);
    set.labels.push_back(static_cast<int>(room - set.rooms.begin()));
  }
  set.folds = block_folds(samples, folds);
  return set;
}

// With fewer samples than features, the best weights lie in the space that the samples span: the
// same regression in coordinates of that space is the same problem with far fewer unknowns.
// samples^T = basis * coordinates^T.
struct SampleSpace {
  Eigen::MatrixXf basis;        // features x dimensions, orthonormal columns
  Eigen::MatrixXf coordinates;  // samples x dimensions
};

SampleSpace span_of(const Eigen::MatrixXf& samples) {
  const Eigen::Index count = samples.rows();
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(samples.transpose().cast<double>());
  SampleSpace space;
  space.basis =
      (qr.householderQ() * Eigen::MatrixXd::Identity(samples.cols(), count)).cast<float>();
  const Eigen::MatrixXd triangle = qr.matrixQR().topRows(count).triangularView<Eigen::Upper>();
  space.coordinates = triangle.transpose().cast<float>();
  return space;
}

// What the held-out test of one weight decay gave.
struct HeldOutTest {
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

// Trains without a fold and adds the results on it to `test`.
Expected<void> test_fold(const TrainingSet& set, int fold, const SoftmaxOptions& options,
                         HeldOutTest& test) {
  std::vector<Eigen::Index> kept;
  std::vector<int> labels;
  for (std::size_t i = 0; i < set.folds.size(); ++i) {
    if (set.folds[i] == fold) continue;
    kept.push_back(static_cast<Eigen::Index>(i));
    labels.push_back(set.labels[i]);
  }
  ROOMWISE_TRY(
      const SoftmaxRegression regression,
      SoftmaxRegression::train(set.samples(kept, Eigen::all), labels, set.classes(), options));
  for (std::size_t i = 0; i < set.folds.size(); ++i) {
    if (set.folds[i] != fold) continue;
    Eigen::Index best = 0;
    regression.probabilities(set.samples.row(static_cast<Eigen::Index>(i))).maxCoeff(&best);
    ++test.tested;
    if (best == set.labels[i]) ++test.correct[static_cast<std::size_t>(best)];
  }
  return {};
}

Expected<HeldOutTest> held_out_test(const TrainingSet& set, int folds, double weight_decay) {
  SoftmaxOptions options;
  options.weight_decay = weight_decay;
  HeldOutTest test;
  test.correct.assign(set.rooms.size(), 0);
  for (int fold = 0; fold < folds; ++fold) {
    ROOMWISE_CHECK_OK(test_fold(set, fold, options, test));
  }
  return test;
}

// The strongest weight decay whose precision is within a standard error of the best one (the
// one-standard-error rule of Breiman et al., Classification and Regression Trees, 1984): where the
// test cannot tell two apart, the simpler classifier fares better on another day.
std::size_t choose(std::span<const double> weight_decays, std::span<const HeldOutTest> tests) {
  const HeldOutTest& best = *std::ranges::max_element(tests, {}, &HeldOutTest::precision);
  const double enough = best.precision() - best.standard_error();
  std::optional<std::size_t> chosen;
  for (std::size_t i = 0; i < tests.size(); ++i) {
    if (tests[i].precision() < enough) continue;
    if (!chosen || weight_decays[i] > weight_decays[*chosen]) chosen = i;
  }
  return *chosen;
}

LearningReport make_report(const TrainingSet& set, const HeldOutTest& test, double weight_decay,
                           const LearningOptions& options) {
  LearningReport report;
  std::vector<std::size_t> pictures(set.rooms.size(), 0);
  for (const int label : set.labels) ++pictures[static_cast<std::size_t>(label)];
  for (std::size_t room = 0; room < set.rooms.size(); ++room) {
    report.rooms.push_back({set.rooms[room], pictures[room], test.correct[room]});
    if (pictures[room] < options.comfortable_pictures) {
      report.warnings.push_back(
          fmt::format("room \"{}\" has only {} pictures; walk through it again for a surer answer",
                      set.rooms[room], pictures[room]));
    }
  }
  report.held_out = test.tested;
  report.held_out_precision = test.precision();
  report.weight_decay = weight_decay;
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
  if (least_pictures < static_cast<std::size_t>(folds)) {
    return fail("least_pictures is {}; expected at least folds ({}), so that every round has some",
                least_pictures, folds);
  }
  return {};
}

Expected<LearnedRooms> learn_rooms(std::span<const RoomSample> samples,
                                   const NetworkIdentity& network, const LearningOptions& options) {
  ROOMWISE_CHECK_OK(options.validate());
  ROOMWISE_CHECK_OK(check_samples(samples));
  ROOMWISE_TRY(std::vector<std::string> rooms, rooms_of(samples, options));
  TrainingSet set = make_training_set(samples, std::move(rooms), options.folds);
  Eigen::MatrixXf basis;  // empty where the samples are left as they are
  if (set.samples.rows() < set.samples.cols()) {
    SampleSpace space = span_of(set.samples);
    basis = std::move(space.basis);
    set.samples = std::move(space.coordinates);
  }

  std::vector<HeldOutTest> tests;
  for (const double weight_decay : options.weight_decays) {
    ROOMWISE_TRY(HeldOutTest test, held_out_test(set, options.folds, weight_decay));
    tests.push_back(std::move(test));
  }
  const std::size_t chosen = choose(options.weight_decays, tests);

  SoftmaxOptions best;
  best.weight_decay = options.weight_decays[chosen];
  ROOMWISE_TRY(SoftmaxRegression regression,
               SoftmaxRegression::train(set.samples, set.labels, set.classes(), best));
  if (basis.size() != 0) {
    regression = SoftmaxRegression(regression.weights() * basis.transpose(), regression.biases());
  }
  LearningReport report = make_report(set, tests[chosen], best.weight_decay, options);
  return LearnedRooms{RoomClassifier(network, set.rooms, std::move(regression)), std::move(report)};
}

}  // namespace roomwise::rooms
