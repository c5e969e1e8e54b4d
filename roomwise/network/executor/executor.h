#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/network/graph/eight_bit_ranges.h"
#include "roomwise/network/graph/onnx_graph.h"
#include "roomwise/network/graph/passes.h"

namespace roomwise::network {

// Numbers in a shape, row by row; whole numbers too (exact up to 2^24).
struct Tensor {
  Shape shape;
  std::vector<float> values;
};

struct ExecutorOptions {
  // What run() gives: names of ONNX outputs, of other values, or of nodes (then their first
  // output). Empty: the network's own outputs.
  std::vector<std::string> outputs;
  PassOptions passes;
  // How many threads share the work on one input (1 to 64). More than one start at the first run of
  // each thread that calls, and wait by turning round in place: for a caller that wants one answer
  // soon and has idle processors.
  std::size_t threads_per_input = 1;
  // By these, convolutions are worked out in 8 bits (quantization.h), for inputs of their shape
  // only. Absent: in 32-bit floats.
  std::optional<EightBitRanges> eight_bits;
};

// Runs one ONNX network by oneDNN. All functions may be called from several threads at once: they
// share the packed weights, and each has the memory of its run to itself.
//
// One input is worked on by one thread, so that the same input gives the same bits however many
// threads there are and whatever else is run beside it.
class Executor {
 public:
  // Fails where an output is not there, or, of a network whose input sizes are fixed, where an
  // operator is not supported or does not fit its inputs, naming node, operator and opset.
  [[nodiscard]] static Expected<std::unique_ptr<Executor>> create(OnnxGraph graph,
                                                                  ExecutorOptions options = {});
  ~Executor();

  // What the network takes; sizes may be dynamic.
  [[nodiscard]] const std::vector<GraphInput>& inputs() const;

  // One tensor an input, in the order of inputs(); gives one an output. The first run with other
  // shapes makes a plan for them, which is kept. Fails where shapes do not fit the network, and
  // where there is not enough memory.
  [[nodiscard]] Expected<std::vector<Tensor>> run(std::span<const Tensor> inputs) const;

  // Of a network with one input: each tensor is an input of its own. As run() one by one, to the
  // bit, by `threads` threads (at least 1).
  [[nodiscard]] Expected<std::vector<std::vector<Tensor>>> run_batch(std::span<const Tensor> batch,
                                                                     std::size_t threads) const;

 private:
  class Implementation;
  explicit Executor(std::unique_ptr<Implementation> implementation);
  std::unique_ptr<Implementation> implementation_;
};

// What 8 bits need to know of the network that these options describe (in floats), on inputs as it
// will get them: all of one shape, that of its only input. Fails where there are none, and where it
// cannot be run.
[[nodiscard]] Expected<EightBitRanges> calibrate_eight_bits(const OnnxGraph& graph,
                                                            const ExecutorOptions& options,
                                                            std::span<const Tensor> inputs);

}  // namespace roomwise::network
