#include "roomwise/pipeline/keyframe_observer.h"

#include <chrono>

#include "roomwise/image/codec.h"

namespace roomwise::pipeline {

Expected<KeyframeObserver> KeyframeObserver::create(home::Home& home, const Networks& networks,
                                                    RunContext& run) {
  KeyframeObserver observer(home, networks, run);
  for (const auto& network : networks) {
    ROOMWISE_TRY(const home::NetworkId id,
                 home.add_network({network->name(), network->fingerprint(), network->labels(),
                                   network->feature_size()}));
    observer.ids_.push_back(id);
  }
  return observer;
}

KeyframeObserver::~KeyframeObserver() {
  for (const Observation& observation : under_way_) observation.prediction.wait();
}

Expected<void> KeyframeObserver::observe(home::KeyframeId keyframe,
                                         std::shared_ptr<const image::ColorImage> color) {
  for (std::size_t i = 0; i < networks_->size(); ++i) submit(keyframe, i, color);
  // Never far behind: pictures that wait take memory.
  const std::size_t most_waiting = 2 * run_->pool.size() * networks_->size();
  const auto is_ready = [](const Observation& observation) {
    return observation.prediction.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  };
  while (!under_way_.empty() &&
         (under_way_.size() > most_waiting || is_ready(under_way_.front()))) {
    ROOMWISE_CHECK_OK(store_first());
  }
  return {};
}

Expected<bool> KeyframeObserver::observe_missing() {
  if (networks_->empty()) return true;
  std::vector<std::map<home::KeyframeId, network::Prediction>> seen;
  for (const home::NetworkId id : ids_) {
    ROOMWISE_TRY(auto predictions, home_->predictions(id));
    seen.push_back(std::move(predictions));
  }
  ROOMWISE_TRY(const auto keyframes, home_->keyframes());
  run_->progress.begin("looking at key-frames", keyframes.size());
  bool seen_all = true;
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    if (run_->progress.interrupted()) {
      seen_all = false;
      break;
    }
    const home::KeyframeId id = keyframes[k].id;
    std::shared_ptr<const image::ColorImage> color;
    for (std::size_t i = 0; i < networks_->size(); ++i) {
      if (seen[i].contains(id)) continue;
      if (!color) {
        ROOMWISE_TRY(const home::KeyframeImages images, home_->images(id));
        ROOMWISE_TRY(image::ColorImage decoded, image::decode_color(images.color));
        color = std::make_shared<const image::ColorImage>(std::move(decoded));
      }
      submit(id, i, color);
      if (under_way_.size() > 2 * run_->pool.size()) ROOMWISE_CHECK_OK(store_first());
    }
    run_->progress.advance(k + 1, "");
  }
  run_->progress.end();
  ROOMWISE_CHECK_OK(finish());
  return seen_all;
}

Expected<void> KeyframeObserver::finish() {
  while (!under_way_.empty()) ROOMWISE_CHECK_OK(store_first());
  return {};
}

void KeyframeObserver::submit(home::KeyframeId keyframe, std::size_t network,
                              const std::shared_ptr<const image::ColorImage>& color) {
  const network::Classifier& classifier = *(*networks_)[network];
  StageClock& clock = run_->clock;
  under_way_.push_back({keyframe, ids_[network], run_->pool.submit([&classifier, &clock, color] {
                          const auto timing = clock.measure("network " + classifier.name());
                          return classifier.predict(*color);
                        })});
}

Expected<void> KeyframeObserver::store_first() {
  Observation first = std::move(under_way_.front());
  under_way_.pop_front();
  ROOMWISE_TRY(const network::Prediction prediction, first.prediction.get());
  const auto timing = run_->clock.measure("store");
  return home_->put_prediction(first.keyframe, first.network, prediction);
}

}  // namespace roomwise::pipeline
