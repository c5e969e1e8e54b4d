#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "roomwise/evaluation/confusion_matrix.h"
#include "roomwise/pipeline/room_recognizer.h"
#include "roomwise/pipeline/room_selection.h"
#include "roomwise/pipeline/run_context.h"
#include "roomwise/recording/tum_recording.h"

namespace roomwise::pipeline {

// How well one rule did.
struct RuleResult {
  evaluation::ConfusionMatrix confusion;
  double median_ms = 0;                          // of the networks' wall time a decision
  std::map<std::string, std::uint64_t> reasons;  // how the answers were reached
};

struct RoomEvaluation {
  RuleResult single;  // each picture alone
  RuleResult pair;    // each picture and the one `pair_step` later, by the two-frame rule
};

// A picture whose room is known. Pictures of one `sequence` follow each other; pairs stay within
// it.
struct LabelledPicture {
  std::function<Expected<image::ColorImage>()> read;
  std::string room;
  std::size_t sequence = 0;
};

struct FrameSelection {
  RoomSelection rooms;
  std::uint64_t margin = 0;  // frames nearer than this to a boundary of their range are left out
};

// The frames of a labelled recording that are selected, every colour image, with depth or not.
// Rooms that were not learned are left out; selecting one by name is an error.
[[nodiscard]] Expected<std::vector<LabelledPicture>> select_frames(
    const recording::ImageList& colors, const recording::RoomLabels& labels,
    const FrameSelection& selection, const std::vector<std::string>& learned);
// The photos of a folder with one folder a room.
[[nodiscard]] Expected<std::vector<LabelledPicture>> select_photos(
    const std::filesystem::path& folder, const std::vector<std::string>& learned);

// Recognises every picture and every pair of pictures `pair_step` apart.
[[nodiscard]] Expected<RoomEvaluation> evaluate_rooms(const std::vector<LabelledPicture>& pictures,
                                                      const RoomRecognizer& recognizer,
                                                      std::size_t pair_step, RunContext& run);

}  // namespace roomwise::pipeline
