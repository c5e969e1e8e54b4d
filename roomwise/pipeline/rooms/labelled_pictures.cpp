#include "roomwise/pipeline/rooms/labelled_pictures.h"

#include <algorithm>
#include <memory>

#include "roomwise/image/codec.h"
#include "roomwise/image/picture_files.h"
#include "roomwise/pipeline/rooms/room_learning.h"

namespace roomwise::pipeline {
namespace {

namespace fs = std::filesystem;

bool is_learned(const std::string& room, const std::vector<std::string>& learned) {
  return std::ranges::count(learned, room) > 0;
}

Expected<void> check_not_empty(const std::vector<LabelledPicture>& pictures) {
  if (pictures.empty())
    return fail("no picture is left to evaluate: check --rooms, --visits and --margin");
  return {};
}

}  // namespace

Expected<RecordedPictures> RecordedPictures::open(const fs::path& folder) {
  RecordedPictures recorded;
  ROOMWISE_TRY(auto colors, recording::ImageList::open(folder, "rgb.txt"));
  recorded.colors = std::make_shared<const recording::ImageList>(std::move(colors));
  if (fs::exists(folder / "depth.txt") && fs::exists(folder / "camera.txt")) {
    ROOMWISE_TRY(recorded.with_depth, recording::TumRecording::open(folder));
  }
  return recorded;
}

LabelledPicture RecordedPictures::picture(std::size_t entry) const {
  LabelledPicture picture;
  picture.read = [list = colors, entry] { return list->read_color(entry); };
  picture.frame = entry;
  const auto& times = colors->timestamps_ns();
  picture.time_s = 1e-9 * static_cast<double>(times[entry] - times[0]);
  const bool has_depth =
      with_depth && std::ranges::binary_search(with_depth->associations(), entry, {},
                                               &recording::Association::first);
  if (has_depth) {
    picture.read_to_locate = [frames = with_depth, entry]() -> Expected<PictureToLocate> {
      ROOMWISE_TRY(auto frame, frames->frame(entry));
      if (!frame) return fail("{}: has no depth image", frames->colors().describe(entry));
      return PictureToLocate{std::move(frame->color), std::move(frame->depth),
                             frames->info().camera};
    };
  }
  return picture;
}

Expected<void> add_frames(const RecordedPictures& recorded, const recording::RoomLabels& labels,
                          const FrameSelection& selection, const std::vector<std::string>& learned,
                          const std::string& walk_name, std::vector<LabelledPicture>& pictures) {
  ROOMWISE_CHECK_OK(selection.rooms.check_against(labels));
  for (const std::string& room : selection.rooms.rooms) {
    if (!is_learned(room, learned)) return fail("the room '{}' was never learned", room);
  }
  const std::size_t before = pictures.size();
  const std::size_t walk = pictures.empty() ? 0 : pictures.back().walk + 1;
  std::size_t sequence = pictures.empty() ? 0 : pictures.back().sequence + 1;
  for (const recording::RoomRange& range : labels.ranges()) {
    ++sequence;
    if (!selection.rooms.contains(range) || !is_learned(range.room, learned)) continue;
    if (range.last_frame >= recorded.colors->size()) {
      return fail(
          "the labels name frame {}, but the recording has {} colour images; are they of another "
          "recording?",
          range.last_frame, recorded.colors->size());
    }
    for (std::uint64_t frame = range.first_frame; frame <= range.last_frame; ++frame) {
      if (labels.frames_to_boundary(frame) < selection.margin) continue;
      LabelledPicture picture = recorded.picture(frame);
      picture.room = range.room;
      picture.sequence = sequence;
      picture.walk = walk;
      picture.name = fmt::format("{}: frame {}", walk_name, frame);
      pictures.push_back(std::move(picture));
    }
  }
  if (pictures.size() == before) ROOMWISE_CHECK_OK(check_not_empty({}));
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
  ROOMWISE_CHECK_OK(check_not_empty(pictures));
  return pictures;
}

Expected<void> add_unknown_pictures(const fs::path& folder,
                                    std::vector<LabelledPicture>& pictures) {
  const std::size_t before = pictures.size();
  std::size_t sequence = pictures.empty() ? 0 : pictures.back().sequence + 1;
  const std::size_t walk = pictures.empty() ? 0 : pictures.back().walk + 1;
  std::error_code error;
  if (fs::exists(folder / "rgb.txt", error)) {
    ROOMWISE_TRY(const RecordedPictures recorded, RecordedPictures::open(folder));
    for (std::size_t i = 0; i < recorded.colors->size(); ++i) {
      pictures.push_back(recorded.picture(i));
      pictures.back().name = recorded.colors->path(i).string();
      pictures.back().sequence = sequence;
      pictures.back().walk = walk;
    }
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
  return {};
}

}  // namespace roomwise::pipeline
