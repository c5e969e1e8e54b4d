#include <algorithm>

#include "roomwise/live/device/owner.h"
#include "roomwise/live/home/live_home.h"

// Things that people teach a home that is open.
namespace roomwise::live {
namespace {

constexpr std::int64_t kNanoseconds = 1'000'000'000;
// Where a thing was seen last is written this often at most: each writing waits for the disk.
constexpr std::int64_t kBetweenWritings_s = 10;

// The key-frame of the map that is nearest to a place, and the place in its camera's frame.
std::optional<std::pair<home::KeyframeId, Eigen::Vector3d>> beside_keyframe(
    const HomeView& view, const Eigen::Vector3d& place_plan) {
  if (!view.map) return std::nullopt;
  const Eigen::Vector3d world = view.map->frame.world_from_plan(place_plan);
  const ViewedKeyframe* nearest = nullptr;
  const auto apart = [&](const ViewedKeyframe& one) {
    return (one.keyframe.pose.world_from_keyframe.translation - world).squaredNorm();
  };
  for (const ViewedKeyframe& one : view.keyframes) {
    if (one.on_map && (nearest == nullptr || apart(one) < apart(*nearest))) nearest = &one;
  }
  if (nearest == nullptr) return std::nullopt;
  const Eigen::Vector3d middle = nearest->keyframe.pose.world_from_keyframe.inverse() * world;
  return std::pair(nearest->keyframe.id, middle);
}

}  // namespace

// ---- what each is told ----

std::shared_ptr<const HomeView> LiveHome::view_for(const service::Identity& who) const {
  const std::scoped_lock lock(view_mutex_);
  const bool is_for_all =
      view_->own_things.empty() && view_->marked.empty() && !set_out_.contains(who.device);
  if (is_for_all) return view_;
  std::shared_ptr<const HomeView>& of_device = views_of_devices_[who.device];
  if (of_device) return of_device;
  auto view = std::make_shared<HomeView>(*view_);
  for (const ViewedOwnThing& one : view_->own_things) {
    if (!one.stored.is_known_to(owner_of(who))) continue;
    const auto live = own_sightings_.find(one.stored.id);
    const bool is_newer =
        live != own_sightings_.end() && live->second.seen_s > one.stored.last_seen.seen_s;
    view->things.push_back(
        is_newer ? with_sighting(one.thing, without_gone_room(live->second, *view_)) : one.thing);
  }
  view->spots = spots_for(who);
  of_device = std::move(view);
  return of_device;
}

guide::KnownThing LiveHome::with_sighting(guide::KnownThing thing, const OwnSighting& sighting) {
  thing.position_plan = sighting.place_plan;
  thing.room = sighting.room;
  thing.seen = calendar_time(sighting.seen_s * kNanoseconds);
  return thing;
}

void LiveHome::note_own_things(const FrameResult& result) {
  if (result.own_things.empty()) return;
  const std::int64_t now_s = unix_now_ns() / kNanoseconds;
  {
    const std::scoped_lock lock(view_mutex_);
    for (const SeenOwnThing& one : result.own_things) {
      OwnSighting& sighting = own_sightings_[one.id];
      sighting = {now_s, one.room, one.place_plan, sighting.written_s};
    }
    views_of_devices_.clear();
  }
  write_own_sightings(now_s - kBetweenWritings_s);
}

std::map<home::OwnThingId, OwnSighting> due_sightings(
    const std::map<home::OwnThingId, OwnSighting>& sightings, std::int64_t before_s) {
  std::map<home::OwnThingId, OwnSighting> due;
  for (const auto& [id, sighting] : sightings) {
    const bool waits = sighting.seen_s > sighting.written_s && sighting.written_s <= before_s;
    if (waits) due.emplace(id, sighting);
  }
  return due;
}

OwnSighting without_gone_room(OwnSighting sighting, const HomeView& now) {
  const bool is_there = sighting.room && std::ranges::find(now.rooms, *sighting.room,
                                                           &rooms::Room::name) != now.rooms.end();
  if (!is_there) sighting.room.reset();
  return sighting;
}

void LiveHome::write_own_sightings(std::int64_t before_s) {
  {
    const std::scoped_lock lock(view_mutex_);
    if (due_sightings(own_sightings_, before_s).empty()) return;
  }
  // Helpers' changes wait for this one as for each other; else they would be refused.
  const std::unique_lock one_by_one(changes_mutex_, std::try_to_lock);
  if (!one_by_one.owns_lock()) return;  // the next sighting, or the end, tries again
  const std::unique_lock home_lock(home_mutex_, std::try_to_lock);
  if (!home_lock.owns_lock()) return;  // a job writes: the same
  store_own_sightings(before_s);
}

// With home_mutex_ held.
void LiveHome::store_own_sightings(std::int64_t before_s) {
  const auto now = view();
  const auto due = [&] {
    const std::scoped_lock lock(view_mutex_);
    return due_sightings(own_sightings_, before_s);
  }();
  for (const auto& [id, sighting] : due) {
    home::OwnThingSighting stored{sighting.seen_s, without_gone_room(sighting, *now).room,
                                  std::nullopt, std::nullopt};
    if (sighting.place_plan) {
      if (const auto beside = beside_keyframe(*now, *sighting.place_plan)) {
        stored.keyframe = beside->first;
        stored.middle_keyframe = beside->second;
      }
    }
    // Of a thing that was forgotten meanwhile nothing is kept; a full disk is told by what must not
    // be lost.
    (void)home_.put_own_thing_sighting(id, stored);
  }
  const std::scoped_lock lock(view_mutex_);
  for (const auto& [id, sighting] : due) {
    const auto written = own_sightings_.find(id);
    if (written != own_sightings_.end()) written->second.written_s = sighting.seen_s;
  }
}

Expected<std::shared_ptr<const pipeline::OwnThingWatch>> LiveHome::own_thing_watch() const {
  ROOMWISE_TRY(const auto things, home_.own_things());
  if (things.empty()) return std::shared_ptr<const pipeline::OwnThingWatch>();
  ROOMWISE_TRY(const auto keyframes, home_.keyframes());
  {
    const std::scoped_lock lock(view_mutex_);
    const bool is_same = view_ && view_->own_thing_watch &&
                         view_->keyframes.size() == keyframes.size() &&
                         std::ranges::equal(view_->own_thing_watch->things(), things, {},
                                            &home::OwnThing::id, &home::OwnThing::id);
    if (is_same) return view_->own_thing_watch;
  }
  // Where what is usual is not known yet, a job learns it.
  auto watch = pipeline::watch_own_things(home_, networks_, finders_.in_pictures);
  return watch ? *std::move(watch) : nullptr;
}

// ---- teaching ----

Expected<void> LiveHome::teach(const std::shared_ptr<Device>& device, const std::string& name,
                               bool is_private, std::vector<objects::ShownThing> shown) {
  const home::OwnThing thing{.name = name,
                             .owner = owner_of(device->who()),
                             .is_shared = !is_private,
                             .taught_s = unix_now_ns() / kNanoseconds};
  const auto learn_it = [this, device, thing,
                         shown = std::move(shown)](Progress& progress) -> Expected<JobEnd> {
    auto taught = teach_now(thing, shown, progress);
    device->was_taught(thing.name, taught);
    // Helpers and the log are told of the job, and not what the thing is called.
    if (!taught && taught.error().code == ErrorCode::kRefused) {
      return job_failure("name_is_none", "a thing's name will not do any more; give it another");
    }
    return taught.map([&](bool is_looked_for) {
      return is_looked_for ? JobEnd{"a thing is known now", "taught"}
                           : JobEnd{"a thing is known, and looked for with the next walk",
                                    "taught_for_later"};
    });
  };
  return instead_of_preparing([&]() -> Expected<void> {
    {
      const std::unique_lock lock(home_mutex_, std::try_to_lock);
      if (!lock.owns_lock()) return fail("the computer is busy; wait until it is done");
      ROOMWISE_RETURN_IF_ERROR(pipeline::check_own_thing_name(home_, name));
      ROOMWISE_RETURN_IF_ERROR(home_.check_new_name(name));
    }
    return start_work("teach", learn_it, WorkPlaces::Urgency::kAnswersWait);
  });
}

Expected<bool> LiveHome::teach_now(const home::OwnThing& thing,
                                   const std::vector<objects::ShownThing>& shown,
                                   Progress& progress) {
  const std::scoped_lock lock(home_mutex_);
  ROOMWISE_RETURN_IF_ERROR(
      pipeline::teach_own_thing(home_, thing, shown, networks_).map([](home::OwnThingId) {}));
  const Expected<bool> looked = look_for_own_things(progress);
  if (looked) return looked;
  // It is known all the same, and looked for with the next walk.
  if (looked.error().code != ErrorCode::kInterrupted) {
    meters_.failed("looking for a thing", looked.error());
  }
  ROOMWISE_RETURN_IF_ERROR(refresh(view()->map));
  return false;
}

// With home_mutex_ held.
Expected<bool> LiveHome::look_for_own_things(Progress& progress) {
  if (!lost_pictures_) begin_lost_pictures();
  pipeline::OwnRunContext run(options_.threads, progress);
  run.lost = lost_pictures_;
  ROOMWISE_TRY(const pipeline::OwnThingLook look,
               pipeline::look_for_own_things(home_, networks_, finders_.in_pictures, run));
  ROOMWISE_RETURN_IF_ERROR(refresh(view()->map));
  return look.is_looked_for;
}

Expected<void> LiveHome::change_own_thing(const service::Identity& who, const std::string& name,
                                          service::Question what) {
  const auto change_it = [&](home::Home& home) -> Expected<void> {
    ROOMWISE_TRY(const auto things, home.own_things());
    const auto thing = std::ranges::find(things, name, &home::OwnThing::name);
    if (thing == things.end() || thing->owner != owner_of(who)) {
      return fail_with(ErrorCode::kRefused, "'{}' was not taught by this device", name);
    }
    if (what != service::Question::kForgetThing) {
      return home.share_own_thing(thing->id, what == service::Question::kShareThing);
    }
    ROOMWISE_RETURN_IF_ERROR(home.remove_own_thing(thing->id));
    {
      const std::scoped_lock lock(view_mutex_);
      own_sightings_.erase(thing->id);
    }
    return {};
  };
  return change(change_it, Owed::kErasedLater);
}

}  // namespace roomwise::live
