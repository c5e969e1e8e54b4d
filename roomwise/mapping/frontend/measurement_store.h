#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <vector>

#include "roomwise/base/scratch_file.h"
#include "roomwise/mapping/frontend/keyframe.h"

namespace roomwise::mapping {

using SharedMeasurements = std::shared_ptr<const motion::FrameMeasurements>;

// Measures a key-frame that was stored, to the same bits each time.
using MeasureStored = std::function<Expected<motion::FrameMeasurements>(KeyframeId)>;

// The measurements of all key-frames: those used last in memory, the others on the disk, from where
// they come back to the bit. (Reading them takes a hundredth of the time of measuring the stored
// images anew.)
class MeasurementStore {
 public:
  explicit MeasurementStore(WorkingSet options) : options_(std::move(options)) {}

  // Of the next key-frame: the first is 0. Finds its features, if that was not done yet.
  [[nodiscard]] Expected<void> add(motion::FrameMeasurements measurements);
  // So many key-frames that are there already, measured when they are asked for first.
  void add_stored(std::size_t count, MeasureStored measure);
  // Of a key-frame that is there. What was asked for is used, and may push others out; the caller's
  // share stays good.
  [[nodiscard]] Expected<SharedMeasurements> get(KeyframeId id);

  [[nodiscard]] std::size_t size() const { return entries_.size(); }
  [[nodiscard]] std::size_t bytes_in_memory() const { return bytes_; }

 private:
  struct Entry {
    SharedMeasurements measurements;  // empty: on the disk, or not asked for yet
    std::size_t memory_bytes = 0;
    std::optional<std::uint64_t> offset;  // in the scratch file, once it was written there
    std::size_t disk_bytes = 0;
    std::list<KeyframeId>::iterator use;
  };
  [[nodiscard]] Expected<void> make_room();
  [[nodiscard]] Expected<void> push_out(Entry& entry);

  WorkingSet options_;
  MeasureStored measure_;
  std::vector<Entry> entries_;  // by key-frame id
  std::list<KeyframeId> used_;  // those in memory, the one used last first
  std::size_t bytes_ = 0;
  std::optional<ScratchFile> scratch_;
};

}  // namespace roomwise::mapping
