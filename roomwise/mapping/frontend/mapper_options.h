#pragma once

#include <cstdint>
#include <string_view>

#include "roomwise/mapping/frontend/loop_closer.h"
#include "roomwise/motion/frame_locator.h"

namespace roomwise::mapping {

enum class MappingMethod {
  kPaper,     // features alone, frame against key-frame
  kCombined,  // whole views where the motion can be predicted, features where not, each checked
};
[[nodiscard]] Expected<MappingMethod> parse_mapping_method(std::string_view name);
[[nodiscard]] std::string_view to_string(MappingMethod method);  // "paper", "combined"

// When the walk goes on from a key-frame that it made earlier, instead of making a new one.
struct ReuseOptions {
  // The camera is nearer to it than this part of the motion that makes a key-frame; 0: never.
  double max_motion_ratio = 0.7;
  // One of the newest so many is gone on from only where whole views leave no doubt, an older one
  // also by its features; none before the map has 15 times as many: new ones make it more exact.
  int min_age = 40;

  [[nodiscard]] Expected<void> validate() const;
};

struct MapperOptions {
  MappingMethod method = MappingMethod::kCombined;
  motion::LocatorOptions locator;
  // The motion is substantial, and the frame becomes a key-frame, from here on.
  double keyframe_translation_m = 0.12;
  double keyframe_rotation_rad = 0.14;
  LoopOptions loops;
  ReuseOptions reuse;
  // After so many frames in a row that match nothing, mapping goes on in a new component.
  int frames_until_new_component = 5;
  // Whether the device's own motion, where it tells it, is taken for a prior. Not in the paper's
  // method.
  bool device_motion = true;
  std::uint64_t seed = 1;

  [[nodiscard]] bool takes_device_motion() const {
    return device_motion && method != MappingMethod::kPaper;
  }
  // The defaults of a method: the paper's draws all its far loop candidates at random.
  [[nodiscard]] static MapperOptions of(MappingMethod method);
  [[nodiscard]] Expected<void> validate() const;
};

}  // namespace roomwise::mapping
