#include "roomwise/rooms/statistics/softmax_regression.h"

#include <algorithm>
#include <cmath>
#include <deque>

#include "roomwise/rooms/statistics/principal_components.h"

namespace roomwise::rooms {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Samples and features that are multiplied at a time. So small, Eigen adds them up in one order,
// whatever the caches of the processor.
constexpr Index kSampleBlock = 64;
constexpr Index kFeatureBlock = 128;
// Of so many samples the directions are found in which they differ, to learn in fewer steps.
constexpr ComponentLimits kComponents{.rows = 200, .directions = 64};
// Of L-BFGS.
constexpr std::size_t kRememberedSteps = 20;
constexpr double kSufficientDecrease = 1e-4;  // of what the slope promises (Armijo)
constexpr double kShortestShare = 1e-6;       // of a step

double dot(const MatrixXd& a, const MatrixXd& b) {
  return a.cwiseProduct(b).sum();
}

Expected<void> check(const Eigen::MatrixXf& samples, std::span<const int> labels, int classes) {
  if (static_cast<std::size_t>(samples.rows()) != labels.size()) {
    return fail("there are {} samples but {} labels", samples.rows(), labels.size());
  }
  if (classes < 1) return fail("there are {} classes; expected at least 1", classes);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (labels[i] < SoftmaxRegression::kHeldOut || labels[i] >= classes) {
      return fail("sample {} has the label {}; expected 0 to {}", i, labels[i], classes - 1);
    }
    if (!samples.row(static_cast<Index>(i)).allFinite()) {
      return fail("sample {} holds a value that is not finite", i);
    }
  }
  for (int k = 0; k < classes; ++k) {
    if (std::ranges::count(labels, k) == 0) return fail("class {} has no sample", k);
  }
  return {};
}

// The loss as a function of the parameters: a row for each feature's weights, then one of biases; a
// column for each class.
class Loss {
 public:
  Loss(const Eigen::MatrixXf& samples, std::span<const int> labels, int classes)
      : samples_(samples),
        labels_(labels),
        classes_(classes),
        // Biases are free, so that a shift of all samples changes nothing but them; about their
        // mean the samples differ in more directions alike.
        mean_(samples.cast<double>().colwise().mean()),
        weights_(VectorXd::Zero(samples.rows())),
        components_(principal_components(samples, kComponents)) {
    const auto sample_count = [&](int label) {
      return static_cast<double>(std::ranges::count(labels, label));
    };
    for (int k = 0; k < classes; ++k) {
      const double weight = 1 / (classes * sample_count(k));
      for (std::size_t i = 0; i < labels.size(); ++i) {
        if (labels[i] == k) weights_[static_cast<Index>(i)] = weight;
      }
    }
  }

  void set_weight_decay(double weight_decay) { weight_decay_ = weight_decay; }
  [[nodiscard]] MatrixXd zero() const { return MatrixXd::Zero(samples_.cols() + 1, classes_); }

  [[nodiscard]] double evaluate(const MatrixXd& parameters, MatrixXd& gradient) const {
    const Index features = samples_.cols();
    gradient = weight_decay_ * parameters;
    gradient.row(features).setZero();
    double loss = weight_decay_ / 2 * parameters.topRows(features).squaredNorm();
    for (Index first = 0; first < samples_.rows(); first += kSampleBlock) {
      const Index count = std::min(kSampleBlock, samples_.rows() - first);
      const auto weights = weights_.segment(first, count);
      if (weights.isZero(0)) continue;
      const MatrixXd rows = samples_.middleRows(first, count).cast<double>().rowwise() - mean_;
      MatrixXd logits = parameters.row(features).replicate(count, 1);
      for (Index f = 0; f < features; f += kFeatureBlock) {
        const Index width = std::min(kFeatureBlock, features - f);
        logits.noalias() += rows.middleCols(f, width) * parameters.middleRows(f, width);
      }
      logits.colwise() -= logits.rowwise().maxCoeff().eval();  // so that exp does not overflow
      MatrixXd residuals = logits.array().exp();  // of the probabilities, times the weights
      const VectorXd sums = residuals.rowwise().sum();
      residuals.array().colwise() *= weights.array() / sums.array();
      for (Index i = 0; i < count; ++i) {
        if (weights[i] == 0) continue;
        const int label = labels_[static_cast<std::size_t>(first + i)];
        loss += weights[i] * (std::log(sums[i]) - logits(i, label));
        residuals(i, label) -= weights[i];
      }
      gradient.topRows(features).noalias() += rows.transpose() * residuals;
      gradient.row(features) += residuals.colwise().sum();
    }
    return loss;
  }

  // About the inverse of the loss's second derivatives times a gradient. Where all classes are as
  // likely, the loss of a class's weights bends by the samples' covariance over the number of
  // classes, which the principal components tell, and by the weight decay.
  [[nodiscard]] MatrixXd precondition(const MatrixXd& gradient) const {
    constexpr double kMinVarianceRatio = 1e-6;  // below that a direction's variance is not known
    const Index features = samples_.cols();
    const Eigen::ArrayXd variances = components_.deviations.cast<double>().array().square();
    const double largest = variances.size() > 0 ? variances[0] : 1;  // 1: nothing is known
    const double remaining = std::max(components_.remaining_variance, kMinVarianceRatio * largest);
    const double of_others = 1 / (weight_decay_ + remaining / classes_);
    const VectorXd more = (weight_decay_ + variances / classes_).inverse() - of_others;
    // Lazily: added up in one order, too.
    const MatrixXd directions = components_.directions.cast<double>();
    MatrixXd scaled = directions.transpose().lazyProduct(gradient.topRows(features));
    scaled.array().colwise() *= more.array();
    MatrixXd product(gradient.rows(), gradient.cols());
    product.topRows(features) =
        of_others * gradient.topRows(features) + directions.lazyProduct(scaled);
    product.row(features) = gradient.row(features) * classes_;
    return product;
  }

  [[nodiscard]] SoftmaxRegression regression_of(const MatrixXd& parameters) const {
    const MatrixXd weights = parameters.topRows(samples_.cols()).transpose();
    const VectorXd biases = parameters.row(samples_.cols()) - mean_ * weights.transpose();
    return {weights.cast<float>(), biases.cast<float>()};
  }

 private:
  const Eigen::MatrixXf& samples_;
  std::span<const int> labels_;
  int classes_;
  Eigen::RowVectorXd mean_;
  VectorXd weights_;  // of the samples: classes weigh the same, all together 1
  PrincipalComponents components_;
  double weight_decay_ = 0;
};

struct Step {
  MatrixXd of_parameters;
  MatrixXd of_gradient;
  double product = 0;  // of the two, above 0
};

// The gradient times what the last steps say of the inverse of the second derivatives (the
// two-loop recursion; Nocedal, 1980).
MatrixXd quasi_newton(const Loss& loss, MatrixXd gradient, const std::deque<Step>& steps) {
  std::vector<double> shares(steps.size());
  for (std::size_t i = steps.size(); i-- > 0;) {
    shares[i] = dot(steps[i].of_parameters, gradient) / steps[i].product;
    gradient -= shares[i] * steps[i].of_gradient;
  }
  MatrixXd direction = loss.precondition(gradient);
  if (!steps.empty()) {  // scaled so that it fits the last step
    const Step& last = steps.back();
    direction *= last.product / dot(last.of_gradient, loss.precondition(last.of_gradient));
  }
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const double share = dot(steps[i].of_gradient, direction) / steps[i].product;
    direction += (shares[i] - share) * steps[i].of_parameters;
  }
  return direction;
}

// The loss's minimum, from `parameters`: L-BFGS with steps that are halved until they lead down.
// Ends where none does, too, since the loss is not more exact.
MatrixXd minimize(const Loss& loss, MatrixXd parameters, const SoftmaxOptions& options) {
  MatrixXd gradient;
  double value = loss.evaluate(parameters, gradient);
  std::deque<Step> steps;
  double share = 1;
  MatrixXd direction;
  for (int i = 1; i < options.max_evaluations; ++i) {
    if (share == 1) {
      if (gradient.cwiseAbs().maxCoeff() < options.gradient_tolerance) break;
      direction = -quasi_newton(loss, gradient, steps);
    }
    MatrixXd next_gradient;
    const MatrixXd next = parameters + share * direction;
    const double next_value = loss.evaluate(next, next_gradient);
    if (!(next_value <= value + kSufficientDecrease * share * dot(gradient, direction))) {
      share /= 2;
      if (share < kShortestShare) break;
      continue;
    }
    Step step{next - parameters, next_gradient - gradient, 0};
    step.product = dot(step.of_parameters, step.of_gradient);
    if (step.product > 0) steps.push_back(std::move(step));
    if (steps.size() > kRememberedSteps) steps.pop_front();
    parameters = next;
    gradient = std::move(next_gradient);
    value = next_value;
    share = 1;
  }
  return parameters;
}

}  // namespace

Expected<void> SoftmaxOptions::validate() const {
  if (!(weight_decay >= 0 && std::isfinite(weight_decay))) {
    return fail("weight_decay is {}; expected 0 or more", weight_decay);
  }
  if (max_evaluations < 1)
    return fail("max_evaluations is {}; expected 1 or more", max_evaluations);
  if (!(gradient_tolerance > 0 && std::isfinite(gradient_tolerance))) {
    return fail("gradient_tolerance is {}; expected more than 0", gradient_tolerance);
  }
  return {};
}

Expected<SoftmaxRegression> SoftmaxRegression::train(const Eigen::MatrixXf& samples,
                                                     std::span<const int> labels, int classes,
                                                     const SoftmaxOptions& options) {
  ROOMWISE_TRY(auto path,
               train_path(samples, labels, classes, std::span(&options.weight_decay, 1), options));
  return std::move(path.front());
}

Expected<std::vector<SoftmaxRegression>> SoftmaxRegression::train_path(
    const Eigen::MatrixXf& samples, std::span<const int> labels, int classes,
    std::span<const double> weight_decays, const SoftmaxOptions& options) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  ROOMWISE_RETURN_IF_ERROR(check(samples, labels, classes));
  Loss loss(samples, labels, classes);
  MatrixXd parameters = loss.zero();
  std::vector<SoftmaxRegression> path;
  for (const double weight_decay : weight_decays) {
    loss.set_weight_decay(weight_decay);
    parameters = minimize(loss, std::move(parameters), options);
    path.push_back(loss.regression_of(parameters));
  }
  return path;
}

Eigen::VectorXf SoftmaxRegression::probabilities(const Eigen::VectorXf& sample) const {
  const Eigen::VectorXd logits = (weights_ * sample + biases_).cast<double>();
  const Eigen::VectorXd powers = (logits.array() - logits.maxCoeff()).exp();
  return (powers / powers.sum()).cast<float>();
}

}  // namespace roomwise::rooms
