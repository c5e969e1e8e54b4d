#pragma once

#include <deque>
#include <future>
#include <memory>
#include <optional>

#include "roomwise/features/feature_extractor.h"
#include "roomwise/motion/frame_measurements.h"
#include "roomwise/pipeline/run_context.h"
#include "roomwise/pipeline/stored/map_settings.h"
#include "roomwise/recording/frame_source.h"

namespace roomwise::pipeline {

struct MeasuredFrame {
  std::shared_ptr<const image::RgbdFrame> frame;
  motion::FrameMeasurements measurements;
};

// Reads frames and measures them a little ahead of the one who asks, on the pool's threads: their
// features where the method needs those of all frames, else their views; their features are then
// found when they are asked for. The frames come in the source's order.
class MeasuredFrameReader {
 public:
  MeasuredFrameReader(recording::FrameSource& source, const features::FeatureExtractor& extractor,
                      const MapSettings& settings, RunContext& run);
  ~MeasuredFrameReader();  // waits for the work under way
  MeasuredFrameReader(const MeasuredFrameReader&) = delete;
  MeasuredFrameReader& operator=(const MeasuredFrameReader&) = delete;

  // The next frame; nothing at the end. After an error the frames read before it have all been
  // given.
  [[nodiscard]] Expected<std::optional<MeasuredFrame>> next();

 private:
  struct Ahead {
    std::shared_ptr<const image::RgbdFrame> frame;
    std::future<motion::FrameMeasurements> measurements;
  };
  void read_ahead();
  [[nodiscard]] motion::FrameMeasurements measure(
      const std::shared_ptr<const image::RgbdFrame>& frame) const;

  recording::FrameSource& source_;
  const features::FeatureExtractor& extractor_;
  const MapSettings& settings_;
  RunContext& run_;
  std::deque<Ahead> ahead_;
  std::optional<Error> error_;
  bool at_end_ = false;
};

// What the reader measures in one frame, its features too.
[[nodiscard]] motion::FrameMeasurements measure_frame(const image::ColorImage& color,
                                                      const image::DepthImage& depth,
                                                      const geometry::PinholeCamera& camera,
                                                      const features::FeatureExtractor& extractor,
                                                      const MapSettings& settings);

}  // namespace roomwise::pipeline
