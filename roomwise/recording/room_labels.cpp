#include "roomwise/recording/room_labels.h"

#include <algorithm>
#include <span>
#include <stdexcept>

#include "roomwise/base/encodings.h"
#include "roomwise/base/file.h"
#include "roomwise/recording/data_lines.h"

namespace roomwise::recording {
namespace {

// "the range 3 to 9 of 'kitchen'"
std::string describe(const RoomRange& range) {
  return fmt::format("the range {} to {} of '{}'", range.first_frame, range.last_frame, range.room);
}

Expected<void> validate(const RoomRange& range) {
  if (range.last_frame < range.first_frame) {
    return fail("{} runs backwards; give the lower frame first", describe(range));
  }
  if (auto name = validate_room_name(range.room); !name) {
    return Unexpected(std::move(name).error().with_context(describe(range)));
  }
  if (range.stay < 1) {
    return fail("{} is visit {}; visits are numbered from 1", describe(range), range.stay);
  }
  return {};
}

Expected<void> validate_order(const RoomRange& before, const RoomRange& range) {
  if (range.first_frame > before.last_frame) return {};
  const bool overlaps = range.last_frame >= before.first_frame;
  return fail("{} {} {}; ranges stand in the order of frames and share none", describe(range),
              overlaps ? "overlaps" : "stands after", describe(before));
}

Expected<RoomRange> parse_range(std::span<const std::string_view> words) {
  constexpr std::size_t kFewestWords = 4;
  if (words.size() < kFewestWords) {
    return fail("{} values, expected first_frame last_frame room visit, for example 0 19 kitchen 1",
                words.size());
  }
  const auto first = parse_number<std::uint64_t>(words[0]);
  if (!first) return fail("first_frame = '{}' is not a frame number", words[0]);
  const auto last = parse_number<std::uint64_t>(words[1]);
  if (!last) return fail("last_frame = '{}' is not a frame number", words[1]);
  const auto stay = parse_number<int>(words.back());
  if (!stay) return fail("visit = '{}' is not a number from 1", words.back());
  // A name may have several words: "living room".
  const auto name = words.subspan(2, words.size() - 3);
  return RoomRange{*first, *last, fmt::format("{}", fmt::join(name, " ")), *stay};
}

}  // namespace

Expected<void> validate_room_name(std::string_view name) {
  const auto lines = data_lines(name);
  if (lines.size() == 1 && fmt::format("{}", fmt::join(lines[0].words, " ")) == name) return {};
  return fail(
      "'{}' is no name for a room; give words divided by single blanks, none with '#' first", name);
}

Expected<RoomLabels> RoomLabels::from_ranges(std::vector<RoomRange> ranges) {
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    ROOMWISE_RETURN_IF_ERROR(validate(ranges[i]));
    if (i > 0) ROOMWISE_RETURN_IF_ERROR(validate_order(ranges[i - 1], ranges[i]));
  }
  RoomLabels labels;
  labels.ranges_ = std::move(ranges);
  return labels;
}

Expected<RoomLabels> RoomLabels::read(const std::filesystem::path& path) {
  ROOMWISE_TRY(const std::string text, read_text_file(path));
  RoomLabels labels;
  for (const DataLine& line : data_lines(text)) {
    const auto parse_and_check = [&]() -> Expected<RoomRange> {
      ROOMWISE_TRY(RoomRange range, parse_range(line.words));
      if (!is_plain_text(range.room)) {
        return fail("the name of the room is not UTF-8 text; save the file as UTF-8");
      }
      ROOMWISE_RETURN_IF_ERROR(validate(range));
      if (!labels.ranges_.empty()) {
        ROOMWISE_RETURN_IF_ERROR(validate_order(labels.ranges_.back(), range));
      }
      return range;
    };
    auto range = parse_and_check();
    if (!range) {
      return Unexpected(
          std::move(range).error().with_context(fmt::format("{}:{}", path.string(), line.number)));
    }
    labels.ranges_.push_back(*std::move(range));
  }
  if (labels.ranges_.empty()) {
    return fail("{}: names no room; expected lines such as 0 19 kitchen 1", path.string());
  }
  return labels;
}

std::string RoomLabels::text() const {
  std::string text = "# first_frame last_frame room visit (frames from 0, both ends included)\n";
  for (const RoomRange& range : ranges_) {
    text +=
        fmt::format("{} {} {} {}\n", range.first_frame, range.last_frame, range.room, range.stay);
  }
  return text;
}

Expected<void> RoomLabels::write(const std::filesystem::path& path) const {
  return write_file(path, text());
}

const RoomRange* RoomLabels::find(std::uint64_t frame) const {
  const auto range = std::ranges::lower_bound(ranges_, frame, {}, &RoomRange::last_frame);
  return range != ranges_.end() && range->first_frame <= frame ? &*range : nullptr;
}

std::uint64_t RoomLabels::frames_to_boundary(std::uint64_t frame) const {
  const RoomRange* range = find(frame);
  if (range == nullptr) throw std::invalid_argument("frames_to_boundary: the frame has no label");
  return std::min(frame - range->first_frame, range->last_frame - frame);
}

}  // namespace roomwise::recording
