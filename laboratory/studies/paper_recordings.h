#pragma once

#include <span>
#include <string>

// The recordings of which the tables of the paper are made.
namespace roomwise::studies {

struct PaperRecording {
  std::string folder;     // in the folder of recordings
  std::string title;      // as tables call it
  std::string camera;     // preset, where the recording has none of its own; else empty
  std::string publisher;  // who keeps it, and where
  bool is_of_paper = false;
};

// The four of TUM RGB-D that the paper maps, then those that stand in for what it recorded itself.
[[nodiscard]] std::span<const PaperRecording> paper_recordings();
// The walk on which rooms are told, and the photos of rooms.
[[nodiscard]] const PaperRecording& office_walk();
[[nodiscard]] const PaperRecording& room_photos();

// "fr1/desk (rgbd_dataset_freiburg1_desk) is not in the folder of recordings; ... keeps it at ..."
[[nodiscard]] std::string missing_text(const PaperRecording& recording);

}  // namespace roomwise::studies
