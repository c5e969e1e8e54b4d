#include "laboratory/training/trainable_graph.h"

#include <ATen/Functions.h>

#include <algorithm>
#include <map>
#include <set>

namespace roomwise::training {
namespace {

std::string name_of(const network::Node& node) {
  return node.name.empty() && !node.outputs.empty() ? node.outputs.front() : node.name;
}

// Numbers that the file holds as nodes become initialisers, so that both are trained alike.
void hoist_constants(network::OnnxGraph& graph) {
  std::erase_if(graph.nodes, [&](const network::Node& node) {
    if (node.operation != "Constant" || node.outputs.size() != 1) return false;
    auto constant = std::make_shared<network::Constant>();
    if (const network::Attribute* value = node.find("value");
        value != nullptr && value->tensor != nullptr) {
      *constant = *value->tensor;
    } else if (const network::Attribute* number = node.find("value_float")) {
      constant->floats = {number->number};
    } else if (const network::Attribute* integer = node.find("value_int")) {
      constant->is_integer = true;
      constant->integers = {integer->integer};
    } else if (const network::Attribute* numbers = node.find("value_floats")) {
      constant->floats = numbers->numbers;
      constant->shape = {std::ssize(constant->floats)};
    } else if (const network::Attribute* integers = node.find("value_ints")) {
      constant->is_integer = true;
      constant->integers = integers->integers;
      constant->shape = {std::ssize(constant->integers)};
    } else {
      return false;
    }
    graph.constants[node.outputs.front()] = std::move(constant);
    return true;
  });
}

// Which inputs of an operator are weights, and which are running statistics.
struct Roles {
  std::vector<std::size_t> weights, statistics;
};
Roles roles_of(const std::string& operation) {
  if (operation == "Conv" || operation == "Gemm") return {{1, 2}, {}};
  if (operation == "MatMul") return {{0, 1}, {}};
  if (operation == "BatchNormalization") return {{1, 2}, {3, 4}};
  return {};
}

// Channels last: libtorch's convolutions, those of single channels above all, are quicker so.
at::Tensor with_layout(const at::Tensor& tensor) {
  return tensor.dim() == 4 ? tensor.contiguous(at::MemoryFormat::ChannelsLast) : tensor;
}

// The values that the outputs hang on.
std::set<std::string> needed_values(const network::OnnxGraph& graph,
                                    const std::vector<std::string>& outputs) {
  std::set<std::string> needed(outputs.begin(), outputs.end());
  for (auto node = graph.nodes.rbegin(); node != graph.nodes.rend(); ++node) {
    const auto wanted = [&](const std::string& value) { return needed.contains(value); };
    if (std::ranges::any_of(node->outputs, wanted))
      needed.insert(node->inputs.begin(), node->inputs.end());
  }
  return needed;
}

}  // namespace

struct TrainableGraph::Builder {
  TrainableGraph& made;
  const TrainableGraphOptions& options;
  std::map<std::string, std::size_t> places = {};
  // An Identity's output: the initialiser behind it.
  std::map<std::string, std::string> same_as = {};
  std::set<std::string> of_input = {};  // values that hang on the network's input
  std::map<std::string, GraphTensor> parameters = {}, statistics = {};
  std::vector<std::string> parameter_order = {}, statistic_order = {};

  std::size_t place_of(const std::string& value) {
    return places.try_emplace(value, places.size()).first->second;
  }

  // The float initialiser that a value is, if it is one.
  [[nodiscard]] std::optional<std::string> initialiser(const std::string& value) const {
    const auto alias = same_as.find(value);
    const std::string& name = alias == same_as.end() ? value : alias->second;
    const auto found = made.graph_.constants.find(name);
    if (found == made.graph_.constants.end() || found->second->is_integer) return std::nullopt;
    return name;
  }

  void add_constants() {
    for (const auto& [name, constant] : made.graph_.constants) {
      place_of(name);
      at::Tensor tensor = tensor_of(*constant);
      if (!constant->is_integer) tensor = with_layout(tensor).to(options.device);
      made.constants_.push_back(std::move(tensor));
    }
  }

  void note_tensor(const network::Node& node, std::size_t input, bool trained,
                   std::map<std::string, GraphTensor>& found, std::vector<std::string>& order) {
    if (input >= node.inputs.size()) return;
    const auto name = initialiser(node.inputs[input]);
    if (!name) return;
    const auto [entry, is_new] =
        found.try_emplace(*name, GraphTensor{*name, made.constants_[place_of(*name)], trained});
    if (is_new) order.push_back(*name);
    // One that is shared is frozen where one of its users is.
    entry->second.trained = entry->second.trained && trained;
  }

  Expected<void> add_node(const network::Node& node, bool trained) {
    Step step;
    step.trained = trained;
    step.who =
        fmt::format("node \"{}\" ({}, opset {})", name_of(node), node.operation, made.graph_.opset);
    const auto in_node = [&](Error error) { return std::move(error).with_context(step.who); };
    ROOMWISE_TRY(step.operation, make_operation(node, made.graph_.opset).map_error(in_node));
    for (const std::string& input : node.inputs) {
      if (!input.empty() && !places.contains(input))
        return fail("{}: nothing before it gives \"{}\"", step.who, input);
      step.inputs.push_back(input.empty() ? std::nullopt : std::optional(place_of(input)));
    }
    if (step.inputs.empty() || node.outputs.empty()) return fail("{}: lacks its input", step.who);
    const auto is_of_input = [&](const std::string& value) { return of_input.contains(value); };
    if (std::ranges::any_of(node.inputs, is_of_input))
      of_input.insert(node.outputs.begin(), node.outputs.end());
    if (node.operation == "Reshape" && !is_of_input(node.inputs[0]))
      step.operation = reshape_of_constant();
    if (node.operation == "Identity") {
      if (const auto name = initialiser(node.inputs[0])) same_as[node.outputs[0]] = *name;
    }
    const Roles roles = roles_of(node.operation);
    for (const std::size_t input : roles.weights)
      note_tensor(node, input, trained, parameters, parameter_order);
    for (const std::size_t input : roles.statistics)
      note_tensor(node, input, trained, statistics, statistic_order);
    for (const std::string& output : node.outputs) step.outputs.push_back(place_of(output));
    made.steps_.push_back(std::move(step));
    return {};
  }

  void finish() {
    made.value_count_ = places.size();
    for (const std::string& name : parameter_order) {
      GraphTensor& parameter = parameters.at(name);
      parameter.tensor.requires_grad_(parameter.trained);
      made.parameters_.push_back(parameter);
    }
    for (const std::string& name : statistic_order) made.statistics_.push_back(statistics.at(name));
    std::set<std::size_t> kept(made.outputs_.begin(), made.outputs_.end());
    for (auto step = made.steps_.rbegin(); step != made.steps_.rend(); ++step) {
      for (const auto& input : step->inputs) {
        if (input && kept.insert(*input).second) step->last_used.push_back(*input);
      }
    }
  }
};

Expected<TrainableGraph> TrainableGraph::create(network::OnnxGraph graph,
                                                const TrainableGraphOptions& options) {
  TrainableGraph made;
  made.graph_ = std::move(graph);
  hoist_constants(made.graph_);
  if (made.graph_.inputs.size() != 1)
    return fail("the network has {} inputs; expected one", made.graph_.inputs.size());
  ROOMWISE_TRY(const std::size_t first, first_trained_node(made.graph_, options.from));
  Builder builder{made, options};
  builder.add_constants();
  made.input_ = builder.place_of(made.graph_.inputs.front().name);
  builder.of_input.insert(made.graph_.inputs.front().name);
  const auto& outputs = options.outputs.empty() ? made.graph_.outputs : options.outputs;
  const std::set<std::string> needed = needed_values(made.graph_, outputs);
  for (std::size_t i = 0; i < made.graph_.nodes.size(); ++i) {
    const network::Node& node = made.graph_.nodes[i];
    const auto wanted = [&](const std::string& value) { return needed.contains(value); };
    if (!std::ranges::any_of(node.outputs, wanted)) continue;
    ROOMWISE_RETURN_IF_ERROR(builder.add_node(node, i >= first));
  }
  for (const std::string& output : outputs) {
    if (!builder.places.contains(output)) return fail("the network has no output \"{}\"", output);
    made.outputs_.push_back(builder.place_of(output));
  }
  builder.finish();
  return made;
}

Expected<Values> TrainableGraph::forward(const at::Tensor& batch, bool learning) const {
  std::vector<at::Tensor> values = constants_;
  values.resize(value_count_);
  values[input_] = with_layout(batch);
  for (const Step& step : steps_) {
    Values inputs;
    for (const auto& input : step.inputs) inputs.push_back(input ? values[*input] : at::Tensor());
    try {
      Values results = step.operation(inputs, learning && step.trained);
      for (std::size_t i = 0; i < std::min(results.size(), step.outputs.size()); ++i)
        values[step.outputs[i]] = std::move(results[i]);
    } catch (const std::exception& error) {  // libtorch's
      return fail("{}: {}", step.who, first_line(error));
    }
    for (const std::size_t value : step.last_used) values[value] = at::Tensor();
  }
  Values results;
  for (const std::size_t output : outputs_) results.push_back(values[output]);
  return results;
}

network::OnnxGraph TrainableGraph::graph() const {
  network::OnnxGraph graph = graph_;
  for (const auto* tensors : {&parameters_, &statistics_}) {
    for (const GraphTensor& part : *tensors)
      graph.constants[part.name] =
          std::make_shared<const network::Constant>(constant_of(part.tensor));
  }
  return graph;
}

Expected<std::size_t> first_trained_node(const network::OnnxGraph& graph, const std::string& from) {
  if (from.empty()) return std::size_t{0};
  const auto named = [&](const network::Node& node) {
    const std::string name = name_of(node);
    if (!name.starts_with(from)) return false;
    return name.size() == from.size() ||
           std::string_view("/._").find(name[from.size()]) != std::string_view::npos;
  };
  const auto found = std::ranges::find_if(graph.nodes, named);
  if (found != graph.nodes.end()) return static_cast<std::size_t>(found - graph.nodes.begin());
  std::vector<std::string> names;
  for (const network::Node& node : graph.nodes) names.push_back(name_of(node));
  constexpr std::size_t kShown = 20;
  if (names.size() > kShown) names.erase(names.begin(), names.end() - kShown);
  return fail("the network has no node or block \"{}\" to train from; its last nodes are {}", from,
              fmt::join(names, ", "));
}

at::Tensor tensor_of(const network::Constant& constant) {
  // from_blob() takes what may be written to; clone() only reads it.
  if (constant.is_integer) {
    auto* integers = const_cast<std::int64_t*>(constant.integers.data());
    return at::from_blob(integers, constant.shape, at::kLong).clone();
  }
  auto* floats = const_cast<float*>(constant.floats.data());
  return at::from_blob(floats, constant.shape, at::kFloat).clone();
}

network::Constant constant_of(const at::Tensor& tensor) {
  network::Constant constant;
  constant.shape = tensor.sizes().vec();
  constant.is_integer = !tensor.is_floating_point();
  if (constant.is_integer) {
    constant.integers = integers_of(tensor);
    return constant;
  }
  const at::Tensor flat = tensor.detach().to(at::kCPU, at::kFloat).contiguous();
  const auto* values = flat.data_ptr<float>();
  constant.floats.assign(values, values + flat.numel());
  return constant;
}

std::string first_line(const std::exception& error) {
  const std::string text = error.what();
  return text.substr(0, text.find('\n'));
}

}  // namespace roomwise::training
