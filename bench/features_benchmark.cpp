// What features cost on real pictures of ROOMWISE_DATA: extraction of about 1,000 key-points by
// each method, one row a picture, and matching beside OpenCV's own matcher. How well they match is
// measured by feature_matching_scores.

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <cstdio>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <string>
#include <vector>

#include "feature_methods.h"
#include "feature_pictures.h"
#include "roomwise/features/matcher.h"
#include "roomwise/features/testing/test_pictures.h"

namespace {

using namespace roomwise;
using namespace roomwise::features;

constexpr int kMaxKeypoints = 1000;
constexpr int kPicturesARecording = 4;

void extract(benchmark::State& state, const FeatureExtractor& extractor,
             const image::GrayImage& picture) {
  std::size_t keypoints = 0;
  for (auto _ : state) {
    const Features features = extractor.extract(picture);
    benchmark::DoNotOptimize(keypoints = features.size());
  }
  state.counters["keypoints"] = static_cast<double>(keypoints);
}

// A picture and what the camera might see a moment later.
struct Pair {
  Features query, train;
};

Pair extract_pair(const FeatureExtractor& extractor, const image::GrayImage& picture) {
  return {extractor.extract(picture),
          extractor.extract(testing::warp(picture, 3, 1.03, 0.5).picture)};
}

void match(benchmark::State& state, const FeatureExtractor& extractor,
           const image::GrayImage& picture) {
  const Pair pair = extract_pair(extractor, picture);
  std::size_t matches = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(matches = match_features(pair.query, pair.train).size());
  }
  state.counters["keypoints"] = static_cast<double>(pair.query.size());
  state.counters["matches"] = static_cast<double>(matches);
}

template <typename Descriptors>
cv::Mat as_rows(const Features& features, int type) {
  const auto& rows = std::get<Descriptors>(features.descriptors);
  cv::Mat copy(static_cast<int>(rows.rows()), static_cast<int>(rows.cols()), type);
  std::copy_n(rows.data(), rows.size(), copy.ptr<typename Descriptors::Scalar>());
  return copy;
}

cv::Mat as_rows(const Features& features) {
  return std::holds_alternative<FloatDescriptors>(features.descriptors)
             ? as_rows<FloatDescriptors>(features, CV_32F)
             : as_rows<BinaryDescriptors>(features, CV_8U);
}

// The same work by OpenCV: the two nearest in one direction and the nearest in the other, for the
// ratio test and the mutual check.
void match_by_opencv(benchmark::State& state, const FeatureExtractor& extractor,
                     const image::GrayImage& picture) {
  const Pair pair = extract_pair(extractor, picture);
  const cv::Mat query = as_rows(pair.query), train = as_rows(pair.train);
  const cv::BFMatcher matcher(query.type() == CV_8U ? cv::NORM_HAMMING : cv::NORM_L2);
  for (auto _ : state) {
    std::vector<std::vector<cv::DMatch>> forward, backward;
    matcher.knnMatch(query, train, forward, 2);
    matcher.knnMatch(train, query, backward, 1);
    benchmark::DoNotOptimize(forward.size() + backward.size());
  }
  state.counters["keypoints"] = static_cast<double>(pair.query.size());
}

using Measure = void (*)(benchmark::State&, const FeatureExtractor&, const image::GrayImage&);

void measure(const std::string& name, Measure function, const bench::FeatureMethod& method,
             const std::vector<image::GrayImage>& pictures) {
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    benchmark::RegisterBenchmark(
        fmt::format("{}/{}/picture{}", name, method.name, i + 1).c_str(),
        [&method, function, &picture = pictures[i]](benchmark::State& state) {
          function(state, *method.extractor, picture);
        })
        ->Unit(benchmark::kMillisecond);
  }
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  cv::setNumThreads(1);
  const auto pictures = bench::load_feature_pictures(kPicturesARecording);
  if (!pictures) {
    fmt::print(stderr, "{}\n", pictures.error().message);
    return 1;
  }
  const auto methods = bench::feature_methods(kMaxKeypoints);
  for (const auto& method : methods) measure("extract", extract, method, *pictures);
  for (const auto& method : methods) {
    if (method.name == "surf-portable" || method.name == "dlib-surf") continue;
    measure("match", match, method, *pictures);
    measure("match_by_opencv", match_by_opencv, method, *pictures);
  }
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
