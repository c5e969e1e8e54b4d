#include "roomwise/rooms/recognition/room_filter.h"

#include <cmath>
#include <stdexcept>
#include <unsupported/Eigen/MatrixFunctions>

namespace roomwise::rooms {
namespace {

// No picture is surer than this: one wrong one must not bury a room for good.
constexpr double kMinSeen = 1e-4;

}  // namespace

Expected<void> RoomFilterOptions::validate() const {
  if (!(mean_dwell_s > 0 && std::isfinite(mean_dwell_s))) {
    return fail("mean_dwell_s is {}; expected more than 0", mean_dwell_s);
  }
  if (!(correlation_time_s >= 0 && std::isfinite(correlation_time_s))) {
    return fail("correlation_time_s is {}; expected 0 or more", correlation_time_s);
  }
  return {};
}

RoomFilter::RoomFilter(const RoomTopology& topology, const RoomFilterOptions& options)
    : rooms_(topology.rooms()), options_(options) {
  if (const auto valid = options.validate(); !valid) {
    throw std::invalid_argument(valid.error().message);
  }
  const auto count = static_cast<Eigen::Index>(rooms_.size());
  rates_ = topology.transition_probabilities() / options.mean_dwell_s;
  rates_.diagonal() = -rates_.rowwise().sum();
  belief_ = Eigen::VectorXd::Constant(count, 1.0 / static_cast<double>(count));
}

void RoomFilter::predict(double elapsed_s) {
  if (!(elapsed_s > 0)) return;
  const Eigen::MatrixXd moves = (rates_ * elapsed_s).exp();
  belief_ = (moves.transpose() * belief_).cwiseMax(0);
  belief_ /= belief_.sum();
}

void RoomFilter::update(std::span<const double> probabilities, double elapsed_s) {
  if (probabilities.size() != rooms_.size()) {
    throw std::invalid_argument("RoomFilter: not one probability a room");
  }
  predict(elapsed_s);
  const Eigen::Map<const Eigen::VectorXd> seen(probabilities.data(), belief_.size());
  if (!(seen.sum() > 0)) return;
  if (!(elapsed_s > 0)) elapsed_s = 0;
  const bool counts_fully = !has_seen_ || options_.correlation_time_s == 0;
  const double weight = counts_fully ? 1 : 1 - std::exp(-elapsed_s / options_.correlation_time_s);
  belief_ = belief_.array() * seen.array().max(kMinSeen).pow(weight);
  belief_ /= belief_.sum();
  has_seen_ = true;
}

}  // namespace roomwise::rooms
