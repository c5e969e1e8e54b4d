#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/dnn.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/network/executor/executor.h"

// The same networks run by OpenCV's DNN module, for tests and benchmarks.
namespace roomwise::network::testing {

// Of a file that PyTorch wrote, OpenCV 4.6 takes the padding into every mean, whatever
// count_include_pad says. The name of another maker (which means nothing else) prevents that.
inline std::vector<std::uint8_t> without_maker(std::span<const std::uint8_t> onnx) {
  std::vector<std::uint8_t> changed(onnx.begin(), onnx.end());
  constexpr std::string_view kMaker = "pytorch";
  const auto head_end = changed.begin() + std::min<std::ptrdiff_t>(64, std::ssize(changed));
  const auto found = std::search(changed.begin(), head_end, kMaker.begin(), kMaker.end());
  if (found != head_end) *found = 'P';
  return changed;
}

class OpenCvNetwork {
 public:
  explicit OpenCvNetwork(std::span<const std::uint8_t> onnx) {
    cv::setNumThreads(1);
    const std::vector<std::uint8_t> bytes = without_maker(onnx);
    net_ = cv::dnn::readNetFromONNX(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    net_.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
    net_.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
  }

  // The network's last output.
  std::vector<float> run(const Tensor& input) {
    const std::vector<int> shape(input.shape.begin(), input.shape.end());
    net_.setInput(cv::Mat(shape, CV_32F, const_cast<float*>(input.values.data())));
    const cv::Mat output = net_.forward();
    return {output.ptr<float>(), output.ptr<float>() + output.total()};
  }

 private:
  cv::dnn::Net net_;
};

// The largest difference over the largest of the expected values; infinite where the numbers of
// values differ or one is no number.
inline double relative_error(std::span<const float> values, std::span<const float> expected) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  if (values.size() != expected.size()) return kInfinite;
  double largest = 0, difference = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) return kInfinite;
    largest = std::max(largest, std::abs(static_cast<double>(expected[i])));
    difference = std::max(
        difference, std::abs(static_cast<double>(values[i]) - static_cast<double>(expected[i])));
  }
  return difference == 0 ? 0 : difference / largest;
}

}  // namespace roomwise::network::testing
