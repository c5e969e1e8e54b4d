#include "roomwise/rooms/statistics/minimizer.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace roomwise::rooms {
namespace {

constexpr std::size_t kChanges = 20;
constexpr double kSufficientDecrease = 1e-4;  // of what the slope promises (Armijo)
constexpr double kShortestShare = 1e-6;
constexpr double kNoise = 1e-6;  // of the function's value, where that is summed up from floats

}  // namespace

void Lbfgs::tell(double value, const Eigen::VectorXd& gradient) {
  if (begun_) {
    // Where the function's last digits drown what is gained, the slope still shows the way: a
    // convex function has fallen as long as it falls where the step ends.
    const double slope = gradient_.dot(step_);
    const double slope_at_end = gradient.dot(step_);
    const bool same = std::abs(value - value_) <= kNoise * std::abs(value_);
    const bool lower = value <= value_ + kSufficientDecrease * share_ * slope ||
                       (same && slope_at_end <= 0 && slope_at_end >= slope);
    if (!lower || !std::isfinite(value)) {
      share_ /= 2;
      place_ = best_ + share_ * step_;
      if (share_ >= kShortestShare) return;
      done_ = !inverse_curvature_;
      if (done_) return;
      // The guess may be what is wrong: once more without it.
      inverse_curvature_ = {};
      changes_.clear();
      begin_step(-downwards());
      return;
    }
    Change change{place_ - best_, gradient - gradient_, 0};
    change.product = change.place.dot(change.gradient);
    if (change.product > 0) changes_.push_back(std::move(change));
    if (changes_.size() > kChanges) changes_.pop_front();
  }
  best_ = place_;
  value_ = value;
  gradient_ = gradient;
  done_ = gradient.cwiseAbs().maxCoeff() < gradient_tolerance_;
  if (!done_) begin_step(-downwards());
  begun_ = true;
}

void Lbfgs::begin_step(const Eigen::VectorXd& direction) {
  step_ = direction;
  // What changes say can only mislead by rounding, or by a wrong guess.
  if (!(gradient_.dot(step_) < 0)) {
    inverse_curvature_ = {};
    changes_.clear();
    step_ = -gradient_;
  }
  share_ = 1;
  place_ = best_ + step_;
}

Eigen::VectorXd Lbfgs::downwards() const {
  Eigen::VectorXd direction = gradient_;
  std::vector<double> shares(changes_.size());
  for (std::size_t i = changes_.size(); i-- > 0;) {
    shares[i] = changes_[i].place.dot(direction) / changes_[i].product;
    direction -= shares[i] * changes_[i].gradient;
  }
  direction = downwards_by_guess(direction);
  for (std::size_t i = 0; i < changes_.size(); ++i) {
    const double share = changes_[i].gradient.dot(direction) / changes_[i].product;
    direction += (shares[i] - share) * changes_[i].place;
  }
  return direction;
}

Eigen::VectorXd Lbfgs::downwards_by_guess(const Eigen::VectorXd& gradient) const {
  if (changes_.empty()) {
    if (inverse_curvature_) return inverse_curvature_(gradient);
    // A first step of length 1; it grows or shrinks by what it finds.
    return gradient / std::max(gradient.norm(), 1e-300);
  }
  const Change& last = changes_.back();
  if (!inverse_curvature_) return last.product / last.gradient.squaredNorm() * gradient;
  const double found = last.gradient.dot(inverse_curvature_(last.gradient));
  return last.product / found * inverse_curvature_(gradient);
}

}  // namespace roomwise::rooms
