#include "roomwise/pipeline/stored/measured_frame_reader.h"

#include "roomwise/image/resample.h"

namespace roomwise::pipeline {
namespace {

motion::MeasuredFeatures find_features(const image::GrayImage& gray, const image::DepthImage& depth,
                                       const geometry::PinholeCamera& camera,
                                       const features::FeatureExtractor& extractor,
                                       const motion::DepthRange& range) {
  return motion::measure_features(extractor.extract(gray), depth, camera, range);
}

motion::RgbdPyramid make_view(const image::GrayImage& gray, const image::DepthImage& depth,
                              const geometry::PinholeCamera& camera, const MapSettings& settings) {
  return motion::make_rgbd_pyramid(gray, depth, camera, {.farthest_m = settings.depth.farthest_m});
}

bool needs_views(const MapSettings& settings) {
  return settings.mapper.method != mapping::MappingMethod::kPaper;
}

}  // namespace

motion::FrameMeasurements measure_frame(const image::ColorImage& color,
                                        const image::DepthImage& depth,
                                        const geometry::PinholeCamera& camera,
                                        const features::FeatureExtractor& extractor,
                                        const MapSettings& settings) {
  const image::GrayImage gray = image::to_gray(color);
  return {find_features(gray, depth, camera, extractor, settings.depth),
          needs_views(settings) ? make_view(gray, depth, camera, settings) : motion::RgbdPyramid()};
}

MeasuredFrameReader::MeasuredFrameReader(recording::FrameSource& source,
                                         const features::FeatureExtractor& extractor,
                                         const MapSettings& settings, RunContext& run)
    : source_(source), extractor_(extractor), settings_(settings), run_(run) {}

MeasuredFrameReader::~MeasuredFrameReader() {
  for (const Ahead& ahead : ahead_) ahead.measurements.wait();
}

Expected<std::optional<MeasuredFrame>> MeasuredFrameReader::next() {
  read_ahead();
  if (ahead_.empty()) {
    if (error_) return Unexpected(*error_);
    return std::nullopt;
  }
  Ahead first = std::move(ahead_.front());
  ahead_.pop_front();
  return MeasuredFrame{std::move(first.frame), first.measurements.get()};
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
    auto measurements = run_.pool.submit([this, shared] { return measure(shared); });
    ahead_.push_back({std::move(shared), std::move(measurements)});
  }
}

motion::FrameMeasurements MeasuredFrameReader::measure(
    const std::shared_ptr<const image::RgbdFrame>& frame) const {
  const geometry::PinholeCamera& camera = source_.info().camera;
  if (!needs_views(settings_)) {
    const auto timing = run_.clock.measure("features");
    return measure_frame(frame->color, frame->depth, camera, extractor_, settings_);
  }
  const auto timing = run_.clock.measure("views");
  image::GrayImage gray = image::to_gray(frame->color);
  motion::RgbdPyramid view = make_view(gray, frame->depth, camera, settings_);
  // May be asked for when the reader is gone, but not the extractor and the clock.
  return {std::move(view), [frame, gray = std::move(gray), camera, range = settings_.depth,
                            &extractor = extractor_, &clock = run_.clock] {
            const auto feature_timing = clock.measure("features");
            return find_features(gray, frame->depth, camera, extractor, range);
          }};
}

}  // namespace roomwise::pipeline
