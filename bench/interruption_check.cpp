// Maps a recording again and again, ended at random moments and taken up again, until the map is
// complete, and compares it with one that was never interrupted:
//   interruption_check INTERRUPTIONS RECORDING [SEED]
// Every second end is a kill, the others are Ctrl-C. Prints what happened; exit code 1 where a home
// was damaged, differs, or the program ended otherwise than it was ended.

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "arguments.h"
#include "child_program.h"
#include "roomwise/base/file.h"
#include "roomwise/base/random.h"
#include "roomwise/home/home.h"

namespace {

using namespace roomwise;
namespace fs = std::filesystem;
using std::chrono::duration;

struct Check {
  fs::path recording;
  std::string seed;
  fs::path home = fs::temp_directory_path() / fmt::format("interruption-check-{}.home", getpid());

  [[nodiscard]] bench::ChildProgram map() const {
    const std::string program = bench::sibling_program("roomwise");
    if (has_map()) {
      return bench::ChildProgram(
          {program, "map", recording.string(), "--home", home.string(), "--resume"});
    }
    remove();
    return bench::ChildProgram(
        {program, "map", recording.string(), "--home", home.string(), "--seed", seed});
  }
  // Whether the home knows its recording; before that there is nothing to go on from. A home that
  // cannot be opened counts as one that does: digest() says what is wrong with it.
  [[nodiscard]] bool has_map() const {
    if (!fs::exists(home)) return false;
    const auto opened = home::Home::open(home);
    if (!opened) return true;
    const auto recordings = opened->recordings();
    return !recordings || !recordings->empty();
  }
  // The digest of a sound home; empty, with a word about it, where it is damaged.
  [[nodiscard]] std::string digest() const {
    const auto opened = home::Home::open(home);
    const auto sound = opened ? opened->verify() : tl::unexpected(opened.error());
    if (!sound) {
      fmt::print("DAMAGED: {}\n", sound.error().message);
      return {};
    }
    return opened->content_digest().value_or("");
  }
  void remove() const {
    for (const char* suffix : {"", "-wal", "-shm", "-lock"}) {
      fs::remove(home.string() + suffix);
    }
  }
};

}  // namespace

int main(int argc, char** argv) {
  constexpr std::string_view kUsage = "interruption_check INTERRUPTIONS RECORDING [SEED]";
  if (argc < 3 || argc > 4) {
    fmt::print(stderr, "usage: {}\n", kUsage);
    return 2;
  }
  const auto given = bench::parse_count(argv[1], kUsage);
  const auto seed = argc > 3 ? bench::parse_count(argv[3], kUsage) : Expected<int>(1);
  for (const auto& number : {given, seed}) {
    if (number) continue;
    fmt::print(stderr, "{}\n", number.error().message);
    return 2;
  }
  const int wanted = *given;
  const Check check{argv[2], argc > 3 ? argv[3] : "1"};
  const auto start = std::chrono::steady_clock::now();
  if (check.map().wait() != 0) {
    fmt::print(stderr, "{} cannot be mapped\n", check.recording.string());
    return 1;
  }
  const double whole_s = duration<double>(std::chrono::steady_clock::now() - start).count();
  const std::string expected = check.digest();
  if (expected.empty()) return 1;
  check.remove();

  RandomStream random(std::strtoull(check.seed.c_str(), nullptr, 10), {0x1207});
  int interrupted = 0, maps = 0, faults = 0;
  while (interrupted < wanted) {
    bench::ChildProgram program = check.map();
    // Short against the whole, so that most maps are ended several times.
    std::this_thread::sleep_for(duration<double>(0.5 * whole_s * random.uniform()));
    const int signal = interrupted % 2 == 0 ? SIGKILL : SIGINT;
    program.send(signal);
    const int code = program.wait();
    if (code == 0) {
      ++maps;
      if (check.digest() != expected) {
        fmt::print("DIFFERENT: map {} after {} interruptions\n", maps, interrupted);
        ++faults;
      }
      check.remove();
      continue;
    }
    ++interrupted;
    // The first Ctrl-C of long work ends it with a word about going on; before and after it, it
    // ends the program at once.
    const bool was_interrupted =
        code == 1 && program.output().find("interrupted") != std::string::npos;
    if (code != 128 + signal && !(signal == SIGINT && (was_interrupted || code == 130))) {
      fmt::print("FAILED: exit code {} after signal {}: {}\n", code, signal, program.output());
      ++faults;
    }
    if (check.has_map() && check.digest().empty()) ++faults;
  }
  check.remove();
  fmt::print(
      "{} interruptions, {} maps completed in between, {} faults (an uninterrupted map takes "
      "{:.1f} s)\n",
      interrupted, maps, faults, whole_s);
  return faults == 0 && maps > 0 ? 0 : 1;
}
