#include "roomwise/network/vision/dense_classifier.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string_view>

#include "roomwise/network/formats/network_file.h"
#include "roomwise/network/graph/constant_math.h"
#include "roomwise/network/vision/picture_input.h"

namespace roomwise::network {
namespace {

// y = weights * x + bias, as a 1x1 convolution has them.
struct LinearLayer {
  ConstantPointer weights;  // outputs x inputs x 1 x 1
  ConstantPointer bias;     // absent: none
};

Error not_linear(const Node& node, const std::string& why) {
  return Error{fmt::format(
      "cannot say what stands where in a picture: its scores must be linear in the mean of a "
      "feature map over the whole picture, but {} ({}) {}",
      node.name.empty() ? node.outputs.front() : node.name, node.operation, why)};
}

Expected<ConstantPointer> constant_of(const OnnxGraph& graph, const Node& node, std::size_t input) {
  const auto found =
      input < node.inputs.size() ? graph.constants.find(node.inputs[input]) : graph.constants.end();
  if (found == graph.constants.end() || found->second->is_integer) {
    return Unexpected(not_linear(node, "has no fixed weights"));
  }
  return found->second;
}

// The bias at this input, if there is one, in one dimension.
Expected<ConstantPointer> bias_of(const OnnxGraph& graph, const Node& node, std::size_t input,
                                  std::int64_t outputs) {
  if (input >= node.inputs.size() || node.inputs[input].empty()) return ConstantPointer();
  ROOMWISE_TRY(const ConstantPointer bias, constant_of(graph, node, input));
  if (static_cast<std::int64_t>(bias->size()) != outputs)
    return Unexpected(not_linear(node, "has a bias of another size than its output"));
  Constant flat = *bias;
  flat.shape = {outputs};
  return std::make_shared<const Constant>(std::move(flat));
}

// A matrix, outputs x inputs, as the weights of a 1x1 convolution.
ConstantPointer as_kernels(Constant matrix) {
  matrix.shape = {matrix.shape[0], matrix.shape[1], 1, 1};
  return std::make_shared<const Constant>(std::move(matrix));
}

Expected<LinearLayer> linear_convolution(const OnnxGraph& graph, const Node& node) {
  LinearLayer layer;
  ROOMWISE_TRY(layer.weights, constant_of(graph, node, 1));
  const Shape& shape = layer.weights->shape;
  if (shape.size() != 4 || shape[2] != 1 || shape[3] != 1 || node.integer("group", 1) != 1)
    return Unexpected(not_linear(node, "looks at more than one place"));
  ROOMWISE_TRY(layer.bias, bias_of(graph, node, 2, shape[0]));
  return layer;
}

// Gemm, and MatMul with its weights on the right.
Expected<LinearLayer> linear_product(const OnnxGraph& graph, const Node& node) {
  constexpr std::array<std::size_t, 2> kTransposed{1, 0};
  ROOMWISE_TRY(const ConstantPointer weights, constant_of(graph, node, 1));
  const bool has_factors = node.number("alpha", 1) != 1 || node.number("beta", 1) != 1;
  if (weights->shape.size() != 2 || node.integer("transA", 0) != 0 || has_factors)
    return Unexpected(not_linear(node, "is no plain product with a matrix"));
  LinearLayer layer;
  layer.weights =
      as_kernels(node.integer("transB", 0) != 0 ? *weights : permute(*weights, kTransposed));
  ROOMWISE_TRY(layer.bias, bias_of(graph, node, 2, layer.weights->shape[0]));
  return layer;
}

bool is_global_mean(const Node& node) {
  if (node.operation == "GlobalAveragePool") return true;
  std::vector<std::int64_t> axes = node.integers("axes", {});
  for (std::int64_t& axis : axes) axis += axis < 0 ? 4 : 0;
  std::ranges::sort(axes);
  return node.operation == "ReduceMean" && axes == std::vector<std::int64_t>{2, 3};
}

// What lies between the mean and the scores, the last layer first, and the map that the mean is of.
struct ClassifierHead {
  std::vector<LinearLayer> layers;
  std::string feature_map;
};

const Node* node_that_gives(const OnnxGraph& graph, const std::string& value) {
  const auto found = std::ranges::find_if(graph.nodes, [&](const Node& node) {
    return std::ranges::find(node.outputs, value) != node.outputs.end();
  });
  return found == graph.nodes.end() ? nullptr : &*found;
}

// The value of this name, or the first output of the node of this name.
std::string value_named(const OnnxGraph& graph, const std::string& name) {
  if (node_that_gives(graph, name) != nullptr) return name;
  const auto node = std::ranges::find(graph.nodes, name, &Node::name);
  return node == graph.nodes.end() || node->outputs.empty() ? name : node->outputs.front();
}

// Goes back from the scores to the mean.
Expected<ClassifierHead> find_head(const OnnxGraph& graph, const std::string& scores) {
  static const std::set<std::string_view> kKeepsValues{"Flatten",  "Reshape", "Squeeze",
                                                       "Identity", "Dropout", "Unsqueeze"};
  ClassifierHead head;
  std::string value = value_named(graph, scores);
  bool may_be_softmax = true;  // at the very end only
  // The graph was not checked yet: of a cycle no more than each node is looked at.
  for (std::size_t step = 0; step < graph.nodes.size() + 1; ++step) {
    const Node* node = node_that_gives(graph, value);
    if (node == nullptr) {
      return fail(
          "cannot say what stands where in a picture: its scores must be linear in the mean of a "
          "feature map over the whole picture, but nothing gives \"{}\"",
          value);
    }
    if (node->inputs.empty()) return Unexpected(not_linear(*node, "has no input"));
    if (is_global_mean(*node)) {
      if (head.layers.empty())
        return Unexpected(not_linear(*node, "is followed by no linear layer"));
      head.feature_map = node->inputs.front();
      return head;
    }
    if (node->operation == "Conv") {
      ROOMWISE_TRY(LinearLayer layer, linear_convolution(graph, *node));
      head.layers.push_back(std::move(layer));
    } else if (node->operation == "Gemm" || node->operation == "MatMul") {
      ROOMWISE_TRY(LinearLayer layer, linear_product(graph, *node));
      head.layers.push_back(std::move(layer));
    } else if (node->operation == "Softmax" && may_be_softmax) {
    } else if (!kKeepsValues.contains(node->operation)) {
      return Unexpected(not_linear(*node, "comes after it"));
    }
    may_be_softmax = may_be_softmax && head.layers.empty() && node->operation != "Softmax";
    value = node->inputs.front();
  }
  return fail("cannot say what stands where in a picture: its nodes lead round in a circle");
}

// Only what the value needs.
void keep_what_gives(const std::string& value, OnnxGraph& graph) {
  std::set<std::string> needed{value};
  std::vector<Node> kept;
  for (auto node = graph.nodes.rbegin(); node != graph.nodes.rend(); ++node) {
    const bool is_needed = std::ranges::any_of(
        node->outputs, [&](const std::string& output) { return needed.contains(output); });
    if (!is_needed) continue;
    needed.insert(node->inputs.begin(), node->inputs.end());
    kept.push_back(std::move(*node));
  }
  std::ranges::reverse(kept);
  graph.nodes = std::move(kept);
  std::erase_if(graph.constants, [&](const auto& one) { return !needed.contains(one.first); });
}

// A name that nothing in the graph has.
std::string free_name(const OnnxGraph& graph, const std::string& wanted) {
  const auto is_taken = [&](const std::string& name) {
    return graph.constants.contains(name) || node_that_gives(graph, name) != nullptr ||
           std::ranges::find(graph.inputs, name, &GraphInput::name) != graph.inputs.end();
  };
  std::string name = wanted;
  while (is_taken(name)) name += "_";
  return name;
}

std::string add_layer(const LinearLayer& layer, const std::string& from, OnnxGraph& graph) {
  Node node;
  node.operation = "Conv";
  node.name = free_name(graph, "cell_logits");
  node.outputs = {node.name};
  node.inputs = {from, free_name(graph, node.name + ".weight")};
  graph.constants[node.inputs.back()] = layer.weights;
  if (layer.bias != nullptr) {
    node.inputs.push_back(free_name(graph, node.name + ".bias"));
    graph.constants[node.inputs.back()] = layer.bias;
  }
  graph.nodes.push_back(node);
  return node.name;
}

}  // namespace

Expected<OnnxGraph> dense_graph(const OnnxGraph& graph, const std::string& scores) {
  ROOMWISE_TRY(ClassifierHead head, find_head(graph, scores));
  OnnxGraph dense = graph;
  keep_what_gives(head.feature_map, dense);
  std::string value = head.feature_map;
  while (!head.layers.empty()) {
    value = add_layer(head.layers.back(), value, dense);
    head.layers.pop_back();
  }
  dense.outputs = {value};
  dense.output_shapes.clear();
  for (GraphInput& input : dense.inputs) {
    for (std::size_t axis = 2; axis < input.shape.size(); ++axis)
      input.shape[axis] = GraphInput::kDynamic;
  }
  return dense;
}

std::span<const float> CellLogits::at(int column, int row) const {
  const auto cell = static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                    static_cast<std::size_t>(column);
  return std::span(values).subspan(cell * labels, labels);
}

std::vector<float> softmax(std::span<const float> logits) {
  std::vector<float> values(logits.begin(), logits.end());
  const float highest = *std::ranges::max_element(values);
  float total = 0;
  for (float& value : values) {
    value = std::exp(value - highest);
    total += value;
  }
  for (float& value : values) value /= total;
  return values;
}

DenseClassifier::InputSize DenseClassifier::usual_size(const ModelCard& card) {
  constexpr int kStep_px = 32;
  static constexpr int kMin_px = 224;
  constexpr double kWider = 11.0 / 7, kHigher = 8.0 / 7;
  const auto in_steps = [](double share, int side_px) {
    return static_cast<int>(std::lround(share * std::max(side_px, kMin_px) / kStep_px)) * kStep_px;
  };
  return {in_steps(kWider, card.input_width_px), in_steps(kHigher, card.input_height_px)};
}

Expected<std::unique_ptr<DenseClassifier>> DenseClassifier::load(
    const std::filesystem::path& weights, std::optional<InputSize> size,
    const std::optional<std::filesystem::path>& labels) {
  const auto in_file = [&](Error error) { return std::move(error).in(weights.string()); };
  ROOMWISE_TRY(NetworkFile file, read_network_in_floats(weights, labels));
  if (file.card.task != Task::kClassify || file.labels.empty()) {
    return fail("{}: is no network that names what whole pictures show", weights.string());
  }
  std::string scores = file.card.scores_output;
  if (scores.empty() && file.graph.outputs.size() == 1) scores = file.graph.outputs.front();
  if (scores.empty()) {
    return fail("{}: its card does not say which output gives the scores", weights.string());
  }
  ROOMWISE_TRY(OnnxGraph graph, dense_graph(file.graph, scores).map_error(in_file));
  std::unique_ptr<DenseClassifier> classifier(new DenseClassifier());
  ROOMWISE_TRY(classifier->executor_, Executor::create(std::move(graph)).map_error(in_file));
  classifier->card_ = std::move(file.card);
  const InputSize input = size.value_or(usual_size(classifier->card_));
  classifier->card_.input_width_px = input.width_px;
  classifier->card_.input_height_px = input.height_px;
  classifier->card_.fit = PictureFit::kStretch;
  classifier->labels_ = std::move(file.labels);
  classifier->fingerprint_ = std::move(file.fingerprint);
  const image::ColorImage black(input.width_px, input.height_px);
  ROOMWISE_CHECK_OK(classifier->look(black).map_error(in_file));
  return classifier;
}

Expected<CellLogits> DenseClassifier::look(const image::ColorImage& image) const {
  if (image.empty()) return fail("the picture has no pixels");
  const Tensor input = picture_input(image, card_);
  ROOMWISE_TRY(const std::vector<Tensor> outputs, executor_->run({&input, 1}));
  const Tensor& map = outputs.front();
  if (map.shape.size() != 4 || map.shape[1] != static_cast<std::int64_t>(labels_.size())) {
    return fail("the network gives scores of the shape {}, but there are {} labels",
                shape_text(map.shape), labels_.size());
  }
  CellLogits logits;
  logits.rows = static_cast<int>(map.shape[2]);
  logits.columns = static_cast<int>(map.shape[3]);
  logits.labels = labels_.size();
  logits.values.resize(map.values.size());
  const std::size_t cells = map.values.size() / logits.labels;
  for (std::size_t label = 0; label < logits.labels; ++label) {
    for (std::size_t cell = 0; cell < cells; ++cell)
      logits.values[cell * logits.labels + label] = map.values[label * cells + cell];
  }
  return logits;
}

}  // namespace roomwise::network
