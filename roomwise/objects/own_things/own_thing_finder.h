#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roomwise/features/feature_extractor.h"
#include "roomwise/network/vision/classifier.h"
#include "roomwise/objects/detection/region_finder.h"
#include "roomwise/objects/own_things/color_likeness.h"
#include "roomwise/objects/own_things/own_thing_model.h"
#include "roomwise/objects/own_things/shown_thing.h"

namespace roomwise::objects {

// What places of a home have in common for a network: the mean of its features over many.
struct HomeBackground {
  std::vector<float>
      mean;  // of the network's feature_size(); empty: not known, nothing is taken off
};

// A view with all that it is compared by.
struct PreparedView {
  std::vector<float> embedding;  // of length 1, without what the home's places have in common
  features::Features features;
  ColorHistogram color{};
  int width_px = 0, height_px = 0;  // of its crop
};
struct PreparedThing {
  std::vector<PreparedView> views;
};

// A place in a picture, and how it compares with one thing.
struct OwnThingCandidate {
  std::size_t thing = 0;  // index
  network::PixelBox box;
  MatchFeatures likeness{};
  double log_odds = 0;
};

// A picture that is searched: what is the same for all things, and what the network made of places
// so far. Not thread-safe.
class SearchedPicture {
 public:
  [[nodiscard]] const std::vector<network::Detection>& detections() const { return detections_; }

 private:
  friend class OwnThingFinder;
  SearchedPicture(image::ColorImage color, float to_full_scale)
      : color_(std::move(color)), to_full_scale_(to_full_scale), colors_(color_) {}

  image::ColorImage color_;  // as it is searched
  float to_full_scale_;      // pixels of the picture to one of color_
  features::Features features_;
  IntegralColorHistogram colors_;
  std::vector<network::Detection> detections_;  // best first, in pixels of color_
  std::vector<std::pair<network::PixelBox, std::vector<float>>> embedded_;
};

struct OwnThingSearch {
  // Embeddings a picture, at most, whatever is searched for: most of the time that a picture takes.
  std::size_t max_boxes = 24;
  std::size_t max_detections = 8;  // of these, boxes of detectors
  // For each thing, at most: places where its local features agree, and windows of its colours.
  std::size_t max_placed_views = 2, max_windows = 3;
  int max_keypoints = 800;  // of a picture
  int view_keypoints = 250;

  [[nodiscard]] Expected<void> validate() const;
};

// Finds taught things in pictures. Its functions may be called from several threads at once and
// give the same bits on every call. What it is given must outlive it.
class OwnThingFinder {
 public:
  OwnThingFinder(const network::Classifier& network, const DetectionFinders& detectors,
                 HomeBackground background, const OwnThingModel& model,
                 const OwnThingSearch& search = {});
  ~OwnThingFinder();

  // The views by which a thing is known, of several that somebody showed: the sharpest, then again
  // and again the one that is least like those chosen; `most` at most. By index of shown.
  [[nodiscard]] Expected<std::vector<std::size_t>> choose_views(std::span<const ShownThing> shown,
                                                                std::size_t most) const;
  [[nodiscard]] Expected<PreparedThing> prepare(std::span<const TaughtView> views) const;

  [[nodiscard]] Expected<SearchedPicture> begin(const image::ColorImage& picture) const;
  // Every place that was compared, with every thing; of a picture that a finder with the same
  // network began.
  [[nodiscard]] Expected<std::vector<OwnThingCandidate>> compare(
      SearchedPicture& picture, std::span<const PreparedThing> things) const;
  // The likeliest place of each thing, by thing.
  [[nodiscard]] Expected<std::vector<OwnThingCandidate>> find(
      const image::ColorImage& picture, std::span<const PreparedThing> things) const;

  // The network's features of places of a picture: for a HomeBackground.
  [[nodiscard]] Expected<std::vector<std::vector<float>>> place_features(
      const image::ColorImage& picture) const;

 private:
  // Where a picture is compared, and how the views of each thing lie in it.
  struct Places;
  [[nodiscard]] Places places_in(const SearchedPicture& picture,
                                 std::span<const PreparedThing> things) const;
  void add_places_of(const PreparedThing& thing, std::size_t index, Places& places) const;
  [[nodiscard]] Expected<std::vector<float>> embed(SearchedPicture& picture,
                                                   const network::PixelBox& place) const;
  [[nodiscard]] std::vector<float> centered(std::vector<float> features) const;

  const network::Classifier& network_;
  const DetectionFinders& detectors_;
  HomeBackground background_;
  const OwnThingModel& model_;
  OwnThingSearch search_;
  std::unique_ptr<features::FeatureExtractor> of_pictures_, of_views_;
};

// Of features of many places.
[[nodiscard]] HomeBackground background_of(std::span<const std::vector<float>> places);

}  // namespace roomwise::objects
