#pragma once

#include <atomic>
#include <cstdint>
#include <future>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "device_camera.h"
#include "device_keys.h"
#include "device_voice.h"
#include "roomwise/service/client/client.h"
#include "roomwise/service/client/device_link.h"
#include "roomwise/service/protocol/messages.h"

namespace roomwise::app {

// What a device is made of; each is used by the session alone.
struct DeviceParts {
  service::ServerAddress server;
  service::ServerCredentials credentials;
  service::Hello hello;
  std::unique_ptr<DeviceCamera> camera;  // nullptr: it sends no frames
  std::unique_ptr<DeviceVoice> voice;
  std::unique_ptr<DeviceKeys> keys;  // nullptr: nobody asks
  service::LinkTimes times;
  service::ClientWait wait;  // but for its interruption, which is the session's
};

// A device at work: sends what the camera sees, asks what keys ask, speaks what comes back, and
// connects again where the connection was lost.
class DeviceSession : private Interruption {
 public:
  explicit DeviceSession(DeviceParts parts) : parts_(std::move(parts)), link_(parts_.times) {}
  ~DeviceSession() override { over_ = true; }
  DeviceSession(const DeviceSession&) = delete;
  DeviceSession& operator=(const DeviceSession&) = delete;

  // Until the recording has ended and all is said, somebody presses x, or `interruption`.
  [[nodiscard]] Expected<void> run(const Interruption& interruption);

  [[nodiscard]] const service::LinkCounts& counts() const { return link_.counts(); }
  [[nodiscard]] std::uint64_t prompts() const { return prompts_; }

 private:
  // Of what waits for the computer.
  [[nodiscard]] bool interrupted() const override { return over_; }
  void connect(TimestampNs now_ns);
  void take_connection(TimestampNs now_ns);
  void take_first_welcome(TimestampNs now_ns);
  void tell_of_failure(const Error& error, TimestampNs now_ns);
  void say_no_connection(TimestampNs now_ns);
  void lose(const std::string& why, TimestampNs now_ns);
  void receive(TimestampNs now_ns);
  void take(const service::HomeMessage& message, TimestampNs now_ns);
  void take_prompt(const service::PromptMessage& message, TimestampNs now_ns);
  void watch_teaching(const std::string& message);
  void watch_guide(const service::PromptMessage& message);
  void lead_as_before(const service::Ask& asked);
  void lead_on(const service::Seen& seen, TimestampNs now_ns);
  void lead_again(TimestampNs now_ns);
  void take_recording(const service::RecordingState& recording, TimestampNs now_ns);
  void take_error(const service::ErrorMessage& error, TimestampNs now_ns);
  void watch_camera(TimestampNs now_ns);
  void watch_buttons(TimestampNs now_ns);
  void send_frames(TimestampNs now_ns);
  void act(const KeyRequest& request, TimestampNs now_ns);
  void find_next(TimestampNs now_ns);
  void take_to_found(TimestampNs now_ns);
  void ask(service::Ask ask, TimestampNs now_ns);
  void tell_guide(service::GuideWish wish, TimestampNs now_ns);
  void ask(service::Question question, const std::string& subject, TimestampNs now_ns);
  void send(const service::DeviceMessage& message, TimestampNs now_ns);
  [[nodiscard]] bool is_over(TimestampNs now_ns) const;

  DeviceParts parts_;
  service::DeviceLink link_;
  std::unique_ptr<service::ServerConnection> connection_;
  std::vector<service::Ask> goals_;  // of the home, as they are asked for
  std::size_t next_goal_ = 0;
  std::optional<service::Ask> found_;  // the goal that was asked for last
  std::int64_t questions_ = 0;
  std::int64_t asked_by_device_ = 0;            // the newest of them that nobody asked
  std::int64_t newest_answered_ = 0;            // of the questions
  std::map<std::int64_t, service::Ask> asked_;  // and not answered
  // How somebody is led, while they are: the computer forgets it where it begins anew.
  struct Led {
    std::optional<service::Ask> by = {};
    std::optional<TimestampNs> again_from_ns = {};  // is to be asked anew, since then
    bool is_paused = false;                         // they do not want to hear of it now
    bool is_unanswered = false;  // when the connection was lost nobody had said whether it is known
  };
  Led led_;
  Led led_before_;             // holds again where the goal that was asked for last is not known
  bool can_localize_ = false;  // the computer
  std::string role_;           // of this device
  service::RecordingState recording_;  // the last that was told
  std::uint64_t prompts_ = 0;
  bool camera_failed_ = false;
  bool buttons_lost_ = false;
  bool quiet_ = false;
  bool is_teaching_ = false;  // a thing is shown, or waits for its name
  TimestampNs heard_ns_ = 0;  // when the computer said something last
  std::string last_failure_;
  bool no_connection_said_ = false;  // or there was one since
  bool removal_said_ = false;
  std::atomic<bool> over_ = false;
  std::future<Expected<std::unique_ptr<service::ServerConnection>>> trying_;  // last: it ends first
};

}  // namespace roomwise::app
