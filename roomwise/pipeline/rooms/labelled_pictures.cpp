#include "roomwise/pipeline/rooms/labelled_pictures.h"

#include <algorithm>
#include <memory>

#include "roomwise/image/codec.h"
#include "roomwise/image/picture_files.h"
#include "roomwise/pipeline/in_blocks.h"
#include "roomwise/pipeline/rooms/room_learning.h"
#include "roomwise/recording/open_recording.h"
#include "roomwise/recording/tum_recording.h"

namespace roomwise::pipeline {
namespace {

namespace fs = std::filesystem;

// A TUM folder whose pictures have no depth, or no known camera.
bool lists_colors_alone(const fs::path& folder) {
  std::error_code ignored;
  const auto has = [&](const char* file) { return fs::exists(folder / file, ignored); };
  return has("rgb.txt") && !(has("depth.txt") && has("camera.txt"));
}

Expected<RecordedPictures> open_colors(const fs::path& folder) {
  ROOMWISE_TRY(auto opened, recording::ImageList::open(folder, "rgb.txt"));
  const auto list = std::make_shared<const recording::ImageList>(std::move(opened));
  RecordedPictures recorded;
  for (const TimestampNs timestamp_ns : list->timestamps_ns()) {
    recorded.pictures.push_back({recorded.pictures.size(), timestamp_ns, false});
  }
  recorded.read_color = [list](std::uint64_t index) { return list->read_color(index); };
  recorded.describe = [list](const auto& one) { return list->path(one.index).string(); };
  return recorded;
}

bool is_learned(const std::string& room, const std::vector<std::string>& learned) {
  return std::ranges::count(learned, room) > 0;
}

Expected<void> check_not_empty(const std::vector<LabelledPicture>& pictures) {
  if (pictures.empty())
    return fail("no picture is left to evaluate: check --rooms, --visits and --margin");
  return {};
}

}  // namespace

Expected<RecordedPictures> RecordedPictures::open(const fs::path& path) {
  if (lists_colors_alone(path)) return open_colors(path);
  ROOMWISE_TRY(auto opened, recording::open_recording(path));
  RecordedPictures recorded;
  recorded.damaged = opened->damaged();
  recorded.with_depth = std::move(opened);
  recorded.pictures = recorded.with_depth->pictures();
  recorded.read_color = [all = recorded.with_depth](std::uint64_t i) { return all->read_color(i); };
  recorded.describe = [all = recorded.with_depth](const auto& one) { return all->describe(one); };
  return recorded;
}

LabelledPicture RecordedPictures::picture(const recording::RecordedPicture& one) const {
  LabelledPicture picture;
  picture.read = [read = read_color, index = one.index] { return read(index); };
  picture.frame = one.index;
  const TimestampNs first_ns = pictures.front().timestamp_ns;
  picture.time_s = 1e-9 * static_cast<double>(one.timestamp_ns - first_ns);
  if (with_depth && one.has_depth) {
    picture.read_to_locate = [all = with_depth, index = one.index]() -> Expected<PictureToLocate> {
      ROOMWISE_TRY(auto frame, all->frame(index));
      if (!frame) return fail("{}: picture {} has no depth", all->info().name, index);
      return PictureToLocate{std::move(frame->color), std::move(frame->depth), all->info().camera};
    };
  }
  return picture;
}

Expected<void> add_frames(const RecordedPictures& recorded, const recording::RoomLabels& labels,
                          const FrameSelection& selection, const std::vector<std::string>& learned,
                          const std::string& walk_name, std::vector<LabelledPicture>& pictures) {
  ROOMWISE_RETURN_IF_ERROR(selection.rooms.check_against(labels));
  for (const std::string& room : selection.rooms.rooms) {
    if (!is_learned(room, learned)) return fail("the room '{}' was never learned", room);
  }
  const std::size_t before = pictures.size();
  const std::size_t walk = pictures.empty() ? 0 : pictures.back().walk + 1;
  std::size_t sequence = pictures.empty() ? 0 : pictures.back().sequence + 1;
  for (const recording::RoomRange& range : labels.ranges()) {
    ++sequence;
    if (!selection.rooms.contains(range) || !is_learned(range.room, learned)) continue;
    std::uint64_t last = recorded.pictures.back().index;
    if (!recorded.damaged.empty()) last = std::max(last, recorded.damaged.back().index);
    if (range.last_frame > last) {
      return fail(
          "the labels name frame {}, but the recording has {} colour images, the last of them {}; "
          "are they of another recording?",
          range.last_frame, recorded.pictures.size(), last);
    }
    for (const recording::RecordedPicture& one : recorded.pictures) {
      const std::uint64_t frame = one.index;
      if (frame < range.first_frame || frame > range.last_frame) continue;
      if (labels.frames_to_boundary(frame) < selection.margin) continue;
      LabelledPicture picture = recorded.picture(one);
      picture.room = range.room;
      picture.sequence = sequence;
      picture.walk = walk;
      picture.name = fmt::format("{}: frame {}", walk_name, frame);
      pictures.push_back(std::move(picture));
    }
  }
  if (pictures.size() == before) ROOMWISE_RETURN_IF_ERROR(check_not_empty({}));
  return {};
}

Expected<std::vector<LabelledPicture>> select_photos(const fs::path& folder,
                                                     const std::vector<std::string>& learned) {
  ROOMWISE_TRY(const std::vector<RoomPhoto> photos, list_room_photos(folder));
  std::vector<LabelledPicture> pictures;
  for (const RoomPhoto& photo : photos) {
    if (!is_learned(photo.room, learned)) continue;
    const bool same_room = !pictures.empty() && pictures.back().room == photo.room;
    const std::size_t sequence =
        pictures.empty() ? 0 : pictures.back().sequence + (same_room ? 0 : 1);
    pictures.push_back({[path = photo.path] { return image::read_color(path); }, photo.room,
                        sequence, 0, 0, 0, photo.path.filename().string()});
  }
  ROOMWISE_RETURN_IF_ERROR(check_not_empty(pictures));
  return pictures;
}

Expected<std::vector<std::string>> add_unknown_pictures(const fs::path& folder,
                                                        std::vector<LabelledPicture>& pictures) {
  std::vector<std::string> damage;
  const std::size_t before = pictures.size();
  std::size_t sequence = pictures.empty() ? 0 : pictures.back().sequence + 1;
  const std::size_t walk = pictures.empty() ? 0 : pictures.back().walk + 1;
  if (lists_colors_alone(folder) || recording::find_recording_kind(folder) != nullptr) {
    ROOMWISE_TRY(const RecordedPictures recorded, RecordedPictures::open(folder));
    for (const recording::RecordedPicture& one : recorded.pictures) {
      pictures.push_back(recorded.picture(one));
      pictures.back().name = recorded.describe(one);
      pictures.back().sequence = sequence;
      pictures.back().walk = walk;
    }
    for (const recording::DamagedFrame& one : recorded.damaged) damage.push_back(one.why);
  } else {
    ROOMWISE_TRY(const auto files, image::picture_files(folder));
    for (const fs::path& file : files) {
      pictures.push_back(
          {[file] { return image::read_color(file); }, "", sequence++, walk, 0, 0, file.string()});
    }
  }
  if (pictures.size() == before) {
    return fail("{}: holds no JPEG or PNG files", folder.string());
  }
  return damage;
}

Expected<std::vector<std::string>> leave_out_damaged(std::vector<LabelledPicture>& pictures,
                                                     RunContext& run) {
  std::vector<std::string> damage;
  std::vector<LabelledPicture> whole;
  const auto index = [](std::size_t i) -> Expected<std::size_t> { return i; };
  const auto why_damaged = [&](std::size_t i, std::size_t) -> Expected<std::string> {
    const auto message = [](const auto& read) { return read ? "" : read.error().message; };
    const LabelledPicture& one = pictures[i];
    return one.read_to_locate ? message(one.read_to_locate()) : message(one.read());
  };
  const auto take = [&](std::size_t i, std::string why) -> Expected<void> {
    if (why.empty()) {
      whole.push_back(pictures[i]);
    } else {
      damage.push_back(std::move(why));
    }
    return {};
  };
  ROOMWISE_RETURN_IF_ERROR(
      in_blocks(pictures.size(), "looking for damage", run, index, why_damaged, take));
  pictures = std::move(whole);
  return damage;
}

}  // namespace roomwise::pipeline
