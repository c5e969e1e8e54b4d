#include <algorithm>

#include "roomwise/base/name.h"
#include "roomwise/live/home/live_home.h"
#include "roomwise/live/recording/walk_frames.h"
#include "roomwise/pipeline/mapping/home_floor.h"
#include "roomwise/pipeline/mapping/map_recording.h"
#include "roomwise/pipeline/rooms/room_learning.h"
#include "roomwise/pipeline/rooms/walk_into_home.h"
#include "roomwise/recording/damage_tolerant_source.h"
#include "roomwise/recording/open_recording.h"

// The long work of a home that is open: recording, mapping, learning.
namespace roomwise::live {

namespace fs = std::filesystem;

namespace {

// How many pictures of each room there are to learn from.
std::map<std::string, std::size_t> pictures_to_learn(
    const HomeView& view, const std::vector<pipeline::RoomPhoto>& photos) {
  const auto taken = view.walks_taken_away();
  std::map<std::string, std::size_t> pictures;
  for (const ViewedKeyframe& one : view.keyframes) {
    if (!one.room.empty() && !taken.contains(one.keyframe.recording)) ++pictures[one.room];
  }
  for (const pipeline::RoomPhoto& photo : photos) ++pictures[photo.room];
  return pictures;
}

// Why rooms cannot be learned of what there is, where people can mend that.
std::optional<JobEnd> why_not_learned(const std::map<std::string, std::size_t>& pictures,
                                      bool has_network) {
  if (!has_network) {
    return job_failure("no_network",
                       "no network is here to learn rooms with; get one: roomwise networks list");
  }
  if (pictures.size() == 1) {
    return job_failure("one_room",
                       fmt::format("there are pictures of {} alone; telling rooms apart "
                                   "takes at least two rooms",
                                   pictures.begin()->first));
  }
  const std::size_t wanted = rooms::LearningOptions{}.min_pictures;
  const auto fewest =
      std::ranges::min_element(pictures, {}, [](const auto& room) { return room.second; });
  if (fewest == pictures.end() || fewest->second >= wanted) return std::nullopt;
  JobEnd end = job_failure(
      "few_pictures", fmt::format("there are {} pictures of {}; learning takes at least {} of each "
                                  "room: walk through it once more, or take photos of it",
                                  fewest->second, fewest->first, wanted));
  end.values = {{"pictures", static_cast<std::int64_t>(fewest->second)},
                {"wanted", static_cast<std::int64_t>(wanted)}};
  return end;
}

// What is told of a recording that was closed.
service::RecordingState end_of_recording(const WalkRecorder& recorder, std::int64_t device,
                                         const Expected<void>& closed) {
  const std::uint64_t frames = recorder.frames(), without_depth = recorder.without_depth();
  service::RecordingState state{device, "saved", recorder.name(), frames, ""};
  if (without_depth > 0) {
    state.text = fmt::format("{} frames had no depth and were left out", without_depth);
  }
  if (closed && frames > 0) return state;
  state.state = closed ? "empty" : "failed";
  if (!closed) state.text = closed.error().message;
  return state;
}

JobEnd map_is_ready() {
  return {"places can be found on the map now", "prepared"};
}

}  // namespace

Jobs::Body LiveHome::with_place(Jobs::Body body, WorkPlaces::Urgency urgency) {
  return [this, body = std::move(body), urgency](JobProgress& progress) -> Expected<JobEnd> {
    ROOMWISE_TRY(const auto place, options_.work_places->take(urgency, progress));
    return with_map_ready(body(progress), progress);
  };
}

Expected<void> LiveHome::start_work(const std::string& kind, Jobs::Body body,
                                    WorkPlaces::Urgency urgency) {
  return jobs_->start(kind, with_place(std::move(body), urgency));
}

Expected<JobEnd> LiveHome::with_map_ready(Expected<JobEnd> ended, Progress& progress) {
  const bool is_stopped = !ended && ended.error().code == ErrorCode::kInterrupted;
  if (is_stopped || is_prepared()) return ended;
  auto prepared = prepare(progress);
  const bool is_well = ended && !ended->has_failed;
  return is_well && !prepared ? prepared : ended;
}

Expected<void> LiveHome::go_on_preparing() {
  if (is_prepared()) return {};
  return jobs_->start_next("prepare", [this](Progress& progress) -> Expected<JobEnd> {
    if (is_prepared()) return map_is_ready();  // by what was done before
    // Questions come first: what helpers look at is fused while they are answered.
    const auto ready = [&]() -> Expected<std::shared_ptr<const LiveMap>> {
      ROOMWISE_TRY(const auto place,
                   options_.work_places->take(WorkPlaces::Urgency::kAnswersWait, progress));
      return make_map_ready(progress);
    }();
    if (!ready) return Unexpected(ready.error());
    ROOMWISE_TRY(const auto place,
                 options_.work_places->take(WorkPlaces::Urgency::kCanWait, progress));
    return fuse_clouds(**ready, progress);
  });
}

bool LiveHome::is_prepared() const {
  const auto now = view();
  return now->walks.empty() || (now->map && now->map->clouds);
}

bool LiveHome::stop_preparing() {
  return jobs_->stop_and_wait("prepare");
}

Expected<void> LiveHome::instead_of_preparing(const std::function<Expected<void>()>& start) {
  const bool was_preparing = stop_preparing();
  Expected<void> started = start();
  if (!started && was_preparing) static_cast<void>(go_on_preparing());
  return started;
}

Expected<JobEnd> LiveHome::prepare(Progress& progress) {
  ROOMWISE_TRY(const auto map, make_map_ready(progress));
  return fuse_clouds(*map, progress);
}

Expected<std::shared_ptr<const LiveMap>> LiveHome::make_map_ready(Progress& progress) {
  if (!lost_pictures_) begin_lost_pictures();
  if (auto ready = view()->map) return ready;
  pipeline::OwnRunContext run(options_.threads, progress);
  run.lost = lost_pictures_;
  // By a reader of its own, so that pictures can be looked at meanwhile.
  ROOMWISE_TRY(const home::Home reader, home::Home::open_read_only(file_, options_.open));
  ROOMWISE_TRY(std::shared_ptr<const LiveMap> map, make_live_map(reader, run));
  const std::scoped_lock lock(home_mutex_);
  ROOMWISE_RETURN_IF_ERROR(pipeline::keep_home_floor(home_, {map->frame, map->floor}));
  // One that lacks pictures is not kept: perhaps they can be read the next time.
  if (map->localizer->new_index() && lost_pictures_->all().empty())
    ROOMWISE_RETURN_IF_ERROR(home_.put_derived_data(*map->localizer->new_index()));
  ROOMWISE_RETURN_IF_ERROR(refresh(map));
  return map;
}

Expected<JobEnd> LiveHome::fuse_clouds(const LiveMap& ready, Progress& progress) {
  pipeline::OwnRunContext run(options_.threads, progress);
  run.lost = lost_pictures_;
  ROOMWISE_TRY(const home::Home reader, home::Home::open_read_only(file_, options_.open));
  ROOMWISE_TRY(auto map, with_clouds(ready, reader, run));
  const std::scoped_lock lock(home_mutex_);
  ROOMWISE_RETURN_IF_ERROR(refresh(std::move(map)));
  // A new walk may show what was taught.
  const bool is_looked_for = view()->own_things.empty() || view()->own_thing_watch != nullptr;
  if (!is_looked_for) {
    ROOMWISE_RETURN_IF_ERROR(look_for_own_things(progress).map([](bool) {}));
  }
  return map_is_ready();
}

Expected<void> LiveHome::learn() {
  if (!jobs_->running() && view()->walks.empty()) {
    ROOMWISE_TRY(const auto photos, photos_->all());
    if (photos.empty()) {
      return fail(
          "this home holds no walk to learn from; take photos of its rooms, or record one first");
    }
  }
  return instead_of_preparing([&] {
    return start_work("learn", [this](Progress& progress) { return learn_now(progress); });
  });
}

Expected<JobEnd> LiveHome::learn_now(Progress& progress) {
  const std::scoped_lock lock(home_mutex_);
  pipeline::OwnRunContext run(options_.threads, progress);
  ROOMWISE_TRY(const auto recordings, home_.recordings());
  ROOMWISE_TRY(const auto photos, photos_->all());
  const auto learn_from_photos = [&]() -> Expected<rooms::LearningReport> {
    ROOMWISE_TRY(const network::Classifier* network, pipeline::features_network(networks_));
    return pipeline::learn_rooms_from_photos(home_, photos, *network,
                                             {.variants = options_.augment}, run);
  };
  pipeline::RoomLearning learning;
  learning.variants = options_.augment;
  learning.photos = photos;
  const bool is_any_named = std::ranges::any_of(
      view()->walks, [](const ViewedWalk& walk) { return !walk.labels.ranges().empty(); });
  if (!is_any_named && photos.empty()) {
    return job_failure("no_room_named", "no room of a walk is named; name its rooms first");
  }
  const auto taken = view()->walks_taken_away();
  if (!taken.empty()) {  // nothing more is learned of what is to be forgotten
    for (const ViewedWalk& walk : view()->walks) {
      const bool is_named = !walk.labels.ranges().empty();
      if (is_named && !taken.contains(walk.stored.id)) learning.walks.push_back(walk.stored.id);
    }
    if (learning.walks.empty() && photos.empty()) {
      return job_failure("no_room_named",
                         "no room of a walk that stays is named; name its rooms first");
    }
  }
  if (auto why_not = why_not_learned(pictures_to_learn(*view(), photos), !networks_.empty())) {
    return *std::move(why_not);
  }
  const bool has_walk = taken.empty() ? !recordings.empty() : !learning.walks.empty();
  ROOMWISE_TRY(const auto report,
               has_walk ? pipeline::learn_rooms_from_keyframes(home_, {}, learning, networks_, run)
                        : learn_from_photos());
  ROOMWISE_RETURN_IF_ERROR(refresh(view()->map));
  const auto right =
      std::llround(report.held_out_precision() * static_cast<double>(report.held_out));
  return JobEnd{
      fmt::format(
          "{} rooms learned; as a test, {} of {} pictures that were kept apart were named rightly",
          report.rooms.size(), right, report.held_out),
      "learned",
      {{"rooms", static_cast<std::int64_t>(report.rooms.size())},
       {"right", right},
       {"tested", static_cast<std::int64_t>(report.held_out)}}};
}

Expected<void> LiveHome::begin_recording(std::int64_t device, const std::string& name) {
  if (!is_name(name))
    return fail("the recording's name has no letter and no digit, or unseen signs");
  ROOMWISE_RETURN_IF_ERROR(recording::validate_room_name(name));
  if (name.find_first_of("/\\") != std::string::npos || name.starts_with('.')) {
    return fail("'{}' is no name for a recording: it must not hold '/' or begin with '.'", name);
  }
  const auto connected = all_devices();
  // Copied here: a device that is locked may wait for devices_mutex_.
  std::optional<service::DeviceCamera> camera;
  const auto found = std::ranges::find_if(connected, [&](const auto& one) {
    if (one->who().device != device || !one->is_here()) return false;
    camera = one->camera();
    return camera.has_value();
  });
  if (found == connected.end()) return fail("device {} is not connected with a camera", device);
  std::shared_ptr<WalkRecorder> recorder;
  ROOMWISE_RETURN_IF_ERROR(instead_of_preparing([&]() -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(check_idle());
    // Its pictures may be removed; the new ones would be taken for them.
    ROOMWISE_TRY(const bool is_known, has_recording_of(walks_folder() / name));
    if (is_known) return fail("the home knows a walk '{}' already; choose another name", name);
    const std::scoped_lock lock(devices_mutex_);
    if (recorder_) return fail("'{}' is being recorded; stop it first", recorder_->name());
    ROOMWISE_RETURN_IF_ERROR(make_walks_folder());
    ROOMWISE_TRY(recorder, WalkRecorder::begin(walks_folder() / name, *camera, unix_now_ns()));
    recorder_ = recorder;
    recording_device_ = device;
    return {};
  }));
  // Before the first frame comes: who is recorded is to know it, and sends whole frames from now
  // on.
  recorded(**found, {device, "recording", recorder->name(), 0, ""});
  (*found)->record_to(recorder);
  // Where that cannot be now, it is done at the end.
  static_cast<void>(start_mapping(recorder));
  return {};
}

Expected<void> LiveHome::end_recording() {
  std::shared_ptr<WalkRecorder> recorder;
  std::int64_t recorded = 0;  // the device
  bool is_being_mapped = false;
  {
    const std::scoped_lock lock(devices_mutex_);
    recorder = std::exchange(recorder_, nullptr);
    recorded = recording_device_;  // from here on another may be recorded
    is_being_mapped = growing_ != nullptr && growing_ == recorder;
  }
  if (!recorder) return fail("nothing is being recorded");
  for (const auto& device : all_devices()) {
    if (device->who().device == recorded) device->record_to(nullptr);
  }
  const Expected<void> closed = recorder->close();
  if (!closed) {
    const std::scoped_lock lock(devices_mutex_);
    unclosed_.push_back(recorder);
  }
  {
    const std::scoped_lock one_by_one(telling_mutex_);
    tell_of_recording(recorded, end_of_recording(*recorder, recorded, closed));
  }
  ROOMWISE_RETURN_IF_ERROR(closed);
  if (is_being_mapped) return {};
  if (recorder->frames() == 0) {  // its name is free again
    std::error_code ignored;
    std::filesystem::remove_all(recorder->folder(), ignored);
    return {};
  }
  const auto map = [this, folder = recorder->folder()](Progress& progress) {
    return map_folder(folder, progress);
  };
  return instead_of_preparing(
      [&] { return jobs_->start_next("map", with_place(map, WorkPlaces::Urgency::kCanWait)); });
}

Expected<void> LiveHome::start_mapping_what_waits() {
  return start_work("map", [this](JobProgress& progress) -> Expected<JobEnd> {
    Expected<JobEnd> ended = JobEnd{"nothing waited to be mapped", "nothing_waited"};
    std::set<fs::path> failed;
    for (std::size_t done = 0;; ++done) {
      ROOMWISE_TRY(const auto waiting, waiting_walks(failed));
      if (waiting.empty()) return ended;
      progress.begin_round(done, done + waiting.size());
      auto mapped = map_folder(waiting.front(), progress);
      if (!mapped && mapped.error().code == ErrorCode::kInterrupted) return mapped;
      if (!mapped) failed.insert(waiting.front());
      if (ended) ended = std::move(mapped);  // the first that failed is told of
    }
  });
}

Expected<void> LiveHome::go_on_mapping() {
  return instead_of_preparing([&]() -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(check_idle());
    ROOMWISE_TRY(const auto waiting, waiting_walks());
    return waiting.empty() ? fail("no walk waits to be mapped") : start_mapping_what_waits();
  });
}

Expected<JobEnd> LiveHome::map_folder(const fs::path& folder, Progress& progress) {
  ROOMWISE_TRY(const auto walk, recording::open_recording(folder));
  return map(folder, *walk, walk->inertial(), progress);
}

// Takes no place: it waits for frames as long as somebody walks.
Expected<void> LiveHome::start_mapping(std::shared_ptr<const WalkRecorder> walk) {
  const auto grows = [this](std::shared_ptr<const WalkRecorder> one) {
    const std::scoped_lock lock(devices_mutex_);
    growing_ = std::move(one);
  };
  grows(walk);
  Expected<void> started = jobs_->start("map", [this, walk, grows](Progress& progress) {
    Expected<JobEnd> mapped = [&]() -> Expected<JobEnd> {
      if (!walk->wait_for_frame(0, progress) && !progress.interrupted()) {
        return JobEnd{"nothing was recorded", "nothing_waited"};
      }
      ROOMWISE_TRY(const auto frames, WalkFrames::open(walk, progress));
      return map(walk->folder(), *frames, {}, progress);
    }();
    grows(nullptr);  // where that failed, it is mapped anew at its end
    return with_map_ready(std::move(mapped), progress);
  });
  if (!started) grows(nullptr);
  return started;
}

void LiveHome::begin_lost_pictures() {
  lost_pictures_ = std::make_shared<pipeline::LostPictures>(
      true, [this](const Error& why) { meters_.failed("reading a picture of the map", why); });
}

Expected<JobEnd> LiveHome::map(const fs::path& folder, recording::FrameSource& walk,
                               const geometry::InertialTrack& felt, Progress& progress) {
  ROOMWISE_TRY(const auto unfinished, unfinished_walk());
  if (unfinished && *unfinished != folder) {
    const auto finished = map_folder(*unfinished, progress);
    if (!finished) {
      return fail_with(finished.error().code,
                       "'{}' was not mapped to its end, and must be first, or be forgotten: {}",
                       unfinished->filename().string(), finished.error().message);
    }
  }
  // One picture that is damaged is not to cost the walk.
  recording::DamageTolerantSource frames(walk, true);
  begin_lost_pictures();
  pipeline::MapSummary summary;
  Expected<void> names_read;
  {
    const std::scoped_lock lock(home_mutex_);
    pipeline::OwnRunContext run(options_.threads, progress);
    run.lost = lost_pictures_;
    ROOMWISE_TRY(const auto stored, pipeline::stored_map_settings(home_));
    pipeline::MapSettings settings = stored.value_or(pipeline::MapSettings{});
    if (!stored) settings.mapper.seed = options_.seed;
    const home::Recording recording{walk.info().name, folder.string(), walk.info().camera,
                                    walk.info().frames_remaining};
    const auto name_rooms = [&]() -> Expected<void> {
      if (!fs::exists(folder / "rooms.txt")) return {};
      const auto labels = recording::RoomLabels::read(folder / "rooms.txt");
      if (labels) return pipeline::name_rooms_if_unnamed(home_, *labels);
      names_read = Unexpected(labels.error());  // the walk is in the home all the same
      return {};
    };
    auto mapped = pipeline::map_recording(frames, recording, home_, networks_, settings, run,
                                          finders_, name_rooms, felt);
    if (!mapped || !mapped->finished)
      ROOMWISE_RETURN_IF_ERROR(refresh(nullptr));  // it may be forgotten
    ROOMWISE_TRY(summary, std::move(mapped));
    for (const std::string& why : summary.unread) meters_.failed("comparing walks", Error{why});
    if (!summary.finished) {
      return fail_with(ErrorCode::kInterrupted,
                       "stopped; it goes on when the computer starts again");
    }
    ROOMWISE_RETURN_IF_ERROR(refresh(nullptr));
  }
  ROOMWISE_RETURN_IF_ERROR(prepare(progress));
  ROOMWISE_RETURN_IF_ERROR(names_read);
  JobEnd end{fmt::format("{} of {} pictures have a place on the map; {} things found",
                         summary.placed, summary.frames, summary.instances),
             "mapped",
             {{"placed", static_cast<std::int64_t>(summary.placed)},
              {"pictures", static_cast<std::int64_t>(summary.frames)},
              {"things", static_cast<std::int64_t>(summary.instances)}}};
  const std::size_t damaged = frames.damage().size() + lost_pictures_->all().size();
  if (damaged > 0) {
    end.text += fmt::format("; {} pictures cannot be read", damaged);
    end.message = "mapped_damaged";
    end.values["damaged"] = static_cast<std::int64_t>(damaged);
  }
  return end;
}

}  // namespace roomwise::live
