#include <algorithm>

#include "roomwise/live/home/live_home.h"
#include "roomwise/live/recording/remove_folder.h"
#include "roomwise/pipeline/edits/edit_rooms.h"
#include "roomwise/pipeline/edits/undo_edit.h"
#include "roomwise/pipeline/edits/walk_edits.h"
#include "roomwise/pipeline/rooms/room_contents.h"
#include "roomwise/pipeline/stored/stored_map.h"

// What people change in a home that is open.
namespace roomwise::live {
namespace {

namespace fs = std::filesystem;

Expected<pipeline::HomeThing> find_thing(const home::Home& home, std::int64_t id) {
  ROOMWISE_TRY(auto things, pipeline::find_home_things(home));
  const auto found =
      std::ranges::find_if(things.things, [&](const auto& one) { return thing_id(one) == id; });
  if (found == things.things.end()) {
    return fail("this home has no thing {} any more; look at it anew", id);
  }
  return std::move(*found);
}

}  // namespace

pipeline::EditAuthor LiveHome::author(const std::string& name) const {
  return {name, options_.clock()};
}

Expected<void> LiveHome::name_rooms(home::RecordingId walk,
                                    std::vector<recording::RoomRange> ranges,
                                    const std::string& by) {
  pipeline::number_stays(ranges);
  ROOMWISE_TRY(const auto labels, recording::RoomLabels::from_ranges(std::move(ranges)));
  ROOMWISE_TRY(const auto counts, photos_->counts());
  std::set<std::string> with_photos;
  for (const RoomPhotos::Count& one : counts) with_photos.insert(one.room);
  return change([&](home::Home& home) {
    return pipeline::name_frames(home, author(by), walk, labels, with_photos);
  });
}

Expected<void> LiveHome::change_room(const std::string& name,
                                     const std::optional<std::string>& new_name,
                                     const std::optional<std::string>& new_type,
                                     const std::string& by) {
  return change([&](home::Home& home) {
    return home.atomically([&]() -> Expected<void> {
      ROOMWISE_TRY(const auto rooms, home.rooms());
      const auto room = std::ranges::find(rooms, name, &rooms::Room::name);
      if (room == rooms.end()) return fail("this home has no room '{}'", name);
      if (new_type && *new_type != room->type) {
        ROOMWISE_RETURN_IF_ERROR(pipeline::set_room_type(home, author(by), name, *new_type));
      }
      if (!new_name || *new_name == name) return {};
      ROOMWISE_RETURN_IF_ERROR(pipeline::rename_room(home, author(by), name, *new_name));
      return photos_->begin_rename(name, *new_name);
    });
  });
}

Expected<home::EditId> LiveHome::edit(const std::string& by, const Edit& work) {
  home::EditId id = 0;
  ROOMWISE_RETURN_IF_ERROR(change([&](home::Home& home) -> Expected<void> {
    ROOMWISE_TRY(id, work(home, *view(), author(by)));
    return {};
  }));
  return id;
}

Expected<void> LiveHome::undo(home::EditId id) {
  return change([&](home::Home& home) {
    return undo_edit(home, *photos_, id).map([](const pipeline::StoredEdit&) {});
  });
}

void LiveHome::settle_photos() {
  if (const auto settled = photos_->settle(home_); !settled) {
    options_.log(fmt::format("photos do not follow their rooms: {}", settled.error().message));
  }
}

Expected<void> LiveHome::forget_removed() {
  ROOMWISE_RETURN_IF_ERROR(photos_->settle(home_));
  ROOMWISE_RETURN_IF_ERROR(photos_->forget_set_aside());
  ROOMWISE_TRY(const bool has_any, pipeline::has_removed_rooms(home_));
  if (has_any) ROOMWISE_RETURN_IF_ERROR(pipeline::forget_removed_rooms(home_));
  ROOMWISE_RETURN_IF_ERROR(pipeline::forget_taken_walks(home_));
  ROOMWISE_TRY(const bool owes_erasing, home_.owes_erasing());
  return owes_erasing ? erase_removed(home_) : Expected<void>();
}

Expected<void> LiveHome::erase_now() {
  return while_idle([&]() -> Expected<void> {
    const std::scoped_lock one_by_one(changes_mutex_);
    const std::scoped_lock lock(home_mutex_);
    recognitions_.clear();  // their pictures may show it
    const Expected<void> done = watched("erasing", forget_removed());
    const bool has_taken_walks = !view()->walks_taken_away().empty();
    ROOMWISE_RETURN_IF_ERROR(
        refresh(has_taken_walks ? nullptr : view()->map));  // the map was made of it
    recognitions_.clear();                                  // what came meanwhile may, too
    return done;
  });
}

void LiveHome::erase_what_waits() {
  settle_photos();
  if (const auto done = pipeline::forget_taken_walks(home_, std::string()); !done) {
    options_.log(fmt::format("a walk is not erased yet: {}", done.error().message));
  }
  make_up_for_erasing(home_);
}

void LiveHome::make_up_for_erasing(home::Home& home) {
  const auto owes_erasing = home.owes_erasing();
  if (!owes_erasing || !*owes_erasing) return;
  if (const auto erased = erase_removed(home); !erased) {
    options_.log(fmt::format("what was forgotten is not erased yet: {}", erased.error().message));
  }
}

Expected<JobEnd> LiveHome::erase_owed(const Interruption& interruption) {
  if (interruption.interrupted()) {
    return fail_with(ErrorCode::kInterrupted, "stopped; it is done with the next change");
  }
  const std::scoped_lock lock(home_mutex_);
  ROOMWISE_TRY(const bool owes_erasing, home_.owes_erasing());
  if (owes_erasing) {
    ROOMWISE_RETURN_IF_ERROR(erase_removed(home_));
    ROOMWISE_RETURN_IF_ERROR(refresh(view()->map));
  }
  return JobEnd{"what was forgotten is erased", "erased"};
}

void LiveHome::erase_forgotten(const service::Identity& who, const std::string& name,
                               service::Question what) {
  const auto tell = [this, who, name, what](const Error& why) {
    for (const auto& device : all_devices()) {
      if (device->who().device == who.device && device->is_here()) {
        device->was_not_erased(name, what, why);
      }
    }
  };
  const auto begun = jobs_->start_next("erase", [this, tell](Progress& progress) {
    Expected<JobEnd> erased = erase_owed(progress);
    if (!erased) tell(erased.error());
    return erased;
  });
  if (!begun) tell(begun.error());
  // What is left is looked for as before; what was usual was worked out with what is forgotten.
  if (!begun || what != service::Question::kForgetThing || view()->own_things.empty()) return;
  const auto look = [this](Progress& progress) -> Expected<JobEnd> {
    const std::scoped_lock lock(home_mutex_);
    ROOMWISE_RETURN_IF_ERROR(look_for_own_things(progress).map([](bool) {}));
    return JobEnd{"what is left is looked for as before", "looked_for"};
  };
  static_cast<void>(jobs_->start_next("teach", with_place(look, WorkPlaces::Urgency::kCanWait)));
}

Expected<void> LiveHome::erase_removed(home::Home& home) {
  coverage_stops_ = true;
  const std::scoped_lock lock(reader_mutex_, coverage_mutex_);
  coverage_stops_ = false;
  covered_ = nullptr;  // it knows of what is gone
  coverage_ = nullptr;
  tones_.clear();
  return home.erase_removed();
}

Expected<void> LiveHome::while_idle(const std::function<Expected<void>()>& forget) {
  const bool was_preparing = stop_preparing();
  Expected<void> forgotten = check_idle();
  if (forgotten) forgotten = forget();
  Expected<void> prepared;
  if (was_preparing || !jobs_->running()) prepared = go_on_preparing();
  return forgotten ? prepared : forgotten;
}

Expected<void> LiveHome::forget_room(const std::string& name, const std::string& by) {
  return while_idle([&] {
    recognitions_.clear();  // their pictures may show it
    Expected<void> forgotten = change([&](home::Home& home) {
      return home.atomically([&]() -> Expected<void> {
        ROOMWISE_RETURN_IF_ERROR(pipeline::remove_room(home, author(by), name));
        return photos_->set_aside(name);  // settle_photos() has them back where that is not stored
      });
    });
    recognitions_.clear();  // what came meanwhile may, too
    return forgotten;
  });
}

Expected<void> LiveHome::rename_thing(std::int64_t id, const std::string& name,
                                      const std::string& by) {
  ROOMWISE_RETURN_IF_ERROR(pipeline::validate_spoken_name(name));
  return change([&](home::Home& home) -> Expected<void> {
    ROOMWISE_TRY(const pipeline::HomeThing thing, find_thing(home, id));
    if (thing.name == name && thing.is_confirmed) return {};
    return pipeline::rename_thing(home, author(by), thing, name).map([](home::EditId) {});
  });
}

Expected<void> LiveHome::forget_thing(std::int64_t id, const std::string& by) {
  return change([&](home::Home& home) -> Expected<void> {
    ROOMWISE_TRY(const pipeline::HomeThing thing, find_thing(home, id));
    return pipeline::remove_thing(home, author(by), thing).map([](home::EditId) {});
  });
}

Expected<void> LiveHome::forget_walk(home::RecordingId walk) {
  return while_idle([&] { return erase_walk(walk); });
}

Expected<void> LiveHome::erase_walk(home::RecordingId walk) {
  return change([&](home::Home& home) -> Expected<void> {
    ROOMWISE_TRY(const auto recordings, home.recordings());
    const auto found = std::ranges::find(recordings, walk, &home::StoredRecording::id);
    if (found == recordings.end()) return fail("this home has no recording {}", walk);
    ROOMWISE_TRY(const auto edits, pipeline::stored_edits(home));
    if (!pipeline::walks_taken_away(edits).contains(walk)) {
      // Whoever is killed from here on goes on with it when the home is opened next.
      ROOMWISE_RETURN_IF_ERROR(pipeline::take_walk_away(home, author({}), walk));
    }
    // Whatever becomes of its bytes in the home: its pictures go, since nobody can ask again.
    const Expected<void> removed = pipeline::remove_walk_folder(home, *found);
    ROOMWISE_RETURN_IF_ERROR(pipeline::forget_walk(home, walk));
    const Expected<void> erased = erase_removed(home);
    recognitions_.clear();                       // before pages hear of it and look again
    ROOMWISE_RETURN_IF_ERROR(refresh(nullptr));  // the map was made of it
    ROOMWISE_RETURN_IF_ERROR(erased);
    return removed;
  });
}

Expected<void> LiveHome::forget_home() {
  return while_idle([&]() -> Expected<void> {
    // Those, too, whose map was never finished.
    const auto recordings = [&] {
      const std::scoped_lock lock(home_mutex_);
      return home_.recordings();
    }();
    ROOMWISE_RETURN_IF_ERROR(recordings);
    for (const home::StoredRecording& walk : *recordings)
      ROOMWISE_RETURN_IF_ERROR(erase_walk(walk.id));
    Expected<void> erased;
    ROOMWISE_RETURN_IF_ERROR(change([&](home::Home& home) -> Expected<void> {
      ROOMWISE_RETURN_IF_ERROR(home.atomically([&]() -> Expected<void> {
        ROOMWISE_TRY(const auto edits, home.edits());
        for (const home::Edit& edit : edits) ROOMWISE_RETURN_IF_ERROR(home.remove_edit(edit.id));
        ROOMWISE_TRY(const auto taught, home.own_things());
        for (const auto& thing : taught) ROOMWISE_RETURN_IF_ERROR(home.remove_own_thing(thing.id));
        ROOMWISE_RETURN_IF_ERROR(home.forget_learned_rooms());
        ROOMWISE_RETURN_IF_ERROR(home.owe_erasing());
        ROOMWISE_RETURN_IF_ERROR(home.replace_instances({}));
        ROOMWISE_RETURN_IF_ERROR(home.replace_confirmed_objects({}));
        ROOMWISE_RETURN_IF_ERROR(pipeline::store_object_claims(home, {}));
        return home.replace_rooms({});
      }));
      {
        const std::scoped_lock lock(view_mutex_);
        own_sightings_.clear();
        set_out_.clear();
      }
      erased = erase_removed(home);  // what is shown is without it all the same
      return {};
    }));
    recognitions_.clear();
    ROOMWISE_RETURN_IF_ERROR(lenses_->forget());
    ROOMWISE_RETURN_IF_ERROR(uploads_->remove_all());
    ROOMWISE_RETURN_IF_ERROR(photos_->remove_all());
    ROOMWISE_RETURN_IF_ERROR(remove_folder(walks_folder()));
    return erased;
  });
}

}  // namespace roomwise::live
