#include "roomwise/speech/speech_dispatcher.h"

#include <libspeechd.h>
#include <poll.h>

#include <csignal>
#include <cstdlib>
#include <map>
#include <mutex>
#include <set>
#include <utility>

#include "roomwise/base/file.h"
#include "roomwise/speech/earcons.h"
#include "roomwise/speech/wav_timeline.h"

namespace roomwise::speech {
namespace {

constexpr int kEarconRate_hz = 22050;
constexpr const char* kMend =
    "install and start it (apt-get install speech-dispatcher speech-dispatcher-espeak-ng; spd-say "
    "hello must speak), or name its socket in SPEECHD_ADDRESS";

// The library writes to its socket without asking whether anybody listens; a daemon that is gone
// must be an error, not this process's end. While it lives, SIGPIPE waits, and one that came is
// taken away.
class NoSigpipe {
 public:
  NoSigpipe() {
    sigemptyset(&sigpipe_);
    sigaddset(&sigpipe_, SIGPIPE);
    sigset_t pending;
    sigpending(&pending);
    was_pending_ = sigismember(&pending, SIGPIPE) == 1;
    pthread_sigmask(SIG_BLOCK, &sigpipe_, &before_);
  }
  ~NoSigpipe() {
    const timespec at_once{};
    if (!was_pending_) sigtimedwait(&sigpipe_, nullptr, &at_once);
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  NoSigpipe(const NoSigpipe&) = delete;
  NoSigpipe& operator=(const NoSigpipe&) = delete;

 private:
  sigset_t sigpipe_{};
  sigset_t before_{};
  bool was_pending_ = false;
};

SPDPriority priority_of(guide::Priority priority) {
  switch (priority) {
    case guide::Priority::kHazard:
      return SPD_IMPORTANT;  // comes before a screen reader, too
    case guide::Priority::kAnswer:
    case guide::Priority::kNotice:
      return SPD_MESSAGE;
    case guide::Priority::kCallout:
      break;
  }
  return SPD_TEXT;
}

// What has ended, as the library's thread tells it.
struct Ends {
  std::mutex mutex;
  std::set<std::size_t> messages;
  std::function<void()> on_done;
};

// The notifications' only way to their connection. Held while one is delivered, so that none comes
// after its connection is gone.
std::mutex listener_mutex;
Ends* listener = nullptr;

void hear_end(std::size_t message, std::size_t /*client*/, SPDNotificationType /*type*/) {
  const std::lock_guard lock(listener_mutex);
  if (listener == nullptr) return;
  {
    const std::lock_guard ends_lock(listener->mutex);
    listener->messages.insert(message);
  }
  if (listener->on_done) listener->on_done();
}

// A folder of WAV files, one a sound, that is gone at its end.
class EarconFiles {
 public:
  [[nodiscard]] Expected<void> write() {
    std::error_code error;
    const auto temporary = std::filesystem::temp_directory_path(error);
    std::string pattern = (temporary / "roomwise-sounds-XXXXXX").string();
    if (error || mkdtemp(pattern.data()) == nullptr) {
      return fail("{}: no folder for the sounds can be made there", temporary.string());
    }
    folder_ = pattern;
    using guide::Sound;
    for (const Sound sound :
         {Sound::kAnswer, Sound::kUnsure, Sound::kLost, Sound::kBack, Sound::kAlert}) {
      const auto path = folder_ / (std::string(guide::to_string(sound)) + ".wav");
      ROOMWISE_RETURN_IF_ERROR(write_file(path, wav_bytes(earcon(sound, kEarconRate_hz))));
      files_[sound] = path;
    }
    return {};
  }
  ~EarconFiles() {
    std::error_code ignored;
    if (!folder_.empty()) std::filesystem::remove_all(folder_, ignored);
  }
  EarconFiles() = default;
  EarconFiles(const EarconFiles&) = delete;
  EarconFiles& operator=(const EarconFiles&) = delete;

  // Empty for no sound.
  [[nodiscard]] std::filesystem::path of(guide::Sound sound) const {
    const auto found = files_.find(sound);
    return found == files_.end() ? std::filesystem::path() : found->second;
  }

 private:
  std::filesystem::path folder_;
  std::map<guide::Sound, std::filesystem::path> files_;
};

struct AddressDeleter {
  void operator()(SPDConnectionAddress* address) const { SPDConnectionAddress__free(address); }
};

bool has_hung_up(int socket) {
  pollfd waited{socket, POLLRDHUP, 0};
  return poll(&waited, 1, 0) != 0;
}

// The text of an error that the library allocated.
std::string taken(char* error) {
  std::string text = error != nullptr ? error : "no reason given";
  std::free(error);  // NOLINT(cppcoreguidelines-no-malloc)
  while (text.ends_with('\n')) text.pop_back();
  return text;
}

// The library knows addresses by the environment alone.
class AddressInEnvironment {
 public:
  explicit AddressInEnvironment(const std::string& address) {
    if (address.empty()) return;
    if (const char* before = std::getenv(kVariable)) before_ = before;
    setenv(kVariable, address.c_str(), 1);
    is_set_ = true;
  }
  ~AddressInEnvironment() {
    if (!is_set_) return;
    before_ ? setenv(kVariable, before_->c_str(), 1) : unsetenv(kVariable);
  }
  AddressInEnvironment(const AddressInEnvironment&) = delete;
  AddressInEnvironment& operator=(const AddressInEnvironment&) = delete;

 private:
  static constexpr const char* kVariable = "SPEECHD_ADDRESS";
  std::optional<std::string> before_;
  bool is_set_ = false;
};

}  // namespace

struct SpeechDispatcher::Connection {
  Ends ends;
  EarconFiles earcons;
  SPDConnection* spd = nullptr;
  std::string language;  // that was set last
  std::size_t message = 0;
  bool is_speaking = false;

  ~Connection() {
    {
      const std::lock_guard lock(listener_mutex);
      if (listener == &ends) listener = nullptr;
    }
    const NoSigpipe no_sigpipe;
    if (spd != nullptr) spd_close(spd);
  }
};

SpeechDispatcher::SpeechDispatcher(std::unique_ptr<Connection> connection)
    : connection_(std::move(connection)) {}
SpeechDispatcher::~SpeechDispatcher() = default;

Expected<std::unique_ptr<SpeechDispatcher>> SpeechDispatcher::open(
    const SpeechDispatcherOptions& options, std::function<void()> on_done) {
  auto connection = std::make_unique<Connection>();
  connection->ends.on_done = std::move(on_done);
  ROOMWISE_RETURN_IF_ERROR(connection->earcons.write());
  {
    const std::lock_guard lock(listener_mutex);
    if (listener != nullptr) return fail("this program speaks through speech-dispatcher already");
    listener = &connection->ends;
  }
  const NoSigpipe no_sigpipe;
  const AddressInEnvironment environment(options.address);
  char* error = nullptr;
  const std::unique_ptr<SPDConnectionAddress, AddressDeleter> address(
      spd_get_default_address(&error));
  if (!address) return fail("speech-dispatcher: {}; {}", taken(error), kMend);
  connection->spd = spd_open2("roomwise", "guide", nullptr, SPD_MODE_THREADED, address.get(),
                              options.may_start_daemon ? 1 : 0, &error);
  if (connection->spd == nullptr) return fail("speech-dispatcher: {}; {}", taken(error), kMend);
  connection->spd->callback_end = hear_end;
  connection->spd->callback_cancel = hear_end;
  const bool is_ready = spd_set_notification_on(connection->spd, SPD_END) == 0 &&
                        spd_set_notification_on(connection->spd, SPD_CANCEL) == 0 &&
                        spd_set_data_mode(connection->spd, SPD_DATA_SSML) == 0;
  if (!is_ready) return fail("speech-dispatcher does not tell when it has spoken; {}", kMend);
  return std::unique_ptr<SpeechDispatcher>(new SpeechDispatcher(std::move(connection)));
}

Expected<void> SpeechDispatcher::begin(const guide::Utterance& utterance, TimestampNs now_ns) {
  ROOMWISE_RETURN_IF_ERROR(stop(now_ns));
  const guide::Prompt& prompt = utterance.prompt;
  const NoSigpipe no_sigpipe;
  if (connection_->language != prompt.language) {
    if (spd_set_language(connection_->spd, prompt.language.c_str()) != 0) {
      return fail("speech-dispatcher does not take the language \"{}\"; {}", prompt.language,
                  kMend);
    }
    connection_->language = prompt.language;
  }
  const std::string message = ssml_of(prompt.text, connection_->earcons.of(prompt.sound));
  const int id = spd_say(connection_->spd, priority_of(prompt.priority), message.c_str());
  if (id <= 0) return fail("speech-dispatcher no longer answers; {}", kMend);
  connection_->message = static_cast<std::size_t>(id);
  connection_->is_speaking = true;
  return {};
}

Expected<void> SpeechDispatcher::stop(TimestampNs now_ns) {
  ROOMWISE_TRY(const bool is_done, this->is_done(now_ns));
  if (is_done) return {};
  const NoSigpipe no_sigpipe;
  if (spd_cancel(connection_->spd) != 0) {
    return fail("speech-dispatcher no longer answers; {}", kMend);
  }
  connection_->is_speaking = false;
  return {};
}

Expected<bool> SpeechDispatcher::is_done(TimestampNs /*now_ns*/) {
  if (!connection_->is_speaking) return true;
  {
    const std::lock_guard lock(connection_->ends.mutex);
    auto& ended = connection_->ends.messages;
    ended.erase(ended.begin(), ended.lower_bound(connection_->message));
    if (ended.contains(connection_->message)) connection_->is_speaking = false;
  }
  // The library does not tell when the daemon is gone; the end would never come.
  if (connection_->is_speaking && has_hung_up(connection_->spd->socket)) {
    connection_->is_speaking = false;
    return fail("speech-dispatcher has ended; {}", kMend);
  }
  return !connection_->is_speaking;
}

std::string ssml_of(const std::string& text, const std::filesystem::path& sound_file) {
  const auto escaped = [](const std::string& raw) {
    std::string result;
    for (const char c : raw) {
      if (c == '&') {
        result += "&amp;";
      } else if (c == '<') {
        result += "&lt;";
      } else if (c == '>') {
        result += "&gt;";
      } else if (c == '"') {
        result += "&quot;";
      } else {
        result += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
      }
    }
    return result;
  };
  const std::string sound =
      sound_file.empty() ? "" : "<audio src=\"" + escaped(sound_file.string()) + "\"/>";
  return "<speak>" + sound + escaped(text) + "</speak>";
}

}  // namespace roomwise::speech
