// Resize and Upsample: another height and width.
#include <algorithm>
#include <cmath>

#include "roomwise/network/graph/lowering.h"

namespace roomwise::network {
namespace {

struct ResizeRule {
  std::string coordinates;  // how a place of the output is found in the input
  std::string nearest;      // how the nearest place is rounded
  bool is_linear = false;
};

// The place in the input, in pixels, of the output's place `i` (the formulas of ONNX's Resize).
double place_in_input(const ResizeRule& rule, std::int64_t i, std::int64_t inputs,
                      std::int64_t outputs, double scale) {
  const auto x = static_cast<double>(i);
  if (rule.coordinates == "asymmetric") return x / scale;
  if (rule.coordinates == "align_corners") {
    return outputs == 1 ? 0.0
                        : x * static_cast<double>(inputs - 1) / static_cast<double>(outputs - 1);
  }
  if (rule.coordinates == "pytorch_half_pixel" && outputs == 1) return 0;
  return (x + 0.5) / scale - 0.5;
}

double round_nearest(const std::string& nearest, double x) {
  if (nearest == "floor") return std::floor(x);
  if (nearest == "ceil") return std::ceil(x);
  if (nearest == "round_prefer_ceil") return std::floor(x + 0.5);
  return std::ceil(x - 0.5);  // round_prefer_floor
}

std::vector<Resampling::Tap> taps_of(const ResizeRule& rule, std::int64_t inputs,
                                     std::int64_t outputs, double scale) {
  const auto inside = [&](double place) {
    return static_cast<std::size_t>(std::clamp(place, 0.0, static_cast<double>(inputs - 1)));
  };
  std::vector<Resampling::Tap> taps;
  for (std::int64_t i = 0; i < outputs; ++i) {
    const double place = place_in_input(rule, i, inputs, outputs, scale);
    if (rule.is_linear) {
      const double low = std::floor(place);
      taps.push_back({inside(low), inside(low + 1), static_cast<float>(place - low)});
    } else {
      const std::size_t nearest = inside(round_nearest(rule.nearest, place));
      taps.push_back({nearest, nearest, 0});
    }
  }
  return taps;
}

Expected<ResizeRule> rule_of(const Lowering& lowering, const Node& node) {
  ResizeRule rule;
  const std::string mode = node.text("mode", "nearest");
  if (mode != "nearest" && mode != "linear") {
    return fail("its mode \"{}\" is not supported; \"nearest\" and \"linear\" are", mode);
  }
  rule.is_linear = mode == "linear";
  const bool old = lowering.opset() < 11;  // before these attributes
  rule.coordinates = old ? "asymmetric" : node.text("coordinate_transformation_mode", "half_pixel");
  rule.nearest = old ? "floor" : node.text("nearest_mode", "round_prefer_floor");
  constexpr std::array kCoordinates{"asymmetric", "align_corners", "pytorch_half_pixel",
                                    "half_pixel"};
  if (std::ranges::find(kCoordinates, rule.coordinates) == kCoordinates.end()) {
    return fail("its coordinate_transformation_mode \"{}\" is not supported", rule.coordinates);
  }
  constexpr std::array kNearest{"round_prefer_floor", "round_prefer_ceil", "floor", "ceil"};
  if (std::ranges::find(kNearest, rule.nearest) == kNearest.end()) {
    return fail("its nearest_mode \"{}\" is none of {}", rule.nearest, fmt::join(kNearest, ", "));
  }
  return rule;
}

struct NewSize {
  Shape shape;
  std::vector<double> scales;  // an axis each
};

// The output's shape, said by `sizes` or by `scales`.
Expected<NewSize> new_size(const Lowering& lowering, const Node& node, const Shape& shape) {
  NewSize result{shape, std::vector<double>(shape.size(), 1)};
  const bool old = lowering.opset() < 11;
  if (!old && lowering.has_input(node, 3)) {
    ROOMWISE_TRY(const auto sizes, lowering.integers_input(node, 3));
    if (sizes.size() != shape.size()) return fail("has {} sizes", sizes.size());
    result.shape = sizes;
    for (std::size_t i = 0; i < shape.size(); ++i) {
      result.scales[i] = static_cast<double>(sizes[i]) / static_cast<double>(shape[i]);
    }
    return result;
  }
  ROOMWISE_TRY(const std::vector<float> scales, lowering.floats_input(node, old ? 1 : 2));
  if (scales.size() != shape.size()) return fail("has {} scales", scales.size());
  for (std::size_t i = 0; i < shape.size(); ++i) {
    if (!(scales[i] > 0 && scales[i] < 1e4F)) return fail("its scale {} is impossible", scales[i]);
    result.scales[i] = static_cast<double>(scales[i]);
    result.shape[i] = static_cast<std::int64_t>(
        std::floor(static_cast<double>(shape[i]) * static_cast<double>(scales[i])));
  }
  return result;
}

}  // namespace

Expected<ValueId> lower_resize(Lowering& lowering, const Node& node) {
  ROOMWISE_TRY(const ValueId input, lowering.input(node, 0));
  const Shape shape = lowering.shape(input);
  ROOMWISE_TRY(const ResizeRule rule, rule_of(lowering, node));
  ROOMWISE_TRY(const NewSize size, new_size(lowering, node, shape));
  ROOMWISE_RETURN_IF_ERROR(check_size(size.shape));
  if (shape.size() != 4 || size.shape[0] != shape[0] || size.shape[1] != shape[1] ||
      size.shape[2] < 1 || size.shape[3] < 1) {
    return fail("from {} to {} is not supported; height and width may change", shape_text(shape),
                shape_text(size.shape));
  }
  Resampling resampling;
  resampling.rows = taps_of(rule, shape[2], size.shape[2], size.scales[2]);
  resampling.columns = taps_of(rule, shape[3], size.shape[3], size.scales[3]);
  return lowering.add(std::move(resampling), {input}, size.shape);
}

}  // namespace roomwise::network
