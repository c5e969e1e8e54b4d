#include "roomwise/objects/own_things/shown_thing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "roomwise/image/codec.h"
#include "roomwise/image/resample.h"

namespace roomwise::objects {
namespace {

// Physical bounds. A network sees a thing at 224 px; where its sharpest edges are smeared over
// twelve of them (four standard deviations), letters, handles and rims are gone.
constexpr int kSeenSide_px = 224;
constexpr double kMaxEdgeWidth_px = 3;
constexpr int kMinBright = 32;   // an eighth of the range: below it a sensor's noise is the picture
constexpr int kMaxMiddle = 250;  // nothing is above that but what is washed out
constexpr double kMinSpread = 5;       // grey levels; a sensor's noise alone makes two or three
constexpr double kReach_m = 1.5;       // of a stretched arm, from a camera at the chest or the head
constexpr double kThingDepth_m = 0.3;  // what a hand holds is not deeper
constexpr double kSurfaceStep_m = 0.03;  // from pixel to pixel of one surface
constexpr double kMinShareOfPicture = 0.005;
constexpr double kMiddleShare = 0.6;
constexpr double kAroundThing = 0.08;  // of its box, to each side: its outline belongs to it
constexpr int kViewQuality = 92;

int quantile_of(const image::GrayImage& gray, double share) {
  std::array<std::size_t, 256> counts{};
  for (const std::uint8_t value : gray.pixels()) ++counts[value];
  const auto wanted = static_cast<std::size_t>(share * static_cast<double>(gray.pixels().size()));
  std::size_t below = 0;
  for (int value = 0; value < 256; ++value) {
    below += counts[static_cast<std::size_t>(value)];
    if (below > wanted) return value;
  }
  return 255;
}

// Over all three channels: a red thing before a green wall may be even in grey.
double spread_of(const image::ColorImage& picture) {
  double greatest = 0;
  for (const auto channel : {&Rgb8::r, &Rgb8::g, &Rgb8::b}) {
    double sum = 0, squares = 0;
    for (const Rgb8& pixel : picture.pixels()) {
      const double value = pixel.*channel;
      sum += value;
      squares += value * value;
    }
    const auto count = static_cast<double>(picture.pixels().size());
    const double mean = sum / count;
    greatest = std::max(greatest, std::sqrt(std::max(0.0, squares / count - mean * mean)));
  }
  return greatest;
}

image::Image<float> blurred_once(const image::Image<float>& picture) {
  // Twice (1 2 1) / 4 along each axis: a variance of 1 px².
  image::Image<float> now = picture;
  for (int pass = 0; pass < 2; ++pass) {
    for (const bool along_x : {true, false}) {
      image::Image<float> next = now;
      for (int y = 0; y < now.height(); ++y) {
        for (int x = 0; x < now.width(); ++x) {
          const int dx = along_x ? 1 : 0, dy = along_x ? 0 : 1;
          const float before = now.at(std::max(0, x - dx), std::max(0, y - dy));
          const float after =
              now.at(std::min(now.width() - 1, x + dx), std::min(now.height() - 1, y + dy));
          next.at(x, y) = (before + 2 * now.at(x, y) + after) / 4;
        }
      }
      now = std::move(next);
    }
  }
  return now;
}

std::vector<float> slopes_of(const image::Image<float>& picture) {
  std::vector<float> slopes;
  for (int y = 1; y + 1 < picture.height(); ++y) {
    for (int x = 1; x + 1 < picture.width(); ++x) {
      slopes.push_back(std::hypot((picture.at(x + 1, y) - picture.at(x - 1, y)) / 2,
                                  (picture.at(x, y + 1) - picture.at(x, y - 1)) / 2));
    }
  }
  return slopes;
}

// The mean of the steepest fiftieth.
double steepest(std::vector<float> slopes) {
  const std::size_t count = std::max<std::size_t>(1, slopes.size() / 50);
  std::ranges::nth_element(slopes, slopes.begin() + static_cast<std::ptrdiff_t>(count - 1),
                           std::greater<float>{});
  double sum = 0;
  for (std::size_t i = 0; i < count; ++i) sum += static_cast<double>(slopes[i]);
  return sum / static_cast<double>(count);
}

struct FoundPart {
  network::PixelBox box;                 // in the picture
  std::optional<image::GrayImage> mask;  // of the depth's size
};

double metres(const ShownDepth& depth, int x, int y) {
  return depth.depth.at(x, y) / depth.units_per_metre;
}

// The tenth part of the middle that is nearest; nothing where little of it was measured.
std::optional<double> nearest_in_middle_m(const ShownDepth& depth) {
  const int width = depth.depth.width(), height = depth.depth.height();
  std::vector<double> measured;
  for (int y = height / 4; y < height - height / 4; ++y) {
    for (int x = width / 4; x < width - width / 4; ++x) {
      if (depth.depth.at(x, y) != 0) measured.push_back(metres(depth, x, y));
    }
  }
  const std::size_t middle = static_cast<std::size_t>(width) * static_cast<std::size_t>(height) / 4;
  if (measured.size() * 10 < middle) return std::nullopt;
  const auto tenth = measured.begin() + static_cast<std::ptrdiff_t>(measured.size() / 10);
  std::ranges::nth_element(measured, tenth);
  return *tenth;
}

// What hangs together from the nearest pixels of the middle on.
image::GrayImage grow_from_nearest(const ShownDepth& depth, double nearest_m) {
  const int width = depth.depth.width(), height = depth.depth.height();
  image::GrayImage mask(width, height, 0);
  std::vector<std::pair<int, int>> open;
  const auto take = [&](int x, int y) {
    mask.at(x, y) = 255;
    open.emplace_back(x, y);
  };
  for (int y = height / 4; y < height - height / 4; ++y) {
    for (int x = width / 4; x < width - width / 4; ++x) {
      const double here_m = metres(depth, x, y);
      if (here_m > 0 && here_m <= nearest_m + kSurfaceStep_m) take(x, y);
    }
  }
  constexpr std::array<std::pair<int, int>, 4> kBeside{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
  while (!open.empty()) {
    const auto [x, y] = open.back();
    open.pop_back();
    for (const auto& [dx, dy] : kBeside) {
      const int to_x = x + dx, to_y = y + dy;
      if (!depth.depth.contains(to_x, to_y) || mask.at(to_x, to_y) != 0) continue;
      const double there_m = metres(depth, to_x, to_y);
      const bool hangs_together = std::abs(there_m - metres(depth, x, y)) < kSurfaceStep_m;
      if (there_m > 0 && there_m < nearest_m + kThingDepth_m && hangs_together) take(to_x, to_y);
    }
  }
  return mask;
}

network::PixelBox box_of(const image::GrayImage& mask) {
  network::PixelBox box{static_cast<float>(mask.width()), static_cast<float>(mask.height()), 0, 0};
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      if (mask.at(x, y) == 0) continue;
      box.left = std::min(box.left, static_cast<float>(x));
      box.top = std::min(box.top, static_cast<float>(y));
      box.right = std::max(box.right, static_cast<float>(x + 1));
      box.bottom = std::max(box.bottom, static_cast<float>(y + 1));
    }
  }
  return box;
}

network::PixelBox middle_of(const image::ColorImage& picture) {
  const auto width = static_cast<float>(picture.width());
  const auto height = static_cast<float>(picture.height());
  const auto aside = static_cast<float>((1 - kMiddleShare) / 2);
  return {aside * width, aside * height, (1 - aside) * width, (1 - aside) * height};
}

tl::expected<FoundPart, ShowFault> part_with_depth(const image::ColorImage& picture,
                                                   const ShownDepth& depth) {
  const auto nearest_m = nearest_in_middle_m(depth);
  // Too near for the sensor, or glass: the picture alone must do.
  if (!nearest_m) return FoundPart{middle_of(picture), std::nullopt};
  if (*nearest_m > kReach_m) return tl::unexpected(ShowFault::kFar);
  image::GrayImage mask = grow_from_nearest(depth, *nearest_m);
  const auto shown = static_cast<double>(std::ranges::count(mask.pixels(), std::uint8_t{255}));
  if (shown < kMinShareOfPicture * static_cast<double>(mask.pixels().size())) {
    return tl::unexpected(ShowFault::kEmpty);
  }
  network::PixelBox box = box_of(mask);
  const float across = static_cast<float>(picture.width()) / static_cast<float>(mask.width());
  const float down = static_cast<float>(picture.height()) / static_cast<float>(mask.height());
  const auto around = static_cast<float>(kAroundThing);
  const float aside = around * (box.right - box.left), above = around * (box.bottom - box.top);
  box = {std::max(0.F, (box.left - aside) * across), std::max(0.F, (box.top - above) * down),
         std::min(static_cast<float>(picture.width()), (box.right + aside) * across),
         std::min(static_cast<float>(picture.height()), (box.bottom + above) * down)};
  return FoundPart{box, std::move(mask)};
}

// The mask over the crop of the box.
image::GrayImage mask_over(const FoundPart& part, const image::ColorImage& picture, int width,
                           int height) {
  image::GrayImage over(width, height, 255);
  if (!part.mask) return over;
  const image::GrayImage& mask = *part.mask;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float across = (static_cast<float>(x) + 0.5F) / static_cast<float>(width);
      const float down = (static_cast<float>(y) + 0.5F) / static_cast<float>(height);
      const float in_x = part.box.left + across * (part.box.right - part.box.left);
      const float in_y = part.box.top + down * (part.box.bottom - part.box.top);
      const int mask_x = static_cast<int>(in_x * static_cast<float>(mask.width()) /
                                          static_cast<float>(picture.width()));
      const int mask_y = static_cast<int>(in_y * static_cast<float>(mask.height()) /
                                          static_cast<float>(picture.height()));
      over.at(x, y) = mask.contains(mask_x, mask_y) ? mask.at(mask_x, mask_y) : 0;
    }
  }
  return over;
}

}  // namespace

double edge_width_px(const image::GrayImage& picture) {
  if (picture.width() < 3 || picture.height() < 3) return std::numeric_limits<double>::infinity();
  image::Image<float> values(picture.width(), picture.height());
  std::ranges::copy(picture.pixels(), values.pixels().begin());
  // The slope of a step that is blurred by sigma falls as 1 / sigma, and variances add up: how much
  // it falls by one more pixel of blur tells sigma.
  const double before = steepest(slopes_of(values));
  const double after = steepest(slopes_of(blurred_once(values)));
  const double ratio = before > 0 ? after / before : 1;
  if (ratio >= 1) return std::numeric_limits<double>::infinity();
  return ratio / std::sqrt(1 - ratio * ratio);
}

tl::expected<ShownThing, ShowFault> find_shown(const image::ColorImage& picture,
                                               const std::optional<ShownDepth>& depth) {
  if (picture.width() < 3 || picture.height() < 3) return tl::unexpected(ShowFault::kEmpty);
  const image::GrayImage gray = image::to_gray(picture);
  if (quantile_of(gray, 0.95) < kMinBright) return tl::unexpected(ShowFault::kDark);
  if (quantile_of(gray, 0.5) >= kMaxMiddle) return tl::unexpected(ShowFault::kGlaring);
  FoundPart part{middle_of(picture), std::nullopt};
  if (depth && !depth->depth.empty()) {
    auto found = part_with_depth(picture, *depth);
    if (!found) return tl::unexpected(found.error());
    part = *std::move(found);
  }
  const network::PixelBox& box = part.box;
  const float side = std::max(box.right - box.left, box.bottom - box.top);
  const float scale = std::min(1.F, static_cast<float>(kShownSide_px) / side);
  const int width = std::max(3, static_cast<int>(std::lround(scale * (box.right - box.left))));
  const int height = std::max(3, static_cast<int>(std::lround(scale * (box.bottom - box.top))));
  ShownThing shown;
  const image::PictureArea area{static_cast<double>(box.left), static_cast<double>(box.top),
                                static_cast<double>(box.right), static_cast<double>(box.bottom)};
  shown.crop = image::resize(picture, area, width, height);
  if (spread_of(shown.crop) < kMinSpread) return tl::unexpected(ShowFault::kEmpty);
  const double seen_scale =
      static_cast<double>(kSeenSide_px) / static_cast<double>(std::max(width, height));
  const double width_px = edge_width_px(image::to_gray(shown.crop)) * std::max(1.0, seen_scale);
  if (width_px > kMaxEdgeWidth_px) return tl::unexpected(ShowFault::kBlurred);
  shown.sharpness = 1 / (1 + width_px);
  shown.mask = mask_over(part, picture, width, height);
  return shown;
}

TaughtView taught_view(const ShownThing& shown) {
  image::DepthImage mask(shown.mask.width(), shown.mask.height());
  std::ranges::transform(shown.mask.pixels(), mask.pixels().begin(),
                         [](std::uint8_t value) { return std::uint16_t{value != 0}; });
  return {image::encode_jpeg(shown.crop, kViewQuality), image::encode_png(mask)};
}

Expected<ShownThing> shown_again(const TaughtView& view) {
  ShownThing shown;
  ROOMWISE_TRY(shown.crop, image::decode_color(view.picture));
  ROOMWISE_TRY(const image::DepthImage mask, image::decode_depth(view.mask));
  if (mask.width() != shown.crop.width() || mask.height() != shown.crop.height()) {
    return fail("a taught view: its mask is {}x{}, its picture {}x{}", mask.width(), mask.height(),
                shown.crop.width(), shown.crop.height());
  }
  shown.mask = image::GrayImage(mask.width(), mask.height());
  std::ranges::transform(mask.pixels(), shown.mask.pixels().begin(), [](std::uint16_t value) {
    return value != 0 ? std::uint8_t{255} : std::uint8_t{0};
  });
  shown.sharpness = 1;
  return shown;
}

}  // namespace roomwise::objects
