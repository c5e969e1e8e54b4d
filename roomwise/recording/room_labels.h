#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/base/expected.h"

namespace roomwise::recording {

// The frames first_frame to last_frame, both included, were taken in `room` on the walk's
// `stay`-th stay there (from 1), which files and options call a visit. Frames are numbered by the
// colour image's place in the recording's list (RgbdFrame::index).
struct RoomRange {
  std::uint64_t first_frame = 0;
  std::uint64_t last_frame = 0;
  std::string room;
  int stay = 1;

  friend bool operator==(const RoomRange&, const RoomRange&) = default;
};

// Fails where rooms.txt could not give the name back: it is words divided by single blanks, none of
// which begins with '#'.
[[nodiscard]] Expected<void> validate_room_name(std::string_view name);

// Which room each frame of a recording shows: rooms.txt, a line a range, "first_frame last_frame
// room visit", '#' begins a comment; a name may have several words. Ranges do not overlap and stand
// in the order of frames.
class RoomLabels {
 public:
  // Fails, naming the range, where ranges overlap, run backwards or have no name.
  [[nodiscard]] static Expected<RoomLabels> from_ranges(std::vector<RoomRange> ranges);
  [[nodiscard]] static Expected<RoomLabels> read(const std::filesystem::path& path);
  [[nodiscard]] Expected<void> write(const std::filesystem::path& path) const;
  [[nodiscard]] std::string text() const;  // of the file

  // The range that holds the frame, or nullptr.
  [[nodiscard]] const RoomRange* find(std::uint64_t frame) const;
  // How many frames lie between `frame` and the nearest end of its range: 0 for the first and the
  // last frame of the range. The frame must be labelled. The very first and last frame of all
  // ranges are no boundary to another room, but count as one, as they do for every range.
  [[nodiscard]] std::uint64_t frames_to_boundary(std::uint64_t frame) const;
  [[nodiscard]] const std::vector<RoomRange>& ranges() const { return ranges_; }

 private:
  std::vector<RoomRange> ranges_;
};

}  // namespace roomwise::recording
