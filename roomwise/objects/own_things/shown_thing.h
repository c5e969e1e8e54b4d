#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <tl/expected.hpp>

#include "roomwise/base/file.h"
#include "roomwise/image/image.h"
#include "roomwise/network/vision/detector.h"

// A person shows a thing to a camera, to have it known again.
namespace roomwise::objects {

// Why a picture shows nothing to learn a thing from; each can be mended at once by whoever shows
// it.
enum class ShowFault {
  kDark,     // turn on a light
  kGlaring,  // turn away from the window
  kBlurred,  // hold it still
  kEmpty,    // nothing is in the middle
  kFar,      // by depth nothing is in reach of an arm: bring it nearer
};
// As protocols and catalogues call them.
constexpr std::array<std::string_view, 5> kShowFaultNames{"dark", "glaring", "blurred", "empty",
                                                          "far"};
[[nodiscard]] constexpr std::string_view name_of(ShowFault fault) {
  return kShowFaultNames.at(static_cast<std::size_t>(fault));
}

// Depth that lies over a picture, maybe of another size.
struct ShownDepth {
  const image::DepthImage& depth;
  double units_per_metre = 1000;
};

// What a picture shows of a thing.
struct ShownThing {
  image::ColorImage crop;  // the thing, its longer side kShownSide_px at most
  image::GrayImage mask;   // of the crop's size: 255 where the thing is, 0 beside it
  double sharpness = 0;    // 0 to 1: how much of the detail is there that a crop may hold
};
constexpr int kShownSide_px = 256;

// With depth: what is nearest in the middle and hangs together, with the hand that holds it.
// Without: the middle of the picture, three fifths of its width and of its height.
[[nodiscard]] tl::expected<ShownThing, ShowFault> find_shown(
    const image::ColorImage& picture, const std::optional<ShownDepth>& depth = std::nullopt);

// The width of a picture's sharpest edges: the standard deviation of the blur that would make a
// step so wide, px. What has no edge at all has none that is sharp: infinite.
[[nodiscard]] double edge_width_px(const image::GrayImage& picture);

// A view by which a thing is known, as it is kept: all else follows from it.
struct TaughtView {
  Bytes picture;  // JPEG of ShownThing::crop
  Bytes mask;     // 16-bit PNG, 1 where the thing is

  friend bool operator==(const TaughtView&, const TaughtView&) = default;
};
[[nodiscard]] TaughtView taught_view(const ShownThing& shown);
// Sharpness is not kept: 1.
[[nodiscard]] Expected<ShownThing> shown_again(const TaughtView& view);

}  // namespace roomwise::objects
