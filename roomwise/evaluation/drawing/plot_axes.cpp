#include "roomwise/evaluation/drawing/plot_axes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace roomwise::evaluation {
namespace {

constexpr double kPxPerTick = 90;

int tick_count(double length_px) {
  return std::max(2, static_cast<int>(length_px / kPxPerTick));
}

// As many decimals as the distance between two ticks has.
std::string tick_text(double value, double step) {
  const int decimals = std::max(0, static_cast<int>(-std::floor(std::log10(step) + 1e-9)));
  return fmt::format("{:.{}f}", value, decimals);
}

}  // namespace

Ticks round_ticks(double low, double high, int count) {
  const double rough_step = (high - low) / count;
  const double power = std::pow(10, std::floor(std::log10(rough_step)));
  double step = 10 * power;
  for (const double factor : {5.0, 2.0, 1.0}) {
    if (factor * power >= rough_step) step = factor * power;
  }
  Ticks ticks{.values = {}, .step = step};
  // Whole multiples, so that zero is zero and no error adds up.
  for (double multiple = std::ceil(low / step - 1e-9); multiple * step <= high + 1e-9 * step;
       ++multiple) {
    ticks.values.push_back(multiple == 0 ? 0 : multiple * step);
  }
  return ticks;
}

SvgDrawing PlotAxes::paper(double width, std::string_view title, std::string_view kind) const {
  SvgDrawing drawing(width, corner.y() + size.y() + 60, fmt::format("{}{}", kind, title));
  drawing.rectangle({0, 0}, drawing.size(), "class=\"paper\"");
  drawing.text({corner.x(), 36}, title, "class=\"heading\"");
  return drawing;
}

Eigen::Vector2d PlotAxes::to_px(const Eigen::Vector2d& value) const {
  const Eigen::Array2d share = (value - low).array() / (high - low).array();
  return {corner.x() + share.x() * size.x(), corner.y() + (1 - share.y()) * size.y()};
}

void PlotAxes::draw(SvgDrawing& drawing, std::string_view x_label, std::string_view y_label) const {
  const double left = corner.x();
  const double right = corner.x() + size.x();
  const double top = corner.y();
  const double bottom = corner.y() + size.y();
  const auto x_ticks = round_ticks(low.x(), high.x(), tick_count(size.x()));
  for (const double tick : x_ticks.values) {
    const double x = to_px({tick, low.y()}).x();
    drawing.line({x, top}, {x, bottom}, "class=\"grid\"");
    drawing.text({x, bottom + 20}, tick_text(tick, x_ticks.step), "class=\"middle\"");
  }
  const auto y_ticks = round_ticks(low.y(), high.y(), tick_count(size.y()));
  for (const double tick : y_ticks.values) {
    const double y = to_px({low.x(), tick}).y();
    drawing.line({left, y}, {right, y}, "class=\"grid\"");
    drawing.text({left - 8, y + 5}, tick_text(tick, y_ticks.step), "class=\"end\"");
  }
  drawing.rectangle(corner, size, "class=\"axis\" fill=\"none\"");
  drawing.text({(left + right) / 2, bottom + 44}, x_label, "class=\"middle\"");
  const double label_x = left - 56;
  const double label_y = (top + bottom) / 2;
  drawing.text(
      {label_x, label_y}, y_label,
      fmt::format("class=\"middle\" transform=\"rotate(-90 {:.2f} {:.2f})\"", label_x, label_y));
}

}  // namespace roomwise::evaluation
