#include "roomwise/pipeline/rooms/walk_into_home.h"

#include "roomwise/pipeline/rooms/room_learning.h"

namespace roomwise::pipeline {

Expected<home::Home> make_or_open_home(const WalkIntoHome& request) {
  if (!std::filesystem::exists(request.home)) return create_home(request.home, request.open);
  ROOMWISE_TRY(home::Home home, home::Home::open(request.home, request.open));
  ROOMWISE_TRY(const auto recordings, home.recordings());
  const bool is_unfinished = !recordings.empty() && !recordings.back().finished;
  if (is_unfinished && recordings.back().next_frame_index > 0 && !request.resume) {
    return fail("{}: its walk {} was not mapped to the end; give {} to go on with it",
                request.home.string(), recordings.back().recording.name, request.resume_option);
  }
  if (!recordings.empty() && !is_unfinished && request.resume) {
    return fail("{}: is finished; without {} {} is added to it as a further walk",
                request.home.string(), request.resume_option, request.recording.string());
  }
  return home;
}

Expected<void> name_rooms_if_unnamed(home::Home& home, const recording::RoomLabels& labels) {
  ROOMWISE_TRY(const auto stored, home.recordings());
  ROOMWISE_TRY(const recording::RoomLabels named, home.room_ranges(stored.back().id));
  if (!named.ranges().empty()) return {};
  return name_rooms(home, stored.back().id, labels);
}

void remove_empty_home(const std::filesystem::path& path) {
  const auto is_empty = [&] {
    const auto home = home::Home::open_read_only(path);
    if (!home) return false;
    const auto keyframes = home->keyframes();
    return keyframes && keyframes->empty();
  };
  std::error_code ignored;
  if (is_empty()) std::filesystem::remove(path, ignored);
}

}  // namespace roomwise::pipeline
