#include "roomwise/objects/own_things/own_thing_finder.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "roomwise/image/resample.h"
#include "roomwise/objects/own_things/placed_features.h"
#include "roomwise/objects/proposals/square_about.h"

namespace roomwise::objects {
namespace {

constexpr float kAround = 1.1F;     // a network sees a place with a rim about it
constexpr float kSamePlace = 0.7F;  // boxes that overlap so are looked at once
constexpr std::size_t kViewsInMean = 3;
constexpr int kWorkingWidth_px = 640;  // of pictures; wider ones are shrunk

double dot_product(std::span<const float> a, std::span<const float> b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    sum += static_cast<double>(a[i]) * static_cast<double>(b[i]);
  }
  return sum;
}

image::ColorImage part_of(const image::ColorImage& picture, const network::PixelBox& box) {
  const network::PixelBox square = square_about(box, kAround, picture.width(), picture.height());
  return image::crop(picture, static_cast<int>(square.left), static_cast<int>(square.top),
                     std::max(1, static_cast<int>(square.right - square.left)),
                     std::max(1, static_cast<int>(square.bottom - square.top)));
}

network::PixelBox cut_to(const network::PixelBox& box, const image::ColorImage& picture) {
  return network::intersection(
      box, {0, 0, static_cast<float>(picture.width()), static_cast<float>(picture.height())});
}

// Only those that the mask holds.
features::Features inside(const features::Features& all, const image::GrayImage& mask) {
  features::Features kept;
  std::vector<Eigen::Index> rows;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const int x = static_cast<int>(std::lround(all.keypoints[i].position_px.x()));
    const int y = static_cast<int>(std::lround(all.keypoints[i].position_px.y()));
    if (!mask.contains(x, y) || mask.at(x, y) == 0) continue;
    kept.keypoints.push_back(all.keypoints[i]);
    rows.push_back(static_cast<Eigen::Index>(i));
  }
  std::visit(
      [&](const auto& descriptors) {
        auto some = descriptors;
        some.resize(static_cast<Eigen::Index>(rows.size()), descriptors.cols());
        for (std::size_t i = 0; i < rows.size(); ++i) {
          some.row(static_cast<Eigen::Index>(i)) = descriptors.row(rows[i]);
        }
        kept.descriptors = std::move(some);
      },
      all.descriptors);
  return kept;
}

// Where in a picture the colours are most like those of the view. Sides are those of things at
// arm's length to across a room.
std::optional<network::PixelBox> colored_window(const IntegralColorHistogram& table,
                                                const PreparedView& view, int width_px,
                                                int height_px) {
  constexpr std::array kSides{0.08F, 0.13F, 0.2F, 0.32F, 0.5F};  // of the picture's width
  const float shape = static_cast<float>(view.width_px) / static_cast<float>(view.height_px);
  std::optional<network::PixelBox> best;
  double max_similarity = 0;
  const auto picture_width = static_cast<float>(width_px);
  const auto picture_height = static_cast<float>(height_px);
  for (const float side : kSides) {
    const float width = side * picture_width * std::sqrt(shape);
    const float height = side * picture_width / std::sqrt(shape);
    for (float top = 0; top + height <= picture_height; top += height / 3) {
      for (float left = 0; left + width <= picture_width; left += width / 3) {
        const network::PixelBox box{left, top, left + width, top + height};
        const double alike = color_likeness(view.color, table.shares(box));
        if (alike <= max_similarity) continue;
        max_similarity = alike;
        best = box;
      }
    }
  }
  return best;
}

// How many of the view's agreeing features lie in the box.
std::size_t inliers_in(const PlacedView& placed, const network::PixelBox& box) {
  return static_cast<std::size_t>(std::ranges::count_if(placed.places_px, [&](const auto& place) {
    return place.x() >= box.left && place.x() < box.right && place.y() >= box.top &&
           place.y() < box.bottom;
  }));
}

MatchFeatures match_features(const PreparedThing& thing, std::span<const float> seen,
                             const ColorHistogram& colors, std::size_t agreeing) {
  std::vector<double> similar;
  double color = 0;
  for (const PreparedView& view : thing.views) {
    similar.push_back(dot_product(seen, view.embedding));
    color = std::max(color, color_likeness(view.color, colors));
  }
  if (similar.empty()) return {};
  std::ranges::sort(similar, std::ranges::greater{});
  const auto in_mean = static_cast<std::ptrdiff_t>(std::min(kViewsInMean, similar.size()));
  const double sum = std::accumulate(similar.begin(), similar.begin() + in_mean, 0.0);
  return {similar.front(), sum / static_cast<double>(in_mean),
          std::log1p(static_cast<double>(agreeing)), color};
}

}  // namespace

struct OwnThingFinder::Places {
  const SearchedPicture& picture;
  std::vector<network::PixelBox> boxes;
  std::vector<std::vector<PlacedView>> placed;  // by thing

  // Of what is large enough to be seen.
  void add(const network::PixelBox& box) {
    constexpr float kMinSide_px = 12;
    const network::PixelBox cut = cut_to(box, picture.color_);
    if (cut.right - cut.left < kMinSide_px || cut.bottom - cut.top < kMinSide_px) return;
    const bool is_known = std::ranges::any_of(boxes, [&](const network::PixelBox& other) {
      return network::intersection_over_union(other, cut) > kSamePlace;
    });
    if (!is_known) boxes.push_back(cut);
  }
};

Expected<void> OwnThingSearch::validate() const {
  if (max_boxes == 0) return fail("max_boxes is 0; a picture needs one place at least");
  if (max_keypoints < 1 || view_keypoints < 1) {
    return fail("max_keypoints is {}, view_keypoints {}; each must be 1 at least", max_keypoints,
                view_keypoints);
  }
  return {};
}

OwnThingFinder::OwnThingFinder(const network::Classifier& network,
                               const DetectionFinders& detectors, HomeBackground background,
                               const OwnThingModel& model, const OwnThingSearch& search)
    : network_(network),
      detectors_(detectors),
      background_(std::move(background)),
      model_(model),
      search_(search),
      of_pictures_(features::make_extractor(features::FeatureKind::kSurf, search.max_keypoints)),
      of_views_(features::make_extractor(features::FeatureKind::kSurf, search.view_keypoints)) {}

OwnThingFinder::~OwnThingFinder() = default;

std::vector<float> OwnThingFinder::centered(std::vector<float> features) const {
  if (background_.mean.size() == features.size()) {
    for (std::size_t i = 0; i < features.size(); ++i) features[i] -= background_.mean[i];
  }
  const double length = std::sqrt(dot_product(features, features));
  if (length > 0) {
    for (float& value : features) value = static_cast<float>(static_cast<double>(value) / length);
  }
  return features;
}

Expected<std::vector<float>> OwnThingFinder::embed(SearchedPicture& picture,
                                                   const network::PixelBox& place) const {
  const auto is_place = [&](const auto& known) {
    const network::PixelBox& box = known.first;
    return box.left == place.left && box.top == place.top && box.right == place.right &&
           box.bottom == place.bottom;
  };
  const auto found = std::ranges::find_if(picture.embedded_, is_place);
  if (found != picture.embedded_.end()) return centered(found->second);
  ROOMWISE_TRY(network::Prediction seen, network_.predict(part_of(picture.color_, place)));
  return centered(picture.embedded_.emplace_back(place, std::move(seen.features)).second);
}

Expected<std::vector<std::size_t>> OwnThingFinder::choose_views(std::span<const ShownThing> shown,
                                                                std::size_t most) const {
  if (shown.empty()) return fail("nothing was shown");
  std::vector<std::vector<float>> embeddings;
  for (const ShownThing& one : shown) {
    ROOMWISE_TRY(network::Prediction seen, network_.predict(one.crop));
    embeddings.push_back(centered(std::move(seen.features)));
  }
  const auto sharpest = std::ranges::max_element(shown, {}, &ShownThing::sharpness);
  std::vector<std::size_t> chosen{static_cast<std::size_t>(sharpest - shown.begin())};
  std::vector<double> nearest(shown.size(), -1);  // to what was chosen
  while (chosen.size() < std::min(most, shown.size())) {
    std::optional<std::size_t> farthest;
    for (std::size_t i = 0; i < shown.size(); ++i) {
      nearest[i] = std::max(nearest[i], dot_product(embeddings[i], embeddings[chosen.back()]));
      if (std::ranges::count(chosen, i) > 0) continue;
      if (!farthest || nearest[i] < nearest[*farthest]) farthest = i;
    }
    chosen.push_back(*farthest);
  }
  return chosen;
}

Expected<PreparedThing> OwnThingFinder::prepare(std::span<const TaughtView> views) const {
  PreparedThing thing;
  for (const TaughtView& view : views) {
    ROOMWISE_TRY(const ShownThing shown, shown_again(view));
    PreparedView& prepared = thing.views.emplace_back();
    ROOMWISE_TRY(network::Prediction seen, network_.predict(shown.crop));
    prepared.embedding = centered(std::move(seen.features));
    prepared.features = inside(of_views_->extract(image::to_gray(shown.crop)), shown.mask);
    prepared.color = color_histogram(shown.crop, shown.mask, light_of(shown.crop));
    prepared.width_px = shown.crop.width();
    prepared.height_px = shown.crop.height();
  }
  return thing;
}

void OwnThingFinder::add_places_of(const PreparedThing& thing, std::size_t index,
                                   Places& places) const {
  const SearchedPicture& picture = places.picture;
  std::vector<PlacedView>& placed = places.placed[index];
  for (const PreparedView& view : thing.views) {
    auto one = verify_view(view.features, view.width_px, view.height_px, picture.features_);
    if (one) placed.push_back(*std::move(one));
  }
  std::ranges::stable_sort(placed, std::ranges::greater{}, &PlacedView::inliers);
  for (std::size_t i = 0; i < std::min(placed.size(), search_.max_placed_views); ++i) {
    places.add(placed[i].box);
  }
  // The best of each view, since colours change from side to side.
  for (std::size_t i = 0; i < std::min(thing.views.size(), search_.max_windows); ++i) {
    const auto window = colored_window(picture.colors_, thing.views[i], picture.color_.width(),
                                       picture.color_.height());
    if (window) places.add(*window);
  }
}

OwnThingFinder::Places OwnThingFinder::places_in(const SearchedPicture& picture,
                                                 std::span<const PreparedThing> things) const {
  Places places{picture, {}, std::vector<std::vector<PlacedView>>(things.size())};
  for (const network::Detection& one : picture.detections_) {
    if (places.boxes.size() == search_.max_detections) break;
    places.add(one.box);
  }
  for (std::size_t i = 0; i < things.size(); ++i) add_places_of(things[i], i, places);
  if (places.boxes.size() > search_.max_boxes) places.boxes.resize(search_.max_boxes);
  return places;
}

Expected<SearchedPicture> OwnThingFinder::begin(const image::ColorImage& full) const {
  const int height = std::max(1, full.height() * kWorkingWidth_px / std::max(1, full.width()));
  const bool is_wide = full.width() > kWorkingWidth_px;
  SearchedPicture picture(is_wide ? image::resize(full, kWorkingWidth_px, height) : full,
                          is_wide ? static_cast<float>(full.width()) / kWorkingWidth_px : 1.F);
  picture.features_ = of_pictures_->extract(image::to_gray(picture.color_));
  for (const auto& detector : detectors_) {
    ROOMWISE_TRY(const auto found, detector->find(picture.color_));
    picture.detections_.insert(picture.detections_.end(), found.begin(), found.end());
  }
  std::ranges::stable_sort(picture.detections_, std::ranges::greater{}, &network::Detection::score);
  return picture;
}

Expected<std::vector<OwnThingCandidate>> OwnThingFinder::compare(
    SearchedPicture& picture, std::span<const PreparedThing> things) const {
  const Places places = places_in(picture, things);
  const float to_full_scale = picture.to_full_scale_;
  std::vector<OwnThingCandidate> candidates;
  for (const network::PixelBox& box : places.boxes) {
    ROOMWISE_TRY(const std::vector<float> seen, embed(picture, box));
    const ColorHistogram colors = picture.colors_.shares(box);
    for (std::size_t i = 0; i < things.size(); ++i) {
      std::size_t agreeing = 0;
      for (const PlacedView& placed : places.placed[i]) {
        agreeing = std::max(agreeing, inliers_in(placed, box));
      }
      OwnThingCandidate candidate{i,
                                  {box.left * to_full_scale, box.top * to_full_scale,
                                   box.right * to_full_scale, box.bottom * to_full_scale},
                                  {},
                                  0};
      candidate.likeness = match_features(things[i], seen, colors, agreeing);
      candidate.log_odds = model_.log_odds(candidate.likeness);
      candidates.push_back(candidate);
    }
  }
  return candidates;
}

Expected<std::vector<OwnThingCandidate>> OwnThingFinder::find(
    const image::ColorImage& color, std::span<const PreparedThing> things) const {
  ROOMWISE_TRY(SearchedPicture picture, begin(color));
  ROOMWISE_TRY(const auto candidates, compare(picture, things));
  std::vector<OwnThingCandidate> best;
  for (std::size_t i = 0; i < things.size(); ++i) {
    const OwnThingCandidate* likeliest = nullptr;
    for (const OwnThingCandidate& one : candidates) {
      if (one.thing != i) continue;
      if (likeliest == nullptr || one.log_odds > likeliest->log_odds) likeliest = &one;
    }
    if (likeliest != nullptr) best.push_back(*likeliest);
  }
  return best;
}

Expected<std::vector<std::vector<float>>> OwnThingFinder::place_features(
    const image::ColorImage& color) const {
  ROOMWISE_TRY(const SearchedPicture picture, begin(color));
  std::vector<network::PixelBox> boxes = places_in(picture, {}).boxes;
  // Of what no detector boxes, the quarters of the picture.
  const auto width = static_cast<float>(picture.color_.width());
  const auto height = static_cast<float>(picture.color_.height());
  for (const float left : {0.F, width / 2}) {
    for (const float top : {0.F, height / 2}) {
      boxes.push_back({left, top, left + width / 2, top + height / 2});
    }
  }
  std::vector<std::vector<float>> all;
  for (const network::PixelBox& box : boxes) {
    ROOMWISE_TRY(network::Prediction seen, network_.predict(part_of(picture.color_, box)));
    all.push_back(std::move(seen.features));
  }
  return all;
}

HomeBackground background_of(std::span<const std::vector<float>> places) {
  HomeBackground background;
  if (places.empty()) return background;
  std::vector<double> sum(places.front().size());
  for (const auto& place : places) {
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += static_cast<double>(place[i]);
  }
  for (const double value : sum) {
    background.mean.push_back(static_cast<float>(value / static_cast<double>(places.size())));
  }
  return background;
}

}  // namespace roomwise::objects
