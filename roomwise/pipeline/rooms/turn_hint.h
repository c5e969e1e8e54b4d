#pragma once

#include <optional>
#include <string>

#include "roomwise/image/image.h"

namespace roomwise::pipeline {

enum class Side { kLeft, kRight };

// The half of a picture that shows clearly more: at least three times as many features (ORB) as the
// other, and no few. Nothing where no half does.
[[nodiscard]] std::optional<Side> side_with_more_to_see(const image::ColorImage& picture);

// What to ask a person for after a picture that does not tell the room: to turn to the side where
// there is more to see, with that reason; or just to turn slowly, where the picture favours none.
[[nodiscard]] std::string turn_hint(const image::ColorImage& picture);

}  // namespace roomwise::pipeline
