#include "roomwise/pipeline/stored/made_from.h"

#include <bit>

namespace roomwise::pipeline {

void MadeFrom::add(std::uint64_t number) {
  for (int shift = 0; shift < 64; shift += 8)
    bytes_.push_back(static_cast<std::uint8_t>(number >> shift));
}

void MadeFrom::add(std::string_view text) {
  add(std::uint64_t{text.size()});
  bytes_.insert(bytes_.end(), text.begin(), text.end());
}

void MadeFrom::add(std::span<const home::Keyframe> keyframes) {
  for (const home::Keyframe& keyframe : keyframes) {
    add(static_cast<std::uint64_t>(keyframe.recording));
    add(std::uint64_t{keyframe.frame_index});
    const geometry::RigidTransform& pose = keyframe.pose.world_from_keyframe;
    for (const double value : pose.translation) add(std::bit_cast<std::uint64_t>(value));
    for (const double value : pose.rotation.coeffs()) add(std::bit_cast<std::uint64_t>(value));
  }
}

}  // namespace roomwise::pipeline
