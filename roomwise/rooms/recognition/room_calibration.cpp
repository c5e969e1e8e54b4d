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
constexpr double kMinDeviation = 1e-3;

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

}  // namespace

Eigen::VectorXd RoomCalibration::probabilities(const Similarity& similarity) const {
  const Eigen::ArrayXd powers =
      ((similarity.of_rooms.array() - similarity.of_rooms.maxCoeff()) / temperature).exp();
  return powers / powers.sum();
}

double RoomCalibration::deviations(const Similarity& similarity) const {
  return ((similarity.whitened_cosine - whitened_cosine_mean) / whitened_cosine_deviation +
          (similarity.plain_cosine - plain_cosine_mean) / plain_cosine_deviation) /
         2;
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
  for (const auto& [name, value] : {std::pair("whitened_cosine_mean", whitened_cosine_mean),
                                    std::pair("plain_cosine_mean", plain_cosine_mean)}) {
    if (!std::isfinite(value)) return fail("{} is {}; expected a number", name, value);
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
  return calibration;
}

}  // namespace roomwise::rooms
