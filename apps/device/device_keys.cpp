#include "device_keys.h"

#include <fcntl.h>
#include <linux/input.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <initializer_list>
#include <optional>
#include <utility>

namespace roomwise::app {
namespace {

using Kind = KeyRequest::Kind;

constexpr double kButtonsTried_s = 2;  // so often, once they are gone
constexpr double kNameWaits_s = 10;    // for its next letter
constexpr std::size_t kMaxNameBytes = 100;
constexpr std::size_t kMaxQuestionBytes = 500;
constexpr char kEscape = 0x1B;
constexpr char kBackspace = 0x08;
constexpr char kDelete = 0x7F;  // what most terminals send for the key Backspace

bool continues_character(char byte) {
  return (byte & 0xC0) == 0x80;
}

template <typename Key>
using KeyKinds = std::initializer_list<std::pair<Key, Kind>>;
constexpr KeyKinds<char> kLettersBeforeName = {
    {'f', Kind::kFind}, {'g', Kind::kTake},    {'l', Kind::kWay},      {'n', Kind::kNameRoom},
    {'m', Kind::kMark}, {'?', Kind::kInWords}, {'c', Kind::kNameThing}};
constexpr KeyKinds<char> kLetters = {
    {'w', Kind::kWhere},   {'a', Kind::kAround}, {'r', Kind::kRepeat}, {'q', Kind::kQuiet},
    {'p', Kind::kPause},   {'o', Kind::kGoOn},   {'h', Kind::kHowFar}, {'t', Kind::kNext},
    {'b', Kind::kBlocked}, {'e', Kind::kEnd},    {'x', Kind::kExit},   {'k', Kind::kBack},
    {'s', Kind::kSpots},   {'y', Kind::kTeach}};
constexpr KeyKinds<int> kButtons = {{KEY_1, Kind::kWhere},
                                    {KEY_2, Kind::kAround},
                                    {KEY_3, Kind::kFindNext},
                                    {KEY_4, Kind::kRepeat},
                                    {KEY_5, Kind::kQuiet}};
constexpr KeyKinds<int> kHeldButtons = {{KEY_1, Kind::kNext},
                                        {KEY_2, Kind::kBlocked},
                                        {KEY_3, Kind::kTakeFound},
                                        {KEY_4, Kind::kPauseOrGoOn},
                                        {KEY_5, Kind::kEnd}};

template <typename Key>
std::optional<Kind> kind_of(Key key, KeyKinds<Key> kinds) {
  const auto* const found = std::ranges::find(kinds, key, &std::pair<Key, Kind>::first);
  return found == kinds.end() ? std::nullopt : std::optional(found->second);
}

// What says that a name is waited for.
Kind asking_for(Kind naming) {
  if (naming == Kind::kInWords) return Kind::kWhichQuestion;
  if (naming == Kind::kMark) return Kind::kWhichSpot;
  if (naming == Kind::kNameThing) return Kind::kWhichName;
  return naming == Kind::kNameRoom ? Kind::kWhichRoom : Kind::kWhichThing;
}

// What can be read now; nothing where the other end is gone.
std::optional<std::vector<std::uint8_t>> read_some(int descriptor) {
  std::vector<std::uint8_t> bytes(4096);
  const ssize_t count = ::read(descriptor, bytes.data(), bytes.size());
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return std::vector<std::uint8_t>();
  if (count <= 0) return std::nullopt;
  bytes.resize(static_cast<std::size_t>(count));
  return bytes;
}

}  // namespace

std::vector<KeyRequest> TypedKeys::take(std::string_view bytes, TimestampNs now_ns) {
  std::vector<KeyRequest> requests;
  if (naming_ && seconds_between(last_key_ns_, now_ns) > kNameWaits_s) {
    end_name(true, requests);
  }
  if (!bytes.empty()) last_key_ns_ = now_ns;
  for (const char key : bytes) take_key(key, requests);
  // A name that came whole, from a pipe, needs no question.
  if (naming_ && !std::exchange(is_announced_, true)) {
    requests.push_back({asking_for(*naming_), ""});
  }
  return requests;
}

void TypedKeys::take_key(char key, std::vector<KeyRequest>& requests) {
  if (naming_) return take_letter_of_name(key, requests);
  naming_ = kind_of(key, kLettersBeforeName);
  is_announced_ = false;
  if (const auto kind = kind_of(key, kLetters)) requests.push_back({*kind, ""});
}

void TypedKeys::take_letter_of_name(char key, std::vector<KeyRequest>& requests) {
  const std::size_t longest = naming_ == Kind::kInWords ? kMaxQuestionBytes : kMaxNameBytes;
  if (key == '\n' || key == '\r') {
    end_name(false, requests);
  } else if (key == kEscape) {
    end_name(true, requests);
  } else if (key == kBackspace || key == kDelete) {
    while (!name_.empty() && continues_character(name_.back())) name_.pop_back();
    if (!name_.empty()) name_.pop_back();
  } else if (static_cast<unsigned char>(key) >= ' ' && name_.size() < longest) {
    name_ += key;
  }
}

void TypedKeys::end_name(bool given_up, std::vector<KeyRequest>& requests) {
  const std::size_t begin = std::min(name_.find_first_not_of(' '), name_.size());
  const bool needs_name = naming_ != Kind::kMark;
  if (given_up || (begin == name_.size() && needs_name)) {
    requests.push_back({Kind::kNoName, ""});
  } else {
    requests.push_back({*naming_, name_.substr(begin)});
  }
  naming_.reset();
  name_.clear();
}

double ButtonEvents::long_press_s(int key) {
  return key == KEY_5 ? kEndPress_s : kLongPress_s;
}

std::vector<KeyRequest> ButtonEvents::take(std::span<const std::uint8_t> bytes,
                                           TimestampNs now_ns) {
  rest_.insert(rest_.end(), bytes.begin(), bytes.end());
  std::vector<KeyRequest> requests;
  std::size_t at = 0;
  for (; at + sizeof(input_event) <= rest_.size(); at += sizeof(input_event)) {
    input_event event{};
    std::memcpy(&event, rest_.data() + at, sizeof event);
    if (event.type == EV_SYN && event.code == SYN_DROPPED) down_s_.clear();  // maybe they went up
    if (event.type != EV_KEY) continue;
    const double at_s = static_cast<double>(event.input_event_sec) +
                        1e-6 * static_cast<double>(event.input_event_usec);
    if (event.value == 1) down_s_[event.code] = at_s;  // 2: is held
    if (event.value != 0) continue;
    const auto down = down_s_.extract(event.code);
    if (down.empty()) continue;  // was heard of while it was held, or before anybody listened
    const bool was_held = at_s - down.mapped() >= long_press_s(event.code);
    const auto kind = kind_of<int>(event.code, was_held ? kHeldButtons : kButtons);
    if (kind) requests.push_back({*kind, ""});
  }
  rest_.erase(rest_.begin(), rest_.begin() + static_cast<std::ptrdiff_t>(at));
  std::erase_if(down_s_, [&](const auto& down) {
    const auto& [key, since_s] = down;
    if (1e-9 * static_cast<double>(now_ns) - since_s < long_press_s(key)) return false;
    if (const auto kind = kind_of<int>(key, kHeldButtons)) requests.push_back({*kind, ""});
    return true;
  });
  return requests;
}

struct DeviceKeys::Terminal {
  int descriptor = -1;
  termios before{};
};

Expected<std::unique_ptr<DeviceKeys>> DeviceKeys::open(int keyboard,
                                                       const std::filesystem::path& buttons) {
  std::unique_ptr<DeviceKeys> keys(new DeviceKeys);
  keys->keyboard_ = keyboard;
  keys->buttons_file_ = buttons;
  if (!buttons.empty()) {
    keys->open_buttons();
    if (keys->buttons_ < 0) {
      return fail("{}: cannot be read: {}; is the user in the group 'input'?", buttons.string(),
                  std::strerror(errno));
    }
  }
  termios settings{};
  if (::isatty(keyboard) == 1 && ::tcgetattr(keyboard, &settings) == 0) {
    keys->terminal_ = std::make_unique<Terminal>(Terminal{keyboard, settings});
    settings.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
    ::tcsetattr(keyboard, TCSANOW, &settings);
  }
  return keys;
}

DeviceKeys::~DeviceKeys() {
  if (terminal_) ::tcsetattr(terminal_->descriptor, TCSANOW, &terminal_->before);
  if (buttons_ >= 0) ::close(buttons_);
}

void DeviceKeys::open_buttons() {
  buttons_ = ::open(buttons_file_.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (buttons_ < 0) return;
  // The clock of wait()'s times, which no step of the calendar's moves. A pipe has none.
  int clock = CLOCK_MONOTONIC;
  (void)::ioctl(buttons_, EVIOCSCLOCKID, &clock);
}

void DeviceKeys::lose_buttons(TimestampNs now_ns) {
  ::close(buttons_);
  buttons_ = -1;
  events_ = {};  // nobody knows what is held
  buttons_tried_ns_ = now_ns;
}

std::vector<KeyRequest> DeviceKeys::wait(int max_ms, TimestampNs now_ns) {
  if (has_lost_buttons() && seconds_between(buttons_tried_ns_, now_ns) >= kButtonsTried_s) {
    buttons_tried_ns_ = now_ns;
    open_buttons();
  }
  // Descriptors below 0 are passed over.
  std::array<pollfd, 2> inputs{{{keyboard_, POLLIN, 0}, {buttons_, POLLIN, 0}}};
  const bool is_any = ::poll(inputs.data(), inputs.size(), max_ms) > 0;
  std::vector<KeyRequest> requests;
  const auto add = [&](std::vector<KeyRequest> more) {
    std::ranges::move(more, std::back_inserter(requests));
  };
  if (!is_any) {
    add(typed_.take({}, now_ns));
  } else if (inputs[0].revents != 0) {
    if (const auto bytes = read_some(keyboard_)) {
      add(typed_.take({reinterpret_cast<const char*>(bytes->data()), bytes->size()}, now_ns));
    } else {
      keyboard_ = -1;
    }
  }
  if (!is_any || inputs[1].revents == 0) {
    if (buttons_ >= 0) add(events_.take({}, now_ns));
  } else {
    if (const auto bytes = read_some(buttons_)) {
      add(events_.take(*bytes, now_ns));
    } else {
      lose_buttons(now_ns);
    }
  }
  return requests;
}

}  // namespace roomwise::app
