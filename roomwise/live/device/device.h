#pragma once

#include <atomic>
#include <chrono>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "roomwise/guide/answers/spot_prompts.h"
#include "roomwise/guide/words/prompt_queue.h"
#include "roomwise/live/device/answers.h"
#include "roomwise/live/device/frame_processor.h"
#include "roomwise/live/device/led_walk.h"
#include "roomwise/live/device/people.h"
#include "roomwise/live/device/teaching.h"
#include "roomwise/live/device/walk_watch.h"
#include "roomwise/live/recording/walk_recorder.h"
#include "roomwise/service/credentials/identity.h"
#include "roomwise/service/server/server.h"

namespace roomwise::live {

class Device;

// What a connected device needs of the home.
class DeviceHost {
 public:
  virtual ~DeviceHost() = default;
  // With what this device may be told of.
  [[nodiscard]] virtual std::shared_ptr<const HomeView> view_for(
      const service::Identity& who) const = 0;
  // A frame waits: Device::work() is to be called soon, on another thread.
  virtual void has_work(const std::shared_ptr<Device>& device) = 0;
  virtual void saw(const Device& device, const FrameResult& result) = 0;
  // A frame was looked at, well or not, which took so long.
  virtual void looked(double seconds, bool well) = 0;
  // A question was answered so long after it had come.
  virtual void answered(service::Question question, double seconds) = 0;
  // A frame that was to be recorded could not be: told once, until one can again.
  virtual void not_recorded(const Error& error) = 0;
  virtual void recorded(const Device& device, const service::RecordingState& state) = 0;
  // What is known of the device's lens, where its camera is not calibrated.
  [[nodiscard]] virtual mapping::LensCalibration lens_of(const Device& device) const = 0;
  // What this device's frames are stored by; null: they are not.
  [[nodiscard]] virtual std::shared_ptr<WalkRecorder> recorder_for(const Device& device) = 0;
  // What is recorded from now on shows this room. A helper says so of any device's walk, a device
  // of its own.
  [[nodiscard]] virtual Expected<void> name_recorded_room(const Device& device,
                                                          const std::string& room) = 0;
  // Learns a thing that this device showed; says what came of it by Device::was_taught(). Fails at
  // once where the name will not do or the computer is busy (ErrorCode::kRefused: the name).
  [[nodiscard]] virtual Expected<void> teach(const std::shared_ptr<Device>& device,
                                             const std::string& name, bool is_private,
                                             std::vector<objects::ShownThing> shown) = 0;
  // kForgetThing, kShareThing or kKeepThing. Fails where the device did not teach it
  // (ErrorCode::kRefused) or the computer is busy.
  [[nodiscard]] virtual Expected<void> change_own_thing(const service::Identity& who,
                                                        const std::string& name,
                                                        service::Question what) = 0;
  // Marks a place of the map as this device's. `name` may be empty. Fails where the name means
  // something else (ErrorCode::kRefused) or the computer is busy.
  [[nodiscard]] virtual Expected<void> mark_spot(const service::Identity& who,
                                                 const std::string& name,
                                                 const Eigen::Vector3d& place_plan) = 0;
  // Forgets one of the device's, or where `new_name` is given renames it; a helper may also change
  // the computer's. Fails where it has none of that name or the new one will not do
  // (ErrorCode::kRefused), or the computer is busy.
  [[nodiscard]] virtual Expected<void> change_spot(const service::Identity& who,
                                                   const std::string& name,
                                                   const std::optional<std::string>& new_name) = 0;
  // Erases what a device forgot (`what`: kForgetThing or kForgetSpot) some time after this has
  // returned; where that fails, the device hears it by Device::was_not_erased().
  virtual void erase_forgotten(const service::Identity& who, const std::string& name,
                               service::Question what) = 0;
  // The people in a picture of this device's; fails where nothing at hand knows people.
  [[nodiscard]] virtual Expected<std::vector<guide::SeenPerson>> people_in(
      const FrameImages& images, const std::optional<geometry::PinholeCamera>& camera) const = 0;
  // From there it is led somewhere: known until the computer closes the home, and never stored.
  virtual void sets_out(const service::Identity& who, const Eigen::Vector3d& place_plan) = 0;
  // Helpers who watch how others are led. This and the next are called while a device is locked:
  // they lock no device.
  [[nodiscard]] virtual std::vector<service::Identity> watchers(
      const service::Identity& of) const = 0;
  // To these, as far as they still watch.
  virtual void shows_walk(const service::WatchedDevice& watched,
                          std::span<const service::Identity> to) = 0;
  virtual void began_to_watch(Device& helper) = 0;
  // It came anew: what an older connection of it let helpers watch is over.
  virtual void came_anew(const Device& device) = 0;
  // Its person lets helpers see less than before.
  virtual void shows_less(const Device& device) = 0;
};

// A client that is connected: takes its frames and questions, answers them by what its newest frame
// told. Thread-safe; work() runs on one thread at a time.
class Device : public std::enable_shared_from_this<Device> {
 public:
  Device(service::Identity who, std::shared_ptr<service::SocketOut> out, DeviceHost& host)
      : who_(std::move(who)), out_(std::move(out)), host_(host) {}

  // ---- from the connection ----
  void on_text(std::string_view text);
  void on_message(Bytes bytes);
  void on_closed();

  // ---- from the home ----
  // Looks at the newest frame, if one waits, and answers what was asked; also what waits without a
  // new one. True where another frame
  // came meanwhile: to be called again.
  bool work();
  // Tells of rooms or things that changed.
  void home_changed();
  void send(const service::HomeMessage& message);
  // Whether what it taught is looked for, or why it is not known.
  void was_taught(const std::string& name, const Expected<bool>& taught);
  // It is known no more, and its bytes are still there: they are erased later.
  void was_not_erased(const std::string& name, service::Question what, const Error& why);
  // To a helper who begins to watch: what its person lets helpers see, who is told first.
  void show_walk_to(Device& helper);
  // The device came by another connection, whose answer counts.
  void let_nobody_watch();
  // The frames are stored from now on; null: no longer.
  void record_to(std::shared_ptr<WalkRecorder> recorder);

  [[nodiscard]] service::Identity who() const;
  // Helpers who watch are told.
  void rename(const std::string& name);
  [[nodiscard]] bool is_here() const;  // said hello, and is connected
  [[nodiscard]] bool watches() const { return watches_; }
  [[nodiscard]] std::optional<service::DeviceCamera> camera() const;
  // Where it is only where its person lets helpers see that.
  [[nodiscard]] service::DeviceSeen seen() const;
  [[nodiscard]] std::uint64_t dropped() const;

 private:
  void greet(const service::Hello& hello);
  void take(const service::DeviceMessage& message);
  using Clock = std::chrono::steady_clock;
  // What was asked, and when that came.
  struct Asked {
    service::Ask ask;
    Clock::time_point came = Clock::now();
  };
  void hear(const Asked& asked);
  void hear_now(const Asked& asked);
  void hear_of_own_things(const service::Ask& ask);
  void hear_of_spots(const service::Ask& ask);
  void mark_spot(const service::Ask& ask);
  // What there is to say of it.
  [[nodiscard]] guide::Prompt mark(const service::Ask& ask);
  void answer_by_picture(const service::Ask& ask);
  void say_spot(guide::SpotStep step, const std::string& name, const service::Ask& ask,
                const std::string& because = {});
  void begin_teaching(const service::Ask& ask);
  void name_taught(const service::Ask& ask);
  void say_step(guide::TeachingStep step, const std::string& name, double t_ms,
                std::optional<std::int64_t> answer_to, const std::string& because = {});
  [[nodiscard]] guide::Wording wording_now() const;
  [[nodiscard]] guide::UserLocation location_now(double t_ms) const;
  [[nodiscard]] std::shared_ptr<Teaching> teaching() const;
  [[nodiscard]] Expected<void> teach(const CameraFrame& frame, Teaching& teaching);
  // A question in one's own words.
  void understand(const Asked& in_words);
  [[nodiscard]] Expected<FrameResult> look(CameraFrame frame);
  // With mutex_ held.
  [[nodiscard]] std::vector<guide::Prompt> answer_now(const service::Ask& ask,
                                                      const std::shared_ptr<const HomeView>& home,
                                                      const Situation& now);
  // With mutex_ held: begins to lead; nothing where the home has no such goal.
  [[nodiscard]] std::vector<guide::Prompt> lead_to(const service::Ask& goal,
                                                   const std::shared_ptr<const HomeView>& home,
                                                   const Situation& now, bool is_way_back);
  // With mutex_ held: a picture came since the device did.
  [[nodiscard]] bool had_pictures() const { return last_result_ || newest_ || looking_; }
  [[nodiscard]] bool is_led() const { return led_ && !led_->is_over(); }
  void answer_waiting(bool more_frames_wait);
  void say(const std::vector<guide::Prompt>& prompts, std::optional<std::int64_t> answer_to,
           std::optional<double> based_on_t_ms);
  // `came`: when the picture did.
  void call_out(const FrameResult& result, Clock::time_point came);
  void let_watch(bool may_watch);
  void say_whether_watched(bool may_watch);
  // To helpers who watch, if there is something new. The person is told of them first.
  void show_walk(bool in_any_case, bool with_end = true);
  // With mutex_ held. A walk that is over is for those who watched it alone.
  [[nodiscard]] service::WatchedDevice watched(bool with_end) const;
  // With mutex_ held.
  void tell_of(std::span<const service::Identity> watchers);
  void heard_at(double t_ms);
  [[nodiscard]] double now_t_ms() const;  // by the device's clock
  // Tells what is wrong, with a question or with the frame of that time.
  void refuse(const Error& error, std::optional<std::int64_t> answer_to = {},
              std::optional<double> frame_t_ms = {});
  // The same of a message that could not be read: many of these close the connection.
  void refuse_unread(const Error& error, std::optional<std::int64_t> answer_to = {},
                     std::optional<double> frame_t_ms = {});
  void has_read();  // a message
  void store(const CameraFrame& frame);
  [[nodiscard]] service::Welcome welcome() const;

  const service::Identity who_;    // as it connected
  mutable std::mutex name_mutex_;  // no other is taken while it is held
  std::string name_ = who_.name;
  const std::shared_ptr<service::SocketOut> out_;
  DeviceHost& host_;

  std::atomic<bool> watches_{false};  // as a helper, how others are led

  mutable std::mutex mutex_;  // of all below but frame_processor_
  bool greeted_ = false, closed_ = false;
  bool speaks_for_itself_ = true;  // of watching; else a newer connection of the device does
  std::optional<service::DeviceCamera> camera_;
  service::SpeakingSettings settings_;
  bool quiet_ = false;
  int unread_ = 0;                     // messages that could not be read, less those that could
  std::optional<CameraFrame> newest_;  // not looked at yet
  Clock::time_point newest_came_;
  bool looking_ = false;
  std::uint64_t dropped_ = 0;
  std::deque<Asked> waiting_;  // for a frame that is being looked at
  std::optional<service::Ask> last_ask_;
  std::optional<guide::Said> marked_;  // of the last place that was to be marked
  // "Did you mean ...?", while the next question may answer it: until then, by the device's clock.
  guide::Understood offered_;
  double offered_until_t_ms_ = 0;
  // The last question in words with a name, while "take me there" may mean it.
  guide::Understood named_;
  double named_t_ms_ = 0;
  guide::Understood chosen_from_;  // the offer of which that was chosen
  std::optional<FrameResult> last_result_;
  Announcer announcer_;
  std::unique_ptr<LedWalk> led_;  // who is led somewhere, or was
  WalkWatch watch_;               // of that walk, while helpers may
  std::shared_ptr<WalkRecorder> recorder_;
  bool storing_fails_ = false;
  std::shared_ptr<Teaching> teaching_;  // while a thing is shown; its pictures are taken by work()
  double last_heard_t_ms_ = 0;          // of its last frame or question
  Clock::time_point last_heard_;        // when that came

  // Held while helpers are told where it is, so that what it showed once comes before what it shows
  // now. No other is held when it is taken.
  std::mutex seen_mutex_;

  std::optional<FrameProcessor> frame_processor_;  // work() alone
};

}  // namespace roomwise::live
