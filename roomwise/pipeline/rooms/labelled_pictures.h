#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "roomwise/pipeline/mapping/home_localizer.h"
#include "roomwise/pipeline/rooms/room_selection.h"
#include "roomwise/recording/recording.h"

namespace roomwise::pipeline {

// A picture whose room is known. Pictures of one `sequence` (a stay in a room) follow each other;
// pairs stay within it.
struct LabelledPicture {
  std::function<Expected<image::ColorImage>()> read;
  std::string room;  // empty: a place that was never learned
  std::size_t sequence = 0;
  std::size_t walk = 0;     // the recording that it is from
  std::uint64_t frame = 0;  // its place in the walk
  double time_s = 0;        // since the walk's first frame; 0 for photos
  std::string name;         // for people: "walk: frame 12"
  // The picture with its depth, to be looked for on a map; empty where it has none, or its camera
  // is not known.
  std::function<Expected<PictureToLocate>()> read_to_locate = {};
};

// The pictures of a recording, with depth where it has some and its camera is known.
struct RecordedPictures {
  std::vector<recording::RecordedPicture> pictures;
  std::function<Expected<image::ColorImage>(std::uint64_t index)> read_color;
  std::function<std::string(const recording::RecordedPicture&)> describe;
  std::shared_ptr<const recording::Recording> with_depth;  // null: none is to be located
  std::vector<recording::DamagedFrame> damaged = {};       // not among `pictures`

  // Of a TUM folder rgb.txt alone is enough. Fails as the recording's kind does.
  [[nodiscard]] static Expected<RecordedPictures> open(const std::filesystem::path& path);
  // One of `pictures`, of no room and no walk yet.
  [[nodiscard]] LabelledPicture picture(const recording::RecordedPicture& picture) const;
};

struct FrameSelection {
  RoomSelection rooms;
  std::uint64_t margin = 0;  // frames nearer than this to a boundary of their range are left out
};

// Adds the frames of a labelled recording that are selected, every colour image, with depth or not.
// Rooms that were not learned are left out; selecting one by name is an error, and so is a
// recording of which nothing is left.
[[nodiscard]] Expected<void> add_frames(const RecordedPictures& recorded,
                                        const recording::RoomLabels& labels,
                                        const FrameSelection& selection,
                                        const std::vector<std::string>& learned,
                                        const std::string& walk_name,
                                        std::vector<LabelledPicture>& pictures);
// The photos of a folder with one folder a room.
[[nodiscard]] Expected<std::vector<LabelledPicture>> select_photos(
    const std::filesystem::path& folder, const std::vector<std::string>& learned);
// Adds every JPEG and PNG file under a folder, each a sequence of its own, or, where it is a
// recording, its pictures, one sequence: pictures of places that were never learned.
// All are one walk. Of frames of a recording that are damaged, why. Fails where there is none.
[[nodiscard]] Expected<std::vector<std::string>> add_unknown_pictures(
    const std::filesystem::path& folder, std::vector<LabelledPicture>& pictures);

// Takes those out that cannot be read, with their depth where they are to be located. Of each, why.
[[nodiscard]] Expected<std::vector<std::string>> leave_out_damaged(
    std::vector<LabelledPicture>& pictures, RunContext& run);

}  // namespace roomwise::pipeline
