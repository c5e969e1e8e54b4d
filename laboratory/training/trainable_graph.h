#pragma once

#include <ATen/core/Tensor.h>

#include <optional>
#include <string>
#include <vector>

#include "laboratory/training/operators.h"
#include "roomwise/network/graph/onnx_graph.h"

namespace roomwise::training {

// A weight of the network, or a running statistic of its batch normalisation.
struct GraphTensor {
  std::string name;  // of the initialiser in the graph
  at::Tensor tensor;
  bool trained = false;
};

struct TrainableGraphOptions {
  // What forward() gives: names of values. Empty: the graph's own outputs.
  std::vector<std::string> outputs;
  // Layers before this one are frozen: no gradients, and batch normalisation by its running
  // statistics. A node's name, or the beginning of one that ends before '/', '.' or '_' ("mixed_9"
  // names all of "mixed_9/..."): the first such node, in the file's order, and all after it are
  // trained. Empty: all are.
  std::string from;
  at::Device device = at::kCPU;
};

// A network as libtorch runs it, with gradients: the same description that Executor runs, so that
// what was trained is what is used. Weights of Conv, Gemm, MatMul and BatchNormalization are
// parameters; other numbers of the graph (limits, shapes, factors) stay as they are.
class TrainableGraph {
 public:
  // Fails where a node is not supported, naming it, its operator and the opset, and where a name is
  // not there.
  [[nodiscard]] static Expected<TrainableGraph> create(network::OnnxGraph graph,
                                                       const TrainableGraphOptions& options = {});

  // batch: batch x channels x height x width, on the options' device. `learning`: as training does
  // it, see Operation. Gradients are kept where libtorch's grad mode is on. Not to be called from
  // two threads at once while learning. Fails where a node does not take its inputs.
  [[nodiscard]] Expected<Values> forward(const at::Tensor& batch, bool learning) const;

  // In the order of their first use. Those that are not trained have no gradient.
  [[nodiscard]] const std::vector<GraphTensor>& parameters() const { return parameters_; }
  // Running means and variances; they change while the network learns where they are "trained".
  [[nodiscard]] const std::vector<GraphTensor>& statistics() const { return statistics_; }

  // The graph with the present values.
  [[nodiscard]] network::OnnxGraph graph() const;

 private:
  struct Step {
    std::string who;  // for errors: node "conv1" (Conv, opset 13)
    Operation operation;
    std::vector<std::optional<std::size_t>> inputs;  // places in the list of values
    std::vector<std::size_t> outputs;
    std::vector<std::size_t> last_used;  // values that nobody needs after this step
    bool trained = false;
  };

  struct Builder;

  network::OnnxGraph graph_;
  std::vector<at::Tensor> constants_;  // the first of the values
  std::size_t input_ = 0;
  std::size_t value_count_ = 0;
  std::vector<Step> steps_;
  std::vector<std::size_t> outputs_;
  std::vector<GraphTensor> parameters_, statistics_;
};

// The first node that `from` names, as TrainableGraphOptions::from says it.
[[nodiscard]] Expected<std::size_t> first_trained_node(const network::OnnxGraph& graph,
                                                       const std::string& from);

// Numbers of a graph as a tensor, and back.
[[nodiscard]] at::Tensor tensor_of(const network::Constant& constant);
[[nodiscard]] network::Constant constant_of(const at::Tensor& tensor);

// An error of libtorch in one line.
[[nodiscard]] std::string first_line(const std::exception& error);

}  // namespace roomwise::training
