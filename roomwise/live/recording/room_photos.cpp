#include "roomwise/live/recording/room_photos.h"

#include <algorithm>
#include <set>
#include <tuple>
#include <utility>

#include "roomwise/base/file.h"
#include "roomwise/image/codec.h"
#include "roomwise/image/metadata.h"
#include "roomwise/live/recording/remove_folder.h"
#include "roomwise/pipeline/edits/undo_edit.h"
#include "roomwise/pipeline/stored/stored_edits.h"

namespace roomwise::live {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kDigits = 24;  // of names that are made of a digest
constexpr const char* kNameFile = "room.txt";
constexpr const char* kAsideFile = "removed_room.txt";  // in its place, of a room that was removed
constexpr const char* kNewNameFile = "new_name.txt";    // beside it, of one that is being renamed
constexpr std::int64_t kMaxPhotoPixels = 24'000'000;
constexpr int kMinPhotoSide_px = 160;

std::string digest_of(std::span<const std::uint8_t> bytes) {
  return sha256_hex(bytes).substr(0, kDigits);
}

const char* ending_of(std::span<const std::uint8_t> picture) {
  if (image::is_png(picture)) return ".png";
  return image::is_webp(picture) ? ".webp" : ".jpg";
}

// What lies in a folder, as far as it can be listed.
std::vector<fs::path> entries_of(const fs::path& folder) {
  std::vector<fs::path> entries;
  std::error_code error;
  fs::directory_iterator one(folder, error);
  for (; !error && one != fs::directory_iterator(); one.increment(error))
    entries.push_back(one->path());
  return entries;
}

std::uint64_t bytes_in(const fs::path& folder) {
  std::uint64_t bytes = 0;
  for (const fs::path& room : entries_of(folder)) {
    for (const fs::path& file : entries_of(room)) {
      std::error_code error;
      const std::uintmax_t size = fs::file_size(file, error);
      if (!error) bytes += size;
    }
  }
  return bytes;
}

Expected<void> rename_file(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (error) return fail("{}: cannot be renamed: {}", from.string(), error.message());
  return {};
}

}  // namespace

Expected<void> PhotoLimits::validate() const {
  if (max_bytes == 0) return fail("max_bytes = 0 takes no photo");
  return {};
}

RoomPhotos::RoomPhotos(fs::path folder, PhotoLimits limits)
    : folder_(std::move(folder)), limits_(std::move(limits)) {
  if (!limits_.free_bytes) limits_.free_bytes = free_bytes_at;
}

// With the lock held.
Expected<void> RoomPhotos::check_room_for(std::uint64_t bytes) {
  ROOMWISE_RETURN_IF_ERROR(limits_.validate());
  constexpr std::uint64_t kMegabyte = 1'000'000;
  if (!taken_bytes_) taken_bytes_ = bytes_in(folder_);
  if (*taken_bytes_ + bytes > limits_.max_bytes) {
    return fail_with(ErrorCode::kDiskFull,
                     "the photos of this home take {} MB, and {} MB are kept for them; take photos "
                     "of a room away that was learned by a walk, then try again",
                     *taken_bytes_ / kMegabyte, limits_.max_bytes / kMegabyte);
  }
  ROOMWISE_TRY(const std::uint64_t free, limits_.free_bytes(folder_));
  if (free < limits_.reserve_bytes + bytes) {
    return fail_with(ErrorCode::kDiskFull,
                     "the computer's disk is nearly full: {} MB are free, of which {} MB stay so; "
                     "free some space, then try again",
                     free / kMegabyte, limits_.reserve_bytes / kMegabyte);
  }
  return {};
}

// The folder whose name file says so. A new one is called by a digest, since a room's name may be
// longer than a file's, and hold a slash; a room that was renamed keeps the folder it had.
fs::path RoomPhotos::folder_of(const std::string& room) const {
  std::error_code error;
  for (const fs::path& one : entries_of(folder_)) {
    const auto name = read_text_file(one / kNameFile);
    if (name && *name == room) return one;
  }
  fs::path fresh =
      folder_ / digest_of({reinterpret_cast<const std::uint8_t*>(room.data()), room.size()});
  while (fs::exists(fresh / kNameFile, error) || fs::exists(fresh / kAsideFile, error)) {
    fresh += "+";
  }
  return fresh;
}

Expected<std::vector<pipeline::RoomPhoto>> RoomPhotos::read_all() const {
  std::vector<pipeline::RoomPhoto> photos;
  std::error_code error;
  for (const fs::path& room : entries_of(folder_)) {
    if (!fs::exists(room / kNameFile, error)) continue;
    ROOMWISE_TRY(const std::string name, read_text_file(room / kNameFile));
    for (const fs::path& file : entries_of(room)) {
      if (file.filename() != kNameFile && file.stem().string().size() == kDigits) {
        photos.push_back({file, name});
      }
    }
  }
  std::ranges::sort(photos, {}, [](const pipeline::RoomPhoto& photo) {
    return std::tie(photo.room, photo.path);
  });
  return photos;
}

Expected<std::vector<pipeline::RoomPhoto>> RoomPhotos::all() const {
  const std::scoped_lock lock(mutex_);
  return read_all();
}

Expected<std::vector<RoomPhotos::Count>> RoomPhotos::counts() const {
  ROOMWISE_TRY(const auto photos, all());
  std::vector<Count> counts;
  for (const pipeline::RoomPhoto& photo : photos) {
    if (counts.empty() || counts.back().room != photo.room) counts.push_back({photo.room, 0});
    ++counts.back().photos;
  }
  return counts;
}

Expected<void> RoomPhotos::check_can_join(const std::string& kept,
                                          const std::string& joined) const {
  ROOMWISE_TRY(const auto rooms, counts());
  const auto found = std::ranges::find(rooms, joined, &Count::room);
  if (found == rooms.end()) return {};
  return fail(
      "{} photos show the room '{}', which would be back when rooms are learned anew; take its "
      "photos away first, or join '{}' to '{}' and rename that",
      found->photos, joined, kept, joined);
}

Expected<std::size_t> RoomPhotos::add(const std::string& room, std::span<const std::uint8_t> sent) {
  ROOMWISE_RETURN_IF_ERROR(pipeline::validate_spoken_name(room));
  ROOMWISE_RETURN_IF_ERROR(recording::validate_room_name(room));
  ROOMWISE_TRY(const image::ColorImage color, image::decode_color(sent, kMaxPhotoPixels));
  const auto bare = image::without_metadata(sent);
  const Bytes picture = bare ? *bare : image::encode_png(color);
  if (std::min(color.width(), color.height()) < kMinPhotoSide_px) {
    return fail("the photo has {} x {} pixels; at least {} a side are needed", color.width(),
                color.height(), kMinPhotoSide_px);
  }
  const std::scoped_lock lock(mutex_);
  ROOMWISE_TRY(const auto photos, read_all());
  std::vector<std::string> rooms;
  for (const auto& photo : photos) rooms.push_back(photo.room);
  const auto of_room = static_cast<std::size_t>(std::ranges::count(rooms, room));
  rooms.erase(std::unique(rooms.begin(), rooms.end()), rooms.end());
  if (of_room >= kMaxPerRoom)
    return fail("there are {} photos of '{}', which is enough", of_room, room);
  if (of_room == 0 && rooms.size() >= kMaxRooms) {
    return fail("there are photos of {} rooms; no more are taken", rooms.size());
  }
  const fs::path folder = folder_of(room);
  const fs::path file = folder / (digest_of(picture) + ending_of(picture));
  std::error_code error;
  if (fs::exists(file, error)) return of_room;
  ROOMWISE_RETURN_IF_ERROR(check_room_for(picture.size()));
  fs::create_directories(folder, error);
  if (error) return fail("{}: cannot be made: {}", folder.string(), error.message());
  fs::permissions(folder_, fs::perms::owner_all, error);  // pictures of a home
  const std::uint64_t taken = *std::exchange(taken_bytes_, std::nullopt);
  ROOMWISE_RETURN_IF_ERROR(write_file(folder / kNameFile, room));
  ROOMWISE_RETURN_IF_ERROR(write_file(file, picture));
  taken_bytes_ = taken + picture.size() + (of_room == 0 ? room.size() : 0);
  return of_room + 1;
}

Expected<void> RoomPhotos::begin_rename(const std::string& room, const std::string& new_name) {
  const std::scoped_lock lock(mutex_);
  std::error_code error;
  const fs::path folder = folder_of(room);
  if (!fs::exists(folder / kNameFile, error) || room == new_name) return {};
  if (fs::exists(folder_of(new_name) / kNameFile, error)) {
    return fail("there are photos of a room '{}' already", new_name);
  }
  return write_file(folder / kNewNameFile, new_name);
}

Expected<void> RoomPhotos::remove(const std::string& room) {
  const std::scoped_lock lock(mutex_);
  taken_bytes_.reset();
  return remove_folder(folder_of(room));
}

std::vector<fs::path> RoomPhotos::folders_set_aside() const {
  std::vector<fs::path> folders;
  std::error_code error;
  for (const fs::path& one : entries_of(folder_)) {
    if (fs::exists(one / kAsideFile, error)) folders.push_back(one);
  }
  std::ranges::sort(folders);
  return folders;
}

Expected<void> RoomPhotos::set_aside(const std::string& room) {
  const std::scoped_lock lock(mutex_);
  std::error_code error;
  const fs::path folder = folder_of(room);
  if (!fs::exists(folder / kNameFile, error)) return {};
  return rename_file(folder / kNameFile, folder / kAsideFile);
}

// With the lock held.
Expected<void> RoomPhotos::bring_back_folder(const fs::path& folder, const std::string& room) {
  taken_bytes_.reset();  // the same picture may be in both folders
  std::error_code error;
  const fs::path now = folder_of(room);  // there may be newer ones
  if (fs::exists(now / kNameFile, error)) {
    for (const fs::path& file : entries_of(folder)) {
      if (file.filename() == kAsideFile) continue;
      fs::rename(file, now / file.filename(), error);
    }
    return remove_folder(folder);
  }
  return rename_file(folder / kAsideFile, folder / kNameFile);
}

Expected<void> RoomPhotos::bring_back(const std::string& room) {
  const std::scoped_lock lock(mutex_);
  for (const fs::path& folder : folders_set_aside()) {
    ROOMWISE_TRY(const std::string name, read_text_file(folder / kAsideFile));
    if (name == room) return bring_back_folder(folder, name);
  }
  return {};
}

Expected<void> RoomPhotos::settle(const home::Home& home) {
  ROOMWISE_TRY(const auto known, home.rooms());
  ROOMWISE_TRY(const auto edits, pipeline::stored_edits(home));
  std::set<std::string> rooms, removed;
  for (const rooms::Room& room : known) rooms.insert(room.name);
  for (const pipeline::StoredEdit& edit : edits) {
    if (edit.kind == pipeline::EditKind::kRemoveRoom) removed.insert(edit.change.room);
  }
  const std::scoped_lock lock(mutex_);
  for (const fs::path& folder : folders_set_aside()) {
    ROOMWISE_TRY(const std::string name, read_text_file(folder / kAsideFile));
    if (!removed.contains(name)) ROOMWISE_RETURN_IF_ERROR(bring_back_folder(folder, name));
  }
  for (const fs::path& folder : entries_of(folder_)) {
    std::error_code error;
    if (!fs::exists(folder / kNewNameFile, error)) continue;
    ROOMWISE_TRY(const std::string name, read_text_file(folder / kNameFile));
    ROOMWISE_TRY(const std::string new_name, read_text_file(folder / kNewNameFile));
    if (rooms.contains(new_name) && !rooms.contains(name)) {
      ROOMWISE_RETURN_IF_ERROR(rename_file(folder / kNewNameFile, folder / kNameFile));
    } else {
      fs::remove(folder / kNewNameFile, error);
    }
  }
  return {};
}

Expected<void> RoomPhotos::forget_set_aside() {
  const std::scoped_lock lock(mutex_);
  taken_bytes_.reset();
  for (const fs::path& folder : folders_set_aside())
    ROOMWISE_RETURN_IF_ERROR(remove_folder(folder));
  return {};
}

Expected<void> RoomPhotos::remove_all() {
  const std::scoped_lock lock(mutex_);
  taken_bytes_.reset();
  return remove_folder(folder_);
}

Expected<pipeline::StoredEdit> undo_edit(home::Home& home, RoomPhotos& photos, home::EditId id) {
  std::optional<pipeline::StoredEdit> undone;
  ROOMWISE_RETURN_IF_ERROR(home.atomically([&]() -> Expected<void> {
    ROOMWISE_TRY(undone, pipeline::undo_edit(home, id));
    if (undone->kind != pipeline::EditKind::kRenameRoom) return {};
    return photos.begin_rename(undone->change.room, undone->change.old_name);
  }));
  if (undone->kind == pipeline::EditKind::kRemoveRoom)
    (void)photos.bring_back(undone->change.room);  // else settle() tries again
  return *std::move(undone);
}

}  // namespace roomwise::live
