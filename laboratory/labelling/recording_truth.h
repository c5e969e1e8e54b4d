#pragma once

#include <filesystem>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "laboratory/labelling/lift.h"

namespace roomwise::labelling {

// A thing of a real recording. World: that of the recording's own true trajectory.
struct TrueThing {
  std::string name;
  std::set<std::string> also_called;  // by another reader
  geometry::OrientedBox box_world;
  double sigma_m = 0;             // of the middle, where it is known least
  std::set<std::string> readers;  // who marked it
  std::set<std::string> sides;    // that were seen
  std::size_t views = 0;          // boxes drawn, by all readers
  std::string note;
  // Whether it counts as missed where it is not found: two readers marked it and call it the same,
  // both sure of the name.
  bool is_expected = false;
};

// RECORDING.objects.json:
//   {"recording", "readers": [...], "how", "objects": [{"name", "also_called": [...],
//     "center": [x, y, z], "size": [x, y, z], "rotation_xyzw": [...], "sigma_m", "readers": [...],
//     "sides": [...], "views", "note", "expected"}]}                                     metres
struct RecordingTruth {
  std::string recording;
  std::vector<std::string> readers;
  std::vector<TrueThing> things;
};

[[nodiscard]] Expected<void> write_recording_truth(const std::filesystem::path& path,
                                                   const RecordingTruth& truth);
// Fails, naming the file, where it is not such a file.
[[nodiscard]] Expected<RecordingTruth> read_recording_truth(const std::filesystem::path& path);

// What one reader marked, in space.
struct LiftedLabels {
  std::string recording, reader;
  std::vector<std::pair<LabelledThing, LiftedThing>> things;
  std::vector<LabelledThing> not_lifted;  // neither two directions nor a depth tell where
};

// How far two readers agree.
struct ReaderAgreement {
  std::size_t both = 0;               // marked by both, under one name
  std::size_t other_name = 0;         // marked by both, under two names
  std::vector<std::size_t> only_one;  // by reader: marked by that one alone
  std::vector<double> between_m;      // the middles of what both marked, sorted
};

// The truth of one or two readers of one recording. Two marks are one thing where they have a name
// and their middles lie within the thing's own size (a hand's breadth at least), the nearest pair
// first; then, of what is left, where they lie within half of it under two names. The middle is the
// mean by certainty. People and other transient marks are left out. Fails where both readers are
// one.
[[nodiscard]] Expected<RecordingTruth> merge_readers(std::span<const LiftedLabels> readers,
                                                     ReaderAgreement& agreement);

}  // namespace roomwise::labelling
