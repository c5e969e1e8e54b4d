#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/image/image.h"
#include "roomwise/network/vision/detector.h"
#include "roomwise/objects/detection/object_vocabulary.h"

namespace roomwise::objects {

// What depth says of a box of a picture: the surface of the thing that it shows, without what
// stands before and behind it. Camera frame, m.
struct DetectionSurface {
  std::vector<Eigen::Vector3f>
      points;  // a sample of the surface, in the order of rows; may be none
  // The share of the box's measured places that lie on the surface, and of all its places that
  // were measured: [0, 1].
  float share = 0;
  float measured = 0;

  friend bool operator==(const DetectionSurface&, const DetectionSurface&) = default;
};

// How something was detected, the surest first.
enum class DetectionSource {
  kDetector,  // by a network that gives boxes
  kProposal,  // by networks that are shown what stands apart in depth (proposal_classifier.h)
};

// How a finder with this fingerprint detects: the method stands in it, behind the weights'. Absent
// for those of earlier programs (class-activation maps), which count no more.
constexpr std::string_view kProposalMethod = " proposals ";
[[nodiscard]] std::optional<DetectionSource> source_of(std::string_view fingerprint);

// What a finder detected in a key-frame, and where depth has it.
struct Detection {
  std::string label;  // as its finder calls it
  float score = 0;    // [0, 1]
  network::PixelBox box;
  DetectionSurface surface;
  DetectionSource source = DetectionSource::kDetector;
  // By the home's vocabulary (classified()); is not stored.
  std::string class_name = {};
  // Otherwise it is one of ObjectVocabulary::look_alikes(): it may take an instance's class away,
  // and is none itself.
  bool is_in_vocabulary = true;
};

// The detections that the vocabulary has a class for, and those of look-alikes, with it.
[[nodiscard]] std::vector<Detection> classified(std::vector<Detection> detections,
                                                const ObjectVocabulary& vocabulary);

// What was looked for and found in a key-frame.
struct KeyframeDetections {
  image::DepthImage coarse_depth;
  std::vector<Detection> detections;  // best first
};

}  // namespace roomwise::objects
