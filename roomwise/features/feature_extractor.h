#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string_view>
#include <variant>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/image/image.h"

namespace roomwise::features {

struct Keypoint {
  Eigen::Vector2f position_px =
      Eigen::Vector2f::Zero();  // (0, 0) is the centre of the top left pixel
  float size_px = 0;            // diameter of the described neighbourhood
  float angle_rad = 0;          // orientation, from x to y
  float response = 0;           // strength; comparable within one kind of feature
  // SURF: a light blob on dark ground (the sign of the Laplacian). Light and dark blobs never
  // match. The other kinds leave it false.
  bool bright = false;
};

// A row a key-point. Float descriptors (SURF, SIFT) have unit length and are compared by Euclidean
// distance, binary ones (ORB) by Hamming distance.
using FloatDescriptors = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using BinaryDescriptors =
    Eigen::Matrix<std::uint8_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// keypoints[i] is described by row i of the descriptors; strongest response first.
struct Features {
  std::vector<Keypoint> keypoints;
  std::variant<FloatDescriptors, BinaryDescriptors> descriptors;

  [[nodiscard]] std::size_t size() const { return keypoints.size(); }
};

// Finds and describes key-points. extract() may be called from several threads at once and gives
// the same bits on every call.
class FeatureExtractor {
 public:
  virtual ~FeatureExtractor() = default;
  [[nodiscard]] virtual Features extract(const image::GrayImage& image) const = 0;
};

enum class FeatureKind { kSurf, kSift, kOrb };

[[nodiscard]] Expected<FeatureKind> parse_feature_kind(
    std::string_view name);  // "surf", "sift", "orb"
[[nodiscard]] std::string_view to_string(FeatureKind kind);

// The extractor of a kind with the options that mapping uses; at most `max_keypoints` a picture.
[[nodiscard]] std::unique_ptr<FeatureExtractor> make_extractor(FeatureKind kind, int max_keypoints);

}  // namespace roomwise::features
