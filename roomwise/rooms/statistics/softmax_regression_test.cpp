#include "roomwise/rooms/statistics/softmax_regression.h"

#include <ceres/ceres.h>
#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::rooms {
namespace {

using ::testing::HasSubstr;

// `count` points of each class around its own corner.
Eigen::MatrixXf clouds(const std::vector<Eigen::Vector2f>& centers, int count, float spread,
                       std::vector<int>& labels) {
  RandomStream random(7);
  Eigen::MatrixXf samples(static_cast<Eigen::Index>(centers.size()) * count, 2);
  labels.clear();
  for (Eigen::Index i = 0; i < samples.rows(); ++i) {
    const auto label = static_cast<std::size_t>(i / count);
    labels.push_back(static_cast<int>(label));
    const Eigen::Vector2d noise(random.normal(), random.normal());
    samples.row(i) = (centers[label] + spread * noise.cast<float>()).transpose();
  }
  return samples;
}

TEST(SoftmaxRegression, ReachesTheKnownMinimumOfASmallProblem) {
  // Two classes at +1 and -1 in one dimension: the weights are +-w with w the root of
  // decay * w = 1 / (1 + exp(2 w)), found here by bisection.
  Eigen::MatrixXf samples(2, 1);
  samples << 1, -1;
  SoftmaxOptions options;
  options.weight_decay = 0.01;
  options.gradient_tolerance = 1e-9;
  const auto regression = SoftmaxRegression::train(samples, std::vector<int>{0, 1}, 2, options);
  ASSERT_OK(regression);
  double low = 0;
  double high = 10;
  for (int i = 0; i < 60; ++i) {
    const double w = (low + high) / 2;
    const double gradient = options.weight_decay * w - 1 / (1 + std::exp(2 * w));
    (gradient < 0 ? low : high) = w;
  }
  EXPECT_NEAR(regression->weights()(0, 0), low, 1e-5);
  EXPECT_NEAR(regression->weights()(1, 0), -low, 1e-5);
  EXPECT_NEAR(regression->biases()[0], regression->biases()[1], 1e-6);
  Eigen::VectorXf sample(1);
  sample << 1;
  EXPECT_NEAR(regression->probabilities(sample)[0], 1 / (1 + std::exp(-2 * low)), 1e-6);
}

TEST(SoftmaxRegression, SeparatesSeparableClasses) {
  std::vector<int> labels;
  const auto samples = clouds({{0, 0}, {5, 0}, {0, 5}}, 30, 0.5F, labels);
  const auto regression = SoftmaxRegression::train(samples, labels, 3, {});
  ASSERT_OK(regression);
  for (Eigen::Index i = 0; i < samples.rows(); ++i) {
    const Eigen::VectorXf probabilities = regression->probabilities(samples.row(i));
    EXPECT_NEAR(probabilities.sum(), 1, 1e-5);
    Eigen::Index best = 0;
    probabilities.maxCoeff(&best);
    EXPECT_EQ(best, labels[static_cast<std::size_t>(i)]);
  }
}

// The loss as its definition says, for Ceres. Parameters: weights class by class, then biases.
class DefinedLoss final : public ceres::FirstOrderFunction {
 public:
  DefinedLoss(Eigen::MatrixXd samples, std::vector<int> labels, int classes, double weight_decay)
      : samples_(std::move(samples)),
        labels_(std::move(labels)),
        classes_(classes),
        weight_decay_(weight_decay) {}
  [[nodiscard]] int NumParameters() const override {
    return classes_ * (static_cast<int>(samples_.cols()) + 1);
  }
  bool Evaluate(const double* parameters, double* cost, double* gradient) const override {
    const Eigen::Index features = samples_.cols();
    const Eigen::Map<const Eigen::MatrixXd> weights(parameters, features, classes_);
    const Eigen::Map<const Eigen::VectorXd> biases(parameters + weights.size(), classes_);
    Eigen::VectorXd sums = Eigen::VectorXd::Zero(NumParameters());
    Eigen::Map<Eigen::MatrixXd>(sums.data(), features, classes_) = weight_decay_ * weights;
    *cost = weight_decay_ / 2 * weights.squaredNorm();
    for (Eigen::Index i = 0; i < samples_.rows(); ++i) {
      const int label = labels_[static_cast<std::size_t>(i)];
      const double weight =
          1.0 / (classes_ * static_cast<double>(std::count(labels_.begin(), labels_.end(), label)));
      const Eigen::VectorXd logits = weights.transpose() * samples_.row(i).transpose() + biases;
      const Eigen::VectorXd p = logits.array().exp() / logits.array().exp().sum();
      *cost -= weight * std::log(p[label]);
      for (int k = 0; k < classes_; ++k) {
        const double residual = weight * (p[k] - (k == label ? 1 : 0));
        sums.segment(k * features, features) += residual * samples_.row(i).transpose();
        sums[weights.size() + k] += residual;
      }
    }
    if (gradient != nullptr) Eigen::Map<Eigen::VectorXd>(gradient, sums.size()) = sums;
    return true;
  }

 private:
  Eigen::MatrixXd samples_;
  std::vector<int> labels_;
  int classes_;
  double weight_decay_;
};

TEST(SoftmaxRegression, FindsTheMinimumThatCeresFinds) {
  // Features as networks give them: none below zero, of length 1, far from the origin.
  RandomStream random(11);
  std::vector<int> labels;
  Eigen::MatrixXf samples(150, 60);
  for (Eigen::Index i = 0; i < samples.rows(); ++i) {
    labels.push_back(static_cast<int>(i % 5 == 0 ? 0 : i % 3));
    for (Eigen::Index k = 0; k < samples.cols(); ++k) {
      samples(i, k) = static_cast<float>(std::abs(1 + 0.5 * random.normal()) +
                                         (k % 7 == labels.back() ? 0.3 : 0));
    }
    samples.row(i).normalize();
  }
  SoftmaxOptions options;
  options.weight_decay = 1e-3;
  options.gradient_tolerance = 1e-6;
  const auto ours = SoftmaxRegression::train(samples, labels, 3, options);
  ASSERT_OK(ours);

  ceres::GradientProblem problem(new DefinedLoss(samples.cast<double>(), labels, 3, 1e-3));
  Eigen::VectorXd parameters = Eigen::VectorXd::Zero(problem.NumParameters());
  ceres::GradientProblemSolver::Options solver;
  solver.max_num_iterations = 2000;
  solver.gradient_tolerance = 1e-10;
  solver.function_tolerance = 0;
  solver.parameter_tolerance = 0;
  solver.logging_type = ceres::SILENT;
  ceres::GradientProblemSolver::Summary summary;
  ceres::Solve(solver, problem, parameters.data(), &summary);
  const Eigen::MatrixXf weights =
      Eigen::Map<Eigen::MatrixXd>(parameters.data(), samples.cols(), 3).transpose().cast<float>();
  EXPECT_LT((ours->weights() - weights).norm(), 2e-3F * weights.norm());
  const SoftmaxRegression theirs(weights, parameters.tail(3).cast<float>());
  for (Eigen::Index i = 0; i < samples.rows(); ++i) {
    EXPECT_LT((ours->probabilities(samples.row(i)) - theirs.probabilities(samples.row(i)))
                  .cwiseAbs()
                  .maxCoeff(),
              1e-3F);
  }
}

// Features that mix a few strong kinds and many weak ones, as a network's do: 300 x 90.
Eigen::MatrixXf mixed_features(std::vector<int>& labels) {
  RandomStream random(3);
  Eigen::MatrixXf kinds(30, 90);
  for (Eigen::Index i = 0; i < kinds.rows(); ++i) {
    for (Eigen::Index k = 0; k < kinds.cols(); ++k)
      kinds(i, k) = static_cast<float>(random.normal() / std::pow(1.3, i));
  }
  Eigen::MatrixXf samples(300, 90);
  labels.clear();
  for (Eigen::Index i = 0; i < samples.rows(); ++i) {
    labels.push_back(static_cast<int>(i % 4));
    samples.row(i).setZero();
    for (Eigen::Index kind = 0; kind < kinds.rows(); ++kind) {
      const double shift = kind % 4 == i % 4 ? 0.7 : 0;
      samples.row(i) += static_cast<float>(random.normal() + shift) * kinds.row(kind);
    }
  }
  return samples;
}

TEST(SoftmaxRegression, IsThereInFewEvaluations) {
  std::vector<int> labels;
  const auto samples = mixed_features(labels);
  SoftmaxOptions thorough, hasty;
  thorough.gradient_tolerance = 1e-7;
  hasty.max_evaluations = 15;
  const auto exact = SoftmaxRegression::train(samples, labels, 4, thorough);
  const auto soon = SoftmaxRegression::train(samples, labels, 4, hasty);
  ASSERT_OK(exact);
  ASSERT_OK(soon);
  EXPECT_LT((soon->weights() - exact->weights()).norm(), 0.02F * exact->weights().norm());
}

TEST(SoftmaxRegression, WithoutWeightDecayOneClassAndEqualSamplesAreLearnedToo) {
  SoftmaxOptions free;
  free.weight_decay = 0;
  std::vector<int> labels;
  const auto samples = clouds({{0, 0}, {1, 0}}, 20, 1, labels);  // they overlap
  const auto two = SoftmaxRegression::train(samples, labels, 2, free);
  ASSERT_OK(two);
  EXPECT_LT(two->weights()(0, 0), two->weights()(1, 0));
  const auto one = SoftmaxRegression::train(samples, std::vector<int>(40, 0), 1, free);
  ASSERT_OK(one);
  EXPECT_EQ(one->probabilities(samples.row(0))[0], 1);
  // Three times as many of class 0: classes weigh the same, and nothing tells them apart.
  const auto equal = SoftmaxRegression::train(Eigen::MatrixXf::Constant(4, 3, 0.5F),
                                              std::vector<int>{0, 0, 0, 1}, 2, free);
  ASSERT_OK(equal);
  EXPECT_NEAR(equal->probabilities(Eigen::Vector3f::Constant(0.5F))[0], 0.5, 1e-4);
}

TEST(SoftmaxRegression, ClassesWeighTheSameHoweverManySamplesEachHas) {
  // The same samples, those of class 1 given nine times: nothing may change.
  std::vector<int> labels;
  const auto samples = clouds({{0, 0}, {1, 0}}, 20, 1, labels);
  Eigen::MatrixXf unbalanced(20 + 9 * 20, 2);
  unbalanced << samples.topRows(20), samples.bottomRows(20).replicate(9, 1);
  std::vector<int> unbalanced_labels(20, 0);
  unbalanced_labels.resize(200, 1);
  SoftmaxOptions options;
  options.gradient_tolerance = 1e-8;
  const auto even = SoftmaxRegression::train(samples, labels, 2, options);
  const auto uneven = SoftmaxRegression::train(unbalanced, unbalanced_labels, 2, options);
  ASSERT_OK(even);
  ASSERT_OK(uneven);
  EXPECT_TRUE(even->weights().isApprox(uneven->weights(), 1e-4F));
  EXPECT_TRUE(even->biases().isApprox(uneven->biases(), 1e-4F));
}

TEST(SoftmaxRegression, WeightDecayKeepsTheWeightsSmall) {
  std::vector<int> labels;
  const auto samples = clouds({{0, 0}, {3, 0}}, 20, 0.5F, labels);
  SoftmaxOptions weak;
  weak.weight_decay = 1e-4;
  SoftmaxOptions strong;
  strong.weight_decay = 1;
  EXPECT_GT(SoftmaxRegression::train(samples, labels, 2, weak)->weights().norm(),
            10 * SoftmaxRegression::train(samples, labels, 2, strong)->weights().norm());
}

TEST(SoftmaxRegression, SamplesThatAreHeldOutAreNotLearnedFrom) {
  std::vector<int> labels;
  const auto samples = clouds({{0, 0}, {1, 0}, {0, 1}}, 50, 1, labels);
  std::vector<int> some = labels;
  std::vector<Eigen::Index> kept;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (i / 10 % 5 == 2) {
      some[i] = SoftmaxRegression::kHeldOut;
    } else {
      kept.push_back(static_cast<Eigen::Index>(i));
    }
  }
  std::vector<int> kept_labels = some;
  std::erase(kept_labels, SoftmaxRegression::kHeldOut);
  SoftmaxOptions options;
  options.gradient_tolerance = 1e-9;
  const auto held_out = SoftmaxRegression::train(samples, some, 3, options);
  const auto alone = SoftmaxRegression::train(samples(kept, Eigen::all), kept_labels, 3, options);
  ASSERT_OK(held_out);
  ASSERT_OK(alone);
  EXPECT_TRUE(held_out->weights().isApprox(alone->weights(), 1e-5F));
  EXPECT_TRUE(held_out->biases().isApprox(alone->biases(), 1e-5F));
  std::ranges::replace(some, 1, SoftmaxRegression::kHeldOut);
  EXPECT_ERROR(SoftmaxRegression::train(samples, some, 3, options), "class 1 has no sample");
}

TEST(SoftmaxRegression, APathOfWeightDecaysEndsAtEachOnesMinimum) {
  std::vector<int> labels;
  const auto samples = mixed_features(labels);
  SoftmaxOptions options;
  options.gradient_tolerance = 1e-8;
  const std::vector<double> decays{1e-2, 1e-3, 1e-4};
  const auto path = SoftmaxRegression::train_path(samples, labels, 4, decays, options);
  ASSERT_OK(path);
  ASSERT_EQ(path->size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    options.weight_decay = decays[i];
    const auto alone = SoftmaxRegression::train(samples, labels, 4, options);
    ASSERT_OK(alone);
    EXPECT_TRUE((*path)[i].weights().isApprox(alone->weights(), 1e-3F)) << decays[i];
  }
}

TEST(SoftmaxRegression, IsTheSameEveryTime) {
  std::vector<int> labels;
  const auto samples = clouds({{0, 0}, {1, 0}, {0, 1}}, 25, 1, labels);
  const auto first = SoftmaxRegression::train(samples, labels, 3, {});
  const auto second = SoftmaxRegression::train(samples, labels, 3, {});
  EXPECT_EQ(first->weights(), second->weights());
  EXPECT_EQ(first->biases(), second->biases());
}

TEST(SoftmaxRegression, LargeLogitsDoNotOverflow) {
  Eigen::MatrixXf weights(2, 1);
  weights << 1e4F, -1e4F;
  const SoftmaxRegression regression(weights, Eigen::VectorXf::Zero(2));
  Eigen::VectorXf sample(1);
  sample << 1;
  EXPECT_FLOAT_EQ(regression.probabilities(sample)[0], 1);
  EXPECT_FLOAT_EQ(regression.probabilities(sample)[1], 0);
}

TEST(SoftmaxRegression, RefusesWhatCannotBeLearned) {
  Eigen::MatrixXf samples = Eigen::MatrixXf::Zero(3, 2);
  const std::vector<int> labels = {0, 1, 0};
  EXPECT_ERROR(SoftmaxRegression::train(samples, labels, 3, {}), "class 2 has no sample");
  EXPECT_ERROR(SoftmaxRegression::train(samples, labels, 1, {}), "sample 1 has the label 1");
  EXPECT_ERROR(SoftmaxRegression::train(samples, std::vector<int>{0, 1}, 2, {}), "3 samples but 2");
  samples(1, 1) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_ERROR(SoftmaxRegression::train(samples, labels, 2, {}), "sample 1 holds a value");
  SoftmaxOptions options;
  options.weight_decay = -1;
  EXPECT_ERROR(SoftmaxRegression::train(samples, labels, 2, options), "weight_decay");
}

}  // namespace
}  // namespace roomwise::rooms
