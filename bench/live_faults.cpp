// What a wearable says, and how it recovers, when the network, the computer, the disk or a clock
// fails: "roomwise serve" and "roomwise device" as two hosts, each in a network namespace of its
// own, with a recording played as the camera.
//   live_faults HOME RECORDING [--only NAME]
// HOME: with learned rooms. Needs root, the networks that the rooms were learned with
// (ROOMWISE_MODELS), and the programs ip, tc, nft, curl and faketime (packages iproute2, nftables,
// curl, faketime). Prints a line for each fault; exit code 1 where what is asked was not kept: the
// device says what is wrong within 3 s, goes on by itself, and nothing recorded is lost but the
// frame in hand.

#include <fmt/ranges.h>
#include <sys/mount.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>

#include "child_program.h"
#include "roomwise/base/file.h"
#include "timing.h"

namespace roomwise::bench {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr double kMaxUntilSaid_s = 3;
constexpr double kMaxUntilBack_s = 20;
constexpr std::string_view kAddress = "192.0.2.1";  // of the computer (TEST-NET-1, RFC 5737)
constexpr int kPort = 8443;

struct Options {
  fs::path home, recording;
  std::string only;
};

// Ends the benchmark; hosts, folders and programs are taken away on the way out.
[[noreturn]] void give_up(const std::string& why) {
  throw std::runtime_error(why);
}

void must(const std::vector<std::string>& words) {
  const FinishedProgram done = run_to_end(words);
  if (done.exit_code != 0) {
    give_up(fmt::format("'{}' failed: {}", fmt::join(words, " "), done.output));
  }
}

void wait_s(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

// Two hosts with one cable between them.
class TwoHosts {
 public:
  TwoHosts() {
    remove();
    must({"ip", "netns", "add", computer()});
    must({"ip", "netns", "add", device()});
    must({"ip", "link", "add", "rw0", "netns", computer(), "type", "veth", "peer", "name", "rw1",
          "netns", device()});
    set_up(computer(), "rw0", fmt::format("{}/24", kAddress));
    set_up(device(), "rw1", "192.0.2.2/24");
  }
  ~TwoHosts() { remove(); }
  TwoHosts(const TwoHosts&) = delete;
  TwoHosts& operator=(const TwoHosts&) = delete;

  [[nodiscard]] static std::string computer() { return "roomwise-computer"; }
  [[nodiscard]] static std::string device() { return "roomwise-device"; }
  // The command, run on that host.
  [[nodiscard]] static std::vector<std::string> on(const std::string& host,
                                                   std::vector<std::string> words) {
    words.insert(words.begin(), {"ip", "netns", "exec", host});
    return words;
  }

  // Every packet vanishes without a word.
  void cut() {
    must(on(device(), {"nft",
                       "add table inet cut; "
                       "add chain inet cut in { type filter hook input priority 0; policy "
                       "drop; }; add chain inet cut out { type filter hook output priority "
                       "0; policy drop; }"}));
  }
  void mend() { must(on(device(), {"nft", "delete table inet cut"})); }
  void limit(const std::string& rate) {
    for (const auto& [host, end] : {std::pair(computer(), "rw0"), std::pair(device(), "rw1")}) {
      must(on(host, {"tc", "qdisc", "add", "dev", end, "root", "tbf", "rate", rate, "burst", "16kb",
                     "latency", "400ms"}));
    }
  }
  void unlimit() {
    must(on(computer(), {"tc", "qdisc", "del", "dev", "rw0", "root"}));
    must(on(device(), {"tc", "qdisc", "del", "dev", "rw1", "root"}));
  }

 private:
  static void set_up(const std::string& host, const std::string& end, const std::string& address) {
    must({"ip", "-n", host, "addr", "add", address, "dev", end});
    must({"ip", "-n", host, "link", "set", end, "up"});
    must({"ip", "-n", host, "link", "set", "lo", "up"});
  }
  static void remove() {
    (void)run_to_end({"ip", "netns", "del", computer()});
    (void)run_to_end({"ip", "netns", "del", device()});
  }
};

// A clock that a program sees and that can be set: its offset from the true one, in a file
// (faketime(1)). Steady clocks stay as they are.
class WallClock {
 public:
  explicit WallClock(fs::path file) : file_(std::move(file)) { set("+0"); }
  void set(const std::string& offset) const {
    need_done(write_file(file_, std::string_view(offset + "\n")));
  }
  [[nodiscard]] std::vector<std::string> environment() const {
    return {"LD_PRELOAD=" + library(), "FAKETIME_TIMESTAMP_FILE=" + file_.string(),
            "FAKETIME_NO_CACHE=1", "FAKETIME_DONT_FAKE_MONOTONIC=1"};
  }

 private:
  static std::string library() {
    for (const auto& folder : {"/usr/lib/x86_64-linux-gnu/faketime", "/usr/lib/faketime"}) {
      if (fs::exists(fs::path(folder) / "libfaketimeMT.so.1")) {
        return (fs::path(folder) / "libfaketimeMT.so.1").string();
      }
    }
    give_up("libfaketimeMT.so.1 was not found; install the package faketime");
  }
  fs::path file_;
};

// A scratch folder; on a file system of its own of so many MB where one is asked for.
class Folder {
 public:
  explicit Folder(int size_mb = 0)
      : path_(fs::temp_directory_path() / fmt::format("roomwise-faults-{}-{}", getpid(), made_++)),
        is_mounted_(size_mb > 0) {
    fs::create_directories(path_);
    const std::string size = fmt::format("size={}m", size_mb);
    if (is_mounted_ && ::mount("tmpfs", path_.c_str(), "tmpfs", 0, size.c_str()) != 0) {
      give_up("no file system can be mounted: this needs root");
    }
  }
  ~Folder() {
    if (is_mounted_) ::umount2(path_.c_str(), MNT_DETACH);
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  inline static int made_ = 0;
  fs::path path_;
  bool is_mounted_ = false;
};

struct Outcome {
  std::vector<std::string> found;
  std::vector<std::string> faults;

  // A figure that must be there and at most so large.
  void add(const std::string& what, std::optional<double> value_s, double max_s) {
    found.push_back(value_s ? fmt::format("{} {:.1f} s", what, *value_s) : what + " never");
    if (!value_s || *value_s > max_s) faults.push_back(found.back());
  }
  void require(bool kept, const std::string& what) {
    if (!kept) faults.push_back("not so: " + what);
  }
};

// A computer and a device in their homes, paired.
class Scene {
 public:
  // `home` is copied into the folder; empty: a new one is made.
  Scene(const Options& options, const fs::path& home, int disk_mb = 0, bool with_clocks = false)
      : options_(options), folder_(disk_mb), clock_(state_.path() / "clock") {
    if (with_clocks) environment_ = clock_.environment();
    if (!home.empty()) fs::copy_file(home, home_file());
    start_computer();
    code_ = digits_of(computer_->line_with("To pair a device: code "));
    pair_helper(digits_of(computer_->line_with("To pair a helper: code ")));
  }

  [[nodiscard]] fs::path home_file() const { return folder_.path() / "faults.home"; }
  [[nodiscard]] const fs::path& folder() const { return folder_.path(); }
  [[nodiscard]] const WallClock& clock() const { return clock_; }

  // Returns once it serves.
  void start_computer() {
    computer_.emplace(
        TwoHosts::on(TwoHosts::computer(),
                     {sibling_program("roomwise"), "serve", home_file().string(), "--address",
                      std::string(kAddress), "--port", std::to_string(kPort), "--pair", "device"}),
        environment_);
    if (!computer_->line_after(0, "Ctrl-C", now_s() + 60)) {
      give_up(fmt::format("the computer does not serve:\n{}", computer_->output()));
    }
  }
  // A home with a map is ready for questions of places only after a while.
  void wait_until_prepared() {
    for (const double until = now_s() + 180; now_s() < until; wait_s(0.5)) {
      const Json job = ask_computer("GET", "/api/job");
      if (job.value("state", "") == "done" || job.value("state", "") == "none") return;
    }
    give_up("the home was not ready in three minutes");
  }
  void start_device(double rate_hz) {
    std::vector<std::string> words = {sibling_program("roomwise"),
                                      "device",
                                      "--server",
                                      fmt::format("{}:{}", kAddress, kPort),
                                      "--name",
                                      "belt",
                                      "--recording",
                                      options_.recording.string(),
                                      "--rate",
                                      fmt::format("{}", rate_hz),
                                      "--speak",
                                      "text",
                                      "--no-callouts"};
    if (!std::exchange(code_, {}).empty()) words.insert(words.end(), {"--pair", used_code_});
    auto environment = environment_;
    environment.push_back("XDG_CONFIG_HOME=" + state_.path().string());
    device_.emplace(TwoHosts::on(TwoHosts::device(), std::move(words)), std::move(environment));
    if (!device_->line_after(0, "Ready.", now_s() + 20)) {
      give_up(fmt::format("the device does not connect:\n{}{}", device_->output(),
                          computer_->output()));
    }
  }
  [[nodiscard]] ChildProgram& computer() { return *computer_; }
  [[nodiscard]] ChildProgram& device() { return *device_; }

  // Asks where it is; how long it took until one of the words was said. An answer comes with the
  // sound of one ("(answer)", "(unsure)"); nothing is called out without being asked.
  std::optional<double> ask_where(std::vector<std::string> words = {"(answer)", "(unsure)"}) {
    constexpr double kMax_s = 10;
    const double asked = now_s();
    device_->type("w");
    std::optional<double> first;
    for (const std::string& word : words) {
      const auto said = device_->line_after(asked, word, first.value_or(asked + kMax_s));
      if (said && (!first || *said < *first)) first = said;
    }
    return first ? std::optional(*first - asked) : std::nullopt;
  }

  Json ask_computer(const std::string& method, const std::string& path, const Json& body = {}) {
    std::vector<std::string> words = {"curl",       "-sk",
                                      "--max-time", "10",
                                      "-X",         method,
                                      "-H",         "Authorization: Bearer " + token_,
                                      "-H",         "Content-Type: application/json"};
    if (!body.is_null()) words.insert(words.end(), {"-d", body.dump()});
    words.push_back(fmt::format("https://{}:{}{}", kAddress, kPort, path));
    const auto done = run_to_end(TwoHosts::on(TwoHosts::device(), std::move(words)));
    Json answer = Json::parse(done.output, nullptr, false);
    return answer.is_discarded() ? Json({{"error", done.output}}) : answer;
  }
  // Records what the device sends; the folder of the recording.
  fs::path start_recording(const std::string& name) {
    Json device;
    for (const Json& one : ask_computer("GET", "/api/devices").value("devices", Json::array())) {
      if (one.value("name", "") == "belt") device = one.value("device", Json());
    }
    const Json answer =
        ask_computer("POST", "/api/recording", {{"device", device}, {"name", name}});
    if (answer.contains("error")) {
      give_up(fmt::format("no recording: {}", answer.dump()));
    }
    return home_file().string() + ".walks/" + name;
  }

 private:
  static std::string digits_of(const std::string& line) {
    std::string digits;
    for (const char c : line.substr(0, line.find(','))) {
      if (c >= '0' && c <= '9') digits += c;
    }
    return digits;
  }
  void pair_helper(const std::string& code) {
    used_code_ = code_;
    token_ =
        ask_computer("POST", "/api/pair", {{"code", code}, {"name", "helper"}}).value("token", "");
    if (token_.empty()) {
      give_up(fmt::format("no helper could be paired:\n{}", computer_->output()));
    }
  }

  const Options& options_;
  Folder state_;
  Folder folder_;
  WallClock clock_;
  std::vector<std::string> environment_;
  std::string code_, used_code_, token_;
  std::optional<ChildProgram> computer_, device_;
};

// Frames of a recording that is not written any more: all that its list names must be there whole.
std::size_t frames_of(const fs::path& recording, Outcome& outcome) {
  const auto info = run_to_end({sibling_program("roomwise"), "info", recording.string(), "--json"});
  outcome.require(info.exit_code == 0, "the recording can be read: " + info.output);
  std::ifstream list(recording / "rgb.txt");
  std::size_t frames = 0;
  for (std::string line; std::getline(list, line);) {
    if (line.empty() || line.front() == '#') continue;
    ++frames;
    const fs::path picture = recording / line.substr(line.find(' ') + 1);
    std::error_code error;
    outcome.require(fs::file_size(picture, error) > 0 && !error, picture.string() + " is there");
  }
  return frames;
}

std::size_t files_in(const fs::path& folder) {
  std::error_code error;
  std::size_t count = 0;
  for (fs::directory_iterator i(folder, error), end; !error && i != end; i.increment(error)) {
    ++count;
  }
  return count;
}

void add_loss(Scene& scene, double began_s, Outcome& outcome) {
  const auto said = scene.device().line_after(began_s, "connection is lost", began_s + 10);
  outcome.add("said after", said ? std::optional(*said - began_s) : std::nullopt, kMaxUntilSaid_s);
}
// `failed_s`: when it went wrong, `mended_s`: when all was well again.
void add_return(Scene& scene, double failed_s, double mended_s, Outcome& outcome) {
  const auto back = scene.device().line_after(failed_s, "Connected again", mended_s + 60);
  outcome.add("back after", back ? std::optional(std::max(0.0, *back - mended_s)) : std::nullopt,
              kMaxUntilBack_s);
}
void add_return_and_answer(Scene& scene, double failed_s, double mended_s, Outcome& outcome) {
  add_return(scene, failed_s, mended_s, outcome);
  wait_s(1);
  outcome.add("then answers after", scene.ask_where(), kMaxUntilSaid_s);
}

// ---- The faults ----

Outcome silent_network(const Options& options, TwoHosts& hosts) {
  Scene scene(options, options.home);
  scene.wait_until_prepared();
  scene.start_device(3);
  wait_s(5);
  Outcome outcome;
  const double cut = now_s();
  hosts.cut();
  // Somebody who asks again and again sends, and must hear of the loss all the same.
  for (int i = 0; i < 4; ++i) {
    scene.device().type("w");
    wait_s(0.5);
  }
  add_loss(scene, cut, outcome);
  outcome.add("asked later, told so after", scene.ask_where({"connection is lost"}),
              kMaxUntilSaid_s);
  wait_s(30 - (now_s() - cut));
  const double mended = now_s();
  hosts.mend();
  add_return_and_answer(scene, cut, mended, outcome);
  return outcome;
}

Outcome slow_link(const Options& options, TwoHosts& hosts) {
  Scene scene(options, options.home);
  scene.wait_until_prepared();
  hosts.limit("1mbit");
  scene.start_device(5);
  const double began = now_s();
  wait_s(3);
  Outcome outcome;
  std::vector<double> answers_s;
  for (int i = 0; i < 15; ++i) {
    const auto answer = scene.ask_where();
    outcome.require(answer.has_value(), "an answer within 10 s");
    if (answer) answers_s.push_back(*answer);
    wait_s(1.5);
  }
  std::ranges::sort(answers_s);
  if (!answers_s.empty()) {
    outcome.found.push_back(fmt::format("{} answers after {:.2f} s in the median, {:.2f} at most",
                                        answers_s.size(), answers_s[answers_s.size() / 2],
                                        answers_s.back()));
  }
  const auto losses = scene.device().count_after(began, "connection is lost");
  outcome.found.push_back(fmt::format("connection lost {} times", losses));
  outcome.require(losses == 0, "the connection is kept");
  hosts.unlimit();
  scene.device().type("x");
  outcome.require(scene.device().wait() == 0, "the device ends soundly");
  outcome.found.push_back(scene.device().line_with("frames sent"));
  return outcome;
}

Outcome computer_stops(const Options& options, int signal) {
  Scene scene(options, options.home);
  scene.wait_until_prepared();
  scene.start_device(3);
  wait_s(5);
  Outcome outcome;
  const double killed = now_s();
  scene.computer().send(signal);
  add_loss(scene, killed, outcome);
  const int code = scene.computer().wait();
  outcome.require(code == (signal == SIGKILL ? 128 + SIGKILL : 0),
                  fmt::format("the server ends as it was told ({})", code));
  wait_s(5);
  scene.start_computer();
  const double serves = now_s();
  add_return_and_answer(scene, killed, serves, outcome);
  return outcome;
}

Outcome computer_stands_still(const Options& options) {
  Scene scene(options, options.home);
  scene.wait_until_prepared();
  scene.start_device(3);
  wait_s(5);
  Outcome outcome;
  const double stopped = now_s();
  scene.computer().send(SIGSTOP);
  add_loss(scene, stopped, outcome);
  wait_s(5);
  const double goes_on = now_s();
  scene.computer().send(SIGCONT);
  add_return_and_answer(scene, stopped, goes_on, outcome);
  return outcome;
}

Outcome device_is_killed(const Options& options) {
  Scene scene(options, {});
  scene.start_device(5);
  const fs::path recording = scene.start_recording("walk");
  wait_s(5);
  Outcome outcome;
  scene.device().send(SIGKILL);
  scene.device().wait();
  const std::size_t files = files_in(recording / "rgb");
  const double again = now_s();
  scene.start_device(5);
  outcome.add("connected again after", now_s() - again, kMaxUntilSaid_s);
  outcome.require(!scene.ask_computer("GET", "/health").contains("error"), "the server is well");
  scene.ask_computer("POST", "/api/recording/stop");
  wait_s(1);
  scene.computer().send(SIGTERM);
  scene.computer().wait();
  const std::size_t frames = frames_of(recording, outcome);
  outcome.found.push_back(
      fmt::format("{} frames recorded, {} were stored at the kill", frames, files));
  outcome.require(frames >= files, "no stored frame is lost");
  return outcome;
}

Outcome computer_is_killed_recording(const Options& options) {
  Scene scene(options, {});
  scene.start_device(5);
  const fs::path recording = scene.start_recording("walk");
  wait_s(6);
  Outcome outcome;
  const double killed = now_s();
  scene.computer().send(SIGKILL);
  scene.computer().wait();
  add_loss(scene, killed, outcome);
  const std::size_t files = files_in(recording / "rgb");
  const std::size_t frames = frames_of(recording, outcome);
  outcome.found.push_back(fmt::format("{} files of pictures, {} frames listed", files, frames));
  outcome.require(frames + 1 >= files && frames > 10, "all but the frame in hand is kept");
  scene.start_computer();
  const double serves = now_s();
  add_return(scene, killed, serves, outcome);
  return outcome;
}

Outcome full_disk(const Options& options) {
  Scene scene(options, {}, /*disk_mb=*/64);
  scene.start_device(5);
  const fs::path ballast = scene.folder() / "ballast";
  const std::string filling(fs::space(scene.folder()).available - (std::size_t{2} << 20U), 'x');
  need_done(write_file(ballast, std::string_view(filling)));
  const fs::path recording = scene.start_recording("walk");
  Outcome outcome;
  double full = 0;
  for (const double until = now_s() + 120; now_s() < until && full == 0; wait_s(0.02)) {
    if (fs::space(scene.folder()).available < 64 * 1024) full = now_s();
  }
  outcome.require(full > 0, "the disk is full");
  const auto said = scene.device().line_after(full - 1, "recording failed", full + 10);
  outcome.add("said after", said ? std::optional(*said - full) : std::nullopt, kMaxUntilSaid_s);
  wait_s(1);
  outcome.add("then answers after", scene.ask_where(), kMaxUntilSaid_s);
  outcome.require(!scene.ask_computer("GET", "/health").contains("error"), "the server is well");
  const std::size_t frames = frames_of(recording, outcome);
  outcome.require(frames > 10, "what was recorded before is kept");
  const double freed = now_s();
  fs::remove(ballast);
  const auto goes_on = scene.device().line_after(freed, "Recording.", freed + 10);
  outcome.add("with room again, records after",
              goes_on ? std::optional(*goes_on - freed) : std::nullopt, kMaxUntilSaid_s);
  wait_s(3);
  scene.ask_computer("POST", "/api/recording/stop");
  const std::size_t in_all = frames_of(recording, outcome);
  outcome.found.push_back(fmt::format("{} frames kept, {} in the end", frames, in_all));
  outcome.require(in_all > frames, "more frames were recorded");
  return outcome;
}

Outcome clock_jumps(const Options& options) {
  Scene scene(options, options.home, 0, /*with_clocks=*/true);
  scene.wait_until_prepared();
  scene.start_device(3);
  wait_s(5);
  Outcome outcome;
  const double began = now_s();
  for (const auto* offset : {"+3600", "-7200", "+864000", "+0"}) {
    scene.clock().set(offset);
    wait_s(4);
    outcome.add(fmt::format("{} s: answers after", offset), scene.ask_where(), kMaxUntilSaid_s);
  }
  outcome.require(scene.device().count_after(began, "connection is lost") == 0,
                  "the connection is kept");
  outcome.require(scene.device().count_after(began, "did not work") == 0, "no answer is stale");
  return outcome;
}

int run(const Options& options) {
  if (::geteuid() != 0) {
    fmt::print(stderr, "network namespaces and mounts need root\n");
    return 1;
  }
  if (!fs::exists(options.home)) {
    fmt::print(stderr, "{} is not there; make it with roomwise map and rooms learn\n",
               options.home.string());
    return 1;
  }
  TwoHosts hosts;
  const std::vector<std::pair<std::string, std::function<Outcome()>>> faults = {
      {"silent-network", [&] { return silent_network(options, hosts); }},
      {"slow-link", [&] { return slow_link(options, hosts); }},
      {"computer-killed", [&] { return computer_stops(options, SIGKILL); }},
      {"computer-ended", [&] { return computer_stops(options, SIGTERM); }},
      {"computer-stands-still", [&] { return computer_stands_still(options); }},
      {"device-killed", [&] { return device_is_killed(options); }},
      {"computer-killed-recording", [&] { return computer_is_killed_recording(options); }},
      {"full-disk", [&] { return full_disk(options); }},
      {"clock-jumps", [&] { return clock_jumps(options); }},
  };
  bool kept = true;
  for (const auto& [name, try_it] : faults) {
    if (!options.only.empty() && options.only != name) continue;
    const Outcome outcome = try_it();
    kept = kept && outcome.faults.empty();
    fmt::print("{:26} {}\n", name, fmt::join(outcome.found, "; "));
    for (const std::string& fault : outcome.faults) fmt::print("{:26} FAULT: {}\n", "", fault);
    std::fflush(stdout);
  }
  return kept ? 0 : 1;
}

}  // namespace
}  // namespace roomwise::bench

int main(int argc, char** argv) {
  roomwise::bench::Options options;
  CLI::App app("What a wearable says, and how it recovers, when something fails");
  app.add_option("HOME", options.home, "Home with learned rooms; it is copied")->required();
  app.add_option("RECORDING", options.recording, "Played as the device's camera")->required();
  app.add_option("--only", options.only, "One fault alone, by the name that is printed");
  CLI11_PARSE(app, argc, argv);
  try {
    return roomwise::bench::run(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
