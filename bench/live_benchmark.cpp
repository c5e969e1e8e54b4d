// What a device waits for: devices send the frames of a recording over TLS on loopback to a home
// that is open for live use, and each asks once a second where it is.
//
// A device sends as the protocol says: its newest frame, when the last was acknowledged. Printed
// for every part of the run: the time from a question to its answer, the age of the picture that
// the answer rests on, and the time until espeak-ng has made sound of its words (the tone before
// them needs none), each as median, 95 % and most; frames looked at and dropped of each device;
// processor time a frame; resident memory. With --led each device is led meanwhile, to one goal of
// the home after the other.
//
// With --phone a device is a phone's page: its frames are upright pictures without depth of a
// camera that nobody calibrated. Then it is printed, too, when a place was first known, and with it
// the focal length.
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <filesystem>
#include <mutex>
#include <opencv2/core/utility.hpp>
#include <thread>

#include "resident_memory.h"
#include "roomwise/evaluation/statistics/quantile.h"
#include "roomwise/image/codec.h"
#include "roomwise/image/resample.h"
#include "roomwise/live/routes/home_routes.h"
#include "roomwise/network/vision/onnx_classifier.h"
#include "roomwise/recording/open_recording.h"
#include "roomwise/service/client/client.h"
#include "roomwise/speech/espeak.h"
#include "timing.h"

namespace roomwise::bench {
namespace {

namespace fs = std::filesystem;
using SteadyClock = std::chrono::steady_clock;

struct Options {
  fs::path home, recording;
  std::vector<fs::path> networks;
  std::size_t devices = 1;
  std::size_t frames = 1000;
  std::size_t frame_workers = ThreadPool::default_size();
  double rate_hz = 10;
  bool depth = false;
  bool phone = false;
  bool led = false;
};

constexpr int kPhoneWidth = 480, kPhoneHeight = 640;  // px

struct EncodedFrame {
  Bytes color, depth;
};

// What one device lived through.
struct Experience {
  std::vector<double> answer_ms;         // from the question to the first prompt
  std::vector<double> age_ms;            // of the picture that it rests on, at the answer
  std::vector<double> words_ms;          // from the question until its words are sound
  std::vector<double> seen_ms;           // from a frame that is sent until it was looked at
  std::optional<double> first_place_ms;  // from the first frame until a place was known
  std::size_t looked_at_before_place = 0;
  std::size_t stale = 0;  // answers that came after they were valid
  std::size_t unanswered = 0;
  std::size_t sent = 0;
  std::size_t looked_at = 0;
  std::uint64_t dropped_by_computer = 0;
  std::size_t walks = 0;    // that it was led on
  std::size_t prompts = 0;  // that it was led by
};

class BenchDevice {
 public:
  BenchDevice(const Options& options, const recording::SourceInfo& info,
              std::span<const EncodedFrame> frames, const service::ServerAddress& server,
              const service::ServerCredentials& credentials)
      : options_(options),
        frames_(frames),
        connection_(need(service::ServerConnection::open(server, credentials))) {
    service::Hello hello;
    hello.version = service::kProtocolVersion;
    hello.name = "bench";
    hello.kind = options.phone ? service::DeviceKind::kPhone : service::DeviceKind::kWearable;
    hello.camera = options.phone ? service::DeviceCamera{kPhoneWidth, kPhoneHeight}
                                 : service::DeviceCamera{info.camera.width, info.camera.height,
                                                         info.camera, options.depth};
    need_done(connection_->send_text(write(service::DeviceMessage(hello))));
  }

  // Sends frames and asks until `count` frames' time has passed; `first` shifts where in the
  // recording it begins.
  Experience run(std::size_t count, std::size_t first) {
    Experience lived;
    const auto begin = SteadyClock::now();
    const double period_ms = 1000 / options_.rate_hz;
    const double end_ms = static_cast<double>(count) * period_ms;
    double next_ask_ms = 500;
    std::int64_t next_frame = 0;  // by its time
    bool under_way = false;
    std::map<std::int64_t, double> asked;  // id -> when
    std::int64_t id = 0;
    const auto now_ms = [&] {
      return std::chrono::duration<double, std::milli>(SteadyClock::now() - begin).count();
    };
    while (now_ms() < end_ms + 1500) {
      const double now = now_ms();
      const auto due = static_cast<std::int64_t>(now / period_ms);
      if (!under_way && due >= next_frame && now < end_ms) {
        const EncodedFrame& frame =
            frames_[(first + static_cast<std::size_t>(due)) % frames_.size()];
        need_done(connection_->send_binary(
            write(service::FrameMessage{now, frame.color,
                                        options_.depth ? std::span<const std::uint8_t>(frame.depth)
                                                       : std::span<const std::uint8_t>()})));
        next_frame = due + 1;
        under_way = true;
        ++lived.sent;
      }
      if (now >= next_ask_ms && now < end_ms) {
        asked[++id] = now;
        need_done(connection_->send_text(write(
            service::DeviceMessage(service::Ask{id, now, service::Question::kWhereAmI, ""}))));
        next_ask_ms += 1000;
      }
      const auto message = need(connection_->receive(std::chrono::milliseconds(2)));
      if (!message || !message->is_text) continue;
      const auto read = need(service::read_home_message(
          {reinterpret_cast<const char*>(message->bytes.data()), message->bytes.size()}));
      if (const auto* arrived = std::get_if<service::FrameArrived>(&read)) {
        under_way = false;
        lived.dropped_by_computer = arrived->dropped;
      } else if (const auto* welcome = std::get_if<service::Welcome>(&read)) {
        rooms_ = welcome->rooms;
      } else if (const auto* seen = std::get_if<service::Seen>(&read)) {
        ++lived.looked_at;
        lived.seen_ms.push_back(now_ms() - seen->t_ms);
        if (seen->position && !lived.first_place_ms) lived.first_place_ms = now_ms();
        if (!lived.first_place_ms) ++lived.looked_at_before_place;
        const bool may_be_led = options_.led && !rooms_.empty() && now < end_ms;
        if (may_be_led && !std::exchange(is_led_, true)) {
          ask_to_be_led(kFirstGoal + static_cast<std::int64_t>(led_to_), now);
          ++lived.walks;
        }
      } else if (const auto* prompt = std::get_if<service::PromptMessage>(&read)) {
        if (prompt->replace_key == "guide") {
          ++lived.prompts;
          is_led_ = is_led_ && !ends_walk(prompt->message_id);
        }
        const auto question = asked.find(prompt->answer_to.value_or(-1));
        if (question == asked.end()) continue;
        const double came = now_ms();
        lived.answer_ms.push_back(came - question->second);
        if (prompt->based_on_t_ms) lived.age_ms.push_back(came - *prompt->based_on_t_ms);
        if (came > prompt->valid_until_t_ms) ++lived.stale;
        (void)need(speech::synthesize(prompt->text, prompt->language, 175));
        lived.words_ms.push_back(now_ms() - question->second);
        asked.erase(question);
      }
    }
    lived.unanswered = asked.size();
    return lived;
  }

 private:
  static constexpr std::int64_t kFirstGoal = 1'000'000;  // ids that no other question has

  void ask_to_be_led(std::int64_t id, double now_ms) {
    service::Ask ask{id, now_ms, service::Question::kTakeMeTo, rooms_[led_to_++ % rooms_.size()]};
    ask.is_room = true;
    need_done(connection_->send_text(write(service::DeviceMessage(ask))));
  }
  static bool ends_walk(std::string_view message) {
    return message.starts_with("guide.there_") || message == "guide.near_end" ||
           message == "guide.ended" || message == "guide.room_next";
  }

  const Options& options_;
  std::span<const EncodedFrame> frames_;
  std::unique_ptr<service::ServerConnection> connection_;
  std::vector<std::string> rooms_;  // of the home
  std::size_t led_to_ = 0;
  bool is_led_ = false;
};

// What the phone's page would send of the middle of such a picture.
Bytes upright_picture(const Bytes& color) {
  constexpr int kQuality = 80;
  const image::ColorImage whole = need(image::decode_color(color));
  const double width = whole.height() * (1.0 * kPhoneWidth / kPhoneHeight);
  const double left = 0.5 * (whole.width() - width);
  return image::encode_jpeg(image::resize(whole, {left, 0, left + width, 1.0 * whole.height()},
                                          kPhoneWidth, kPhoneHeight),
                            kQuality);
}

std::vector<EncodedFrame> read_frames(recording::FrameSource& source, bool phone) {
  constexpr std::size_t kMax = 400;
  std::vector<EncodedFrame> frames;
  while (frames.size() < kMax) {
    auto frame = need(source.next());
    if (!frame) break;
    if (phone) {
      frames.push_back({upright_picture(frame->encoded_color), {}});
    } else {
      frames.push_back({std::move(frame->encoded_color), std::move(frame->encoded_depth)});
    }
  }
  return frames;
}

std::string spread(std::vector<double> values) {
  if (values.empty()) return "-";
  std::ranges::sort(values);
  return fmt::format("{:.0f} / {:.0f} / {:.0f}", evaluation::quantile(values, 0.5),
                     evaluation::quantile(values, 0.95), values.back());
}

void print(const std::vector<Experience>& devices, std::string_view part, double cpu,
           double max_mb) {
  Experience all;
  std::vector<std::size_t> looked_at;
  for (const Experience& one : devices) {
    all.answer_ms.insert(all.answer_ms.end(), one.answer_ms.begin(), one.answer_ms.end());
    all.age_ms.insert(all.age_ms.end(), one.age_ms.begin(), one.age_ms.end());
    all.words_ms.insert(all.words_ms.end(), one.words_ms.begin(), one.words_ms.end());
    all.seen_ms.insert(all.seen_ms.end(), one.seen_ms.begin(), one.seen_ms.end());
    all.stale += one.stale;
    all.unanswered += one.unanswered;
    all.sent += one.sent;
    all.looked_at += one.looked_at;
    all.walks += one.walks;
    all.prompts += one.prompts;
    looked_at.push_back(one.looked_at);
  }
  const auto within = std::ranges::count_if(all.age_ms, [](double age) { return age <= 400; });
  fmt::print(
      "{}: {} questions, answered after {} ms, sound of the words after {} ms, by a picture {} ms "
      "old ({:.1f} % within 400), {} "
      "stale, {} unanswered; frames sent {}, looked at {} ({}), each after {} ms; {:.0f} CPU-ms a "
      "look; {:.0f} MB; "
      "led on {} walks "
      "by {} prompts\n",
      part, all.answer_ms.size(), spread(all.answer_ms), spread(all.words_ms), spread(all.age_ms),
      100.0 * static_cast<double>(within) /
          static_cast<double>(std::max<std::size_t>(1, all.age_ms.size())),
      all.stale, all.unanswered, all.sent, all.looked_at, fmt::join(looked_at, " "),
      spread(all.seen_ms), cpu / static_cast<double>(std::max<std::size_t>(1, all.looked_at)),
      max_mb, all.walks, all.prompts);
  for (const Experience& one : devices) {
    if (!one.first_place_ms) continue;
    fmt::print("  its first place {:.0f} ms after the first frame, {} looked at before\n",
               *one.first_place_ms, one.looked_at_before_place);
  }
  std::fflush(stdout);
}

void run(const Options& options) {
  cv::setNumThreads(1);
  pipeline::Networks networks;
  for (const fs::path& file : options.networks) {
    networks.push_back(need(network::OnnxClassifier::load(file)));
  }
  const objects::ObjectFinders finders;
  live::LiveHomeOptions live_options;
  live_options.threads = ThreadPool::default_size();
  live_options.frame_workers = options.frame_workers;
  const auto home = need(live::LiveHome::open(options.home, networks, finders, live_options));
  home->jobs().wait();
  fmt::print("home: {}; rooms {}; places {}\n", home->jobs().state()->text,
             home->view()->recognizer ? "learned" : home->view()->why_no_recognizer,
             home->view()->map ? "known" : "not known");

  const fs::path access_folder =
      fs::temp_directory_path() / fmt::format("roomwise-live-benchmark-{}", ::getpid());
  service::ServerOptions server_options;
  server_options.session_threads = live_options.threads;  // as serve has it
  server_options.certificate =
      need(service::own_certificate(access_folder, {"127.0.0.1"}, service::Now::read().unix_s));
  const std::string fingerprint = server_options.certificate.fingerprint;
  const auto access = need(service::AccessRegister::open(access_folder, fingerprint));
  const auto server = need(service::Server::start(
      std::move(server_options), service::Router(live::home_routes(*home)), *access, *home));

  const auto source = need(recording::open_recording(options.recording, {}));
  const std::vector<EncodedFrame> frames = read_frames(*source, options.phone);
  std::vector<std::unique_ptr<BenchDevice>> devices;
  for (std::size_t i = 0; i < options.devices; ++i) {
    const auto pairing = need(access->pair_here(service::Role::kDevice, fmt::format("bench {}", i),
                                                service::Now::read()));
    devices.push_back(std::make_unique<BenchDevice>(
        options, source->info(), frames, service::ServerAddress{"127.0.0.1", server->port()},
        service::ServerCredentials{fingerprint, pairing.token}));
  }
  constexpr std::size_t kPart = 1000;
  for (std::size_t done = 0; done < options.frames; done += kPart) {
    const std::size_t count = std::min(kPart, options.frames - done);
    std::vector<Experience> lived(options.devices);
    const double cpu_before = cpu_ms();
    std::vector<std::thread> threads;
    for (std::size_t i = 0; i < options.devices; ++i) {
      threads.emplace_back([&, i] { lived[i] = devices[i]->run(count, done + 37 * i); });
    }
    for (std::thread& thread : threads) thread.join();
    print(lived, fmt::format("frames {} to {}", done, done + count - 1), cpu_ms() - cpu_before,
          resident_mb());
  }
  devices.clear();
  server->stop();
  std::error_code ignored;
  fs::remove_all(access_folder, ignored);
}

}  // namespace
}  // namespace roomwise::bench

int main(int argc, char** argv) {
  using namespace roomwise::bench;
  Options options;
  CLI::App app("What a device waits for that asks a home over TLS on loopback");
  app.add_option("HOME", options.home, "Home with learned rooms")->required();
  app.add_option("RECORDING", options.recording, "Whose frames are sent, over and over")
      ->required();
  app.add_option("NETWORK", options.networks,
                 "ONNX files; the one that the rooms were learned with")
      ->required();
  app.add_option("--devices", options.devices)->check(CLI::Range(1, 64))->capture_default_str();
  app.add_option("--frames", options.frames, "Frames' time of each device")->capture_default_str();
  app.add_option("--rate", options.rate_hz, "Frames a second")
      ->check(CLI::Range(0.1, 100.0))
      ->capture_default_str();
  auto* const depth = app.add_flag("--depth", options.depth, "Send depth too");
  app.add_flag("--phone", options.phone,
               "Send upright pictures without depth, of a camera that nobody calibrated")
      ->excludes(depth);
  app.add_flag("--led", options.led, "Each device is led from room to room meanwhile");
  app.add_option("--looking-threads", options.frame_workers,
                 "That look at devices' frames; default: as serve, all processors")
      ->check(CLI::Range(1, 64));
  CLI11_PARSE(app, argc, argv);
  run(options);
  return 0;
}
