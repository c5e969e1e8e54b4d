#include "roomwise/rooms/recognition/room_calibration.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace roomwise::rooms {
namespace {

// Where all held-out pictures were right, the coldest temperature would be the best; but a later
// day's pictures are never as sure.
constexpr double kColdest = 0.03;
constexpr double kWarmest = 0.5;
constexpr int kTemperatures = 60;
constexpr double kMinSure = 0.5;
constexpr double kMaxSure = 0.95;
constexpr double kMinDeviation = 1e-3;
// A room's mean familiarity is that of its pictures and of so many average ones.
constexpr double kAveragePictures = 5;

double cross_entropy(std::span<const HeldOutPicture> pictures, double temperature) {
  RoomCalibration calibration;
  calibration.temperature = temperature;
  double sum = 0;
  for (const HeldOutPicture& picture : pictures) {
    sum -= std::log(std::max(calibration.probabilities(picture.similarity)[picture.room], 1e-12));
  }
  return sum;
}

double best_temperature(std::span<const HeldOutPicture> pictures) {
  double best = kColdest;
  double lowest = cross_entropy(pictures, best);
  for (int i = 1; i < kTemperatures; ++i) {
    const double temperature =
        kColdest * std::pow(kWarmest / kColdest, i / double{kTemperatures - 1});
    if (const double loss = cross_entropy(pictures, temperature); loss < lowest) {
      lowest = loss;
      best = temperature;
    }
  }
  return best;
}

struct Spread {
  double mean = 0;
  double deviation = 0;
};

Spread spread_of(const std::vector<double>& values) {
  Spread spread;
  for (const double value : values) spread.mean += value / static_cast<double>(values.size());
  for (const double value : values) {
    spread.deviation += std::pow(value - spread.mean, 2) / static_cast<double>(values.size());
  }
  spread.deviation = std::max(std::sqrt(spread.deviation), kMinDeviation);
  return spread;
}

double lower_quantile(std::vector<double> values, double share) {
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size()))];
}

Eigen::Index most_similar_room(const Similarity& similarity) {
  Eigen::Index room = 0;
  similarity.of_rooms.maxCoeff(&room);
  return room;
}

// By a calibration without them.
std::vector<double> room_familiarity_means(std::span<const HeldOutPicture> pictures,
                                           const RoomCalibration& calibration) {
  const auto rooms = pictures.front().similarity.of_rooms.size();
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(rooms);
  Eigen::VectorXd counts = Eigen::VectorXd::Constant(rooms, kAveragePictures);
  for (const HeldOutPicture& picture : pictures) {
    const Eigen::Index room = most_similar_room(picture.similarity);
    sums[room] += calibration.familiarity(picture.similarity);
    counts[room] += 1;
  }
  const Eigen::VectorXd means = sums.cwiseQuotient(counts);
  return {means.begin(), means.end()};
}

// The lowest probability from which on the answers are right often enough.
double surely_right_from(std::span<const HeldOutPicture> pictures,
                         const RoomCalibration& calibration) {
  struct Answer {
    double probability;
    bool right;
  };
  std::vector<Answer> answers;
  for (const HeldOutPicture& picture : pictures) {
    const double probability = calibration.probabilities(picture.similarity).maxCoeff();
    answers.push_back({probability, most_similar_room(picture.similarity) == picture.room});
  }
  std::ranges::sort(answers, std::ranges::greater{}, &Answer::probability);
  double lowest = kMaxSure;
  double right = 0;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    right += answers[i].right ? 1 : 0;
    const bool is_last = i + 1 == answers.size();
    if (!is_last && answers[i + 1].probability == answers[i].probability) continue;
    if (right / static_cast<double>(i + 1) >= RoomCalibration::kMinPrecision) {
      lowest = answers[i].probability;
    }
  }
  return std::clamp(lowest, kMinSure, kMaxSure);
}

}  // namespace

Eigen::VectorXd RoomCalibration::probabilities(const Similarity& similarity) const {
  const Eigen::ArrayXd powers =
      ((similarity.of_rooms.array() - similarity.of_rooms.maxCoeff()) / temperature).exp();
  return powers / powers.sum();
}

double RoomCalibration::familiarity(const Similarity& similarity) const {
  const double mean =
      ((similarity.whitened_cosine - whitened_cosine_mean) / whitened_cosine_deviation +
       (similarity.plain_cosine - plain_cosine_mean) / plain_cosine_deviation) /
      2;
  if (room_familiarity_means.empty()) return mean;
  // Of the one room: weighed by all rooms' probabilities, which are soft, it names fewer of the
  // home's pictures (docs/experiments/rooms-usual-likeness.md).
  return mean - room_familiarity_means.at(static_cast<std::size_t>(most_similar_room(similarity)));
}

Expected<void> RoomCalibration::validate() const {
  for (const auto& [name, value] :
       {std::pair("temperature", temperature),
        std::pair("whitened_cosine_deviation", whitened_cosine_deviation),
        std::pair("plain_cosine_deviation", plain_cosine_deviation)}) {
    if (!(value > 0 && std::isfinite(value))) {
      return fail("{} is {}; expected more than 0", name, value);
    }
  }
  for (std::size_t room = 0; room < room_familiarity_means.size(); ++room) {
    if (!std::isfinite(room_familiarity_means[room])) {
      return fail("room_familiarity_means[{}] is {}; expected a number", room,
                  room_familiarity_means[room]);
    }
  }
  for (const auto& [name, value] : {std::pair("whitened_cosine_mean", whitened_cosine_mean),
                                    std::pair("plain_cosine_mean", plain_cosine_mean),
                                    std::pair("acceptance_threshold", acceptance_threshold),
                                    std::pair("reject_threshold", reject_threshold)}) {
    if (!std::isfinite(value)) return fail("{} is {}; expected a number", name, value);
  }
  if (!(confidence_threshold >= 0 && confidence_threshold <= 1)) {
    return fail("confidence_threshold is {}; expected 0 to 1", confidence_threshold);
  }
  if (reject_threshold > acceptance_threshold) {
    return fail("reject_threshold is {}; expected at most acceptance_threshold ({})",
                reject_threshold, acceptance_threshold);
  }
  return {};
}

RoomCalibration calibrate(std::span<const HeldOutPicture> held_out) {
  std::vector<double> whitened_cosine;
  std::vector<double> plain_cosine;
  for (const HeldOutPicture& picture : held_out) {
    whitened_cosine.push_back(picture.similarity.whitened_cosine);
    plain_cosine.push_back(picture.similarity.plain_cosine);
  }
  RoomCalibration calibration;
  calibration.temperature = best_temperature(held_out);
  const Spread whitened = spread_of(whitened_cosine);
  const Spread plain = spread_of(plain_cosine);
  calibration.whitened_cosine_mean = whitened.mean;
  calibration.whitened_cosine_deviation = whitened.deviation;
  calibration.plain_cosine_mean = plain.mean;
  calibration.plain_cosine_deviation = plain.deviation;
  calibration.confidence_threshold = surely_right_from(held_out, calibration);
  calibration.room_familiarity_means = room_familiarity_means(held_out, calibration);
  std::vector<double> familiarity;
  for (const HeldOutPicture& picture : held_out) {
    familiarity.push_back(calibration.familiarity(picture.similarity));
  }
  calibration.acceptance_threshold = lower_quantile(familiarity, 0.05);
  calibration.reject_threshold = lower_quantile(familiarity, 0.01);
  return calibration;
}

}  // namespace roomwise::rooms
