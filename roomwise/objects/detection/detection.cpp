#include "roomwise/objects/detection/detection.h"

#include <utility>

namespace roomwise::objects {

std::optional<DetectionSource> source_of(std::string_view fingerprint) {
  const auto is_by = [&](std::string_view method) {
    return fingerprint.find(method) != std::string_view::npos;
  };
  if (is_by(" activation maps ")) return std::nullopt;
  return is_by(kProposalMethod) ? DetectionSource::kProposal : DetectionSource::kDetector;
}

std::vector<Detection> classified(std::vector<Detection> detections,
                                  const ObjectVocabulary& vocabulary) {
  static const auto look_alikes = ObjectVocabulary::look_alikes();
  std::vector<Detection> kept;
  for (Detection& detection : detections) {
    auto object = vocabulary.object_of(detection.label);
    detection.is_in_vocabulary = object.has_value();
    if (!object) object = look_alikes.object_of(detection.label);
    if (!object) continue;
    detection.class_name = *std::move(object);
    kept.push_back(std::move(detection));
  }
  return kept;
}

}  // namespace roomwise::objects
