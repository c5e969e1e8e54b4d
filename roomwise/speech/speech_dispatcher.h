#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "roomwise/speech/speaker.h"

namespace roomwise::speech {

struct SpeechDispatcherOptions {
  // "unix_socket:/run/user/1000/speech-dispatcher/speechd.sock" or "inet_socket:127.0.0.1:6560".
  // Empty: as the environment's SPEECHD_ADDRESS says, else where speech-dispatcher is by default.
  std::string address;
  // Whether a daemon that does not run is started, as its own library does it.
  bool may_start_daemon = true;
};

// Speaks through speech-dispatcher, with the voice, rate and volume that somebody has set there.
//
// The sound before the words goes along in the same message (SSML's <audio> with a WAV file in a
// folder of its own), so that nothing can come between them and both end together. espeak-ng's
// module plays it; another module may leave it out and speak the words alone.
//
// One a process: the library's notifications do not say for whom they are.
class SpeechDispatcher : public Speaker {
 public:
  // `on_done` is called when an utterance has ended, from a thread of the library: it must be quick
  // and must not call the speaker. Fails, naming what to install or start, where there is no
  // speech-dispatcher.
  [[nodiscard]] static Expected<std::unique_ptr<SpeechDispatcher>> open(
      const SpeechDispatcherOptions& options, std::function<void()> on_done = {});
  ~SpeechDispatcher() override;

  [[nodiscard]] Expected<void> begin(const guide::Utterance& utterance,
                                     TimestampNs now_ns) override;
  [[nodiscard]] Expected<void> stop(TimestampNs now_ns) override;
  [[nodiscard]] Expected<bool> is_done(TimestampNs now_ns) override;

 private:
  struct Connection;
  explicit SpeechDispatcher(std::unique_ptr<Connection> connection);

  std::unique_ptr<Connection> connection_;
};

// The message of a prompt: `sound_file` (empty: none) and the text, its signs made harmless.
[[nodiscard]] std::string ssml_of(const std::string& text, const std::filesystem::path& sound_file);

}  // namespace roomwise::speech
