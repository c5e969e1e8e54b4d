#include "roomwise/pipeline/rooms/room_coverage.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <span>
#include <utility>

#include "roomwise/pipeline/rooms/home_layout.h"
#include "roomwise/pipeline/stored/keyframe_images.h"
#include "roomwise/pipeline/stored/stored_rooms.h"
#include "roomwise/rooms/recognition/room_classifier.h"

namespace roomwise::pipeline {
namespace {

// ---- light ----

PictureTone tone_of(const image::ColorImage& picture) {
  constexpr int kStep_px = 8;  // a sample tells the mean as well
  double red = 0, green = 0, blue = 0, count = 0;
  for (int y = 0; y < picture.height(); y += kStep_px) {
    for (int x = 0; x < picture.width(); x += kStep_px) {
      const Rgb8 color = picture.at(x, y);
      red += color.r;
      green += color.g;
      blue += color.b;
      ++count;
    }
  }
  // As image::to_gray() weighs them (ITU-R BT.601).
  const double gray = 0.299 * red + 0.587 * green + 0.114 * blue;
  return {gray / (255 * count), (red + count) / (blue + count)};
}

std::array<double, 3> quartiles(std::vector<double> values) {
  std::ranges::sort(values);
  const auto at = [&](double share) {
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
  };
  return {at(0.25), at(0.5), at(0.75)};
}

RoomLight light_of(const std::vector<PictureTone>& tones) {
  std::vector<double> brightness, red_over_blue;
  for (const PictureTone& tone : tones) {
    brightness.push_back(tone.brightness);
    red_over_blue.push_back(tone.red_over_blue);
  }
  const auto [b_low, b, b_high] = quartiles(std::move(brightness));
  const auto [r_low, r, r_high] = quartiles(std::move(red_over_blue));
  return {b, b_low, b_high, r, r_low, r_high};
}

// Of the key-frames that have a room those that are not known yet; what is not in the home any more
// is known no more.
Expected<void> look_at_tones(const home::Home& home, const std::vector<home::Keyframe>& named,
                             PictureTones& known, RunContext& run) {
  PictureTones tones;
  std::vector<home::Keyframe> unknown;
  for (const home::Keyframe& one : named) {
    const auto found = known.find({one.id, one.timestamp_ns});
    if (found == known.end()) {
      unknown.push_back(one);
    } else {
      tones.insert(*found);
    }
  }
  ROOMWISE_RETURN_IF_ERROR(for_each_keyframe(
      home, unknown, "looking at the light", run,
      [](const home::Keyframe&, const DecodedImages& images) { return tone_of(images.color); },
      [&](const home::Keyframe& one, PictureTone tone) -> Expected<void> {
        tones[{one.id, one.timestamp_ns}] = tone;
        return {};
      }));
  known = std::move(tones);
  return {};
}

Expected<void> add_lights(const home::Home& home, const std::vector<home::Keyframe>& keyframes,
                          const KeyframeRooms& rooms, std::vector<RoomSeen>& seen,
                          PictureTones& known, RunContext& run) {
  std::vector<home::Keyframe> named;
  for (const home::Keyframe& one : keyframes) {
    if (rooms.contains(one.id)) named.push_back(one);
  }
  ROOMWISE_RETURN_IF_ERROR(look_at_tones(home, named, known, run));
  std::map<std::pair<std::string, home::RecordingId>, std::vector<PictureTone>> tones;
  for (const home::Keyframe& one : named) {
    tones[{rooms.at(one.id), one.recording}].push_back(known.at({one.id, one.timestamp_ns}));
  }
  for (RoomSeen& room : seen) {
    for (RoomOnWalk& walk : room.walks) {
      if (walk.pictures > 0) walk.light = light_of(tones.at({room.room, walk.walk}));
    }
  }
  return {};
}

// ---- rooms and walks ----

RoomOnWalk& walk_of(RoomSeen& room, home::RecordingId id, TimestampNs at_ns) {
  auto walk = std::ranges::find(room.walks, id, &RoomOnWalk::walk);
  if (walk == room.walks.end()) {
    walk = room.walks.insert(room.walks.end(), {id, 0, at_ns, at_ns, std::nullopt});
  }
  walk->first_ns = std::min(walk->first_ns, at_ns);
  walk->last_ns = std::max(walk->last_ns, at_ns);
  return *walk;
}

// A walk saw a room by its placed frames, which culling keeps, also where none of its key-frames
// is left there.
Expected<std::vector<RoomSeen>> rooms_by_walk(const home::Home& home,
                                              std::span<const home::StoredRecording> recordings,
                                              const std::vector<home::Keyframe>& keyframes,
                                              const KeyframeRooms& room_of) {
  std::vector<RoomSeen> seen;
  ROOMWISE_TRY(const auto rooms, home.rooms());
  for (const rooms::Room& room : rooms) seen.push_back({room.name, {}});
  const auto find_room = [&](const std::string& name) {
    return std::ranges::find(seen, name, &RoomSeen::room);
  };
  for (const home::StoredRecording& recording : recordings) {
    ROOMWISE_TRY(const auto labels, home.room_ranges(recording.id));
    if (labels.ranges().empty()) continue;
    ROOMWISE_TRY(const auto frames, home.frames(recording.id));
    for (const scene::Frame& frame : frames) {
      const recording::RoomRange* const range = frame.place ? labels.find(frame.index) : nullptr;
      if (range == nullptr) continue;
      const auto room = find_room(range->room);
      if (room != seen.end()) walk_of(*room, recording.id, frame.timestamp_ns);
    }
  }
  for (const home::Keyframe& one : keyframes) {
    const auto named = room_of.find(one.id);
    if (named == room_of.end()) continue;
    const auto room = find_room(named->second);
    if (room != seen.end()) ++walk_of(*room, one.recording, one.timestamp_ns).pictures;
  }
  return seen;
}

// How many pictures each room was learned from.
Expected<void> add_learned(const home::Home& home, std::vector<RoomSeen>& seen) {
  ROOMWISE_TRY(const auto record, home.room_classifier());
  if (!record) return {};
  // One that cannot be read is learned anew, and counts for nothing.
  const auto classifier = rooms::RoomClassifier::from_bytes(record->classifier);
  if (!classifier) return {};
  const rooms::RoomGallery& gallery = classifier->retrieval().gallery;
  std::map<int, std::set<int>> pictures_of;  // by room; a picture has rows for its variants, too
  for (std::size_t row = 0; row < gallery.room().size(); ++row) {
    pictures_of[gallery.room()[row]].insert(gallery.picture()[row]);
  }
  for (const auto& [number, pictures] : pictures_of) {
    const std::string& name = classifier->rooms().at(static_cast<std::size_t>(number));
    const auto room = std::ranges::find(seen, name, &RoomSeen::room);
    if (room != seen.end()) room->learned_pictures = pictures.size();
  }
  return {};
}

constexpr std::array<std::pair<Missing, std::string_view>, 7> kMissing{
    {{Missing::kJoin, "join"},
     {Missing::kNames, "names"},
     {Missing::kPictures, "pictures"},
     {Missing::kMorePictures, "more pictures"},
     {Missing::kSecondWalk, "second walk"},
     {Missing::kOtherLight, "other light"},
     {Missing::kFloor, "floor"}}};

}  // namespace

bool RoomLight::differs_from(const RoomLight& other) const {
  const auto differ = [](double a, double a_low, double a_high, double b, double b_low,
                         double b_high) {
    return std::abs(a - b) > std::max(a_high - a_low, b_high - b_low);
  };
  return differ(brightness, brightness_low, brightness_high, other.brightness, other.brightness_low,
                other.brightness_high) ||
         differ(red_over_blue, red_over_blue_low, red_over_blue_high, other.red_over_blue,
                other.red_over_blue_low, other.red_over_blue_high);
}

std::size_t RoomSeen::pictures() const {
  std::size_t pictures = 0;
  for (const RoomOnWalk& walk : walks) pictures += walk.pictures;
  return pictures;
}

bool RoomSeen::is_shown_whole() const {
  return std::ranges::any_of(walks, [](const RoomOnWalk& walk) { return walk.pictures == 0; });
}

std::optional<bool> RoomSeen::by_several_lights() const {
  for (std::size_t a = 0; a < walks.size(); ++a) {
    if (walks[a].pictures == 0) continue;  // culled: by the light of one that was kept
    if (!walks[a].light) return std::nullopt;
    for (std::size_t b = 0; b < a; ++b) {
      if (walks[b].light && walks[a].light->differs_from(*walks[b].light)) return true;
    }
  }
  return false;
}

Expected<void> CoverageOptions::validate() const {
  ROOMWISE_RETURN_IF_ERROR(floor.validate());
  return learning.validate();
}

Expected<RoomCoverage> find_room_coverage(const home::Home& home, const CoverageOptions& options,
                                          RunContext& run, PictureTones& known) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  RoomCoverage coverage;
  ROOMWISE_TRY(coverage.walks, home.recordings());
  ROOMWISE_TRY(const auto all_keyframes, home.keyframes());
  auto keyframes = all_keyframes;
  std::erase_if(coverage.walks,
                [&](const home::StoredRecording& one) { return options.without.contains(one.id); });
  std::erase_if(keyframes,
                [&](const home::Keyframe& one) { return options.without.contains(one.recording); });
  ROOMWISE_TRY(const KeyframeRooms room_of, rooms_of_keyframes(home));
  for (const home::StoredRecording& walk : coverage.walks) {
    const auto is_of_walk = [&](const home::Keyframe& one) { return one.recording == walk.id; };
    const bool is_on_map = std::ranges::any_of(keyframes, [&](const home::Keyframe& one) {
      return is_of_walk(one) && one.pose.component == 0;
    });
    if (!is_on_map) coverage.not_joined.push_back(walk.id);
    coverage.unnamed.push_back(
        static_cast<std::size_t>(std::ranges::count_if(keyframes, [&](const home::Keyframe& one) {
          return is_of_walk(one) && !room_of.contains(one.id);
        })));
  }
  ROOMWISE_TRY(coverage.rooms, rooms_by_walk(home, coverage.walks, keyframes, room_of));
  ROOMWISE_RETURN_IF_ERROR(add_learned(home, coverage.rooms));
  if (!home.is_locked()) {
    ROOMWISE_RETURN_IF_ERROR(add_lights(home, keyframes, room_of, coverage.rooms, known, run));
  }
  ROOMWISE_TRY(const auto layout, find_home_layout(home, run));
  coverage.knows_floor = layout.has_value();
  if (layout) {
    ROOMWISE_TRY(coverage.gaps, find_floor_gaps(home, *layout, all_keyframes, options.floor));
  }
  return coverage;
}

Expected<RoomCoverage> find_room_coverage(const home::Home& home, const CoverageOptions& options,
                                          RunContext& run) {
  PictureTones none;
  return find_room_coverage(home, options, run, none);
}

std::string_view to_string(Missing what) {
  return std::ranges::find(kMissing, what, &std::pair<Missing, std::string_view>::first)->second;
}

std::vector<CoverageItem> missing_items(const RoomCoverage& coverage,
                                        const CoverageOptions& options) {
  std::vector<CoverageItem> items;
  for (const home::RecordingId walk : coverage.not_joined) {
    items.push_back({Missing::kJoin, {}, walk, 0, std::nullopt});
  }
  for (std::size_t i = 0; i < coverage.walks.size(); ++i) {
    if (coverage.unnamed[i] == 0) continue;
    items.push_back({Missing::kNames, {}, coverage.walks[i].id, coverage.unnamed[i], std::nullopt});
  }
  for (const RoomSeen& room : coverage.rooms) {
    const std::size_t pictures = room.pictures();
    const std::size_t comfortable = options.learning.comfortable_pictures;
    if (pictures < options.learning.min_pictures) {
      items.push_back({Missing::kPictures, room.room, std::nullopt, pictures, std::nullopt});
    } else if (pictures < comfortable && room.learned_pictures < comfortable &&
               !room.is_shown_whole()) {
      items.push_back({Missing::kMorePictures, room.room, std::nullopt, pictures, std::nullopt});
    }
    if (room.walks.size() == 1) {
      items.push_back(
          {Missing::kSecondWalk, room.room, room.walks.front().walk, pictures, std::nullopt});
    } else if (room.by_several_lights() == false && !room.walks.empty()) {
      items.push_back({Missing::kOtherLight, room.room, std::nullopt, pictures, std::nullopt});
    }
  }
  for (const FloorGap& gap : coverage.gaps) {
    items.push_back({Missing::kFloor, gap.room, std::nullopt, 0, gap});
  }
  std::ranges::stable_sort(items, {}, &CoverageItem::what);
  return items;
}

}  // namespace roomwise::pipeline
