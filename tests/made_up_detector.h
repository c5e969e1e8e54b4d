#pragma once

#include <filesystem>
#include <string>

#include "roomwise/base/file.h"
#include "roomwise/network/testing/tiny_network.h"

namespace roomwise::testing {

// A NanoDet-Plus of two labels that gives the same whatever it is shown: the second label, in a box
// of half the picture's width and height about its middle.
inline std::string detector_of_the_middle() {
  constexpr std::size_t kLabels = 2, kBins = 8, kRow = kLabels + 4 * kBins;
  constexpr std::size_t kAnchors = 64 + 16 + 4 + 1;  // of 64 x 64 pixels
  std::vector<float> rows(kAnchors * kRow, -20.F);
  float* const middle = rows.data() + (4 * 8 + 4) * kRow;  // stride 8: at (32, 32)
  middle[1] = 3;
  for (std::size_t side = 0; side < 4; ++side) middle[kLabels + side * kBins + 2] = 20;
  TinyGraph graph;
  graph.nodes = {node("GlobalAveragePool", "picture", "pooled"), node("Flatten", "pooled", "means"),
                 layer("Gemm", {"means", "weights", "rows"}, {"found"})};
  const auto size = static_cast<std::int64_t>(rows.size());
  graph.constants = {tensor("weights", {3, size}, std::vector<float>(3 * rows.size(), 0.F)),
                     tensor("rows", {size}, rows)};
  graph.input = {1, 3, 64, 64};
  graph.outputs = {{"found", {1, rows.size()}}};
  return onnx(graph);
}

// Puts it into a folder of networks, told apart as bed and toilet.
[[nodiscard]] inline Expected<void> write_detector_of_the_middle(
    const std::filesystem::path& folder) {
  std::error_code ignored;
  std::filesystem::create_directories(folder, ignored);
  ROOMWISE_RETURN_IF_ERROR(write_file(folder / "middle.onnx", detector_of_the_middle()));
  ROOMWISE_RETURN_IF_ERROR(write_file(
      folder / "middle.card.json",
      R"({"task": "nanodet-plus", "input": {"width": 64, "height": 64}, "labels": "kinds.txt"})"));
  return write_file(folder / "kinds.txt", std::string("bed\ntoilet\n"));
}

}  // namespace roomwise::testing
