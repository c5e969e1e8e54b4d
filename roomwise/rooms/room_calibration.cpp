#include "roomwise/rooms/room_calibration.h"

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
constexpr double kLeastSure = 0.5;
constexpr double kMostSure = 0.95;
constexpr double kLeastDeviation = 1e-3;
// What is usual in a room is told by its pictures, and by so many more that are known as the mean.
constexpr double kAveragePictures = 5;

double cross_entropy(std::span<const HeldOutPicture> pictures, double temperature) {
  RoomCalibration calibration;
  calibration.temperature = temperature;
  double sum = 0;
  for (const HeldOutPicture& picture : pictures) {
    sum -= std::log(std::max(calibration.probabilities(picture.likeness)[picture.room], 1e-12));
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
  spread.deviation = std::max(std::sqrt(spread.deviation), kLeastDeviation);
  return spread;
}

double lower_quantile(std::vector<double> values, double share) {
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size()))];
}

Eigen::Index most_alike(const Likeness& likeness) {
  Eigen::Index room = 0;
  likeness.of_rooms.maxCoeff(&room);
  return room;
}

// RoomCalibration::usual_of_rooms, by a calibration without it.
std::vector<double> usual_of_rooms(std::span<const HeldOutPicture> pictures,
                                   const RoomCalibration& calibration) {
  const auto rooms = pictures.front().likeness.of_rooms.size();
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(rooms);
  Eigen::VectorXd counts = Eigen::VectorXd::Constant(rooms, kAveragePictures);
  for (const HeldOutPicture& picture : pictures) {
    const Eigen::Index room = most_alike(picture.likeness);
    sums[room] += calibration.known(picture.likeness);
    counts[room] += 1;
  }
  const Eigen::VectorXd usual = sums.cwiseQuotient(counts);
  return {usual.begin(), usual.end()};
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
    const double probability = calibration.probabilities(picture.likeness).maxCoeff();
    answers.push_back({probability, most_alike(picture.likeness) == picture.room});
  }
  std::ranges::sort(answers, std::ranges::greater{}, &Answer::probability);
  double lowest = kMostSure;
  double right = 0;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    right += answers[i].right ? 1 : 0;
    const bool is_last = i + 1 == answers.size();
    if (!is_last && answers[i + 1].probability == answers[i].probability) continue;
    if (right / static_cast<double>(i + 1) >= RoomCalibration::kLeastPrecision) {
      lowest = answers[i].probability;
    }
  }
  return std::clamp(lowest, kLeastSure, kMostSure);
}

}  // namespace

Eigen::VectorXd RoomCalibration::probabilities(const Likeness& likeness) const {
  const Eigen::ArrayXd powers =
      ((likeness.of_rooms.array() - likeness.of_rooms.maxCoeff()) / temperature).exp();
  return powers / powers.sum();
}

double RoomCalibration::known(const Likeness& likeness) const {
  const double known = ((likeness.finely - finely_mean) / finely_deviation +
                        (likeness.coarsely - coarsely_mean) / coarsely_deviation) /
                       2;
  if (usual_of_rooms.empty()) return known;
  // Of the one room: weighed by all rooms' probabilities, which are soft, it names fewer of the
  // home's pictures (docs/benchmarks.md).
  return known - usual_of_rooms.at(static_cast<std::size_t>(most_alike(likeness)));
}

Expected<void> RoomCalibration::validate() const {
  for (const auto& [name, value] :
       {std::pair("temperature", temperature), std::pair("finely_deviation", finely_deviation),
        std::pair("coarsely_deviation", coarsely_deviation)}) {
    if (!(value > 0 && std::isfinite(value))) {
      return fail("{} is {}; expected more than 0", name, value);
    }
  }
  for (std::size_t room = 0; room < usual_of_rooms.size(); ++room) {
    if (!std::isfinite(usual_of_rooms[room])) {
      return fail("usual_of_rooms[{}] is {}; expected a number", room, usual_of_rooms[room]);
    }
  }
  for (const auto& [name, value] :
       {std::pair("finely_mean", finely_mean), std::pair("coarsely_mean", coarsely_mean),
        std::pair("known_from", known_from), std::pair("none_below", none_below)}) {
    if (!std::isfinite(value)) return fail("{} is {}; expected a number", name, value);
  }
  if (!(sure_from >= 0 && sure_from <= 1)) {
    return fail("sure_from is {}; expected 0 to 1", sure_from);
  }
  if (none_below > known_from) {
    return fail("none_below is {}; expected at most known_from ({})", none_below, known_from);
  }
  return {};
}

RoomCalibration calibrate(std::span<const HeldOutPicture> held_out) {
  std::vector<double> finely;
  std::vector<double> coarsely;
  for (const HeldOutPicture& picture : held_out) {
    finely.push_back(picture.likeness.finely);
    coarsely.push_back(picture.likeness.coarsely);
  }
  RoomCalibration calibration;
  calibration.temperature = best_temperature(held_out);
  const Spread fine = spread_of(finely);
  const Spread coarse = spread_of(coarsely);
  calibration.finely_mean = fine.mean;
  calibration.finely_deviation = fine.deviation;
  calibration.coarsely_mean = coarse.mean;
  calibration.coarsely_deviation = coarse.deviation;
  calibration.sure_from = surely_right_from(held_out, calibration);
  calibration.usual_of_rooms = usual_of_rooms(held_out, calibration);
  std::vector<double> known;
  for (const HeldOutPicture& picture : held_out) {
    known.push_back(calibration.known(picture.likeness));
  }
  calibration.known_from = lower_quantile(known, 0.05);
  calibration.none_below = lower_quantile(known, 0.01);
  return calibration;
}

}  // namespace roomwise::rooms
