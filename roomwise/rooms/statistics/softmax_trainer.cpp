#include "roomwise/rooms/statistics/softmax_trainer.h"

#include <algorithm>
#include <cmath>

namespace roomwise::rooms {
namespace {

// The blocks of samples are shared out in so many parts, whose sums are added in order: the same
// bits at any number of threads.
constexpr std::size_t kShares = 16;
// Of so many samples it is found along which directions they differ, to learn in fewer steps.
constexpr ComponentLimits kComponents{.rows = 200, .directions = 64};

// How much each sample of a part counts: classes weigh the same, all together 1.
Expected<std::vector<double>> sample_weights(const std::vector<bool>& part,
                                             std::span<const int> labels, int classes) {
  std::vector<double> counts(static_cast<std::size_t>(classes), 0);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (part[i]) counts[static_cast<std::size_t>(labels[i])] += 1;
  }
  for (int k = 0; k < classes; ++k) {
    if (counts[static_cast<std::size_t>(k)] == 0) return fail("class {} has no sample", k);
  }
  std::vector<double> weights(labels.size(), 0);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (part[i]) weights[i] = 1 / (classes * counts[static_cast<std::size_t>(labels[i])]);
  }
  return weights;
}

// Turns a sample's logits into the gradient of its loss times `weight`, adds that to `sums`, too,
// and returns that loss. The gradient over all classes is zero, but not once it is rounded to
// floats: the sums, along which the loss is flat, must not feel that.
double to_residuals(std::span<float> logits, int label, double weight, std::span<double> sums) {
  if (weight == 0) {
    std::ranges::fill(logits, 0.0F);
    return 0;
  }
  const auto own = static_cast<std::size_t>(label);
  const double highest = *std::ranges::max_element(logits);
  const double own_logit = logits[own];
  double sum = 0;
  for (const float logit : logits) sum += std::exp(logit - highest);
  for (std::size_t k = 0; k < logits.size(); ++k) {
    const double probability = std::exp(logits[k] - highest) / sum;
    const double residual = weight * (probability - (k == own ? 1 : 0));
    logits[k] = static_cast<float>(residual);
    sums[k] += residual;
  }
  return weight * (highest + std::log(sum) - own_logit);
}

}  // namespace

// The losses of several regressions, each a column for each class. Parameters: the weights class by
// class, then the biases.
class SoftmaxTrainer::Losses {
 public:
  Losses(const SoftmaxTrainer& trainer, double weight_decay,
         std::vector<std::vector<double>> sample_weights)
      : trainer_(trainer),
        weight_decay_(weight_decay),
        sample_weights_(std::move(sample_weights)),
        features_(trainer.blocks_.features()),
        classes_(static_cast<std::size_t>(trainer.classes_)) {}

  // Evaluates the regressions that are not done, at their places, and tells them.
  void advance(std::vector<Lbfgs>& regressions) const {
    std::vector<std::size_t> active;
    for (std::size_t i = 0; i < regressions.size(); ++i) {
      if (!regressions[i].done()) active.push_back(i);
    }
    const std::size_t columns = active.size() * classes_;
    PaddedRows weights(features_, columns);
    std::vector<float> biases;
    for (std::size_t a = 0; a < active.size(); ++a) {
      const Eigen::VectorXd& place = regressions[active[a]].place();
      for (std::size_t k = 0; k < classes_; ++k) {
        const double* of_class = place.data() + k * features_;
        for (std::size_t f = 0; f < features_; ++f) {
          weights.row(f)[a * classes_ + k] = static_cast<float>(of_class[f]);
        }
        biases.push_back(static_cast<float>(place[index(classes_ * features_ + k)]));
      }
    }

    const std::size_t shares = std::min(kShares, trainer_.blocks_.blocks());
    std::vector<Sums> sums(shares, Sums(features_, columns, active.size()));
    const auto add_up = [&](std::size_t share) {
      add_share(share, shares, active, weights, biases, sums[share]);
    };
    if (trainer_.pool_ != nullptr) {
      trainer_.pool_->parallel_for(shares, add_up);
    } else {
      for (std::size_t share = 0; share < shares; ++share) add_up(share);
    }
    for (std::size_t a = 0; a < active.size(); ++a) tell(regressions[active[a]], a, sums);
  }

 private:
  struct Sums {
    Sums(std::size_t features, std::size_t columns, std::size_t regressions)
        : weights(features, columns), biases(columns), losses(regressions) {}
    PaddedRows weights;
    std::vector<double> biases;
    std::vector<double> losses;
  };
  static Eigen::Index index(std::size_t i) { return static_cast<Eigen::Index>(i); }

  void add_share(std::size_t share, std::size_t shares, std::span<const std::size_t> active,
                 const PaddedRows& weights, std::span<const float> biases, Sums& sums) const {
    const SampleBlocks& blocks = trainer_.blocks_;
    PaddedRows logits(SampleBlocks::kRows, biases.size());
    const std::size_t end = blocks.blocks() * (share + 1) / shares;
    for (std::size_t block = blocks.blocks() * share / shares; block < end; ++block) {
      blocks.multiply(block, weights, logits);
      for (std::size_t row = 0; row < SampleBlocks::kRows; ++row) {
        float* values = logits.row(row);
        const std::size_t sample = block * SampleBlocks::kRows + row;
        if (sample >= blocks.samples()) {
          std::fill_n(values, logits.columns, 0.0F);
          continue;
        }
        for (std::size_t c = 0; c < biases.size(); ++c) values[c] += biases[c];
        for (std::size_t a = 0; a < active.size(); ++a) {
          const std::size_t first = a * classes_;
          sums.losses[a] += to_residuals({values + first, classes_}, trainer_.labels_[sample],
                                         sample_weights_[active[a]][sample],
                                         std::span(sums.biases).subspan(first, classes_));
        }
      }
      blocks.add_transposed_product(block, logits, sums.weights);
    }
  }

  void tell(Lbfgs& regression, std::size_t a, std::span<const Sums> sums) const {
    const Eigen::VectorXd& place = regression.place();
    const auto weights = place.head(index(classes_ * features_));
    double loss = weight_decay_ / 2 * weights.squaredNorm();
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(place.size());
    gradient.head(weights.size()) = weight_decay_ * weights;
    for (const Sums& share : sums) {
      loss += share.losses[a];
      for (std::size_t k = 0; k < classes_; ++k) {
        const std::size_t column = a * classes_ + k;
        double* of_class = gradient.data() + k * features_;
        for (std::size_t f = 0; f < features_; ++f) of_class[f] += share.weights.row(f)[column];
        gradient[index(classes_ * features_ + k)] += share.biases[column];
      }
    }
    regression.tell(loss, gradient);
  }

  const SoftmaxTrainer& trainer_;
  double weight_decay_;
  std::vector<std::vector<double>> sample_weights_;
  std::size_t features_;
  std::size_t classes_;
};

Expected<SoftmaxTrainer> SoftmaxTrainer::create(const Eigen::MatrixXf& samples,
                                                std::span<const int> labels, int classes,
                                                ThreadPool* pool) {
  if (static_cast<std::size_t>(samples.rows()) != labels.size()) {
    return fail("there are {} samples but {} labels", samples.rows(), labels.size());
  }
  if (classes < 1) return fail("there are {} classes; expected at least 1", classes);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (labels[i] < 0 || labels[i] >= classes) {
      return fail("sample {} has the label {}; expected 0 to {}", i, labels[i], classes - 1);
    }
    if (!samples.row(static_cast<Eigen::Index>(i)).allFinite()) {
      return fail("sample {} holds a value that is not finite", i);
    }
  }
  // Biases are free, so that a shift of all samples changes nothing but them; about their mean the
  // samples differ in more directions alike, and the minimum is found in fewer steps.
  const auto count = static_cast<double>(std::max<Eigen::Index>(samples.rows(), 1));
  const Eigen::RowVectorXf mean = (samples.cast<double>().colwise().sum() / count).cast<float>();
  PrincipalComponents components;
  if (samples.rows() > 0) components = principal_components(samples, kComponents);
  return SoftmaxTrainer(SampleBlocks(samples, mean), mean, std::move(components),
                        {labels.begin(), labels.end()}, classes, pool);
}

Expected<std::vector<SoftmaxRegression>> SoftmaxTrainer::train(
    std::span<const std::vector<bool>> parts, const SoftmaxOptions& options,
    std::span<const SoftmaxRegression> starts) const {
  ROOMWISE_CHECK_OK(options.validate());
  std::vector<std::vector<double>> weights;
  std::vector<Lbfgs> minimizers;
  const auto parameters = static_cast<Eigen::Index>(blocks_.features() + 1) * classes_;
  const Lbfgs::Product guess = inverse_curvature(options.weight_decay);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    ROOMWISE_TRY(auto of_part, sample_weights(parts[i], labels_, classes_));
    weights.push_back(std::move(of_part));
    minimizers.emplace_back(
        starts.empty() ? Eigen::VectorXd::Zero(parameters).eval() : parameters_of(starts[i]),
        options.gradient_tolerance, guess);
  }
  const Losses losses(*this, options.weight_decay, std::move(weights));
  for (int i = 0; i < options.max_iterations; ++i) {
    if (std::ranges::all_of(minimizers, &Lbfgs::done)) break;
    losses.advance(minimizers);
  }
  std::vector<SoftmaxRegression> trained;
  for (const Lbfgs& minimizer : minimizers) {
    if (!minimizer.lowest().allFinite()) {
      return fail("the regression diverged; are the samples in scale?");
    }
    trained.push_back(regression_of(minimizer.lowest()));
  }
  return trained;
}

// Where all classes are as likely, the loss of a class's weights bends by the samples' covariance
// over the number of classes, which the principal components tell, and by the weight decay.
Lbfgs::Product SoftmaxTrainer::inverse_curvature(double weight_decay) const {
  // Below that, a direction's variance is not known.
  constexpr double kMinVarianceRatio = 1e-6;
  const Eigen::ArrayXd variances = components_.deviations.cast<double>().array().square();
  const double largest = variances.size() > 0 ? variances[0] : 1;  // 1: nothing is known
  const double of_classes = 1.0 / classes_;
  const double of_others = 1 / (weight_decay + of_classes * std::max(components_.remaining_variance,
                                                                     kMinVarianceRatio * largest));
  const Eigen::VectorXf more =
      ((weight_decay + of_classes * variances).inverse() - of_others).matrix().cast<float>();
  const auto features = static_cast<Eigen::Index>(blocks_.features());
  return [=, this](const Eigen::VectorXd& gradient) {
    const Eigen::Map<const Eigen::MatrixXd> weights(gradient.data(), features, classes_);
    // Lazily: in one order, where a product of matrices is grouped by the processor's caches.
    const Eigen::MatrixXf along =
        components_.directions.transpose().lazyProduct(weights.cast<float>().eval());
    const Eigen::MatrixXf scaled = more.asDiagonal() * along;
    Eigen::VectorXd product(gradient.size());
    Eigen::Map<Eigen::MatrixXd>(product.data(), features, classes_) =
        of_others * weights + components_.directions.lazyProduct(scaled).cast<double>();
    product.tail(classes_) = gradient.tail(classes_) / of_classes;
    return product;
  };
}

Eigen::VectorXd SoftmaxTrainer::parameters_of(const SoftmaxRegression& regression) const {
  const Eigen::MatrixXd weights = regression.weights().cast<double>();
  Eigen::VectorXd parameters(weights.size() + weights.rows());
  for (Eigen::Index k = 0; k < weights.rows(); ++k) {
    parameters.segment(k * weights.cols(), weights.cols()) = weights.row(k);
  }
  parameters.tail(weights.rows()) =
      regression.biases().cast<double>() + weights * mean_.transpose().cast<double>();
  return parameters;
}

SoftmaxRegression SoftmaxTrainer::regression_of(const Eigen::VectorXd& parameters) const {
  const auto features = static_cast<Eigen::Index>(blocks_.features());
  Eigen::MatrixXd weights(classes_, features);
  for (Eigen::Index k = 0; k < classes_; ++k) {
    weights.row(k) = parameters.segment(k * features, features);
  }
  const Eigen::VectorXd biases =
      parameters.tail(classes_) - weights * mean_.transpose().cast<double>();
  return SoftmaxRegression(weights.cast<float>(), biases.cast<float>());
}

}  // namespace roomwise::rooms
