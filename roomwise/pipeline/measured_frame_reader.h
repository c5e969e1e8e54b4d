#pragma once

#include <deque>
#include <future>
#include <memory>
#include <optional>

#include "roomwise/features/feature_extractor.h"
#include "roomwise/motion/measured_features.h"
#include "roomwise/pipeline/run_context.h"
#include "roomwise/recording/frame_source.h"

namespace roomwise::pipeline {

struct MeasuredFrame {
  std::shared_ptr<const image::RgbdFrame> frame;
  motion::MeasuredFeatures features;
};

// Reads frames and finds their features a little ahead of the one who asks, on the pool's threads.
// The frames come in the source's order.
class MeasuredFrameReader {
 public:
  MeasuredFrameReader(recording::FrameSource& source, const features::FeatureExtractor& extractor,
                      const motion::DepthRange& depth, RunContext& run);
  ~MeasuredFrameReader();  // waits for the work under way
  MeasuredFrameReader(const MeasuredFrameReader&) = delete;
  MeasuredFrameReader& operator=(const MeasuredFrameReader&) = delete;

  // The next frame; nothing at the end. After an error the frames read before it have all been
  // given.
  [[nodiscard]] Expected<std::optional<MeasuredFrame>> next();

 private:
  struct Ahead {
    std::shared_ptr<const image::RgbdFrame> frame;
    std::future<motion::MeasuredFeatures> features;
  };
  void read_ahead();

  recording::FrameSource& source_;
  const features::FeatureExtractor& extractor_;
  motion::DepthRange depth_;
  RunContext& run_;
  std::deque<Ahead> ahead_;
  std::optional<Error> error_;
  bool at_end_ = false;
};

// The features of one frame, as the reader finds them.
[[nodiscard]] motion::MeasuredFeatures measure_frame(const image::ColorImage& color,
                                                     const image::DepthImage& depth_image,
                                                     const geometry::PinholeCamera& camera,
                                                     const features::FeatureExtractor& extractor,
                                                     const motion::DepthRange& depth);

}  // namespace roomwise::pipeline
