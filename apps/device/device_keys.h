#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/base/timestamp.h"

namespace roomwise::app {

// What a person asks the device by a key.
struct KeyRequest {
  enum class Kind {
    kWhere,
    kAround,
    kFind,
    kFindNext,
    kTake,       // be led there
    kTakeFound,  // be led to what kFindNext named last
    kWay,        // hear the whole way
    kPause,      // of the guide
    kGoOn,
    kPauseOrGoOn,
    kHowFar,
    kNext,
    kBlocked,
    kEnd,
    kNameRoom,
    kInWords,
    kMark,       // this place
    kBack,       // to where that was, or where one set out
    kSpots,      // which were marked
    kTeach,      // begins to show a thing, or stops that
    kNameThing,  // that was shown
    kRepeat,
    kQuiet,
    kExit,
    kWhichThing,  // its name is to be typed now
    kWhichRoom,
    kWhichQuestion,
    kWhichSpot,  // its name is to be typed now, or none
    kWhichName,  // of the thing that was shown
    kNoName,     // that was given up
  };
  Kind kind = Kind::kWhere;
  // The thing of kFind, kTake, kWay and kNameThing, the room of kNameRoom, the question of
  // kInWords, the spot of kMark (empty: without a name).
  std::string name;

  bool operator==(const KeyRequest&) const = default;
};

// Letters as they come from a keyboard or a pipe: w (where am I), a (around me), f NAME Enter
// (find), g NAME Enter (go there), l NAME Enter (list the way there), n NAME Enter (name the room
// while it is recorded), ? QUESTION Enter (ask in one's own words), m [NAME] Enter (mark this
// place), k (back there, or to where one set out), s (which places were marked), y (teach: show a
// thing to the camera; again: stop), c NAME Enter (call it), r (repeat), q (quiet), x (exit); to
// the guide p (pause), o (go on), h (how far), t (what is next), b (the way is blocked), e (end).
// Others mean nothing. Backspace takes back the last letter of a name; Escape, or ten seconds
// without a key, ends it.
class TypedKeys {
 public:
  // Also without bytes, to see that time passes.
  [[nodiscard]] std::vector<KeyRequest> take(std::string_view bytes, TimestampNs now_ns);

 private:
  void take_key(char key, std::vector<KeyRequest>& requests);
  void take_letter_of_name(char key, std::vector<KeyRequest>& requests);
  // `given_up`: by Escape, or since no key came.
  void end_name(bool given_up, std::vector<KeyRequest>& requests);

  std::optional<KeyRequest::Kind> naming_;  // after f, g, l, n or ?, until Enter
  bool is_announced_ = false;               // that a name is waited for
  TimestampNs last_key_ns_ = 0;
  std::string name_;  // UTF-8
};

// Events of a Linux input device (struct input_event), in pieces of any size: the keys 1 (where am
// I), 2 (around me), 3 (find the next goal of the home), 4 (repeat), 5 (quiet), when they go up.
// As soon as they were held for kLongPress_s: 1 (what comes next), 2 (the way is blocked), 3 (lead
// me to the goal that was named), 4 (pause, go on); for kEndPress_s: 5 (end), as who is led and
// does not know of it loses most by that.
class ButtonEvents {
 public:
  static constexpr double kLongPress_s = 0.7;
  static constexpr double kEndPress_s = 2;

  // Also without bytes, to see that time passes, by the clock of the events.
  [[nodiscard]] std::vector<KeyRequest> take(std::span<const std::uint8_t> bytes,
                                             TimestampNs now_ns);

 private:
  [[nodiscard]] static double long_press_s(int key);

  std::vector<std::uint8_t> rest_;
  // Of the keys that are held and were not heard of yet, by the device's clock: since when.
  std::map<int, double> down_s_;
};

// Both, as they come in. While it lives, a terminal gives each key at once and does not show it.
class DeviceKeys {
 public:
  // `keyboard`: a descriptor, standard input, or -1. `buttons`: /dev/input/eventN, or empty. Fails
  // where they cannot be read.
  [[nodiscard]] static Expected<std::unique_ptr<DeviceKeys>> open(
      int keyboard, const std::filesystem::path& buttons);
  ~DeviceKeys();
  DeviceKeys(const DeviceKeys&) = delete;
  DeviceKeys& operator=(const DeviceKeys&) = delete;

  // Whether the input device is gone, as an unplugged one is. wait() opens it again once it is
  // there.
  [[nodiscard]] bool has_lost_buttons() const { return buttons_ < 0 && !buttons_file_.empty(); }
  // What was asked since the last call; waits for it, but no longer than so many milliseconds. The
  // time is that of the steady clock.
  [[nodiscard]] std::vector<KeyRequest> wait(int max_ms, TimestampNs now_ns);

 private:
  DeviceKeys() = default;
  void open_buttons();
  void lose_buttons(TimestampNs now_ns);

  struct Terminal;  // its settings as they were
  std::unique_ptr<Terminal> terminal_;
  TypedKeys typed_;
  ButtonEvents events_;
  int keyboard_ = -1;  // descriptors; -1 where there is none (any more)
  int buttons_ = -1;
  std::filesystem::path buttons_file_;
  TimestampNs buttons_tried_ns_ = 0;  // to open them again
};

}  // namespace roomwise::app
