#pragma once

#include <deque>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <vector>

#include "roomwise/home/home.h"
#include "roomwise/image/rgbd_frame.h"
#include "roomwise/network/vision/classifier.h"
#include "roomwise/objects/detection/region_finder.h"
#include "roomwise/pipeline/run_context.h"

namespace roomwise::pipeline {

// The networks that look at every key-frame.
using Networks = std::vector<std::unique_ptr<network::Classifier>>;

// What the finder finds in a picture, and what the depth says of its surfaces.
[[nodiscard]] Expected<objects::KeyframeDetections> look_at(const objects::DetectionFinder& finder,
                                                            const image::ColorImage& color,
                                                            const image::DepthImage& depth,
                                                            const geometry::PinholeCamera& camera);

// Shows key-frames to the networks and to the finders on the pool's threads and stores
// in the home what they see. Mapping goes on meanwhile; what a killed run did not get to,
// observe_missing() makes up for.
class KeyframeObserver {
 public:
  // Makes the networks and the finders known to the home. What it is given must outlive it.
  [[nodiscard]] static Expected<KeyframeObserver> create(home::Home& home, const Networks& networks,
                                                         const objects::DetectionFinders& finders,
                                                         RunContext& run);
  KeyframeObserver(KeyframeObserver&&) = default;
  KeyframeObserver& operator=(KeyframeObserver&&) = delete;
  ~KeyframeObserver();  // waits for the work under way

  // The key-frame must be in the home already. Stores what is ready by now.
  [[nodiscard]] Expected<void> observe(home::KeyframeId keyframe,
                                       std::shared_ptr<const image::RgbdFrame> frame,
                                       const geometry::PinholeCamera& camera);
  // Shows every stored key-frame to those that have not seen it yet, and waits for all. Fails where
  // the user interrupts, or a picture cannot be read; what was seen until then is stored.
  [[nodiscard]] Expected<void> observe_missing();
  // Waits for the work under way and stores it.
  [[nodiscard]] Expected<void> finish();

 private:
  using Store = std::function<Expected<void>()>;  // of what was seen, into the home
  struct Images {
    std::shared_ptr<const image::ColorImage> color;
    std::shared_ptr<const image::DepthImage> depth;
  };
  KeyframeObserver(home::Home& home, const Networks& networks,
                   const objects::DetectionFinders& finders, RunContext& run)
      : home_(&home), networks_(&networks), finders_(&finders), run_(&run) {}
  [[nodiscard]] Expected<Images> stored_images(home::KeyframeId keyframe, bool needs_depth) const;
  void show_network(home::KeyframeId keyframe, std::size_t network,
                    const std::shared_ptr<const image::ColorImage>& color);
  void show_finder(home::KeyframeId keyframe, std::size_t finder, const Images& images,
                   const geometry::PinholeCamera& camera);
  [[nodiscard]] Expected<void> store_first();

  home::Home* home_;
  const Networks* networks_;
  const objects::DetectionFinders* finders_;
  RunContext* run_;
  std::vector<home::NetworkId> network_ids_;  // of networks_, in the home
  std::vector<home::FinderId> finder_ids_;    // of finders_
  std::deque<std::future<Expected<Store>>> under_way_;
};

}  // namespace roomwise::pipeline
