#pragma once

#include <optional>
#include <vector>

#include "roomwise/guide/answers/people_prompts.h"
#include "roomwise/live/recording/frame_images.h"
#include "roomwise/objects/detection/region_finder.h"

// What a picture by itself tells; nothing of it is kept.
namespace roomwise::live {

// The people in a picture, by the first finder that knows them. `camera`: absent where it is not
// calibrated; then sides are thirds of the picture. Fails where no finder knows people.
[[nodiscard]] Expected<std::vector<guide::SeenPerson>> people_in(
    const FrameImages& images, const std::optional<geometry::PinholeCamera>& camera,
    const objects::DetectionFinders& finders);

// Whether so little is bright in it that the room is, by the camera, dark.
[[nodiscard]] bool is_dark(const image::ColorImage& picture);

}  // namespace roomwise::live
