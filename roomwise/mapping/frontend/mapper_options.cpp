#include "roomwise/mapping/frontend/mapper_options.h"

namespace roomwise::mapping {

MapperOptions MapperOptions::of(MappingMethod method) {
  MapperOptions options;
  options.method = method;
  if (method == MappingMethod::kPaper) {
    options.loops.random = 5;
    options.loops.similar = 0;
    options.reuse.max_motion_ratio = 0;
  }
  return options;
}

Expected<void> ReuseOptions::validate() const {
  if (!(max_motion_ratio >= 0 && max_motion_ratio <= 1)) {
    return fail("max_motion_ratio = {} must be between 0 and 1", max_motion_ratio);
  }
  if (min_age < 0) return fail("min_age = {} must not be negative", min_age);
  return {};
}

Expected<void> MapperOptions::validate() const {
  ROOMWISE_RETURN_IF_ERROR(locator.validate());
  ROOMWISE_RETURN_IF_ERROR(loops.validate());
  ROOMWISE_RETURN_IF_ERROR(reuse.validate());
  if (!(keyframe_translation_m > 0) || !(keyframe_rotation_rad > 0)) {
    return fail("keyframe_translation_m = {} and keyframe_rotation_rad = {} must be positive",
                keyframe_translation_m, keyframe_rotation_rad);
  }
  if (frames_until_new_component < 1) {
    return fail("frames_until_new_component = {} must be at least 1", frames_until_new_component);
  }
  return {};
}

Expected<MappingMethod> parse_mapping_method(std::string_view name) {
  for (const MappingMethod method : {MappingMethod::kPaper, MappingMethod::kCombined}) {
    if (name == to_string(method)) return method;
  }
  return fail("'{}' is not a mapping method; there are combined and paper", name);
}

std::string_view to_string(MappingMethod method) {
  return method == MappingMethod::kPaper ? "paper" : "combined";
}

}  // namespace roomwise::mapping
