#include "roomwise/objects/proposals/square_about.h"

#include <algorithm>
#include <cmath>

namespace roomwise::objects {

network::PixelBox square_about(const network::PixelBox& box, float margin, int width_px,
                               int height_px) {
  const float longest = std::max(box.right - box.left, box.bottom - box.top);
  const int side = std::clamp(static_cast<int>(margin * longest), 1, std::min(width_px, height_px));
  const auto begin = [side](float from, float to, int size) {
    return static_cast<float>(
        std::clamp(static_cast<int>((from + to) / 2) - side / 2, 0, size - side));
  };
  const float left = begin(box.left, box.right, width_px);
  const float top = begin(box.top, box.bottom, height_px);
  return {left, top, left + static_cast<float>(side), top + static_cast<float>(side)};
}

}  // namespace roomwise::objects
