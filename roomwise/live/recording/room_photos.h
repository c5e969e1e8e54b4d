#pragma once

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roomwise/live/recording/free_disk_bytes.h"
#include "roomwise/pipeline/rooms/room_learning.h"
#include "roomwise/pipeline/stored/stored_edits.h"

namespace roomwise::live {

// How much of the disk photos take.
struct PhotoLimits {
  std::uint64_t max_bytes = std::uint64_t{4} << 30U;      // of all, those set aside among them
  std::uint64_t reserve_bytes = std::uint64_t{1} << 30U;  // of the disk, that stay free
  FreeBytesQuery free_bytes = {};                         // none: free_bytes_at()

  [[nodiscard]] Expected<void> validate() const;
};

// Photos of rooms, by which a home can be begun before anybody walked through it, kept as files so
// that rooms can be learned anew when another is added. Thread-safe.
class RoomPhotos {
 public:
  // A whole turn on the spot: with every eighth of it a picture, the pictures of a phone's camera,
  // some 60 degrees wide, overlap.
  static constexpr std::size_t kPerRoom = 8;
  static constexpr std::size_t kMaxPerRoom = 64;
  static constexpr std::size_t kMaxRooms = 200;

  struct Count {
    std::string room;
    std::size_t photos = 0;

    friend bool operator==(const Count&, const Count&) = default;
  };

  // `folder` is made with the first photo.
  explicit RoomPhotos(std::filesystem::path folder, PhotoLimits limits = {});

  // Keeps the picture alone (metadata.h): not where it was taken. How many photos of the room there
  // are now; one that is there already is not counted again.
  // Fails on what is no picture or a tiny one, and where there are enough; by kDiskFull, with the
  // mend, where photos or the disk leave no room for it.
  [[nodiscard]] Expected<std::size_t> add(const std::string& room,
                                          std::span<const std::uint8_t> sent);
  [[nodiscard]] Expected<std::vector<Count>> counts() const;             // by room
  [[nodiscard]] Expected<std::vector<pipeline::RoomPhoto>> all() const;  // by room and file
  // Fails, saying what to do, where the room has photos: rooms that are learned with them would
  // have it again after it was joined to `kept`.
  [[nodiscard]] Expected<void> check_can_join(const std::string& kept,
                                              const std::string& joined) const;
  // Where the room has photos. They are called so once settle() finds that the room is.
  [[nodiscard]] Expected<void> begin_rename(const std::string& room, const std::string& new_name);
  [[nodiscard]] Expected<void> remove(const std::string& room);
  // Keeps them where nothing finds them, until they are brought back or forgotten.
  [[nodiscard]] Expected<void> set_aside(const std::string& room);
  [[nodiscard]] Expected<void> bring_back(const std::string& room);
  // After a change of the home's rooms, whether it was stored or not, and where a program may have
  // been killed in one: new names hold where the rooms have them, else they are dropped, and photos
  // come back that were set aside with a room that no change takes out.
  [[nodiscard]] Expected<void> settle(const home::Home& home);
  [[nodiscard]] Expected<void> forget_set_aside();
  [[nodiscard]] Expected<void> remove_all();

 private:
  [[nodiscard]] std::filesystem::path folder_of(const std::string& room) const;
  [[nodiscard]] std::vector<std::filesystem::path> folders_set_aside() const;
  [[nodiscard]] Expected<void> bring_back_folder(const std::filesystem::path& folder,
                                                 const std::string& room);
  [[nodiscard]] Expected<std::vector<pipeline::RoomPhoto>> read_all() const;
  [[nodiscard]] Expected<void> check_room_for(std::uint64_t bytes);

  std::filesystem::path folder_;
  PhotoLimits limits_;
  std::optional<std::uint64_t> taken_bytes_;  // of all photos; none: to be counted anew
  mutable std::mutex mutex_;
};

// pipeline::undo_edit(); settle() is to follow.
[[nodiscard]] Expected<pipeline::StoredEdit> undo_edit(home::Home& home, RoomPhotos& photos,
                                                       home::EditId id);

}  // namespace roomwise::live
