#include "roomwise/speech/espeak.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <mutex>
#include <set>
#include <vector>

#include "roomwise/base/file.h"

namespace roomwise::speech {
namespace {

constexpr int kSlowest = 80, kFastest = 450;  // words a minute, as espeak-ng takes them

// One end of a pipe, closed when it goes.
class PipeEnd {
 public:
  explicit PipeEnd(int descriptor) : descriptor_(descriptor) {}
  ~PipeEnd() { close_now(); }
  PipeEnd(const PipeEnd&) = delete;
  PipeEnd& operator=(const PipeEnd&) = delete;
  [[nodiscard]] int get() const { return descriptor_; }
  void close_now() {
    if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
  }

 private:
  int descriptor_;
};

// What espeak-ng prints. It is a program of its own, not a library of ours, since its licence (GPL)
// is another.
Expected<Bytes> run_espeak(std::vector<std::string> arguments, std::string_view input) {
  std::array<int, 2> to{}, from{};
  // A socket, since writing to a pipe that nobody reads any more would end the program.
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, to.data()) != 0) {
    return fail("no socket: {}", std::strerror(errno));
  }
  PipeEnd to_read(to[0]), to_write(to[1]);
  if (::pipe2(from.data(), O_CLOEXEC) != 0) return fail("no pipe: {}", std::strerror(errno));
  PipeEnd from_read(from[0]), from_write(from[1]);

  arguments.insert(arguments.begin(), "espeak-ng");
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, to_read.get(), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&files, from_write.get(), STDOUT_FILENO);
  posix_spawn_file_actions_addopen(&files, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  pid_t child = -1;
  const int spawned = ::posix_spawnp(&child, "espeak-ng", &files, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  if (spawned != 0) return fail("espeak-ng cannot be run; install it: apt-get install espeak-ng");
  to_read.close_now();
  from_write.close_now();

  // A text is shorter than what a socket holds, so this does not wait for the reader. Where there
  // is none, nothing is sent: who lists the voices may have ended by now, and sending would fail.
  const bool written = input.empty() || ::send(to_write.get(), input.data(), input.size(),
                                               MSG_NOSIGNAL) == static_cast<ssize_t>(input.size());
  to_write.close_now();
  Bytes output;
  std::array<std::uint8_t, 65'536> piece{};
  for (ssize_t count = 0; (count = ::read(from_read.get(), piece.data(), piece.size())) > 0;) {
    output.insert(output.end(), piece.begin(), piece.begin() + count);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  if (!written || !WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    return fail("espeak-ng failed on \"{}\"", input);
  }
  return output;
}

// It speaks languages that it does not know in another's voice, and says nothing of it.
Expected<void> look_for_voice(const std::string& language) {
  ROOMWISE_TRY(const Bytes output, run_espeak({"--voices=" + language}, ""));
  // Voices of languages that only begin alike are listed too: " 5  en-gb  --/M  ...  (en 2)".
  const std::string voices(output.begin(), output.end());
  for (const char* end : {" ", "-"}) {
    if (voices.find(" " + language + end) != std::string::npos) return {};
  }
  if (voices.find("(" + language + " ") != std::string::npos) return {};
  return fail("espeak-ng has no voice \"{}\"; install espeak-ng-data", language);
}

// The same, once for each language that has one: else each prompt would start espeak-ng twice.
Expected<void> check_language(const std::string& language) {
  static std::mutex mutex;
  static std::set<std::string> with_voice;
  {
    const std::scoped_lock lock(mutex);
    if (with_voice.contains(language)) return {};
  }
  ROOMWISE_RETURN_IF_ERROR(look_for_voice(language));
  const std::scoped_lock lock(mutex);
  with_voice.insert(language);
  return {};
}

// A WAV file of 16-bit mono whose lengths are not meant, as what is written to a pipe has.
Expected<Pcm> parse_wav(const Bytes& wav) {
  constexpr std::size_t kHeader = 44;
  if (wav.size() < kHeader || std::memcmp(wav.data(), "RIFF", 4) != 0) {
    return fail("espeak-ng gave no sound");
  }
  std::uint32_t rate_hz = 0;
  std::memcpy(&rate_hz, wav.data() + 24, sizeof rate_hz);
  Pcm pcm{static_cast<int>(rate_hz), std::vector<std::int16_t>((wav.size() - kHeader) / 2)};
  std::memcpy(pcm.samples.data(), wav.data() + kHeader, 2 * pcm.samples.size());
  return pcm;
}

}  // namespace

Expected<Pcm> synthesize(const std::string& text, const std::string& language,
                         int words_per_minute) {
  constexpr std::size_t kLongest = 4096;  // bytes
  if (words_per_minute < kSlowest || words_per_minute > kFastest) {
    return fail("{} words a minute; expected {} to {}", words_per_minute, kSlowest, kFastest);
  }
  if (text.size() > kLongest) return fail("a text of more than {} bytes is no prompt", kLongest);
  ROOMWISE_RETURN_IF_ERROR(check_language(language));
  if (text.empty()) return Pcm{22'050, {}};
  // -b 1: the text is UTF-8, whatever the environment says.
  ROOMWISE_TRY(const Bytes wav, run_espeak({"-v", language, "-s", std::to_string(words_per_minute),
                                            "-b", "1", "--stdin", "--stdout"},
                                           text));
  return parse_wav(wav);
}

}  // namespace roomwise::speech
