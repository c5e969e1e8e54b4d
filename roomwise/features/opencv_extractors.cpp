#include "roomwise/features/opencv_extractors.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <stdexcept>
#include <tuple>

namespace roomwise::features {
namespace {

// OpenCV's detectors carry state from call to call and promise nothing about threads, so each call
// makes its own; that costs nothing beside the work.

struct Detections {
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
};

Detections detect(cv::Feature2D& detector, const image::GrayImage& image) {
  // OpenCV only reads the pixels, but its matrix header knows no const.
  const cv::Mat pixels(image.height(), image.width(), CV_8UC1,
                       const_cast<std::uint8_t*>(image.pixels().data()));
  Detections found;
  detector.detectAndCompute(pixels, cv::noArray(), found.keypoints, found.descriptors);
  return found;
}

// Places of the key-points in the order strongest first; equal ones by place, size and angle.
std::vector<int> strongest_first(const std::vector<cv::KeyPoint>& keypoints, std::size_t most) {
  std::vector<int> order(keypoints.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](int i) {
    const cv::KeyPoint& k = keypoints[static_cast<std::size_t>(i)];
    return std::tuple(-k.response, k.pt.y, k.pt.x, k.size, k.angle);
  };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return key(a) < key(b); });
  if (most > 0 && order.size() > most) order.resize(most);
  return order;
}

// OpenCV's angles are degrees from x to y in [0, 360).
float signed_radians(float degrees) {
  const float half_turns = degrees > 180 ? degrees / 180 - 2 : degrees / 180;
  return half_turns * std::numbers::pi_v<float>;
}

Keypoint convert(const cv::KeyPoint& keypoint, float size_px) {
  Keypoint result;
  result.position_px = {keypoint.pt.x, keypoint.pt.y};
  result.size_px = size_px;
  result.angle_rad = signed_radians(keypoint.angle);
  result.response = keypoint.response;
  return result;
}

// A level of OpenCV's ORB pyramid is the picture shrunk about its corner to a whole number of
// pixels; but OpenCV brings a place found there back by the level's nominal scale about the centre
// of the first pixel, which is more than a pixel off on the coarse levels. This undoes the one and
// does the other, along one axis.
float place_in_picture(float opencv_px, int level, int extent_px) {
  constexpr double kScalePerLevel = 1.2F;  // OpenCV's default
  const auto nominal = static_cast<float>(std::pow(kScalePerLevel, level));
  const auto level_px = static_cast<float>(cvRound(static_cast<float>(extent_px) * (1 / nominal)));
  return (opencv_px / nominal + 0.5F) * static_cast<float>(extent_px) / level_px - 0.5F;
}

// RootSIFT: the Hellinger kernel of two histograms is the dot product of their square roots.
void root_sift(const float* histogram, float* values, int count) {
  float sum = 0;
  for (int i = 0; i < count; ++i) sum += histogram[i];
  for (int i = 0; i < count; ++i) values[i] = sum > 0 ? std::sqrt(histogram[i] / sum) : 0;
}

}  // namespace

SiftExtractor::SiftExtractor(int max_keypoints, double contrast_threshold)
    : max_keypoints_(max_keypoints), contrast_threshold_(contrast_threshold) {
  if (max_keypoints < 0) throw std::invalid_argument("SiftExtractor: negative max_keypoints");
}

Features SiftExtractor::extract(const image::GrayImage& image) const {
  constexpr int kDescriptorSize = 128;
  Features features{{}, FloatDescriptors(0, kDescriptorSize)};
  if (image.empty()) return features;
  const Detections found = detect(*cv::SIFT::create(max_keypoints_, 3, contrast_threshold_), image);
  const auto order = strongest_first(found.keypoints, static_cast<std::size_t>(max_keypoints_));
  FloatDescriptors descriptors(order.size(), kDescriptorSize);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const cv::KeyPoint& keypoint = found.keypoints[static_cast<std::size_t>(order[i])];
    // OpenCV's size is two sigma; the window is 4 squares of 3 sigma each.
    features.keypoints.push_back(convert(keypoint, 6 * keypoint.size));
    // OpenCV doubles the picture about its corners and halves the found places about the centre of
    // the first pixel, which shifts all of them by a quarter of a pixel.
    features.keypoints.back().position_px.array() -= 0.25F;
    root_sift(found.descriptors.ptr<float>(order[i]),
              descriptors.row(static_cast<Eigen::Index>(i)).data(), kDescriptorSize);
  }
  features.descriptors = std::move(descriptors);
  return features;
}

OrbExtractor::OrbExtractor(int max_keypoints, int corner_threshold)
    : max_keypoints_(max_keypoints), corner_threshold_(corner_threshold) {
  if (max_keypoints < 1) throw std::invalid_argument("OrbExtractor: max_keypoints below 1");
}

Features OrbExtractor::extract(const image::GrayImage& image) const {
  constexpr int kBytes = 32;
  constexpr int kBorderPx = 31;  // OpenCV looks for no key-point nearer to the edge
  Features features{{}, BinaryDescriptors(0, kBytes)};
  // OpenCV fails on pictures whose pyramid ends at nothing.
  if (std::min(image.width(), image.height()) <= 2 * kBorderPx) return features;
  const Detections found = detect(*cv::ORB::create(max_keypoints_, 1.2F, 8, kBorderPx, 0, 2,
                                                   cv::ORB::HARRIS_SCORE, 31, corner_threshold_),
                                  image);
  const auto order = strongest_first(found.keypoints, static_cast<std::size_t>(max_keypoints_));
  BinaryDescriptors descriptors(order.size(), kBytes);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const cv::KeyPoint& keypoint = found.keypoints[static_cast<std::size_t>(order[i])];
    features.keypoints.push_back(convert(keypoint, keypoint.size));
    features.keypoints.back().position_px = {
        place_in_picture(keypoint.pt.x, keypoint.octave, image.width()),
        place_in_picture(keypoint.pt.y, keypoint.octave, image.height())};
    std::copy_n(found.descriptors.ptr<std::uint8_t>(order[i]), kBytes,
                descriptors.row(static_cast<Eigen::Index>(i)).data());
  }
  features.descriptors = std::move(descriptors);
  return features;
}

}  // namespace roomwise::features
