#include "device_command.h"

#include <unistd.h>

#include <array>
#include <chrono>
#include <iostream>
#include <memory>
#include <thread>

#include "device_credentials.h"
#include "device_session.h"
#include "live_camera.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

struct DeviceOptions {
  std::string server;
  std::string code;
  std::string name;
  fs::path recording;
  std::string camera;  // openni2, v4l2, ...; empty: none
  fs::path calibration;
  std::optional<double> rate_hz;
  std::string speak = "speech-dispatcher";
  fs::path buttons;
  std::string language = "en";
  std::string distances = "metres";
  double step_m = 0.7;
  bool no_callouts = false;
  OpenRecording open_recording = nullptr;
};

std::string own_host_name() {
  std::array<char, 65> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? std::string(name.data()) : "device";
}

// Says a message to its end: whoever cannot see the terminal waits for it.
void say_now(DeviceVoice& voice, const std::string& message, guide::Sound sound,
             const Interruption& interruption) {
  voice.notice(message, sound, steady_now_ns());
  while (!interruption.interrupted() && voice.step(steady_now_ns()) &&
         !voice.is_silent(steady_now_ns()))
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
}

const char* message_of(service::PairingRefusal refusal) {
  switch (refusal) {
    case service::PairingRefusal::kCode:
      return "device.code_wrong";
    case service::PairingRefusal::kName:
      return "device.name_wrong";
    case service::PairingRefusal::kMustWait:
      return "device.many_codes";
    case service::PairingRefusal::kNone:
      break;
  }
  return "device.connection_lost";
}

// find_pairing(), and says how that went.
Expected<service::ServerCredentials> find_credentials_aloud(const DeviceOptions& options,
                                                            DeviceVoice& voice,
                                                            const Interruption& interruption) {
  const auto say = [&](const std::string& message, guide::Sound sound) {
    say_now(voice, message, sound, interruption);
  };
  ROOMWISE_TRY(const fs::path file, credentials_file());
  auto pairing = find_pairing(file, options.server, options.code, options.name,
                              {.timeout = service::kPairingTimeout, .interruption = &interruption});
  if (!pairing) {
    say(options.code.empty() ? "device.not_paired" : message_of(pairing.error().refusal),
        guide::Sound::kAlert);
    return Unexpected(std::move(pairing).error());
  }
  if (pairing->is_new) say("device.paired", guide::Sound::kBack);
  return std::move(pairing->credentials);
}

// Says it, too, where a part is not there: whoever cannot see the terminal would wait.
template <typename Part>
Expected<Part> aloud(Expected<Part> part, const char* message, DeviceVoice& voice,
                     const Interruption& interruption) {
  if (!part) say_now(voice, message, guide::Sound::kAlert, interruption);
  return part;
}

Expected<std::unique_ptr<DeviceCamera>> open_camera(const DeviceOptions& options) {
  std::unique_ptr<recording::FrameSource> source;
  DeviceCamera::Reopen reopen;
  if (!options.camera.empty()) {
    reopen = [chosen = LiveCamera{options.camera, "", options.calibration}] {
      return open_live_camera(chosen);
    };
    ROOMWISE_TRY(source, reopen());
  } else if (!options.recording.empty()) {
    ROOMWISE_TRY(source, options.open_recording(options.recording));
  } else {
    return nullptr;
  }
  return std::make_unique<DeviceCamera>(std::move(source),
                                        CameraPace{!options.rate_hz, options.rate_hz.value_or(0)},
                                        std::move(reopen));
}

service::Hello hello_of(const DeviceOptions& options, const DeviceCamera* camera) {
  service::Hello hello;
  hello.version = service::kProtocolVersion;
  hello.name = options.name;
  hello.kind = service::DeviceKind::kWearable;
  hello.settings = {
      options.language,
      options.distances == "steps" ? service::Distances::kSteps : service::Distances::kMetres,
      options.step_m, !options.no_callouts};
  if (camera == nullptr) return hello;
  const geometry::PinholeCamera& calibrated = camera->info().camera;
  hello.camera = service::DeviceCamera{calibrated.width, calibrated.height, calibrated, true};
  return hello;
}

Expected<std::unique_ptr<DeviceVoice>> open_voice(const DeviceOptions& options,
                                                  const guide::MessageCatalogue& catalogue) {
  guide::Wording wording;
  wording.catalogue = &catalogue;
  wording.style.language = options.language;
  wording.style.step_m = options.step_m;
  ROOMWISE_RETURN_IF_ERROR(wording.style.validate(catalogue));
  ROOMWISE_TRY(auto speaker, open_speaker(options.speak, steady_now_ns(), std::cout));
  // A file is listened to later: who plays a walk into it sees what is said.
  if (options.speak.starts_with("wav:")) {
    speaker = std::make_unique<ShownSpeaker>(std::cout, std::move(speaker));
  }
  return std::make_unique<DeviceVoice>(std::move(speaker), wording);
}

Expected<Answer> run_device(const DeviceOptions& given, Context& context) {
  catch_interrupts();
  DeviceOptions options = given;
  if (options.name.empty()) options.name = own_host_name();
  const auto catalogue = guide::MessageCatalogue::built_in();
  DeviceParts parts;
  ROOMWISE_TRY(parts.server, service::parse_server_address(options.server));
  ROOMWISE_TRY(parts.voice, open_voice(options, catalogue));
  ROOMWISE_TRY(parts.credentials, find_credentials_aloud(options, *parts.voice, context.progress));
  ROOMWISE_TRY(parts.keys, aloud(DeviceKeys::open(STDIN_FILENO, options.buttons),
                                 "device.buttons_lost", *parts.voice, context.progress));
  ROOMWISE_TRY(parts.camera,
               aloud(open_camera(options), "device.camera_failed", *parts.voice, context.progress));
  parts.hello = hello_of(options, parts.camera.get());
  DeviceSession session(std::move(parts));
  ROOMWISE_RETURN_IF_ERROR(session.run(context.progress));
  const service::LinkCounts& counts = session.counts();
  return Answer{
      fmt::format(
          "{} frames sent, {} passed over for newer ones; {} prompts; the connection was lost {} "
          "times\n",
          counts.sent, counts.replaced, session.prompts(), counts.losses),
      {{"frames_sent", counts.sent},
       {"frames_passed_over", counts.replaced},
       {"prompts", session.prompts()},
       {"losses", counts.losses}}};
}

}  // namespace

void make_device_command(CLI::App& command, Context& context, OpenRecording open_recording) {
  // "roomwise device", or a program of its own.
  const bool is_program = command.get_parent() == nullptr;
  DeviceOptions& options =
      make_command(command, context,
                   fmt::format("{} --server flat.local:8443 --pair 123456 --camera",
                               is_program ? command.get_name() : "roomwise " + command.get_name()),
                   run_device);
  options.open_recording = open_recording;
  command.add_option("--server", options.server, "The home's computer, HOST:PORT")->required();
  command.add_option(
      "--pair", options.code,
      "Code, or the whole address with '#', that the computer shows; needed once: where an "
      "earlier pairing holds, that is used. It is kept in "
      "$XDG_CONFIG_HOME/roomwise/device.json");
  command.add_option("--name", options.name,
                     "Name of this device that helpers see; default: this computer's name");
  auto* recording = command.add_option("--recording", options.recording,
                                       "Folder of a recording, sent as if it were a camera");
  auto* camera =
      command
          .add_flag("--camera{openni2}", options.camera,
                    std::string("The first depth camera that OpenNI 2 finds; --camera=WHICH: ") +
                        kLiveCameras)
          ->excludes(recording);
  add_calibration_option(command, options.calibration)->needs(camera);
  command
      .add_option("--rate", options.rate_hz,
                  "Frames a second of a recording; default: as it was recorded")
      ->check(positive())
      ->needs(recording);
  add_setting(command, "--speak", options.speak,
              "speech-dispatcher, text (lines on standard output), or wav:FILE (a recording "
              "of what would be heard)");
  command.add_option("--buttons", options.buttons,
                     "Input device whose keys 1 to 5 ask too: where, around, the next goal (rooms, "
                     "marked places, the way out, things), repeat, quiet; held for 0.7 s: what "
                     "comes next, blocked, lead me to the goal just named, pause or go on; for "
                     "2 s: end; "
                     "/dev/input/eventN");
  add_setting(command, "--language", options.language, "en, de, es or fr");
  add_setting(command, "--distances", options.distances, "metres or steps",
              CLI::IsMember({"metres", "steps"}));
  add_setting(command, "--step", options.step_m, "Length of a step, m", positive());
  command.add_flag("--no-callouts", options.no_callouts,
                   "Say nothing of a room that is entered without being asked");
}

}  // namespace roomwise::app
