#include "roomwise/live/device/people.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "roomwise/image/resample.h"
#include "roomwise/pipeline/objects/own_things.h"

namespace roomwise::live {
namespace {

using Side = guide::SeenPerson::Side;

// As COCO, which detectors learn from, calls them.
constexpr std::string_view kPersonLabel = "person";
// From here on by the detector's own word more likely there than not.
constexpr float kMoreLikely = 0.5F;
constexpr double kHalfAnHour_rad = 15 * std::numbers::pi / 180;  // of a clock: 12 o'clock

Side side_of(const network::PixelBox& box, const FrameImages& images,
             const std::optional<geometry::PinholeCamera>& camera) {
  const double middle_px = 0.5 * (static_cast<double>(box.left) + static_cast<double>(box.right));
  const double width_px = images.color.width();
  double aside = 3 * middle_px / width_px - 1.5;  // beyond 0.5 in an outer third
  if (camera) aside = 0.5 * std::atan2(middle_px - camera->cx, camera->fx) / kHalfAnHour_rad;
  if (std::abs(aside) <= 0.5) return Side::kAhead;
  return aside < 0 ? Side::kLeft : Side::kRight;
}

}  // namespace

Expected<std::vector<guide::SeenPerson>> people_in(
    const FrameImages& images, const std::optional<geometry::PinholeCamera>& camera,
    const objects::DetectionFinders& finders) {
  for (const auto& finder : finders) {
    const auto& labels = finder->labels();
    const auto label = std::ranges::find(labels, kPersonLabel);
    if (label == labels.end()) continue;
    ROOMWISE_TRY(const auto detections, finder->find(images.color));
    std::vector<guide::SeenPerson> people;
    for (const network::Detection& one : detections) {
      if (one.label != static_cast<std::size_t>(label - labels.begin())) continue;
      guide::SeenPerson person{side_of(one.box, images, camera), std::nullopt,
                               one.score >= kMoreLikely};
      if (images.depth && camera) {
        const auto middle = pipeline::middle_by_depth(*images.depth, *camera, one.box);
        if (middle) person.distance_m = std::hypot(middle->x(), middle->z());
      }
      people.push_back(person);
    }
    return people;
  }
  return fail("no detector that knows people is at hand");
}

bool is_dark(const image::ColorImage& picture) {
  constexpr int kMinBright =
      32;  // an eighth of the range: below it a sensor's noise is the picture
  const image::GrayImage gray = image::to_gray(picture);
  const auto bright = std::ranges::count_if(
      gray.pixels(), [](std::uint8_t value) { return static_cast<int>(value) >= kMinBright; });
  constexpr std::ptrdiff_t kTwentieth = 20;
  return bright * kTwentieth < static_cast<std::ptrdiff_t>(gray.pixels().size());
}

}  // namespace roomwise::live
