#include "roomwise/live/home/live_home.h"

#include <algorithm>
#include <limits>
#include <map>
#include <ranges>

#include "roomwise/base/file.h"
#include "roomwise/image/codec.h"
#include "roomwise/pipeline/edits/walk_edits.h"
#include "roomwise/pipeline/objects/changed_networks.h"
#include "roomwise/pipeline/objects/thing_history.h"
#include "roomwise/pipeline/rooms/room_learning.h"
#include "roomwise/recording/data_lines.h"
#include "roomwise/recording/open_recording.h"

namespace roomwise::live {

namespace fs = std::filesystem;

namespace {

// When it was written last.
fs::file_time_type time_of_walk(const fs::path& walk) {
  std::error_code error;
  const fs::path list = walk / "rgb.txt";  // of a recording that grew
  return fs::last_write_time(fs::exists(list, error) ? list : walk, error);
}

// A recording that was begun, and to which nothing was stored.
bool holds_no_frame(const fs::path& walk) {
  const auto list = read_text_file(walk / "rgb.txt");
  return list && recording::data_lines(*list).empty();
}

}  // namespace

// A connection's way to its device.
class LiveHome::Session final : public service::SocketSession {
 public:
  Session(LiveHome& home, std::shared_ptr<Device> device)
      : home_(home), device_(std::move(device)) {}

  void on_text(std::string_view text) override {
    const bool was_here = device_->is_here();
    device_->on_text(text);
    if (was_here || !device_->is_here()) return;
    home_.tell_helpers(device_->seen());
    home_.tell_what_is_recorded(*device_);
  }
  void on_message(Bytes bytes) override { device_->on_message(std::move(bytes)); }
  void on_closed() override {
    device_->on_closed();
    home_.left(device_);
  }
  [[nodiscard]] bool greeted() const override { return device_->is_here(); }

 private:
  LiveHome& home_;
  std::shared_ptr<Device> device_;
};

LiveHome::LiveHome(fs::path file, home::Home home, home::Home reader,
                   const pipeline::Networks& networks, const objects::ObjectFinders& finders,
                   LiveHomeOptions options)
    : file_(std::move(file)),
      networks_(networks),
      finders_(finders),
      options_(std::move(options)),
      erases_when_closed_(options_.erases_removed),
      home_(std::move(home)),
      reader_(std::move(reader)),
      meters_(options_.log) {}

LiveHome::~LiveHome() {
  jobs_.reset();
  looking_.reset();
  write_own_sightings(std::numeric_limits<std::int64_t>::max());
  if (lenses_) (void)lenses_->save();  // what is lost is learned anew
  if (recorder_) (void)recorder_->close();
  for (const auto& recorder : unclosed_) (void)recorder->close();
  if (photos_ && erases_when_closed_) {
    const std::scoped_lock lock(home_mutex_);
    (void)forget_removed();  // where it fails, it waits as before, or is owed
  }
}

Expected<std::unique_ptr<LiveHome>> LiveHome::open(const fs::path& file,
                                                   const pipeline::Networks& networks,
                                                   const objects::ObjectFinders& finders,
                                                   LiveHomeOptions options) {
  ROOMWISE_TRY(home::Home home, fs::exists(file) ? home::Home::open(file, options.open)
                                                 : pipeline::create_home(file, options.open));
  // Without its passphrase a protected home would serve no picture, map nothing and find no place.
  if (home.is_locked()) return Unexpected(home.locked_error());
  ROOMWISE_TRY(home::Home reader, home::Home::open_read_only(file, options.open));
  std::unique_ptr<LiveHome> live(new LiveHome(file, std::move(home), std::move(reader), networks,
                                              finders, std::move(options)));
  ROOMWISE_TRY(live->lenses_, LensMemory::open(live->lenses_file()));
  ROOMWISE_TRY(Uploads uploads, Uploads::open(live->uploads_folder(), {}));
  live->uploads_ = std::make_unique<Uploads>(std::move(uploads));
  live->photos_ = std::make_unique<RoomPhotos>(live->photos_folder());
  // Who only waits for another program to read the home need not do without it meanwhile.
  {
    const std::scoped_lock lock(live->home_mutex_);
    live->erase_what_waits();
    ROOMWISE_RETURN_IF_ERROR(live->refresh(nullptr));
  }
  if (const auto done = live->go_on_with_uploads(); !done) {
    live->options_.log(fmt::format("files that were handed in: {}", done.error().message));
  }
  ROOMWISE_RETURN_IF_ERROR(live->check_networks());
  live->jobs_ = std::make_unique<Jobs>(
      [raw = live.get()](const service::JobState& state) { raw->tell_helpers(state); },
      [raw = live.get()](const JobNews& news) { raw->meters_.on_job(news); });
  live->looking_ = std::make_unique<FrameWorkers>(
      live->options_.frame_workers, [raw = live.get()](const Error& fault) {
        raw->meters_.failed("looking at what a device sent", fault);
      });

  ROOMWISE_TRY(const auto waiting, live->waiting_walks());
  ROOMWISE_RETURN_IF_ERROR(waiting.empty() ? live->go_on_preparing()
                                           : live->start_mapping_what_waits());
  return live;
}

Expected<void> LiveHome::check_networks() {
  ROOMWISE_TRY(const auto changed,
               pipeline::changed_networks(home_, networks_, finders_.in_pictures));
  for (const auto& one : changed) options_.log(pipeline::in_words(one, home_.file()));
  meters_.networks_changed(changed.size());
  return {};
}

// ---- devices ----

std::unique_ptr<service::SocketSession> LiveHome::connect(const service::Identity& who,
                                                          std::shared_ptr<service::SocketOut> out) {
  auto device = std::make_shared<Device>(who, std::move(out), static_cast<DeviceHost&>(*this));
  {
    const std::scoped_lock lock(devices_mutex_);
    devices_.insert(device);
  }
  if (const auto job = jobs_->state(); job && who.role == service::Role::kHelper) {
    device->send(*job);
  }
  return std::make_unique<Session>(*this, device);
}

void LiveHome::left(const std::shared_ptr<Device>& device) {
  {
    const std::scoped_lock lock(devices_mutex_);
    devices_.erase(device);
  }
  dropped_by_gone_ += device->dropped();
  (void)lenses_->save();  // a full disk is told by what must not be lost
  // It may have come back before the old connection was found to be dead.
  const auto others = all_devices();
  const auto again = std::ranges::find_if(others, [&](const auto& one) {
    return one->who().device == device->who().device && one->is_here();
  });
  tell_helpers(again != others.end() ? (*again)->seen() : device->seen());
}

std::vector<std::shared_ptr<Device>> LiveHome::all_devices() const {
  const std::scoped_lock lock(devices_mutex_);
  return {devices_.begin(), devices_.end()};
}

void LiveHome::device_renamed(std::int64_t device, const std::string& name) {
  for (const auto& one : all_devices()) {
    if (one->who().device != device) continue;
    one->rename(name);
    if (one->is_here()) tell_helpers(one->seen());
  }
}

std::vector<service::DeviceSeen> LiveHome::devices() const {
  std::vector<service::DeviceSeen> seen;
  for (const auto& device : all_devices()) {
    if (device->is_here()) seen.push_back(device->seen());
  }
  std::ranges::sort(seen, {}, &service::DeviceSeen::device);
  return seen;
}

std::uint64_t LiveHome::frames_dropped() const {
  std::uint64_t dropped = dropped_by_gone_;
  for (const auto& device : all_devices()) dropped += device->dropped();
  return dropped;
}

void LiveHome::tell_helpers(const service::HomeMessage& message) const {
  for (const auto& device : all_devices()) {
    if (device->who().role == service::Role::kHelper && device->is_here()) device->send(message);
  }
}

void LiveHome::has_work(const std::shared_ptr<Device>& device) {
  looking_->add(device);
}

void LiveHome::saw(const Device& device, const FrameResult& result) {
  ++frames_processed_;
  note_own_things(result);
  if (result.lens) lenses_->learn(device.who().device, device.camera()->lens, *result.lens);
  const service::DeviceSeen seen = device.seen();
  if (seen.seen && result.decision) {
    const std::int64_t now_s = options_.clock();
    const std::scoped_lock lock(view_mutex_);
    // None of a room that was forgotten while it was looked at.
    const bool is_there =
        seen.seen->room.empty() ||
        std::ranges::find(view_->rooms, seen.seen->room, &rooms::Room::name) != view_->rooms.end();
    if (is_there) recognitions_.add(device.who(), now_s, *seen.seen, result.picture);
  }
  tell_helpers(seen);
}

mapping::LensCalibration LiveHome::lens_of(const Device& device) const {
  const auto camera = device.camera();
  return lenses_->recall(device.who().device, camera ? camera->lens : "");
}

void LiveHome::recorded(const Device& device, const service::RecordingState& state) {
  const std::scoped_lock one_by_one(telling_mutex_);
  {
    const std::scoped_lock lock(devices_mutex_);
    // Of a frame that was in hand when the recording ended nothing is told after the end.
    if (!recorder_ || recorder_->name() != state.name) return;
  }
  tell_of_recording(device.who().device, state);
}

void LiveHome::tell_of_recording(std::int64_t device, const service::RecordingState& state) {
  for (const auto& one : all_devices()) {
    const bool wants_it = one->who().role == service::Role::kHelper || one->who().device == device;
    if (wants_it && one->is_here()) one->send(state);
  }
}

void LiveHome::tell_what_is_recorded(Device& device) {
  const service::Identity who = device.who();
  const auto camera = device.camera();
  service::RecordingState state;
  {
    // Under the lock, so that the recording's end is told after this.
    const std::scoped_lock lock(devices_mutex_);
    const bool is_own = recorder_ && recording_device_ == who.device;
    if (!is_own) device.send(service::RecordingState{who.device, "none", "", 0, ""});
    if (!is_own && (!recorder_ || who.role != service::Role::kHelper)) return;
    state = {recording_device_, "recording", recorder_->name(), recorder_->frames(), ""};
    // Without a camera it is a page of the device that looks on.
    if (!is_own || !camera || is_camera_of_recording(camera)) return device.send(state);
  }
  state.state = "failed";
  state.text =
      "the device came back with another camera than the recording began with, and is not "
      "recorded; end the recording and begin another";
  recorded(device, state);
}

bool LiveHome::is_camera_of_recording(const std::optional<service::DeviceCamera>& camera) const {
  return recorder_ && camera && camera->calibrated == recorder_->camera();
}

std::shared_ptr<WalkRecorder> LiveHome::recorder_for(const Device& device) {
  const auto camera = device.camera();
  std::shared_ptr<WalkRecorder> recorder;
  {
    const std::scoped_lock lock(devices_mutex_);
    // Another camera's frames would make a wrong map.
    const bool is_own = device.who().device == recording_device_;
    if (!is_own || !is_camera_of_recording(camera)) return nullptr;
    recorder = recorder_;
  }
  // What is still on its way by an older connection is of another clock.
  for (const auto& one : all_devices()) {
    if (one.get() != &device && one->who().device == device.who().device) one->record_to(nullptr);
  }
  return recorder;
}

Expected<void> LiveHome::name_recorded_room(const Device& device, const std::string& room) {
  const service::Identity& who = device.who();
  const std::scoped_lock lock(devices_mutex_);
  const bool may = who.role == service::Role::kHelper || who.device == recording_device_;
  if (recorder_ && may) return recorder_->name_room(room);
  if (recorder_) return fail("another device's walk is recorded; that one names its rooms");
  return fail("rooms are named while a walk is recorded, or on the helper's page");
}

bool LiveHome::is_at_work() const {
  {
    const std::scoped_lock lock(devices_mutex_);
    if (recorder_) return true;
  }
  return jobs_->running();
}

// ---- helpers who watch ----

std::vector<service::Identity> LiveHome::watchers(const service::Identity& of) const {
  std::vector<service::Identity> watchers;
  for (const auto& one : all_devices()) {
    if (one->watches() && one->who().device != of.device) watchers.push_back(one->who());
  }
  return watchers;
}

void LiveHome::shows_walk(const service::WatchedDevice& watched,
                          std::span<const service::Identity> to) {
  for (const auto& one : all_devices()) {
    const bool is_meant =
        std::ranges::find(to, one->who().device, &service::Identity::device) != to.end();
    if (is_meant && one->watches()) one->send(watched);
  }
}

void LiveHome::came_anew(const Device& device) {
  for (const auto& one : all_devices()) {
    if (one.get() != &device && one->who().device == device.who().device) one->let_nobody_watch();
  }
}

void LiveHome::shows_less(const Device& device) {
  const service::DeviceSeen seen = device.seen();
  if (seen.seen) tell_helpers(seen);
}

void LiveHome::began_to_watch(Device& helper) {
  for (const auto& one : all_devices()) one->show_walk_to(helper);
}

// ---- what happened ----

void LiveHome::watch_disk() {
  std::error_code error;
  const fs::space_info space = fs::space(fs::absolute(file_).parent_path(), error);
  if (!error) meters_.disk(space.available);
}

void LiveHome::write_metrics(service::MetricsText& text) {
  watch_disk();
  text.single("frames_looked_at_total", "counter", "Frames that were looked at.",
              frames_processed());
  text.single("frames_dropped_total", "counter", "Frames that a newer one took the place of.",
              frames_dropped());
  meters_.write(text);
}

// ---- looking ----

std::shared_ptr<const HomeView> LiveHome::view() const {
  const std::scoped_lock lock(view_mutex_);
  return view_;
}

Expected<Bytes> LiveHome::keyframe_picture(home::KeyframeId id) const {
  const auto now = view();
  const auto keyframe = std::ranges::find(
      now->keyframes, id, [](const ViewedKeyframe& one) { return one.keyframe.id; });
  if (keyframe != now->keyframes.end() &&
      now->walks_taken_away().contains(keyframe->keyframe.recording)) {
    return fail("the walk of this picture is taken away");
  }
  const std::scoped_lock lock(reader_mutex_);
  ROOMWISE_TRY(home::KeyframeImages images, watched("a picture", reader_.images(id)));
  return std::move(images.color);
}

Expected<rooms::RoomDecision> LiveHome::test_picture(const Bytes& picture) const {
  const auto now = view();
  if (!now->recognizer) return fail("{}", now->why_no_recognizer);
  constexpr std::int64_t kMaxPixels = 24'000'000;  // of a phone's photo
  ROOMWISE_TRY(const image::ColorImage color, image::decode_color(picture, kMaxPixels));
  return now->recognizer->recognize({&color, 1});
}

// ---- the view ----

Expected<void> LiveHome::refresh(std::shared_ptr<const LiveMap> map) {
  ROOMWISE_RETURN_IF_ERROR(
      pipeline::keep_home_history(home_));  // else each view would follow things anew
  ROOMWISE_TRY(auto watch, own_thing_watch());
  ROOMWISE_TRY(auto view, view_home(home_, networks_, std::move(map), std::move(watch)));
  {
    const std::scoped_lock lock(view_mutex_);
    views_of_devices_.clear();
    if (!view->map) set_out_.clear();  // key-frames of a map that is made anew have other numbers
    view_ = std::move(view);
  }
  for (const auto& device : all_devices()) device->home_changed();
  return {};
}

Expected<void> LiveHome::change(const std::function<Expected<void>(home::Home&)>& change,
                                Owed owed) {
  const std::scoped_lock one_by_one(changes_mutex_);
  const std::unique_lock lock(home_mutex_, std::try_to_lock);
  if (!lock.owns_lock()) return fail("the computer is busy; wait until it is done, or stop it");
  store_own_sightings(std::numeric_limits<std::int64_t>::max());  // rooms may be called otherwise
  const Expected<void> changed = watched("a change", change(home_));
  settle_photos();
  ROOMWISE_RETURN_IF_ERROR(changed);
  if (owed == Owed::kErasedNow) make_up_for_erasing(home_);
  return refresh(view()->map);
}

Expected<std::optional<fs::path>> LiveHome::unfinished_walk() {
  const std::scoped_lock lock(home_mutex_);
  ROOMWISE_TRY(const auto recordings, home_.recordings());
  if (recordings.empty() || recordings.back().finished) return std::nullopt;
  return pipeline::folder_of_walk(home_, recordings.back());
}

Expected<bool> LiveHome::has_recording_of(const fs::path& folder) {
  const std::scoped_lock lock(home_mutex_);
  ROOMWISE_TRY(const auto recordings, home_.recordings());
  return std::ranges::any_of(recordings, [&](const home::StoredRecording& one) {
    return pipeline::folder_of_walk(home_, one) == folder;
  });
}

Expected<std::vector<fs::path>> LiveHome::waiting_walks(const std::set<fs::path>& failed) {
  ROOMWISE_TRY(const auto unfinished, unfinished_walk());
  if (unfinished && failed.contains(*unfinished)) return std::vector<fs::path>();
  std::error_code error;
  std::multimap<fs::file_time_type, fs::path, std::greater<>> by_time;
  for (const auto& entry : fs::directory_iterator(walks_folder(), error)) {
    const bool is_being_made = entry.path().filename().string().starts_with('.');
    if (is_being_made || failed.contains(entry.path())) continue;
    if (recording::find_recording_kind(entry.path()) == nullptr) continue;
    ROOMWISE_TRY(const bool is_mapped, has_recording_of(entry.path()));
    if (!is_mapped && !holds_no_frame(entry.path()))
      by_time.emplace(time_of_walk(entry.path()), entry.path());
  }
  std::vector<fs::path> waiting;
  if (unfinished) waiting.push_back(*unfinished);
  std::ranges::copy(by_time | std::views::values, std::back_inserter(waiting));
  return waiting;
}

bool LiveHome::walk_waits() {
  if (jobs_->running()) return false;
  // Who only looks does not wait for what is under way.
  if (!std::unique_lock(home_mutex_, std::try_to_lock)) return false;
  const auto waiting = waiting_walks();
  return waiting && !waiting->empty();
}

Expected<void> LiveHome::check_idle() const {
  {
    const std::scoped_lock lock(devices_mutex_);
    if (recorder_) return fail("'{}' is being recorded; stop it first", recorder_->name());
  }
  if (!jobs_->running()) return {};
  return fail("the computer is busy ({}); wait until it is done, or stop it", jobs_->state()->kind);
}

fs::path LiveHome::walks_folder() const {
  return pipeline::own_walks_folder(file_);
}

Expected<void> LiveHome::make_walks_folder() const {
  std::error_code error;
  fs::create_directories(walks_folder(), error);
  if (!error) fs::permissions(walks_folder(), fs::perms::owner_all, error);
  if (error) return fail("{}: cannot be made: {}", walks_folder().string(), error.message());
  return {};
}

fs::path LiveHome::photos_folder() const {
  return fs::path(file_.string() + ".photos");
}

fs::path LiveHome::lenses_file() const {
  return fs::path(file_.string() + ".lenses.json");
}

}  // namespace roomwise::live
