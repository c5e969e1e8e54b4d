#include "open_home.h"

#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <iostream>
#include <memory>
#include <string_view>

#include "roomwise/base/shell_word.h"
#include "roomwise/pipeline/stored/stored_edits.h"

namespace roomwise::app {
namespace {

// A terminal that gives each key as it is pressed and shows none; it is again as it was at the end.
// Ctrl-C is a key too: the program would else end with the terminal left like this.
class SilentTerminal {
 public:
  static Expected<SilentTerminal> take(int terminal) {
    termios before{};
    if (::tcgetattr(terminal, &before) != 0) {
      return fail("the terminal cannot be asked for a passphrase: {}", std::strerror(errno));
    }
    termios silent = before;
    silent.c_lflag &= ~static_cast<tcflag_t>(ECHO | ICANON | ISIG);
    silent.c_cc[VMIN] = 1;
    silent.c_cc[VTIME] = 0;
    ::tcsetattr(terminal, TCSAFLUSH, &silent);
    return SilentTerminal(terminal, before);
  }
  ~SilentTerminal() {
    if (terminal_ >= 0) ::tcsetattr(terminal_, TCSAFLUSH, &before_);
  }
  SilentTerminal(SilentTerminal&& other) noexcept
      : terminal_(std::exchange(other.terminal_, -1)), before_(other.before_) {}
  SilentTerminal& operator=(SilentTerminal&&) = delete;

 private:
  SilentTerminal(int terminal, const termios& before) : terminal_(terminal), before_(before) {}

  int terminal_;
  termios before_;
};

void show(int terminal, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(terminal, text.data(), text.size());
    if (written <= 0) return;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

// The last character of UTF-8 text, which may be several bytes.
std::size_t size_without_last(std::span<const std::uint8_t> text) {
  std::size_t size = text.size();
  while (size > 0 && (text[--size] & 0xc0U) == 0x80U) {
  }
  return size;
}

}  // namespace

Expected<home::OpenOptions> open_options(const Context& context) {
  home::OpenOptions options;
  if (context.passphrase_file.empty()) return options;
  ROOMWISE_TRY(home::Passphrase passphrase, home::Passphrase::read(context.passphrase_file));
  options.passphrase = std::make_shared<const home::Passphrase>(std::move(passphrase));
  using std::filesystem::perms;
  std::error_code error;
  const perms open_to = std::filesystem::status(context.passphrase_file, error).permissions();
  if (!error && (open_to & (perms::group_read | perms::others_read)) != perms::none) {
    std::cerr << fmt::format("note: others can read {0}; keep it to yourself: chmod 600 {1}\n",
                             context.passphrase_file.string(),
                             shell_word(context.passphrase_file.string()));
  }
  return options;
}

Expected<home::Home> open_home(const std::filesystem::path& path, const Context& context) {
  ROOMWISE_TRY(const home::OpenOptions options, open_options(context));
  return home::Home::open(path, options);
}

Expected<home::Home> open_home_read_only(const std::filesystem::path& path,
                                         const Context& context) {
  ROOMWISE_TRY(const home::OpenOptions options, open_options(context));
  return home::Home::open_read_only(path, options);
}

Expected<home::RecordingId> find_walk(const home::Home& home, const std::string& text) {
  ROOMWISE_TRY(const auto recordings, home.recordings());
  if (recordings.empty()) return fail("{}: holds no walk; use roomwise map first", home.file());
  if (text.empty()) {
    ROOMWISE_TRY(const auto staying, pipeline::walks_that_stay(home));
    if (staying.empty()) return fail("{}: all its walks are taken away", home.file());
    return staying.back().id;
  }
  std::vector<std::string> names;
  std::vector<home::RecordingId> found;
  for (const home::StoredRecording& walk : recordings) {
    const std::string number = fmt::format("#{}", names.size() + 1);
    names.push_back(fmt::format("{} ({})", walk.recording.name, number));
    if (walk.recording.name == text || number == text || names.back() == text) {
      found.push_back(walk.id);
    }
  }
  if (found.size() == 1) return found.front();
  return fail("{}: has {} walks '{}'; give one of {}", home.file(), found.size(), text,
              fmt::join(names, ", "));
}

Expected<home::Passphrase> ask_passphrase(int terminal, const std::string& question) {
  constexpr std::uint8_t kCtrlC = 3, kCtrlD = 4, kBackspace = 8, kCtrlU = 21, kDelete = 127;
  ROOMWISE_TRY(const SilentTerminal silent, SilentTerminal::take(terminal));
  show(terminal, question + ": ");
  home::SecretBytes typed(home::Passphrase::kMaxBytes + 1);
  std::size_t size = 0;
  for (;;) {
    std::uint8_t key = 0;
    const ssize_t got = ::read(terminal, &key, 1);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0 || key == kCtrlC || key == kCtrlD) {
      show(terminal, "\n");
      return fail("no passphrase was given");
    }
    if (key == '\n' || key == '\r') break;
    if (key == kCtrlU) {
      size = 0;
    } else if (key == kDelete || key == kBackspace) {
      size = size_without_last(typed.bytes().first(size));
    } else if (size < typed.bytes().size()) {
      typed.data()[size++] = key;
    }
  }
  show(terminal, "\n");
  return home::Passphrase::from({reinterpret_cast<const char*>(typed.data()), size});
}

Expected<home::Passphrase> ask_new_passphrase(int terminal) {
  ROOMWISE_TRY(home::Passphrase passphrase, ask_passphrase(terminal, "New passphrase"));
  ROOMWISE_TRY(const home::Passphrase again, ask_passphrase(terminal, "The same again"));
  if (!(passphrase == again)) return fail("the two passphrases differ; nothing was changed");
  return passphrase;
}

}  // namespace roomwise::app
