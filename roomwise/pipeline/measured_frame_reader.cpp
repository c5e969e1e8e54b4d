#include "roomwise/pipeline/measured_frame_reader.h"

#include "roomwise/image/resample.h"

namespace roomwise::pipeline {

motion::MeasuredFeatures measure_frame(const image::ColorImage& color,
                                       const image::DepthImage& depth_image,
                                       const geometry::PinholeCamera& camera,
                                       const features::FeatureExtractor& extractor,
                                       const motion::DepthRange& depth) {
  return motion::measure_features(extractor.extract(image::to_gray(color)), depth_image, camera,
                                  depth);
}

MeasuredFrameReader::MeasuredFrameReader(recording::FrameSource& source,
                                         const features::FeatureExtractor& extractor,
                                         const motion::DepthRange& depth, RunContext& run)
    : source_(source), extractor_(extractor), depth_(depth), run_(run) {}

MeasuredFrameReader::~MeasuredFrameReader() {
  for (const Ahead& ahead : ahead_) ahead.features.wait();
}

Expected<std::optional<MeasuredFrame>> MeasuredFrameReader::next() {
  read_ahead();
  if (ahead_.empty()) {
    if (error_) return Unexpected(*error_);
    return std::nullopt;
  }
  Ahead first = std::move(ahead_.front());
  ahead_.pop_front();
  return MeasuredFrame{std::move(first.frame), first.features.get()};
}

void MeasuredFrameReader::read_ahead() {
  const std::size_t depth = run_.pool.size() + 1;
  while (!at_end_ && ahead_.size() < depth) {
    auto frame = [&] {
      const auto timing = run_.clock.measure("read");
      return source_.next();
    }();
    if (!frame || !*frame) {
      at_end_ = true;
      if (!frame) error_ = std::move(frame).error();
      return;
    }
    auto shared = std::make_shared<const image::RgbdFrame>(*std::move(*frame));
    auto features = run_.pool.submit([this, shared] {
      const auto timing = run_.clock.measure("features");
      return measure_frame(shared->color, shared->depth, source_.info().camera, extractor_, depth_);
    });
    ahead_.push_back({std::move(shared), std::move(features)});
  }
}

}  // namespace roomwise::pipeline
