#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "roomwise/base/file.h"

namespace roomwise::service {

struct LinkTimes {
  double first_wait_s = 0.5;  // before trying again; each wait is twice as long as the one before
  double longest_wait_s = 5;
  double acknowledged_s = 10;  // a frame of which nothing is heard for so long is given up
  // The link is slow from a frame on that took so long to arrive, until so many small ones in a row
  // were quick; each relapse doubles their number, up to kMaxCaution times.
  double slow_from_s = 0.5;
  double quick_until_s = 0.1;
  int quick_frames = 20;

  static constexpr int kMaxCaution = 16;
};

struct LinkCounts {
  std::uint64_t offered = 0;  // frames
  std::uint64_t sent = 0;
  std::uint64_t replaced = 0;  // by a newer one, never sent
  std::uint64_t tries = 0;     // to connect
  std::uint64_t losses = 0;
};

// The rules of a device's connection: when to try again, which frame to send, and whether whole
// frames get through in time. One frame is under way at a time; until it is acknowledged only the
// newest one waits. It connects nothing itself: the caller says what happened and when (a steady
// clock), and does what is said. Not thread-safe.
class DeviceLink {
 public:
  enum class State { kWaiting, kConnecting, kConnected };
  enum class News { kNone, kConnected, kLost, kBack };

  explicit DeviceLink(const LinkTimes& times = {}) : times_(times) {}

  // Whether to begin a try now; then connected() or failed() must follow.
  [[nodiscard]] bool begin_try(double now_s);
  // Each tells what a person should hear of it: the first connection, one that was lost, one that
  // is back. A try that fails is no news.
  [[nodiscard]] News connected();           // and welcomed
  [[nodiscard]] News failed(double now_s);  // the try, or the connection
  // When begin_try() will be true; nothing while it is connecting or connected.
  [[nodiscard]] std::optional<double> next_try_s() const;

  // A new frame, as it is sent. Without a connection it is dropped: what was seen then is no help
  // later.
  void offer(double t_ms, Bytes message);
  // What to send now.
  [[nodiscard]] std::optional<Bytes> next_frame(double now_s);
  // The computer has the frame of that time, and dropped the one before it perhaps.
  void acknowledged(double t_ms, double now_s);
  // Whether frames should be small: whole ones would arrive too late to be of use. A new connection
  // is not slow, until it shows.
  [[nodiscard]] bool is_slow() const { return is_slow_; }
  // Whether it has become slow since this was asked last.
  [[nodiscard]] bool take_became_slow() { return std::exchange(became_slow_, false); }

  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] const LinkCounts& counts() const { return counts_; }

 private:
  struct Frame {
    double t_ms = 0;
    Bytes message;
  };
  struct UnderWay {
    double t_ms = 0;
    double since_s = 0;
  };

  LinkTimes times_;
  LinkCounts counts_;
  State state_ = State::kWaiting;
  bool was_connected_ = false;
  double wait_s_ = 0;  // the next one; 0: the first
  double try_at_s_ = 0;
  std::optional<Frame> newest_;
  std::optional<UnderWay> under_way_;
  void become_slow();

  bool is_slow_ = false;
  bool became_slow_ = false;
  int quick_in_row_ = 0;
  int caution_ = 1;
};

}  // namespace roomwise::service
