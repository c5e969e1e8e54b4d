#pragma once

#include <deque>
#include <future>
#include <memory>
#include <span>
#include <vector>

#include "roomwise/home/home.h"
#include "roomwise/network/classifier.h"
#include "roomwise/pipeline/run_context.h"

namespace roomwise::pipeline {

// The networks that look at every key-frame.
using Networks = std::vector<std::unique_ptr<network::Classifier>>;

// Shows key-frames to the networks on the pool's threads and stores in the home what they see.
// Mapping goes on meanwhile; what a killed run did not get to, observe_missing() makes up for.
class KeyframeObserver {
 public:
  // Makes the networks known to the home.
  [[nodiscard]] static Expected<KeyframeObserver> create(home::Home& home, const Networks& networks,
                                                         RunContext& run);
  KeyframeObserver(KeyframeObserver&&) = default;
  KeyframeObserver& operator=(KeyframeObserver&&) = delete;
  ~KeyframeObserver();  // waits for the work under way

  // The key-frame must be in the home already. Stores the predictions that are ready by now.
  [[nodiscard]] Expected<void> observe(home::KeyframeId keyframe,
                                       std::shared_ptr<const image::ColorImage> color);
  // Shows every stored key-frame to the networks that have not seen it yet, and waits for all.
  // False where the user interrupted before all were seen.
  [[nodiscard]] Expected<bool> observe_missing();
  // Waits for the work under way and stores it.
  [[nodiscard]] Expected<void> finish();

 private:
  struct Observation {
    home::KeyframeId keyframe = 0;
    home::NetworkId network = 0;
    std::future<Expected<network::Prediction>> prediction;
  };
  KeyframeObserver(home::Home& home, const Networks& networks, RunContext& run)
      : home_(&home), networks_(&networks), run_(&run) {}
  void submit(home::KeyframeId keyframe, std::size_t network,
              const std::shared_ptr<const image::ColorImage>& color);
  [[nodiscard]] Expected<void> store_first();

  home::Home* home_;
  const Networks* networks_;
  RunContext* run_;
  std::vector<home::NetworkId> ids_;  // of networks_, in the home
  std::deque<Observation> under_way_;
};

}  // namespace roomwise::pipeline
