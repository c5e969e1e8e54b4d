#pragma once

#include <filesystem>
#include <memory>
#include <span>

#include "roomwise/recording/recording.h"

namespace roomwise::recording {

// A way in which devices, apps and robots write recordings.
struct RecordingKind {
  std::string_view name;     // for people: "TUM folder"
  std::string_view told_by;  // for people: "rgb.txt and depth.txt"
  // By a look at names and first bytes, never by reading a whole file; false where nothing is there
  // or it cannot be read.
  bool (*recognises)(const std::filesystem::path& path);
  Expected<std::unique_ptr<Recording>> (*open)(const std::filesystem::path& path,
                                               const RecordingOptions& options);
};

// All kinds that are read, in the order in which they are asked.
[[nodiscard]] std::span<const RecordingKind> recording_kinds();

// The kind of a folder or file by its content; null where it is no recording.
[[nodiscard]] const RecordingKind* find_recording_kind(const std::filesystem::path& path);

// Opens a recording of any kind. Fails where nothing is there, where no kind fits, naming all that
// are read, and as the kind's own open() does.
[[nodiscard]] Expected<std::unique_ptr<Recording>> open_recording(
    const std::filesystem::path& path, const RecordingOptions& options = {});

// Where the camera truly was: of a text file in TUM's format that; of a recording its
// groundtruth.txt, or where it has none what the device itself wrote. Fails where there is neither.
[[nodiscard]] Expected<Trajectory> read_truth(const std::filesystem::path& path);

}  // namespace roomwise::recording
