#include <algorithm>

#include "roomwise/live/live_home.h"
#include "roomwise/live/remove_folder.h"
#include "roomwise/pipeline/rooms/room_contents.h"
#include "roomwise/pipeline/rooms/room_learning.h"
#include "roomwise/pipeline/stored/stored_map.h"

// What people change in a home that is open.
namespace roomwise::live {
namespace {

namespace fs = std::filesystem;

// Counts each room's visits, in the order of frames.
void number_visits(std::vector<recording::RoomRange>& ranges) {
  std::ranges::sort(ranges, {}, &recording::RoomRange::first_frame);
  std::map<std::string, int> visits;
  for (recording::RoomRange& range : ranges) range.visit = ++visits[range.room];
}

// A learned classifier goes on with the new name.
Expected<void> rename_in_classifier(home::Home& home, const std::string& name,
                                    const std::string& new_name) {
  ROOMWISE_TRY(auto record, home.room_classifier());
  if (!record) return {};
  auto classifier = rooms::RoomClassifier::from_bytes(record->classifier);
  if (!classifier) return home.forget_learned_rooms();
  std::vector<std::string> rooms = classifier->rooms();
  std::ranges::replace(rooms, name, new_name);
  record->classifier = rooms::RoomClassifier(classifier->network(), rooms, classifier->regression(),
                                             classifier->retrieval())
                           .to_bytes();
  ROOMWISE_CHECK_OK(home.put_room_classifier(*record));
  ROOMWISE_TRY(auto pictures, home.visit_pictures());
  for (home::VisitPicture& picture : pictures) {
    if (picture.room == name) picture.room = new_name;
  }
  ROOMWISE_CHECK_OK(home.replace_visit_pictures(pictures));
  ROOMWISE_TRY(auto keyframe_rooms, home.keyframe_rooms());
  for (auto& [keyframe, scores] : keyframe_rooms) {
    for (rooms::RoomScore& score : scores) {
      if (score.room == name) score.room = new_name;
    }
  }
  return home.replace_keyframe_rooms(keyframe_rooms);
}

// Changes the name of a room wherever the walks have it; none: its ranges go.
Expected<void> rename_in_walks(home::Home& home, const std::string& name,
                               const std::optional<std::string>& new_name) {
  ROOMWISE_TRY(const auto recordings, home.recordings());
  for (const home::StoredRecording& recording : recordings) {
    ROOMWISE_TRY(const recording::RoomLabels labels, home.room_ranges(recording.id));
    std::vector<recording::RoomRange> ranges = labels.ranges();
    if (new_name) {
      for (recording::RoomRange& range : ranges) {
        if (range.room == name) range.room = *new_name;
      }
    } else {
      std::erase_if(ranges, [&](const recording::RoomRange& range) { return range.room == name; });
    }
    number_visits(ranges);
    ROOMWISE_CHECK_OK(home.replace_room_ranges(recording.id, ranges));
  }
  return {};
}

Expected<void> rename_room(home::Home& home, const std::string& name, const std::string& new_name) {
  ROOMWISE_TRY(auto rooms, home.rooms());
  const auto room = std::ranges::find(rooms, name, &rooms::Room::name);
  if (std::ranges::find(rooms, new_name, &rooms::Room::name) != rooms.end()) {
    return fail("there is a room '{}' already", new_name);
  }
  // Both names stand until no range has the old one any more.
  rooms.push_back({new_name, room->type});
  ROOMWISE_CHECK_OK(home.replace_rooms(rooms));
  ROOMWISE_CHECK_OK(rename_in_walks(home, name, new_name));
  std::erase_if(rooms, [&](const rooms::Room& one) { return one.name == name; });
  ROOMWISE_CHECK_OK(rename_in_classifier(home, name, new_name));
  ROOMWISE_CHECK_OK(pipeline::move_object_claims(home, name, new_name));
  return home.replace_rooms(rooms);
}

Expected<void> check_has_room(const home::Home& home, const std::string& name) {
  ROOMWISE_TRY(const auto rooms, home.rooms());
  if (std::ranges::find(rooms, name, &rooms::Room::name) != rooms.end()) return {};
  return fail("this home has no room '{}'", name);
}

Expected<std::vector<objects::Instance>::iterator> find_thing(
    std::vector<objects::Instance>& things, std::int64_t id) {
  const auto found = std::ranges::find(things, id, thing_id);
  if (found == things.end()) {
    return fail("this home has no thing {} any more; look at it anew", id);
  }
  return found;
}

}  // namespace

Expected<void> LiveHome::name_rooms(home::RecordingId walk,
                                    std::vector<recording::RoomRange> ranges) {
  number_visits(ranges);
  ROOMWISE_TRY(const auto labels, recording::RoomLabels::from_ranges(std::move(ranges)));
  return change([&](home::Home& home) { return pipeline::name_rooms(home, walk, labels); });
}

Expected<void> LiveHome::change_room(const std::string& name,
                                     const std::optional<std::string>& new_name,
                                     const std::optional<std::string>& new_type) {
  return change([&](home::Home& home) {
    return home.atomically([&]() -> Expected<void> {
      ROOMWISE_CHECK_OK(check_has_room(home, name));
      if (new_type) {
        ROOMWISE_TRY(auto rooms, home.rooms());
        std::ranges::find(rooms, name, &rooms::Room::name)->type = *new_type;
        ROOMWISE_CHECK_OK(home.replace_rooms(rooms));
      }
      if (!new_name || *new_name == name) return {};
      ROOMWISE_CHECK_OK(rename_room(home, name, *new_name));
      return photos_->rename(name, *new_name);
    });
  });
}

Expected<void> LiveHome::erase_removed(home::Home& home) {
  const std::scoped_lock lock(reader_mutex_);
  return home.erase_removed();
}

Expected<void> LiveHome::while_idle(const std::function<Expected<void>()>& forget) {
  static_cast<void>(stop_preparing());
  Expected<void> forgotten = check_idle();
  if (forgotten) forgotten = forget();
  Expected<void> prepared = go_on_preparing();
  return forgotten ? prepared : forgotten;
}

Expected<void> LiveHome::forget_room(const std::string& name) {
  return while_idle([&]() -> Expected<void> {
    recognitions_.clear();  // their pictures may show it
    return change([&](home::Home& home) -> Expected<void> {
      ROOMWISE_CHECK_OK(home.atomically([&]() -> Expected<void> {
        ROOMWISE_CHECK_OK(check_has_room(home, name));
        ROOMWISE_CHECK_OK(rename_in_walks(home, name, std::nullopt));
        ROOMWISE_CHECK_OK(pipeline::move_object_claims(home, name, std::nullopt));
        ROOMWISE_CHECK_OK(home.forget_learned_rooms());
        ROOMWISE_TRY(auto rooms, home.rooms());
        std::erase_if(rooms, [&](const rooms::Room& one) { return one.name == name; });
        return home.replace_rooms(rooms);
      }));
      ROOMWISE_CHECK_OK(photos_->remove(name));
      const Expected<void> erased = erase_removed(home);
      if (erased) return {};
      ROOMWISE_CHECK_OK(refresh(view()->map));  // it is gone, whatever became of its bytes
      return erased;
    });
  });
}

Expected<void> LiveHome::rename_thing(std::int64_t id, const std::string& name) {
  if (name.empty()) return fail("'name' is empty; a thing needs a name");
  return change([&](home::Home& home) -> Expected<void> {
    ROOMWISE_TRY(auto things, home.instances());
    ROOMWISE_TRY(const auto thing, find_thing(things, id));
    thing->name = name;
    thing->names = {{name, 1.0}};
    thing->probability = 1;  // somebody says so who was there
    return home.replace_instances(things);
  });
}

Expected<void> LiveHome::forget_thing(std::int64_t id) {
  return change([&](home::Home& home) -> Expected<void> {
    ROOMWISE_TRY(auto things, home.instances());
    ROOMWISE_TRY(const auto thing, find_thing(things, id));
    things.erase(thing);
    return home.replace_instances(things);
  });
}

Expected<void> LiveHome::forget_walk(home::RecordingId walk) {
  return while_idle([&] { return erase_walk(walk); });
}

Expected<void> LiveHome::erase_walk(home::RecordingId walk) {
  fs::path folder;
  bool is_gone = false;
  const Expected<void> forgotten = change([&](home::Home& home) -> Expected<void> {
    ROOMWISE_TRY(const auto recordings, home.recordings());
    const auto found = std::ranges::find(recordings, walk, &home::StoredRecording::id);
    if (found == recordings.end()) return fail("this home has no recording {}", walk);
    folder = found->recording.folder;
    ROOMWISE_CHECK_OK(pipeline::forget_walk(home, walk));
    is_gone = true;
    const Expected<void> erased = erase_removed(home);
    recognitions_.clear();                // before pages hear of it and look again
    ROOMWISE_CHECK_OK(refresh(nullptr));  // the map was made of it
    return erased;
  });
  // Whatever became of its bytes in the home: its pictures go, since nobody can ask again.
  std::error_code error;
  if (is_gone && folder.parent_path() == walks_folder()) fs::remove_all(folder, error);
  ROOMWISE_CHECK_OK(forgotten);
  if (error) return fail("{}: could not be removed: {}", folder.string(), error.message());
  return {};
}

Expected<void> LiveHome::forget_home() {
  return while_idle([&]() -> Expected<void> {
    // Those, too, whose map was never finished.
    const auto recordings = [&] {
      const std::scoped_lock lock(home_mutex_);
      return home_.recordings();
    }();
    ROOMWISE_CHECK_OK(recordings);
    for (const home::StoredRecording& walk : *recordings) ROOMWISE_CHECK_OK(erase_walk(walk.id));
    ROOMWISE_CHECK_OK(change([&](home::Home& home) -> Expected<void> {
      ROOMWISE_CHECK_OK(home.atomically([&]() -> Expected<void> {
        ROOMWISE_CHECK_OK(home.forget_learned_rooms());
        ROOMWISE_CHECK_OK(home.replace_instances({}));
        ROOMWISE_CHECK_OK(home.replace_paper_objects({}));
        ROOMWISE_CHECK_OK(pipeline::store_object_claims(home, {}));
        return home.replace_rooms({});
      }));
      return erase_removed(home);
    }));
    recognitions_.clear();
    ROOMWISE_CHECK_OK(lenses_->forget());
    ROOMWISE_CHECK_OK(uploads_->remove_all());
    ROOMWISE_CHECK_OK(photos_->remove_all());
    return remove_folder(walks_folder());
  });
}

}  // namespace roomwise::live
