#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/network/executor/executor.h"
#include "roomwise/network/testing/opencv_network.h"
#include "roomwise/network/testing/tiny_network.h"

// Small networks, run by us and by OpenCV.
namespace roomwise::network::testing {

using roomwise::testing::attribute;
using roomwise::testing::layer;
using roomwise::testing::onnx;
using roomwise::testing::tensor;
using roomwise::testing::TinyGraph;

inline std::vector<float> random_values(std::size_t count, std::uint64_t seed) {
  RandomStream random(seed);
  std::vector<float> values;
  for (std::size_t i = 0; i < count; ++i) values.push_back(static_cast<float>(random.normal()));
  return values;
}

inline Tensor random_tensor(const Shape& shape, std::uint64_t seed = 1) {
  return {shape, random_values(element_count(shape), seed)};
}

// A tensor of random weights.
inline std::string random_weights(const std::string& name, const std::vector<std::int64_t>& shape,
                                  std::uint64_t seed) {
  std::size_t count = 1;
  for (const std::int64_t size : shape) count *= static_cast<std::size_t>(size);
  return tensor(name, shape, random_values(count, seed));
}

inline std::span<const std::uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

inline Expected<std::unique_ptr<Executor>> load(const std::string& file,
                                                ExecutorOptions options = {}) {
  ROOMWISE_TRY(OnnxGraph graph, read_onnx_graph(bytes_of(file)));
  return Executor::create(std::move(graph), std::move(options));
}

inline Expected<std::vector<Tensor>> run(const std::string& file, const Tensor& input,
                                         ExecutorOptions options = {}) {
  ROOMWISE_TRY(const auto executor, load(file, std::move(options)));
  return executor->run({&input, 1});
}

inline Shape input_shape(const TinyGraph& graph) {
  return {graph.input.begin(), graph.input.end()};
}

// The same file said to be PyTorch's (of a field that is given twice the last counts): of others
// OpenCV 4.6 leaves the padding out of every mean, whatever count_include_pad says.
inline std::vector<std::uint8_t> as_by_pytorch(std::vector<std::uint8_t> file) {
  const std::string maker = roomwise::testing::field(2, std::string("pytorch"));
  file.insert(file.end(), maker.begin(), maker.end());
  return file;
}

// That OpenCV gives the same for random numbers.
inline void expect_like_opencv(const TinyGraph& graph, double tolerance = 1e-5) {
  const std::string file = onnx(graph);
  const Tensor input = random_tensor(input_shape(graph));
  const auto outputs = run(file, input);
  ASSERT_OK(outputs);
  const std::vector<float> expected = OpenCvNetwork(bytes_of(file)).run(input);
  EXPECT_LT(relative_error(outputs->front().values, expected), tolerance);
}

}  // namespace roomwise::network::testing
