#include "roomwise/rooms/softmax_regression.h"

#include <ceres/ceres.h>

#include <cmath>

namespace roomwise::rooms {
namespace {

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Each row of logits becomes probabilities; returns each row's log of the sum of exponentials.
Eigen::VectorXd softmax_rows(Eigen::MatrixXd& logits) {
  const Eigen::VectorXd highest = logits.rowwise().maxCoeff();
  logits.colwise() -= highest;
  logits = logits.array().exp().matrix();
  const Eigen::VectorXd sums = logits.rowwise().sum();
  logits.array().colwise() /= sums.array();
  return highest + sums.array().log().matrix();
}

// The loss of SoftmaxRegression::train. Parameters: the weights row by row, then the biases.
class CrossEntropy final : public ceres::FirstOrderFunction {
 public:
  CrossEntropy(const Eigen::MatrixXf& samples, std::span<const int> labels, int classes,
               double weight_decay)
      : samples_(samples.cast<double>()),
        labels_(labels),
        classes_(classes),
        weight_decay_(weight_decay),
        sample_weights_(samples.rows()) {
    Eigen::VectorXd counts = Eigen::VectorXd::Zero(classes);
    for (const int label : labels) counts[label] += 1;
    for (Eigen::Index i = 0; i < samples.rows(); ++i) {
      sample_weights_[i] = 1 / (classes * counts[label(i)]);
    }
  }

  [[nodiscard]] int NumParameters() const override {
    return classes_ * (static_cast<int>(samples_.cols()) + 1);
  }

  bool Evaluate(const double* parameters, double* cost, double* gradient) const override {
    const Eigen::Map<const RowMajorMatrix> weights(parameters, classes_, samples_.cols());
    const Eigen::Map<const Eigen::RowVectorXd> biases(parameters + weights.size(), classes_);
    Eigen::MatrixXd logits = (samples_ * weights.transpose()).rowwise() + biases;
    *cost = weight_decay_ / 2 * weights.squaredNorm();
    for (Eigen::Index i = 0; i < logits.rows(); ++i) {
      *cost -= sample_weights_[i] * logits(i, label(i));
    }
    Eigen::MatrixXd& residuals = logits;
    *cost += sample_weights_.dot(softmax_rows(residuals));
    if (gradient == nullptr) return true;

    for (Eigen::Index i = 0; i < residuals.rows(); ++i) residuals(i, label(i)) -= 1;
    residuals.array().colwise() *= sample_weights_.array();
    Eigen::Map<RowMajorMatrix>(gradient, classes_, samples_.cols()) =
        residuals.transpose() * samples_ + weight_decay_ * weights;
    Eigen::Map<Eigen::RowVectorXd>(gradient + weights.size(), classes_) = residuals.colwise().sum();
    return true;
  }

 private:
  [[nodiscard]] int label(Eigen::Index i) const { return labels_[static_cast<std::size_t>(i)]; }

  Eigen::MatrixXd samples_;
  std::span<const int> labels_;
  int classes_;
  double weight_decay_;
  Eigen::VectorXd sample_weights_;  // classes weigh the same, all samples together 1
};

Expected<void> check_samples(const Eigen::MatrixXf& samples, std::span<const int> labels,
                             int classes) {
  if (static_cast<std::size_t>(samples.rows()) != labels.size()) {
    return fail("there are {} samples but {} labels", samples.rows(), labels.size());
  }
  if (classes < 1) return fail("there are {} classes; expected at least 1", classes);
  std::vector<int> counts(static_cast<std::size_t>(classes), 0);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (labels[i] < 0 || labels[i] >= classes) {
      return fail("sample {} has the label {}; expected 0 to {}", i, labels[i], classes - 1);
    }
    ++counts[static_cast<std::size_t>(labels[i])];
    if (!samples.row(static_cast<Eigen::Index>(i)).allFinite()) {
      return fail("sample {} holds a value that is not finite", i);
    }
  }
  for (int k = 0; k < classes; ++k) {
    if (counts[static_cast<std::size_t>(k)] == 0) return fail("class {} has no sample", k);
  }
  return {};
}

}  // namespace

Expected<void> SoftmaxOptions::validate() const {
  if (!(weight_decay >= 0 && std::isfinite(weight_decay))) {
    return fail("weight_decay is {}; expected 0 or more", weight_decay);
  }
  if (most_iterations < 1)
    return fail("most_iterations is {}; expected 1 or more", most_iterations);
  if (!(gradient_tolerance > 0 && std::isfinite(gradient_tolerance))) {
    return fail("gradient_tolerance is {}; expected more than 0", gradient_tolerance);
  }
  return {};
}

Expected<SoftmaxRegression> SoftmaxRegression::train(const Eigen::MatrixXf& samples,
                                                     std::span<const int> labels, int classes,
                                                     const SoftmaxOptions& options) {
  ROOMWISE_CHECK_OK(options.validate());
  ROOMWISE_CHECK_OK(check_samples(samples, labels, classes));
  // The loss is convex: every start ends at the same minimum.
  ceres::GradientProblem problem(
      new CrossEntropy(samples, labels, classes, options.weight_decay));  // the problem owns it
  Eigen::VectorXd parameters = Eigen::VectorXd::Zero(problem.NumParameters());
  ceres::GradientProblemSolver::Options solver;
  solver.line_search_direction_type = ceres::LBFGS;
  solver.max_num_iterations = options.most_iterations;
  solver.gradient_tolerance = options.gradient_tolerance;
  solver.function_tolerance = 0;  // only the gradient says when it is done
  solver.parameter_tolerance = 0;
  solver.logging_type = ceres::SILENT;
  ceres::GradientProblemSolver::Summary summary;
  ceres::Solve(solver, problem, parameters.data(), &summary);
  if (!parameters.allFinite()) return fail("the regression diverged; are the samples in scale?");

  const Eigen::Index features = samples.cols();
  const Eigen::Map<const RowMajorMatrix> weights(parameters.data(), classes, features);
  return SoftmaxRegression(weights.cast<float>(), parameters.tail(classes).cast<float>());
}

Eigen::VectorXf SoftmaxRegression::probabilities(const Eigen::VectorXf& sample) const {
  Eigen::MatrixXd logits = (weights_ * sample + biases_).transpose().cast<double>();
  softmax_rows(logits);
  return logits.row(0).transpose().cast<float>();
}

}  // namespace roomwise::rooms
