#include "roomwise/mapping/frontend/measurement_store.h"

#include <utility>

#include "roomwise/motion/measurement_bytes.h"

namespace roomwise::mapping {

Expected<void> MeasurementStore::add(motion::FrameMeasurements measurements) {
  used_.push_front(entries_.size());
  Entry& entry = entries_.emplace_back();
  entry.memory_bytes = motion::memory_bytes(measurements);
  entry.measurements = std::make_shared<const motion::FrameMeasurements>(std::move(measurements));
  entry.use = used_.begin();
  bytes_ += entry.memory_bytes;
  return make_room();
}

void MeasurementStore::add_stored(std::size_t count, MeasureStored measure) {
  entries_.resize(entries_.size() + count);
  measure_ = std::move(measure);
}

Expected<SharedMeasurements> MeasurementStore::get(KeyframeId id) {
  Entry& entry = entries_.at(id);
  if (entry.measurements) {
    used_.splice(used_.begin(), used_, entry.use);
    return entry.measurements;
  }
  const auto read = [&]() -> Expected<motion::FrameMeasurements> {
    if (!entry.offset) return measure_(id);
    ROOMWISE_TRY(const Bytes bytes, scratch_->read(*entry.offset, entry.disk_bytes));
    return motion::measurements_from_bytes(bytes);
  };
  ROOMWISE_TRY(motion::FrameMeasurements measurements, read());
  if (entry.memory_bytes == 0) entry.memory_bytes = motion::memory_bytes(measurements);
  const auto shared = std::make_shared<const motion::FrameMeasurements>(std::move(measurements));
  entry.measurements = shared;
  used_.push_front(id);
  entry.use = used_.begin();
  bytes_ += entry.memory_bytes;
  ROOMWISE_RETURN_IF_ERROR(make_room());
  return shared;
}

Expected<void> MeasurementStore::make_room() {
  if (options_.scratch_folder.empty()) return {};
  while (bytes_ > options_.max_bytes && used_.size() > 1) {
    ROOMWISE_RETURN_IF_ERROR(push_out(entries_[used_.back()]));
    used_.pop_back();
  }
  return {};
}

Expected<void> MeasurementStore::push_out(Entry& entry) {
  if (!entry.offset) {
    if (!scratch_) {
      ROOMWISE_TRY(ScratchFile scratch, ScratchFile::create(options_.scratch_folder));
      scratch_.emplace(std::move(scratch));
    }
    const Bytes bytes = motion::to_bytes(*entry.measurements);
    ROOMWISE_TRY(entry.offset, scratch_->append(bytes));
    entry.disk_bytes = bytes.size();
  }
  entry.measurements.reset();
  bytes_ -= entry.memory_bytes;
  return {};
}

}  // namespace roomwise::mapping
