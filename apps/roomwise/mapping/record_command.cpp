#include <unistd.h>

#include <filesystem>
#include <memory>

#include "camera_option.h"
#include "command_run.h"
#include "commands.h"
#include "left_out.h"
#include "live_camera.h"
#include "roomwise/base/calendar_time.h"
#include "roomwise/recording/damage_tolerant_source.h"
#include "roomwise/recording/inertial_file.h"
#include "roomwise/recording/open_recording.h"
#include "roomwise/recording/read_ahead_source.h"
#include "roomwise/recording/room_labels.h"
#include "roomwise/recording/tum_writer.h"
#include "skip_damaged.h"
#include "typed_room.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

struct RecordOptions {
  std::string source;
  fs::path output;
  std::string camera;  // preset or file; empty: what the source says
  fs::path calibration;
  std::string room;
  std::optional<std::uint64_t> frames;
  std::optional<double> seconds;
  bool skip_damaged = false;
};

Expected<std::unique_ptr<recording::FrameSource>> open_source(const RecordOptions& options,
                                                              Context& context) {
  if (is_live_camera(options.source)) {
    return open_live_camera({options.source, options.camera, options.calibration});
  }
  if (!options.calibration.empty()) {
    return fail("--calibration is for v4l2; a recording says itself, or by --camera");
  }
  ROOMWISE_TRY(const auto camera, given_camera(options.camera));
  ROOMWISE_TRY(auto source, recording::open_recording(options.source, {.camera = camera}));
  for (const std::string& note : source->notes()) context.progress.note(note);
  if (!options.skip_damaged && !source->damaged().empty()) {  // before a folder is made
    return fail("{}{}", source->damaged().front().why, kNamingSkipDamaged);
  }
  return std::unique_ptr<recording::FrameSource>(std::move(source));
}

// Which room the frames show: what the user types, after --room, after what the copied recording's
// own rooms.txt says.
class CurrentRoom {
 public:
  static Expected<CurrentRoom> start(const RecordOptions& options) {
    CurrentRoom current;
    if (!options.room.empty()) {
      ROOMWISE_RETURN_IF_ERROR(recording::validate_room_name(options.room));
      current.room_ = options.room;
    }
    const fs::path labels = fs::path(options.source) / "rooms.txt";
    if (options.room.empty() && !is_live_camera(options.source) && fs::exists(labels)) {
      ROOMWISE_TRY(current.labels_, recording::RoomLabels::read(labels));
    }
    return current;
  }

  std::optional<std::string> at(std::uint64_t frame, TerminalProgress& progress) {
    if (typed_.take(room_, progress)) labels_.reset();
    if (!labels_) return room_;
    const recording::RoomRange* range = labels_->find(frame);
    return range == nullptr ? std::nullopt : std::optional(range->room);
  }

 private:
  // Only a person at a terminal types rooms; a pipe or a file on standard input is left alone.
  TypedRoom typed_{::isatty(STDIN_FILENO) == 1 ? STDIN_FILENO : -1};
  std::optional<std::string> room_;
  std::optional<recording::RoomLabels> labels_;
};

// The number of frames to come, as far as it can be known.
std::optional<std::uint64_t> expected_frames(const RecordOptions& options,
                                             std::optional<std::uint64_t> in_source) {
  if (!options.frames || !in_source) return options.frames ? options.frames : in_source;
  return std::min(*options.frames, *in_source);
}

// What brings a camera's stamps to the calendar's time: its own clock begins with itself. Those of
// a recording stay.
TimestampNs to_calendar_ns(const recording::FrameSource& source, TimestampNs first_ns) {
  const bool is_live_camera = !source.info().frames_remaining;
  return is_live_camera ? unix_now_ns() - first_ns : 0;
}

Expected<void> copy_frames(recording::FrameSource& source, recording::TumWriter& writer,
                           const RecordOptions& options, CurrentRoom& current,
                           TerminalProgress& progress) {
  std::optional<TimestampNs> first_ns;
  TimestampNs offset_ns = 0;
  while (!progress.interrupted() && writer.frames_written() != options.frames) {
    ROOMWISE_TRY(std::optional<image::RgbdFrame> frame, source.next());
    if (!frame) break;
    if (!first_ns) {
      first_ns = frame->timestamp_ns;
      offset_ns = to_calendar_ns(source, *first_ns);
    }
    const double elapsed_s = static_cast<double>(frame->timestamp_ns - *first_ns) * kSecondsPerNs;
    if (options.seconds && elapsed_s > *options.seconds) break;
    const std::optional<std::string> room = current.at(frame->index, progress);
    ROOMWISE_RETURN_IF_ERROR(writer.name_room(room));
    frame->timestamp_ns += offset_ns;
    ROOMWISE_RETURN_IF_ERROR(writer.write(*frame));
    progress.advance(writer.frames_written(), room ? "room " + *room : "");
  }
  return {};
}

// Nor is what an inertial sensor felt in the frames.
Expected<void> copy_inertial(const recording::FrameSource& source, const RecordOptions& options) {
  if (is_live_camera(options.source)) return {};
  const auto& copied = dynamic_cast<const recording::Recording&>(source);
  if (copied.inertial().empty()) return {};
  return recording::write_inertial(options.output, copied.inertial(), "of " + source.info().name);
}

// A copy of a recording keeps what `eval trajectory --truth` takes of the recording itself: its
// ground truth, else poses that were reconstructed from its pictures afterwards. The device's own
// motion is kept with the frames.
Expected<void> copy_ground_truth(const recording::FrameSource& source,
                                 const RecordOptions& options) {
  if (is_live_camera(options.source)) return {};
  const fs::path truth = fs::path(options.source) / "groundtruth.txt";
  if (fs::exists(truth)) {
    std::error_code error;
    fs::copy_file(truth, options.output / "groundtruth.txt", error);
    if (error) return fail("{}: cannot be copied: {}", truth.string(), error.message());
    return {};
  }
  const auto& copied = dynamic_cast<const recording::Recording&>(source);
  if (copied.has_device_motion() || copied.device_poses().empty()) return {};
  return recording::write_trajectory(options.output / "groundtruth.txt", copied.device_poses());
}

Expected<Answer> run(const RecordOptions& options, Context& context) {
  ROOMWISE_TRY(const std::unique_ptr<recording::FrameSource> source, open_source(options, context));
  warn_of_camera(source->info().camera, context);
  ROOMWISE_TRY(CurrentRoom current, CurrentRoom::start(options));  // before a folder is made
  ROOMWISE_TRY(const std::unique_ptr<recording::TumWriter> writer,
               recording::TumWriter::create(options.output, source->info().camera));
  context.progress.begin("recording", expected_frames(options, source->info().frames_remaining));
  // What was recorded until an error is kept: the writer is closed in any case.
  const bool is_live = is_live_camera(options.source);
  CommandRun threads(context);
  std::optional<recording::ReadAheadSource> ahead;
  if (auto* const copied = dynamic_cast<recording::Recording*>(source.get())) {
    ahead.emplace(*copied, threads.pool, &recording::encode_images);
  }
  recording::FrameSource& read = ahead ? *ahead : *source;
  recording::DamageTolerantSource frames(read, options.skip_damaged && !is_live);
  Expected<void> copied = copy_frames(frames, *writer, options, current, context.progress);
  if (!copied && frames.is_stopped() && !is_live) {
    copied.error().message += kNamingSkipDamaged;
  }
  context.progress.end();
  ROOMWISE_RETURN_IF_ERROR(writer->close());
  ROOMWISE_RETURN_IF_ERROR(copied);
  ROOMWISE_RETURN_IF_ERROR(copy_inertial(*source, options));
  ROOMWISE_RETURN_IF_ERROR(copy_ground_truth(*source, options));

  const std::uint64_t lost = source->info().lost_frames;
  const image::PersonalData& left_out = source->info().personal_data;
  return Answer{fmt::format("recorded {} frames from {} to {}{}\n{}", writer->frames_written(),
                            source->info().name, options.output.string(),
                            lost == 0 ? "" : fmt::format("; {} more were lost on the way", lost),
                            left_out.any() ? "left out: " + left_out_text(left_out) + "\n" : "") +
                    damage_text(frames.damage(), "frames that cannot be read"),
                {{"frames", writer->frames_written()},
                 {"lost_frames", lost},
                 {"left_out", left_out_json(left_out)},
                 {"damaged", frames.damage()},
                 {"source", source->info().name},
                 {"output", options.output.string()}}};
}

}  // namespace

void add_record_command(CLI::App& app, Context& context) {
  const auto [command, options] = add_command<RecordOptions>(
      app, context, "record",
      "Record from a depth camera, or copy a recording, to a folder in TUM's format.\n"
      "On a terminal, type a room's name and Enter when you walk into it (Enter alone: no room); "
      "Ctrl-C ends the recording.",
      "roomwise record --source openni2 -o walk --room corridor", run);
  command
      ->add_option("--source", options.source,
                   std::string(kLiveCameras) + ", or a recording of any kind that is read")
      ->required();
  command->add_option("-o,--output", options.output, "Folder to write; new or empty")->required();
  command->add_option("--room", options.room, "The room that the recording starts in");
  add_camera_option(*command, options.camera, "as the source says");
  add_calibration_option(*command, options.calibration);
  command->add_flag(
      kSkipDamaged, options.skip_damaged,
      "Leave out frames of a recording that cannot be read, and name them; without it "
      "the first such ends the copy");
  command->add_option("--frames", options.frames, "Stop after this many frames")->check(positive());
  command->add_option("--seconds", options.seconds, "Stop after this many seconds of the recording")
      ->check(not_negative());
}

}  // namespace roomwise::app
