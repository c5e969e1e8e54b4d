#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "roomwise/pipeline/mapping/home_localizer.h"

namespace roomwise::trials {

struct LocalizationTrial {
  std::uint64_t frame_index = 0;
  mapping::Localization answer;
  double error_m = 0;    // of an answer with a pose
  double error_rad = 0;  // of an answer with a pose
  // Of an unknown lens, before the picture was asked for: over the true one.
  std::optional<double> focal_ratio;
  double cpu_s = 0;  // to measure the picture and to localise it
};

struct LocalizationEvaluationOptions {
  std::uint64_t every = 1;  // of the frames that are tried
  bool with_depth = true;
  // As of a phone: by colour alone, the focal length and the distortion found from picture to
  // picture.
  bool unknown_lens = false;
  bool pairs = false;  // two pictures a question: a frame and the one before it
};

// Localises the frames of another walk through the same home, whose truth lies in the same world as
// that of the recording from which the home was mapped: two simulated walks through one home, or
// two that were measured by one motion capture. The map is moved onto the truth as its trajectory
// fits best.
[[nodiscard]] Expected<std::vector<LocalizationTrial>> evaluate_localization(
    const home::Home& home, const std::filesystem::path& mapped_recording,
    const std::filesystem::path& visit, const mapping::LocalizerOptions& localizer,
    const LocalizationEvaluationOptions& options, pipeline::RunContext& run);

}  // namespace roomwise::trials
