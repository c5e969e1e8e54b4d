// Any bytes as an ONNX file: read, lowered for small inputs, and run where that is little work.

#include <algorithm>

#include "fuzz_target.h"
#include "roomwise/network/executor/executor.h"
#include "roomwise/network/graph/lowering.h"

namespace {

using namespace roomwise::network;

constexpr std::size_t kMaxFileBytes = 1 << 16;
constexpr std::int64_t kFreeSize = 4;         // in place of a size that the file leaves open
constexpr std::int64_t kMaxInputs = 1 << 12;  // numbers
constexpr std::size_t kMaxNumbers = 1 << 16;  // of all values that come between, to be run

// The sizes to try; none where the file asks for more than is tried.
std::vector<Shape> small_shapes(const OnnxGraph& graph) {
  std::vector<Shape> shapes;
  for (const GraphInput& input : graph.inputs) {
    Shape shape = input.shape;
    std::int64_t count = 1;
    for (std::int64_t& size : shape) {
      if (size == GraphInput::kDynamic) size = kFreeSize;
      if (size < 0 || size > kMaxInputs) return {};
      count *= size;
      if (count > kMaxInputs) return {};
    }
    shapes.push_back(shape);
  }
  return shapes;
}

bool is_little_work(const Program& program) {
  std::size_t numbers = 0;
  for (const auto& value : program.values) {
    for (const std::int64_t size : value.shape) {
      if (size < 0 || size > static_cast<std::int64_t>(kMaxNumbers)) return false;
    }
    numbers += element_count(value.shape);
    if (numbers > kMaxNumbers) return false;
  }
  return true;
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size > kMaxFileBytes) return 0;
  auto graph = read_onnx_graph({data, size});
  if (!graph) return 0;
  const std::vector<Shape> shapes = small_shapes(*graph);
  if (shapes.size() != graph->inputs.size()) return 0;
  const auto program = lower(*graph, shapes, graph->outputs);
  if (!program || !is_little_work(*program)) return 0;
  const auto executor = Executor::create(*std::move(graph));
  if (!executor) return 0;
  std::vector<Tensor> inputs;
  for (const Shape& shape : shapes) {
    inputs.push_back({shape, std::vector<float>(element_count(shape), 0.5F)});
  }
  std::ignore = (*executor)->run(inputs);
  return 0;
}
