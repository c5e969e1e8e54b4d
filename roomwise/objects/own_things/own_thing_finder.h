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
  ColorShares color{};
  int width_px = 0, height_px = 0;  // of its crop
};
struct PreparedThing {
  std::vector<PreparedView> views;
};

// A place in a picture, and how it compares with one thing.
struct OwnThingCandidate {
  std::size_t thing = 0;  // index
  network::PixelBox box;
  Likeness likeness{};
  double log_odds = 0;
};

struct OwnThingSearch {
  // Embeddings a picture, at most, whatever is searched for: most of the time that a picture takes.
  std::size_t max_places = 24;
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

  // Every place that was compared, with every thing.
  [[nodiscard]] Expected<std::vector<OwnThingCandidate>> compare(
      const image::ColorImage& picture, std::span<const PreparedThing> things) const;
  // The likeliest place of each thing, by thing.
  [[nodiscard]] Expected<std::vector<OwnThingCandidate>> find(
      const image::ColorImage& picture, std::span<const PreparedThing> things) const;

  // Features of places of a picture, as many as are compared: for a HomeBackground.
  [[nodiscard]] Expected<std::vector<std::vector<float>>> place_features(
      const image::ColorImage& picture) const;

 private:
  struct Picture;
  [[nodiscard]] Expected<Picture> look(const image::ColorImage& picture,
                                       std::span<const PreparedThing> things) const;
  void add_places_of(const PreparedThing& thing, std::size_t index, Picture& picture) const;
  [[nodiscard]] Expected<std::vector<float>> embed(const image::ColorImage& picture) const;
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
