#include "laboratory/training/loss.h"

#include <ATen/Functions.h>
#include <ATen/TensorOperators.h>
#include <ATen/core/grad_mode.h>

#include <cmath>
#include <limits>

#include "roomwise/network/vision/picture_input.h"

namespace roomwise::training {
namespace {

using Picture = Expected<std::vector<float>>;

// The values of several pictures, one after the other.
Expected<std::vector<float>> values_of(const TrainingData& data, const network::ModelCard& card,
                                       const std::vector<std::size_t>& pictures, ThreadPool& pool) {
  std::vector<std::future<Picture>> futures;
  for (const std::size_t i : pictures) {
    futures.push_back(pool.submit([&data, &card, i]() -> Picture {
      ROOMWISE_TRY(const image::ColorImage picture, data.picture(i));
      return network::picture_input(picture, card).values;
    }));
  }
  std::vector<Picture> read;  // all of them before an error ends what they work on
  for (auto& future : futures) read.push_back(future.get());
  std::vector<float> values;
  for (const Picture& picture : read) {
    if (!picture) return Unexpected(picture.error());
    values.insert(values.end(), picture->begin(), picture->end());
  }
  return values;
}

// The sum of the cross-entropies, and how many are named rightly.
struct Sums {
  double cross_entropy = 0, right = 0;
};
Sums score(const at::Tensor& logits, const at::Tensor& labels) {
  const at::Tensor entropies =
      at::cross_entropy_loss(logits.flatten(1), labels, {}, at::Reduction::Sum);
  const at::Tensor right = at::eq(logits.flatten(1).argmax(1), labels).sum();
  return {entropies.item<double>(), right.item<double>()};
}

}  // namespace

TensorBatch tensors_of(std::vector<float>& pictures, const std::vector<std::int64_t>& labels,
                       const network::ModelCard& card, at::Device device) {
  const at::Tensor values =
      at::from_blob(pictures.data(),
                    {std::ssize(labels), 3, card.input_height_px, card.input_width_px}, at::kFloat);
  return {values.to(device), at::tensor(labels, at::kLong).to(device)};
}

at::Tensor loss_of(const Values& outputs, const at::Tensor& labels,
                   const TrainingOptions& options) {
  const auto cross_entropy = [&](const at::Tensor& logits) {
    return at::cross_entropy_loss(logits.flatten(1), labels, {}, at::Reduction::Mean, -100,
                                  options.label_smoothing);
  };
  at::Tensor loss = cross_entropy(outputs[0]);
  if (outputs.size() > 1) loss = loss + cross_entropy(outputs[1]) * options.aux_weight;
  return loss;
}

Expected<HeldOutScore> score_held_out(const TrainableGraph& graph, const TrainingTask& task,
                                      const TrainingOptions& options, at::Device device,
                                      Processes& processes) {
  const TrainingData* data = task.held_out;
  if (data == nullptr || data->size() == 0) {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    return HeldOutScore{kNone, kNone};
  }
  const at::NoGradGuard no_gradient;
  ThreadPool pool(options.loader_threads);
  Sums sums;
  const auto stride = static_cast<std::size_t>(processes.count());
  std::vector<std::size_t> pictures;
  for (auto i = static_cast<std::size_t>(processes.rank()); i < data->size(); i += stride) {
    pictures.push_back(i);
    if (std::ssize(pictures) < options.batch && i + stride < data->size()) continue;
    ROOMWISE_TRY(std::vector<float> values, values_of(*data, task.card, pictures, pool));
    std::vector<std::int64_t> labels;
    for (const std::size_t picture : pictures)
      labels.push_back(static_cast<std::int64_t>(data->label(picture)));
    const TensorBatch batch = tensors_of(values, labels, task.card, device);
    ROOMWISE_TRY(const Values outputs, graph.forward(batch.pictures, false));
    const Sums found = score(outputs.front(), batch.labels);
    sums.cross_entropy += found.cross_entropy;
    sums.right += found.right;
    pictures.clear();
  }
  const at::Tensor shared = at::tensor({sums.cross_entropy, sums.right}, at::kFloat).to(device);
  ROOMWISE_RETURN_IF_ERROR(processes.average({&shared, 1}));
  if (processes.count() > 1) {
    sums.cross_entropy = shared[0].item<double>() * processes.count();
    sums.right = std::round(shared[1].item<double>() * processes.count());
  }
  const auto count = static_cast<double>(data->size());
  return HeldOutScore{sums.cross_entropy / count, sums.right / count};
}

}  // namespace roomwise::training
