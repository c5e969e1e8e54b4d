#include "laboratory/training/training_state.h"

#include <ATen/Functions.h>
#include <ATen/core/grad_mode.h>
#include <torch/optim/adam.h>
#include <torch/optim/rmsprop.h>
#include <torch/optim/sgd.h>
#include <torch/serialize/archive.h>

#include <algorithm>

namespace roomwise::training {
namespace {

using torch::optim::OptimizerParamGroup;
using torch::serialize::InputArchive;
using torch::serialize::OutputArchive;

// Biases and the gains and shifts of batch normalisation are lists; they are not made smaller.
template <typename Options>
std::vector<OptimizerParamGroup> groups_of(const TrainableGraph& graph, Options options,
                                           double weight_decay) {
  std::vector<at::Tensor> weights, others;
  for (const GraphTensor& parameter : graph.parameters()) {
    if (!parameter.trained) continue;
    (parameter.tensor.dim() > 1 ? weights : others).push_back(parameter.tensor);
  }
  std::vector<OptimizerParamGroup> groups;
  groups.emplace_back(others, std::make_unique<Options>(options));
  options.weight_decay(weight_decay);
  groups.emplace_back(weights, std::make_unique<Options>(options));
  return groups;
}

std::unique_ptr<torch::optim::Optimizer> make_optimizer(const TrainableGraph& graph,
                                                        const TrainingOptions& options) {
  const double rate = options.rate.base;
  switch (options.optimizer) {
    case Optimizer::kRmsProp: {
      const auto settings = torch::optim::RMSpropOptions(rate).momentum(options.momentum);
      return std::make_unique<torch::optim::RMSprop>(
          groups_of(graph, settings, options.weight_decay), settings);
    }
    case Optimizer::kAdam: {
      const auto settings =
          torch::optim::AdamOptions(rate).betas(std::make_tuple(options.momentum, 0.999));
      return std::make_unique<torch::optim::Adam>(groups_of(graph, settings, options.weight_decay),
                                                  settings);
    }
    case Optimizer::kSgd:
      break;
  }
  const auto settings = torch::optim::SGDOptions(rate).momentum(options.momentum);
  return std::make_unique<torch::optim::SGD>(groups_of(graph, settings, options.weight_decay),
                                             settings);
}

constexpr std::int64_t kNumbersOfPoint = 4;
std::vector<double> numbers_of(const CurvePoint& point) {
  return {static_cast<double>(point.step), point.cross_entropy, point.held_out_cross_entropy,
          point.held_out_precision};
}
CurvePoint point_of(const double* numbers) {
  return {static_cast<std::int64_t>(numbers[0]), numbers[1], numbers[2], numbers[3]};
}

at::Tensor table_of(const std::vector<CurvePoint>& points) {
  std::vector<double> numbers;
  for (const CurvePoint& point : points) {
    const auto row = numbers_of(point);
    numbers.insert(numbers.end(), row.begin(), row.end());
  }
  return at::tensor(numbers, at::kDouble).view({std::ssize(points), kNumbersOfPoint});
}
std::vector<CurvePoint> points_of(const at::Tensor& table) {
  std::vector<CurvePoint> points;
  const at::Tensor rows = table.contiguous();
  for (std::int64_t i = 0; i < rows.size(0); ++i)
    points.push_back(point_of(rows.data_ptr<double>() + i * kNumbersOfPoint));
  return points;
}

void read_tensors(InputArchive& archive, const std::string& key, std::vector<at::Tensor>& tensors) {
  const at::NoGradGuard no_gradient;
  for (std::size_t i = 0; i < tensors.size(); ++i) {
    at::Tensor stored;
    archive.read(fmt::format("{}{}", key, i), stored, /*is_buffer=*/true);
    TORCH_CHECK(stored.sizes() == tensors[i].sizes(), "holds weights of other sizes");
    tensors[i].copy_(stored);
  }
}

}  // namespace

std::string first_difference(std::string_view before, std::string_view now) {
  const auto line = [](std::string_view& text) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view first = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    return first;
  };
  while (!before.empty() || !now.empty()) {
    const std::string_view then = line(before), today = line(now);
    if (then != today) return fmt::format("\"{}\", not \"{}\"", then, today);
  }
  return "";
}

Expected<Bytes> TrainingState::write(const std::string& fingerprint) const {
  Bytes bytes;
  try {
    OutputArchive archive;
    archive.write("fingerprint", c10::IValue(fingerprint));
    archive.write("step", c10::IValue(step));
    archive.write("loss_sum", c10::IValue(loss_sum));
    archive.write("curve", table_of(curve), true);
    archive.write("best", table_of(best ? std::vector{*best} : std::vector<CurvePoint>{}), true);
    for (std::size_t i = 0; i < tensors.size(); ++i)
      archive.write(fmt::format("tensor{}", i), tensors[i].detach(), true);
    for (std::size_t i = 0; i < best_tensors.size(); ++i)
      archive.write(fmt::format("best_tensor{}", i), best_tensors[i], true);
    OutputArchive of_optimizer(archive.compilation_unit());
    optimizer->save(of_optimizer);
    archive.write("optimizer", of_optimizer);
    archive.save_to([&](const void* data, std::size_t size) {
      const auto* begin = static_cast<const std::uint8_t*>(data);
      bytes.insert(bytes.end(), begin, begin + size);
      return size;
    });
  } catch (const std::exception& error) {  // libtorch's
    return fail("the checkpoint could not be made: {}", first_line(error));
  }
  return bytes;
}

Expected<void> TrainingState::read(const Bytes& bytes, const std::string& fingerprint) {
  try {
    InputArchive archive;
    archive.load_from(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    c10::IValue value;
    archive.read("fingerprint", value);
    if (value.toStringRef() != fingerprint) {
      return fail("is of another training: {}; give the same options, or begin anew",
                  first_difference(value.toStringRef(), fingerprint));
    }
    archive.read("step", value);
    step = value.toInt();
    archive.read("loss_sum", value);
    loss_sum = value.toDouble();
    at::Tensor table;
    archive.read("curve", table, true);
    curve = points_of(table);
    archive.read("best", table, true);
    const auto points = points_of(table);
    best = points.empty() ? std::nullopt : std::optional(points.front());
    read_tensors(archive, "tensor", tensors);
    best_tensors.clear();
    for (std::size_t i = 0; best && i < tensors.size(); ++i)
      best_tensors.push_back(at::empty_like(tensors[i].detach()));
    read_tensors(archive, "best_tensor", best_tensors);
    InputArchive of_optimizer;
    archive.read("optimizer", of_optimizer);
    optimizer->load(of_optimizer);
  } catch (const std::exception& error) {  // libtorch's
    return fail("is no checkpoint of this training, or a damaged one: {}", first_line(error));
  }
  return {};
}

TrainingState begin_training(const TrainableGraph& graph, const TrainingOptions& options) {
  TrainingState state;
  for (const auto* parts : {&graph.parameters(), &graph.statistics()}) {
    for (const GraphTensor& part : *parts) {
      if (part.trained) state.tensors.push_back(part.tensor);
    }
  }
  state.optimizer = make_optimizer(graph, options);
  return state;
}

void descend(TrainingState& state, double learning_rate) {
  for (OptimizerParamGroup& group : state.optimizer->param_groups())
    group.options().set_lr(learning_rate);
  state.optimizer->step();
  state.optimizer->zero_grad();
}

}  // namespace roomwise::training
