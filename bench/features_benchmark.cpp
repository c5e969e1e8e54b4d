// How long features take: extraction of about as many key-points by each kind, and matching beside
// OpenCV's own matcher. The picture is the first of fr1/rpy where ROOMWISE_DATA has it, otherwise a
// synthetic texture of the same size.

#include <benchmark/benchmark.h>

#include <cstdlib>
#include <filesystem>
#include <opencv2/features2d.hpp>
#include <string>
#include <vector>

#include "roomwise/features/matcher.h"
#include "roomwise/features/test_pictures.h"
#include "roomwise/image/codec.h"
#include "roomwise/image/resample.h"

namespace roomwise::features {
namespace {

constexpr int kMostKeypoints = 1000;

struct Subject {
  image::GrayImage picture;
  std::string name;
};

Subject load_subject() {
  const std::string name = "rgbd_dataset_freiburg1_rpy/rgb/1305031229.528748.jpg";
  if (const char* data = std::getenv("ROOMWISE_DATA"); data != nullptr) {
    if (auto picture = image::read_color(std::filesystem::path(data) / name)) {
      return {image::to_gray(*picture), name};
    }
  }
  return {testing::textured_picture(640, 480, 1), "synthetic texture"};
}

const Subject& subject() {
  static const Subject loaded = load_subject();
  return loaded;
}

const image::GrayImage& picture() {
  return subject().picture;
}

// The picture as the camera might see it a moment later.
const image::GrayImage& next_picture() {
  static const image::GrayImage warped = testing::warp(picture(), 3, 1.03, 0.5).picture;
  return warped;
}

void extract(benchmark::State& state, FeatureKind kind) {
  cv::setNumThreads(1);
  const auto extractor = make_extractor(kind, kMostKeypoints);
  std::size_t keypoints = 0;
  for (auto _ : state) {
    const Features features = extractor->extract(picture());
    benchmark::DoNotOptimize(keypoints = features.size());
  }
  state.SetLabel(subject().name);
  state.counters["keypoints"] = static_cast<double>(keypoints);
}

void match(benchmark::State& state, FeatureKind kind) {
  cv::setNumThreads(1);
  const auto extractor = make_extractor(kind, kMostKeypoints);
  const Features query = extractor->extract(picture());
  const Features train = extractor->extract(next_picture());
  std::size_t matches = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(matches = match_features(query, train).size());
  }
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
  return std::holds_alternative<RealDescriptors>(features.descriptors)
             ? as_rows<RealDescriptors>(features, CV_32F)
             : as_rows<BinaryDescriptors>(features, CV_8U);
}

// The same work by OpenCV: the two nearest in one direction and the nearest in the other, for the
// ratio test and the mutual check.
void match_by_opencv(benchmark::State& state, FeatureKind kind) {
  cv::setNumThreads(1);
  const auto extractor = make_extractor(kind, kMostKeypoints);
  const cv::Mat query = as_rows(extractor->extract(picture()));
  const cv::Mat train = as_rows(extractor->extract(next_picture()));
  const cv::BFMatcher matcher(kind == FeatureKind::kOrb ? cv::NORM_HAMMING : cv::NORM_L2);
  for (auto _ : state) {
    std::vector<std::vector<cv::DMatch>> forward, backward;
    matcher.knnMatch(query, train, forward, 2);
    matcher.knnMatch(train, query, backward, 1);
    benchmark::DoNotOptimize(forward.size() + backward.size());
  }
}

#define ROOMWISE_BENCHMARK_KINDS(function)                                              \
  BENCHMARK_CAPTURE(function, surf, FeatureKind::kSurf)->Unit(benchmark::kMillisecond); \
  BENCHMARK_CAPTURE(function, sift, FeatureKind::kSift)->Unit(benchmark::kMillisecond); \
  BENCHMARK_CAPTURE(function, orb, FeatureKind::kOrb)->Unit(benchmark::kMillisecond)

ROOMWISE_BENCHMARK_KINDS(extract);
ROOMWISE_BENCHMARK_KINDS(match);
ROOMWISE_BENCHMARK_KINDS(match_by_opencv);

}  // namespace
}  // namespace roomwise::features

BENCHMARK_MAIN();
