#include "roomwise/pipeline/objects/keyframe_observer.h"

#include <chrono>

#include "roomwise/image/codec.h"
#include "roomwise/pipeline/stored/keyframe_images.h"
#include "roomwise/pipeline/stored/lost_pictures.h"

namespace roomwise::pipeline {

Expected<objects::KeyframeDetections> look_at(const objects::DetectionFinder& finder,
                                              const image::ColorImage& color,
                                              const image::DepthImage& depth,
                                              const geometry::PinholeCamera& camera) {
  ROOMWISE_TRY(const auto detections, finder.find(color));
  objects::KeyframeDetections look;
  look.coarse_depth = objects::coarse_depth(depth);
  for (const network::Detection& detection : detections) {
    look.detections.push_back({finder.labels().at(detection.label), detection.score, detection.box,
                               objects::region_surface(depth, camera, detection.box),
                               objects::DetectionSource::kDetector});
  }
  return look;
}

Expected<KeyframeObserver> KeyframeObserver::create(home::Home& home, const Networks& networks,
                                                    const objects::DetectionFinders& finders,
                                                    RunContext& run) {
  KeyframeObserver observer(home, networks, finders, run);
  for (const auto& network : networks) {
    ROOMWISE_TRY(const home::NetworkId id,
                 home.add_network({network->name(), network->fingerprint(), network->labels(),
                                   network->feature_size()}));
    observer.network_ids_.push_back(id);
  }
  for (const auto& finder : finders) {
    ROOMWISE_TRY(const home::FinderId id,
                 home.add_region_finder({finder->name(), finder->fingerprint(), finder->labels()}));
    observer.finder_ids_.push_back(id);
  }
  return observer;
}

KeyframeObserver::~KeyframeObserver() {
  for (const auto& observation : under_way_) observation.wait();
}

Expected<void> KeyframeObserver::observe(home::KeyframeId keyframe,
                                         std::shared_ptr<const image::RgbdFrame> frame,
                                         const geometry::PinholeCamera& camera) {
  const Images images{{frame, &frame->color}, {frame, &frame->depth}};
  for (std::size_t i = 0; i < networks_->size(); ++i) show_network(keyframe, i, images.color);
  for (std::size_t i = 0; i < finders_->size(); ++i) show_finder(keyframe, i, images, camera);
  // Never far behind: pictures that wait take memory.
  const std::size_t max_waiting = 2 * run_->pool.size() * (networks_->size() + finders_->size());
  const auto is_ready = [](const std::future<Expected<Store>>& observation) {
    return observation.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  };
  while (!under_way_.empty() && (under_way_.size() > max_waiting || is_ready(under_way_.front()))) {
    ROOMWISE_RETURN_IF_ERROR(store_first());
  }
  return {};
}

Expected<void> KeyframeObserver::observe_missing() {
  if (networks_->empty() && finders_->empty()) return {};
  std::vector<std::map<home::KeyframeId, network::Prediction>> predicted;
  for (const home::NetworkId id : network_ids_) {
    ROOMWISE_TRY(auto predictions, home_->predictions(id));
    predicted.push_back(std::move(predictions));
  }
  std::vector<std::set<home::KeyframeId>> looked_at;
  for (const home::FinderId id : finder_ids_) {
    ROOMWISE_TRY(auto keyframes, home_->looked_at(id));
    looked_at.push_back(std::move(keyframes));
  }
  ROOMWISE_TRY(const auto cameras, recording_cameras(*home_));
  ROOMWISE_TRY(const auto keyframes, home_->keyframes());
  run_->progress.begin("looking at key-frames", keyframes.size());
  Expected<void> go_on;
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    go_on = run_->progress.check("looking at key-frames");
    if (!go_on) break;
    const home::KeyframeId id = keyframes[k].id;
    const auto misses = [id](const auto& seen) { return !seen.contains(id); };
    const bool find = std::ranges::any_of(looked_at, misses);
    if (find || std::ranges::any_of(predicted, misses)) {
      const auto images = stored_images(id, find);
      // It stays among those that miss something.
      if (!images) ROOMWISE_RETURN_IF_ERROR(go_on_without(*home_, id, images.error(), run_->lost));
      for (std::size_t i = 0; images && i < networks_->size(); ++i) {
        if (misses(predicted[i])) show_network(id, i, images->color);
      }
      for (std::size_t i = 0; images && i < finders_->size(); ++i) {
        if (misses(looked_at[i])) show_finder(id, i, *images, cameras.at(keyframes[k].recording));
      }
    }
    while (under_way_.size() > 2 * run_->pool.size()) ROOMWISE_RETURN_IF_ERROR(store_first());
    run_->progress.advance(k + 1, "");
  }
  run_->progress.end();
  ROOMWISE_RETURN_IF_ERROR(finish());
  return go_on;
}

Expected<void> KeyframeObserver::finish() {
  while (!under_way_.empty()) ROOMWISE_RETURN_IF_ERROR(store_first());
  return {};
}

Expected<KeyframeObserver::Images> KeyframeObserver::stored_images(home::KeyframeId keyframe,
                                                                   bool needs_depth) const {
  ROOMWISE_TRY(const home::KeyframeImages stored, home_->images(keyframe));
  Images images;
  ROOMWISE_TRY(image::ColorImage color, image::decode_color(stored.color));
  images.color = std::make_shared<const image::ColorImage>(std::move(color));
  if (needs_depth) {
    ROOMWISE_TRY(image::DepthImage depth, image::decode_depth(stored.depth));
    images.depth = std::make_shared<const image::DepthImage>(std::move(depth));
  }
  return images;
}

void KeyframeObserver::show_network(home::KeyframeId keyframe, std::size_t network,
                                    const std::shared_ptr<const image::ColorImage>& color) {
  const network::Classifier& classifier = *(*networks_)[network];
  const home::NetworkId id = network_ids_[network];
  under_way_.push_back(run_->pool.submit(
      [&classifier, &clock = run_->clock, home = home_, id, keyframe, color]() -> Expected<Store> {
        const auto timing = clock.measure("network " + classifier.name());
        ROOMWISE_TRY(network::Prediction prediction, classifier.predict(*color));
        return Store([home, id, keyframe, prediction = std::move(prediction)] {
          return home->put_prediction(keyframe, id, prediction);
        });
      }));
}

void KeyframeObserver::show_finder(home::KeyframeId keyframe, std::size_t finder,
                                   const Images& images, const geometry::PinholeCamera& camera) {
  const objects::DetectionFinder& shown = *(*finders_)[finder];
  const home::FinderId id = finder_ids_[finder];
  under_way_.push_back(run_->pool.submit([&shown, &clock = run_->clock, home = home_, id, keyframe,
                                          images, camera]() -> Expected<Store> {
    const auto timing = clock.measure("regions " + shown.name());
    ROOMWISE_TRY(objects::KeyframeDetections look,
                 look_at(shown, *images.color, *images.depth, camera));
    return Store([home, id, keyframe, look = std::move(look)] {
      return home->put_detections(keyframe, id, look);
    });
  }));
}

Expected<void> KeyframeObserver::store_first() {
  auto first = std::move(under_way_.front());
  under_way_.pop_front();
  ROOMWISE_TRY(const Store store, first.get());
  const auto timing = run_->clock.measure("store");
  return store();
}

}  // namespace roomwise::pipeline
