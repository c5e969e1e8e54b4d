#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "roomwise/live/device/device.h"
#include "roomwise/live/device/frame_workers.h"
#include "roomwise/live/home/home_meters.h"
#include "roomwise/live/home/jobs.h"
#include "roomwise/live/home/lens_memory.h"
#include "roomwise/live/home/recognition_log.h"
#include "roomwise/live/home/work_places.h"
#include "roomwise/live/recording/room_photos.h"
#include "roomwise/live/recording/uploads.h"
#include "roomwise/live/view/home_view.h"
#include "roomwise/objects/proposals/object_finders.h"
#include "roomwise/pipeline/edits/edit_things.h"
#include "roomwise/pipeline/rooms/room_coverage.h"
#include "roomwise/service/server/server.h"

namespace roomwise::live {

// What became of a file that was handed in.
struct TakenIn {
  std::filesystem::path path;     // of the walk: its folder, or file
  std::optional<JobEnd> refused;  // it is none; why: then there is no path
};

// Where a thing was seen while the home is open.
struct OwnSighting {
  std::int64_t seen_s = 0;  // since 1970
  std::optional<std::string> room;
  std::optional<Eigen::Vector3d> place_plan;
  std::int64_t written_s = 0;  // seen_s of what the home has
};
// Those that the home has not, of things that were written then, or before, last.
[[nodiscard]] std::map<home::OwnThingId, OwnSighting> due_sightings(
    const std::map<home::OwnThingId, OwnSighting>& sightings, std::int64_t before_s);
// Without a room that the home has not any more: who looked may have had an older view of it.
[[nodiscard]] OwnSighting without_gone_room(OwnSighting sighting, const HomeView& now);

struct LiveHomeOptions {
  std::size_t threads = 1;        // for long work: mapping, learning
  std::size_t frame_workers = 1;  // that look at devices' frames
  int augment = 2;                // variants of each picture that rooms are learned from
  std::uint64_t seed = 0;
  home::OpenOptions open = {};  // the passphrase of a protected home
  // What is removed and could be undone is erased when the home is closed; after a kill it waits.
  bool erases_removed = true;
  // For long work, shared by all homes of a process.
  std::shared_ptr<WorkPlaces> work_places = std::make_shared<WorkPlaces>(1);
  // Seconds since 1970.
  std::function<std::int64_t()> clock = [] { return std::int64_t{0}; };
  // A line of each job and of what failed, never of what was asked; on any thread.
  std::function<void(std::string_view)> log = [](std::string_view) {};
};

// A home that is open for live use: devices connect to it, walks are recorded and mapped, rooms
// named and learned, while questions are answered from the newest view of it. Thread-safe.
class LiveHome final : public service::SocketHandler, private DeviceHost {
 public:
  // Opens the home, or makes a new one. What was being mapped when the computer stopped is gone on
  // with, and so is a walk that was recorded and not mapped yet; else the map is made ready in the
  // background. `networks` and `finders` must outlive it.
  [[nodiscard]] static Expected<std::unique_ptr<LiveHome>> open(
      const std::filesystem::path& file, const pipeline::Networks& networks,
      const objects::ObjectFinders& finders, LiveHomeOptions options);
  ~LiveHome() override;  // stops the job in hand; closes the recording
  // What is removed is erased when it is closed, whatever the options say; to be called by whoever
  // closes it next.
  void erase_when_closed() { erases_when_closed_ = true; }
  LiveHome(const LiveHome&) = delete;
  LiveHome& operator=(const LiveHome&) = delete;

  // ---- devices ----
  std::unique_ptr<service::SocketSession> connect(const service::Identity& who,
                                                  std::shared_ptr<service::SocketOut> out) override;
  [[nodiscard]] std::vector<service::DeviceSeen> devices() const;  // connected, by number
  // Also where it is connected by its old name.
  void device_renamed(std::int64_t device, const std::string& name);
  [[nodiscard]] std::uint64_t frames_processed() const { return frames_processed_; }
  [[nodiscard]] std::uint64_t frames_dropped() const;
  [[nodiscard]] const RecognitionLog& recognitions() const { return recognitions_; }

  // What happened since it was opened; how much of the disk is free is looked up.
  void write_metrics(service::MetricsText& text);
  // Whether a job runs or a walk is recorded, which closing it would break off.
  [[nodiscard]] bool is_at_work() const;
  // Tells in the log when the disk gets full; to be called now and then.
  void watch_disk();

  // Why what was learned of phones' lenses is gone, where it is.
  [[nodiscard]] const std::optional<std::string>& why_lenses_are_new() const {
    return lenses_->set_aside();
  }

  // ---- looking ----
  [[nodiscard]] std::shared_ptr<const HomeView> view() const;
  // With the taught things that this device may be told of.
  [[nodiscard]] std::shared_ptr<const HomeView> view_for(
      const service::Identity& who) const override;
  [[nodiscard]] Expected<Bytes> keyframe_picture(home::KeyframeId id) const;
  // What one picture tells, with nothing known from before.
  [[nodiscard]] Expected<rooms::RoomDecision> test_picture(const Bytes& picture) const;

  // What the walks have not shown yet. Looks at pictures that it has not looked at before, which
  // takes a moment; null while the map is not ready, or others wait for it: ask again soon. Fails
  // where a picture is damaged, or something is forgotten meanwhile.
  [[nodiscard]] Expected<std::shared_ptr<const pipeline::RoomCoverage>> coverage();

  // ---- changing; each fails while a job writes the home, forgetting while any is at work, but
  // for the job "prepare", which stops for it. What a device forgets waits for neither: its bytes
  // are erased by a job of their own ("erase") ----
  // `by`: the name of who changes it. Each of these is kept as a row of its own
  // (pipeline/stored/stored_edits.h), which outlives later walks and can be undone.
  [[nodiscard]] Expected<void> name_rooms(home::RecordingId walk,
                                          std::vector<recording::RoomRange> ranges,
                                          const std::string& by = {});
  [[nodiscard]] Expected<void> change_room(const std::string& name,
                                           const std::optional<std::string>& new_name,
                                           const std::optional<std::string>& new_type,
                                           const std::string& by = {});
  // The room, and where it was on the walks. It can be undone until it is erased; then its photos
  // and what was learned of it go, and no byte of it is left.
  [[nodiscard]] Expected<void> forget_room(const std::string& name, const std::string& by = {});
  // By thing_id().
  [[nodiscard]] Expected<void> rename_thing(std::int64_t id, const std::string& name,
                                            const std::string& by = {});
  [[nodiscard]] Expected<void> forget_thing(std::int64_t id, const std::string& by = {});
  // Any other change of things or rooms; returns its number.
  using Edit = std::function<Expected<home::EditId>(home::Home&, const HomeView&,
                                                    const pipeline::EditAuthor&)>;
  [[nodiscard]] Expected<home::EditId> edit(const std::string& by, const Edit& work);
  // Takes a change back.
  [[nodiscard]] Expected<void> undo(home::EditId id);
  // The recording, all that came from it, what was learned, and its folder if it was recorded here.
  // To take it away with a way back: pipeline::take_walk_away() by edit().
  [[nodiscard]] Expected<void> forget_walk(home::RecordingId walk);
  // All that is removed and could be undone until now, and what could not be erased before.
  [[nodiscard]] Expected<void> erase_now();
  // Everything.
  [[nodiscard]] Expected<void> forget_home();

  // ---- long work ----
  [[nodiscard]] Expected<void> learn();
  // Records what the device sends, and maps it as it comes (job "map").
  [[nodiscard]] Expected<void> begin_recording(std::int64_t device, const std::string& name);
  // Ends the recording, and with its last frame the map; where that was stopped, it is gone on
  // with.
  [[nodiscard]] Expected<void> end_recording();
  // With the map of a walk whose mapping was stopped, or that waits (job "map").
  [[nodiscard]] Expected<void> go_on_mapping();
  // Whether there is one; false while a job is at work.
  [[nodiscard]] bool walk_waits();
  [[nodiscard]] Jobs& jobs() { return *jobs_; }

  // ---- photos of rooms, from which they can be learned without a walk ----
  [[nodiscard]] RoomPhotos& photos() { return *photos_; }

  // ---- recordings that are handed in as files ----
  [[nodiscard]] Uploads& uploads() { return *uploads_; }
  // As Uploads::put(); what a full disk refused is counted.
  [[nodiscard]] Expected<Upload> put_upload(const std::string& id, std::uint64_t offset,
                                            std::span<const std::uint8_t> piece);
  // Unpacks a file that is whole, if it is an archive, and maps the recording (job "map"). The file
  // becomes the walk; where it cannot be read, or the disk is full, it waits as it is.
  [[nodiscard]] Expected<void> map_upload(const std::string& id);
  [[nodiscard]] bool is_being_mapped(const std::string& upload) const;
  // Fails while it is being mapped.
  [[nodiscard]] Expected<void> remove_upload(const std::string& id);

 private:
  class Session;
  LiveHome(std::filesystem::path file, home::Home home, home::Home reader,
           const pipeline::Networks& networks, const objects::ObjectFinders& finders,
           LiveHomeOptions options);

  // DeviceHost
  void has_work(const std::shared_ptr<Device>& device) override;
  void saw(const Device& device, const FrameResult& result) override;
  void looked(double seconds, bool well) override { meters_.looked(seconds, well); }
  void answered(service::Question question, double seconds) override {
    meters_.answered(question, seconds);
  }
  void not_recorded(const Error& error) override { meters_.failed("a recording", error); }
  void recorded(const Device& device, const service::RecordingState& state) override;
  [[nodiscard]] mapping::LensCalibration lens_of(const Device& device) const override;
  [[nodiscard]] std::shared_ptr<WalkRecorder> recorder_for(const Device& device) override;
  [[nodiscard]] Expected<void> name_recorded_room(const Device& device,
                                                  const std::string& room) override;
  [[nodiscard]] Expected<void> teach(const std::shared_ptr<Device>& device, const std::string& name,
                                     bool is_private,
                                     std::vector<objects::ShownThing> shown) override;
  [[nodiscard]] Expected<void> change_own_thing(const service::Identity& who,
                                                const std::string& name,
                                                service::Question what) override;
  void erase_forgotten(const service::Identity& who, const std::string& name,
                       service::Question what) override;

  [[nodiscard]] Expected<void> mark_spot(const service::Identity& who, const std::string& name,
                                         const Eigen::Vector3d& place_plan) override;
  [[nodiscard]] Expected<void> change_spot(const service::Identity& who, const std::string& name,
                                           const std::optional<std::string>& new_name) override;
  [[nodiscard]] Expected<std::vector<guide::SeenPerson>> people_in(
      const FrameImages& images,
      const std::optional<geometry::PinholeCamera>& camera) const override {
    return live::people_in(images, camera, finders_.in_pictures);
  }
  void sets_out(const service::Identity& who, const Eigen::Vector3d& place_plan) override;
  [[nodiscard]] std::vector<service::Identity> watchers(const service::Identity& of) const override;
  void shows_walk(const service::WatchedDevice& watched,
                  std::span<const service::Identity> to) override;
  void began_to_watch(Device& helper) override;
  void came_anew(const Device& device) override;
  void shows_less(const Device& device) override;
  // Runs `change` on the home and shows what came of spots, and of nothing else.
  [[nodiscard]] Expected<void> change_spots(
      const std::function<Expected<void>(home::Home&)>& change);
  // What of the view's spots a device may name. With view_mutex_ held.
  [[nodiscard]] std::vector<ViewedSpot> spots_for(const service::Identity& who) const;

  [[nodiscard]] static guide::KnownThing with_sighting(guide::KnownThing thing,
                                                       const OwnSighting& sighting);
  void note_own_things(const FrameResult& result);
  // Into the home those of things that were written then, or before, last; unless a job writes it.
  void write_own_sightings(std::int64_t before_s);
  void store_own_sightings(std::int64_t before_s);
  // Whether it is looked for from now on.
  [[nodiscard]] Expected<bool> teach_now(const home::OwnThing& thing,
                                         const std::vector<objects::ShownThing>& shown,
                                         Progress& progress);
  // Learns what is usual where that is not known, then looks on the newest walk; false where the
  // home does not tell what is usual yet. With home_mutex_ held.
  [[nodiscard]] Expected<bool> look_for_own_things(Progress& progress);
  // That of the view, or a new one where things or key-frames are others. With home_mutex_ held.
  [[nodiscard]] Expected<std::shared_ptr<const pipeline::OwnThingWatch>> own_thing_watch() const;

  // Tells of networks that are not those that the home was made with.
  [[nodiscard]] Expected<void> check_networks();
  [[nodiscard]] std::vector<std::shared_ptr<Device>> all_devices() const;
  void tell_helpers(const service::HomeMessage& message) const;
  // Helpers and the device whose frames are recorded.
  void tell_of_recording(std::int64_t device, const service::RecordingState& state);
  // To a device that came, also that nothing is: the end may have been told while it was away.
  void tell_what_is_recorded(Device& device);
  // With devices_mutex_ held.
  [[nodiscard]] bool is_camera_of_recording(
      const std::optional<service::DeviceCamera>& camera) const;
  void left(const std::shared_ptr<Device>& device);
  [[nodiscard]] Expected<void> check_idle() const;
  // Counts and tells what failed because of a full disk or damage. Else people were told all there
  // is to say: that the home is busy, or that there is no such room.
  template <typename T>
  [[nodiscard]] Expected<T> watched(const char* what, Expected<T> outcome) const {
    if (!outcome && (outcome.error().code == ErrorCode::kDiskFull ||
                     outcome.error().code == ErrorCode::kDamaged)) {
      meters_.failed(what, outcome.error());
    }
    return outcome;
  }
  // What erasing is owed before a change is done with it, or later: that takes seconds.
  enum class Owed { kErasedNow, kErasedLater };
  // Runs `change` on the home and shows what came of it.
  [[nodiscard]] Expected<void> change(const std::function<Expected<void>(home::Home&)>& change,
                                      Owed owed = Owed::kErasedNow);
  // So that no byte of what was removed is left in the file.
  [[nodiscard]] Expected<void> erase_removed(home::Home& home);
  // The same where it is owed; what fails again is told in the log, and stays owed.
  void make_up_for_erasing(home::Home& home);
  // The same, as a job.
  [[nodiscard]] Expected<JobEnd> erase_owed(const Interruption& interruption);
  // Makes the view anew. With home_mutex_ held.
  [[nodiscard]] Expected<void> refresh(std::shared_ptr<const LiveMap> map);
  // Whether the map is ready, with what helpers look at, or there is none.
  [[nodiscard]] bool is_prepared() const;
  // Whether the map was being made ready. It can wait; whoever stops it has it gone on with.
  [[nodiscard]] bool stop_preparing();
  // Where it is not ready: once nothing else is done.
  [[nodiscard]] Expected<void> go_on_preparing();
  // Runs what begins other work; where it fails, the map is made ready as before.
  [[nodiscard]] Expected<void> instead_of_preparing(const std::function<Expected<void>()>& start);
  // Runs `forget` while no job is at work; then the map of what is left is made ready.
  [[nodiscard]] Expected<void> while_idle(const std::function<Expected<void>()>& forget);
  [[nodiscard]] Expected<void> erase_walk(home::RecordingId walk);
  [[nodiscard]] pipeline::EditAuthor author(const std::string& name) const;
  // What is still to be erased when the home is opened: what a kill left of erase_walk(), and what
  // was forgotten and not erased. What can be undone waits on.
  void erase_what_waits();
  // RoomPhotos::settle(); where that fails, it is told in the log. With home_mutex_ held.
  void settle_photos();
  // What could be undone until now. With home_mutex_ held.
  [[nodiscard]] Expected<void> forget_removed();
  // All that waits to be mapped, one walk after the other; one that cannot be keeps back no other.
  [[nodiscard]] Expected<void> start_mapping_what_waits();
  [[nodiscard]] Expected<JobEnd> map_folder(const std::filesystem::path& folder,
                                            Progress& progress);
  // While it is recorded, to its end.
  [[nodiscard]] Expected<void> start_mapping(std::shared_ptr<const WalkRecorder> walk);
  // `walk`: the frames in the folder; `felt`: by the device's inertial sensor, if anything. A walk
  // that was left unfinished is finished first.
  [[nodiscard]] Expected<JobEnd> map(const std::filesystem::path& folder,
                                     recording::FrameSource& walk,
                                     const geometry::InertialTrack& felt, Progress& progress);
  [[nodiscard]] Expected<JobEnd> prepare(Progress& progress);
  // What a job came to that was not stopped, once the map is ready again: what is mapped already
  // answers all the same.
  [[nodiscard]] Expected<JobEnd> with_map_ready(Expected<JobEnd> ended, Progress& progress);
  // Its two parts: what answers need, and what helpers look at.
  [[nodiscard]] Expected<std::shared_ptr<const LiveMap>> make_map_ready(Progress& progress);
  [[nodiscard]] Expected<JobEnd> fuse_clouds(const LiveMap& ready, Progress& progress);
  // What begins when there is a place for it, and makes the map ready.
  [[nodiscard]] Jobs::Body with_place(Jobs::Body body, WorkPlaces::Urgency urgency);
  // A job of that.
  [[nodiscard]] Expected<void> start_work(
      const std::string& kind, Jobs::Body body,
      WorkPlaces::Urgency urgency = WorkPlaces::Urgency::kCanWait);
  // From now on each picture of the map that cannot be read again is logged once more.
  void begin_lost_pictures();
  [[nodiscard]] Expected<JobEnd> learn_now(Progress& progress);
  [[nodiscard]] std::filesystem::path walks_folder() const;
  // Pictures of a home: only its owner can look into it.
  [[nodiscard]] Expected<void> make_walks_folder() const;
  [[nodiscard]] std::filesystem::path lenses_file() const;
  [[nodiscard]] std::filesystem::path uploads_folder() const;
  [[nodiscard]] std::filesystem::path photos_folder() const;
  [[nodiscard]] std::filesystem::path unpacking_folder() const;
  // After a kill: what became a walk of the home waits no more as a file.
  [[nodiscard]] Expected<void> go_on_with_uploads();
  // Makes a walk's folder, or file, of what was handed in.
  [[nodiscard]] Expected<TakenIn> take_in(const Upload& upload, Progress& progress);
  [[nodiscard]] Expected<TakenIn> take_in(const Upload& upload,
                                          const std::filesystem::path& unpacked,
                                          Progress& progress);
  [[nodiscard]] Expected<std::filesystem::path> unused_path(const std::string& stem,
                                                            const std::string& ending);
  // The folder of the walk whose map is not finished, if there is one; the folder of a recording of
  // this home.
  [[nodiscard]] Expected<std::optional<std::filesystem::path>> unfinished_walk();
  [[nodiscard]] Expected<bool> has_recording_of(const std::filesystem::path& folder);
  // The unfinished one, before which no other can be mapped, then those that were recorded and are
  // not in the home yet, the newest first. But for those in `failed`.
  [[nodiscard]] Expected<std::vector<std::filesystem::path>> waiting_walks(
      const std::set<std::filesystem::path>& failed = {});

  const std::filesystem::path file_;
  const pipeline::Networks& networks_;
  const objects::ObjectFinders& finders_;
  const LiveHomeOptions options_;
  bool erases_when_closed_;

  std::mutex changes_mutex_;  // helpers' changes wait for each other, and not for jobs
  std::mutex home_mutex_;     // of home_; a job holds it as long as it writes
  home::Home home_;
  mutable std::mutex reader_mutex_;
  home::Home reader_;  // for pictures

  // Of coverage(): erasing waits until nothing is read, and has it stop.
  std::mutex coverage_mutex_;
  std::atomic<bool> coverage_stops_{false};
  std::shared_ptr<const HomeView> covered_;  // what coverage_ is of
  std::shared_ptr<const pipeline::RoomCoverage> coverage_;
  pipeline::PictureTones tones_;

  mutable std::mutex view_mutex_;
  std::shared_ptr<const HomeView> view_;
  mutable std::map<std::int64_t, std::shared_ptr<const HomeView>> views_of_devices_;  // of view_
  std::map<home::OwnThingId, OwnSighting> own_sightings_;
  std::map<std::int64_t, home::EditPlace> set_out_;  // by device: from where it was led somewhere

  mutable std::mutex devices_mutex_;
  std::set<std::shared_ptr<Device>> devices_;
  std::shared_ptr<WalkRecorder> recorder_;
  std::shared_ptr<const WalkRecorder> growing_;          // what a job maps while it is recorded
  std::vector<std::shared_ptr<WalkRecorder>> unclosed_;  // closing failed: tried again at the end
  std::int64_t recording_device_ = 0;
  std::mutex telling_mutex_;  // what is told of the recording, its end last

  mutable HomeMeters meters_;  // counts also what only looks at the home
  RecognitionLog recognitions_;
  std::unique_ptr<LensMemory> lenses_;
  std::unique_ptr<Uploads> uploads_;
  mutable std::mutex upload_mutex_;
  std::string upload_in_hand_;  // of the job that maps it
  std::unique_ptr<RoomPhotos> photos_;
  std::atomic<std::uint64_t> frames_processed_{0};
  std::atomic<std::uint64_t> dropped_by_gone_{0};          // by devices that are not here any more
  std::shared_ptr<pipeline::LostPictures> lost_pictures_;  // jobs alone

  // Last, so that their threads end first.
  std::unique_ptr<FrameWorkers> looking_;
  std::unique_ptr<Jobs> jobs_;
};

}  // namespace roomwise::live
