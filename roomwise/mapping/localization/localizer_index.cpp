#include "roomwise/mapping/localization/localizer_index.h"

#include <type_traits>
#include <utility>

namespace roomwise::mapping {
namespace {

static_assert(std::is_trivially_copyable_v<geometry::PinholeCamera>);

// Whatever is asked, features hash alike, so that one index serves all.
constexpr std::uint64_t kIndexSeed = AppearanceIndex::kUsualSeed;

}  // namespace

MeasuredKeyframe MeasuredKeyframe::of(motion::FrameMeasurements measurements) {
  static_cast<void>(measurements.features());
  motion::ViewPattern pattern = motion::ViewPattern::of(measurements.view());
  return {std::move(measurements), std::move(pattern)};
}

LocalizerIndex::LocalizerIndex() : appearances_(kIndexSeed) {}

void LocalizerIndex::add(const motion::FrameMeasurements& measurements) {
  appearances_.add(size_++, measurements.features().features);
  const motion::RgbdPyramid& view = measurements.view();
  if (view.empty()) return;
  depths_.add(view);
  if (!view_camera_) view_camera_ = view.levels.back().camera;
}

void LocalizerIndex::keep_only(std::span<const std::size_t> kept) {
  const std::vector<KeyframeId> ids(kept.begin(), kept.end());
  appearances_.keep_only(ids);
  if (depths_.size() > 0) depths_.keep_only(kept);
  size_ = kept.size();
}

Bytes LocalizerIndex::to_bytes() const {
  PlainWriter writer;
  // Of a large map this is most of what is in memory: it is not to be copied as it grows.
  writer.reserve(appearances_.written_bytes() + depths_.written_bytes() +
                 2 * sizeof(std::uint64_t) + sizeof(geometry::PinholeCamera));
  writer.put(static_cast<std::uint64_t>(size_));
  appearances_.write(writer);
  depths_.write(writer);
  writer.put(static_cast<std::uint64_t>(view_camera_ ? 1 : 0));
  if (view_camera_) writer.put(*view_camera_);
  return writer.take();
}

std::optional<LocalizerIndex> LocalizerIndex::from_bytes(std::span<const std::uint8_t> bytes) {
  PlainReader reader(bytes);
  LocalizerIndex index;
  index.size_ = reader.get<std::uint64_t>();
  index.appearances_.read(reader);
  index.depths_.read(reader);
  if (reader.get<std::uint64_t>() == 1) index.view_camera_ = reader.get<geometry::PinholeCamera>();
  const std::size_t views = index.depths_.size();
  const bool fits = views == 0 ? !index.view_camera_ : index.view_camera_ && views == index.size_;
  if (!reader.is_whole() || !fits) return std::nullopt;
  return index;
}

}  // namespace roomwise::mapping
