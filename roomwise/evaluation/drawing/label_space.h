#pragma once

#include <Eigen/Core>
#include <string_view>
#include <vector>

namespace roomwise::evaluation {

// Where labels stand in a drawing already, so that none covers another. In px, y down.
class LabelSpace {
 public:
  static constexpr double kLetterWidth = 0.6;  // of the font's size, about

  explicit LabelSpace(const Eigen::Vector2d& size) : size_(size) {}

  struct Box {
    Eigen::Vector2d low;
    Eigen::Vector2d high;
  };
  // Of a text whose baseline begins at `start`.
  [[nodiscard]] static Box of_text(const Eigen::Vector2d& start, std::string_view text,
                                   double font_px) {
    return {{start.x(), start.y() - 0.8 * font_px},
            {start.x() + width_of(text, font_px), start.y() + 0.25 * font_px}};
  }
  [[nodiscard]] static double width_of(std::string_view text, double font_px) {
    return kLetterWidth * font_px * static_cast<double>(text.size());
  }

  // Inside the drawing, and nothing stands there.
  [[nodiscard]] bool is_free(const Box& box) const {
    if ((box.low.array() < 0).any() || (box.high.array() > size_.array()).any()) return false;
    for (const Box& other : taken_) {
      if ((box.low.array() < other.high.array()).all() &&
          (other.low.array() < box.high.array()).all()) {
        return false;
      }
    }
    return true;
  }
  void take(const Box& box) { taken_.push_back(box); }

 private:
  Eigen::Vector2d size_;
  std::vector<Box> taken_;
};

}  // namespace roomwise::evaluation
