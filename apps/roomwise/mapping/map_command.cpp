#include <filesystem>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>

#include "camera_option.h"
#include "command_run.h"
#include "commands.h"
#include "left_out.h"
#include "networks.h"
#include "open_home.h"
#include "readout.h"
#include "roomwise/base/shell_word.h"
#include "roomwise/pipeline/mapping/map_recording.h"
#include "roomwise/pipeline/objects/own_things.h"
#include "roomwise/pipeline/rooms/room_learning.h"
#include "roomwise/pipeline/rooms/walk_into_home.h"
#include "roomwise/pipeline/stored/lost_pictures.h"
#include "roomwise/pipeline/stored/stored_map.h"
#include "roomwise/recording/damage_tolerant_source.h"
#include "roomwise/recording/open_recording.h"
#include "skip_damaged.h"
#include "things/history_words.h"
#include "things/thing_places.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

struct MapOptions {
  fs::path recording;
  fs::path home;
  bool resume = false;
  std::string camera;
  std::string features = "surf";
  std::string method = "combined";
  bool no_bundle_adjustment = false;
  bool no_upright = false;
  bool no_device_motion = false;
  bool no_keyframe_culling = false;
  std::optional<int> loop_random, loop_similar;  // default: the method's own
  std::optional<double> reuse;                   // likewise
  std::size_t working_set_mb = 128;
  pipeline::MapSettings settings;
  NetworkOptions networks;
  bool no_networks = false;
  bool skip_damaged = false;
  fs::path trajectory;
  std::function<std::vector<std::string>()> given_settings;  // names of options that say how to map
};

Expected<home::Home> make_or_open_home(const MapOptions& options, const Context& context) {
  ROOMWISE_TRY(const home::OpenOptions open, open_options(context));
  ROOMWISE_TRY(home::Home home, pipeline::make_or_open_home({options.home, options.recording, open,
                                                             options.resume, "--resume"}));
  ROOMWISE_TRY(const auto recordings, home.recordings());
  const std::vector<std::string> given = options.given_settings();
  if (!recordings.empty() && !given.empty()) {
    return fail("{}: holds a map, and a further walk is mapped as that was; leave out {}",
                options.home.string(), fmt::join(given, ", "));
  }
  return home;
}

// Those that the options ask for.
Expected<pipeline::MapSettings> new_settings(const MapOptions& options) {
  pipeline::MapSettings settings = options.settings;
  ROOMWISE_TRY(settings.features, features::parse_feature_kind(options.features));
  ROOMWISE_TRY(settings.mapper.method, mapping::parse_mapping_method(options.method));
  settings.bundle_adjustment = !options.no_bundle_adjustment;
  settings.refinement.uses_gravity = !options.no_upright;
  settings.keyframe_culling = !options.no_keyframe_culling;
  settings.mapper.device_motion = !options.no_device_motion;
  settings.mapper.loops = mapping::MapperOptions::of(settings.mapper.method).loops;
  settings.mapper.loops.neighbors = options.settings.mapper.loops.neighbors;
  settings.mapper.loops.random = options.loop_random.value_or(settings.mapper.loops.random);
  settings.mapper.loops.similar = options.loop_similar.value_or(settings.mapper.loops.similar);
  settings.mapper.reuse = mapping::MapperOptions::of(settings.mapper.method).reuse;
  settings.mapper.reuse.max_motion_ratio =
      options.reuse.value_or(settings.mapper.reuse.max_motion_ratio);
  ROOMWISE_RETURN_IF_ERROR(settings.validate());
  return settings;
}

// The settings of a home that is gone on with are its own.
Expected<pipeline::MapSettings> choose_settings(const MapOptions& options, std::uint64_t seed,
                                                const home::Home& home) {
  ROOMWISE_TRY(const auto stored, pipeline::stored_map_settings(home));
  if (stored) return *stored;
  ROOMWISE_TRY(pipeline::MapSettings settings, new_settings(options));
  settings.mapper.seed = seed;
  return settings;
}

Expected<std::unique_ptr<recording::Recording>> open_recording(const MapOptions& options,
                                                               const home::Home& home) {
  recording::RecordingOptions how;
  ROOMWISE_TRY(const auto stored, home.recordings());
  ROOMWISE_TRY(how.camera, given_camera(options.camera));
  if (!how.camera && options.resume && !stored.empty()) how.camera = stored.back().recording.camera;
  return recording::open_recording(options.recording, how);
}

// A recording that says its rooms itself needs no --labels later.
Expected<std::optional<recording::RoomLabels>> rooms_of_recording(const fs::path& recording) {
  const fs::path file = recording / "rooms.txt";
  if (!fs::exists(file)) return std::nullopt;
  ROOMWISE_TRY(recording::RoomLabels labels, recording::RoomLabels::read(file));
  return labels;
}

// Of the device's own motion, where it tells it.
std::string motion_text(const pipeline::MapSummary& summary) {
  if (summary.with_device_motion == 0 && summary.felt_up == 0) return "";
  std::string text = "device      ";
  if (summary.with_device_motion == 0) {
    text += fmt::format("feels up at {} frames\n", summary.felt_up);
  } else if (summary.is_by_inertial_sensor) {
    text += fmt::format("feels its turns at {} frames, up at {}; {} placed by turns alone\n",
                        summary.with_device_motion, summary.felt_up, summary.motion_alone);
  } else {
    text += fmt::format("tells its motion at {} frames; {} placed by it alone\n",
                        summary.with_device_motion, summary.motion_alone);
  }
  if (summary.motion_dropped > 0) {
    text += fmt::format(
        "            {} dropped for {} of {} frames: {}\n",
        summary.is_by_inertial_sensor ? "its turns were" : "the device's own motion was",
        summary.motion_dropped, summary.with_device_motion,
        summary.is_by_inertial_sensor ? "pictures say otherwise" : "it jumped");
  }
  if (summary.contradicted_gravity > 0) {
    text += fmt::format(
        "            up as it is felt was dropped at {} key-frames: level surfaces say otherwise\n",
        summary.contradicted_gravity);
  }
  return text;
}

// Of what a further walk is to the map.
std::string walks_text(const pipeline::MapSummary& summary) {
  if (summary.walks < 2) return "";
  return fmt::format(
      "walks       {}; this one {}\n{}", summary.walks,
      summary.is_joined ? "has joined the map"
                        : "shows too little that the map knows: it stays a piece of its own until "
                          "a later walk joins the two",
      summary.culled == 0 ? ""
                          : fmt::format("culled      {} key-frames of the walk before, whose views "
                                        "the walks before it have in the same light\n",
                                        summary.culled));
}

// Where the pictures surely fit another focal length than the camera's.
std::string focal_length_text(const pipeline::MapSummary& summary,
                              const geometry::PinholeCamera& camera) {
  const auto& fit = summary.focal_length;
  if (!fit || !fit->contradicts()) return "";
  return fmt::format(
      "camera      its focal length is said to be {:.0f} px, and the pictures fit about {:.0f} px "
      "better ({:.0f} to {:.0f}): is it this camera's?\n",
      camera.fx, fit->ratio * camera.fx, fit->low() * camera.fx, fit->high() * camera.fx);
}

Json focal_length_json(const pipeline::MapSummary& summary, const geometry::PinholeCamera& camera) {
  const auto& fit = summary.focal_length;
  if (!fit) return nullptr;
  return {{"fits_px", fit->ratio * camera.fx},
          {"low_px", fit->low() * camera.fx},
          {"high_px", fit->high() * camera.fx},
          {"named_px", camera.fx},
          {"contradicts", fit->contradicts()}};
}

std::string to_text(const pipeline::MapSummary& summary, const std::vector<std::string>& networks,
                    const std::vector<std::string>& detectors) {
  std::string text = fmt::format(
      "frames      {} of {} have a place on the map\n"
      "key-frames  {}\n"
      "edges       {} ({} contradicted the others and were left out)\n"
      "returns     {} to a place seen more than ten key-frames before\n"
      "pieces      {}\n"
      "pose graph  F {:.6g} -> {:.6g}\n",
      summary.placed, summary.frames, summary.keyframes, summary.edges, summary.rejected_edges,
      summary.loops, summary.components, summary.graph_error_before, summary.graph_error_after);
  text += walks_text(summary);
  text += motion_text(summary);
  if (summary.landmarks > 0) {
    text += fmt::format("landmarks   {}, seen {} times; rolling shutter {}\n", summary.landmarks,
                        summary.landmark_views, readout_text(summary.readout_s));
  }
  text +=
      networks.empty()
          ? "objects     none: no network was given, nothing can be named; give --network FILE\n"
          : fmt::format("objects     {} ({} by the paper's rules)\nnetworks    {}\n",
                        summary.instances, summary.objects, fmt::join(networks, ", "));
  if (!detectors.empty()) text += fmt::format("detectors   {}\n", fmt::join(detectors, ", "));
  return text;
}

// What the walk changed of what the walks before it had shown.
Expected<void> add_changes(const home::Home& home, Context& context, Answer& answer) {
  answer.json["changes"] = Json::array();
  ROOMWISE_TRY(const auto recordings, home.recordings());
  if (recordings.size() < 2) return {};
  ROOMWISE_TRY(HistoryWords words, HistoryWords::of(home));
  const home::RecordingId walk = recordings.back().id;
  ROOMWISE_TRY(ThingPlaces places, ThingPlaces::read(home));
  if (!words.history().changes_by(walk).empty()) {
    ROOMWISE_RETURN_IF_ERROR(places.find_layout(home, context));
  }
  words.place_by([&](const pipeline::HomeThing& thing) { return places.room_of(thing); });
  answer.json["changes"] = words.changes_json(walk);
  const char* label = "changed    ";
  for (const std::string& one : words.changes(walk)) {
    answer.text += fmt::format("{} {}\n", label, one);
    label = "           ";
  }
  return {};
}

// The first picture from frame i on that can be read; the error of frame i where none can.
Expected<image::ColorImage> first_color_from(const recording::Recording& recording, std::size_t i) {
  auto picture = recording.read_color(recording.frames()[i]);
  for (std::size_t next = i + 1; !picture && next < recording.frames().size(); ++next) {
    if (auto other = recording.read_color(recording.frames()[next])) return other;
  }
  return picture;
}

Expected<Answer> map(const MapOptions& options, Context& context) {
  cv::setNumThreads(1);  // the threads are ours
  if (!options.trajectory.empty() && fs::is_directory(options.trajectory)) {
    return fail("{}: is a folder; --trajectory needs a file", options.trajectory.string());
  }
  // The recording is looked at before a home is made: a wrong path leaves nothing behind.
  ROOMWISE_TRY(const auto labels, rooms_of_recording(options.recording));
  if (!fs::exists(options.home)) {
    ROOMWISE_TRY(const auto camera, given_camera(options.camera));
    ROOMWISE_RETURN_IF_ERROR(recording::open_recording(options.recording, {.camera = camera}));
    ROOMWISE_RETURN_IF_ERROR(new_settings(options));
  }
  ROOMWISE_TRY(home::Home home, make_or_open_home(options, context));
  ROOMWISE_TRY(const std::unique_ptr<recording::Recording> source, open_recording(options, home));
  for (const std::string& note : source->notes()) context.progress.note(note);
  ROOMWISE_TRY(const pipeline::MapSettings settings, choose_settings(options, context.seed, home));
  warn_of_camera(source->info().camera, context);
  pipeline::Networks networks;
  objects::ObjectFinders finders;
  if (!options.no_networks) {
    const auto picture = [&](std::size_t i) {
      return options.skip_damaged ? first_color_from(*source, i)
                                  : source->read_color(source->frames()[i]);
    };
    ROOMWISE_TRY(networks, load_networks_for_new(options.networks, home, source->frames().size(),
                                                 picture, context));
    ROOMWISE_TRY(finders, load_object_finders());
  }
  if (networks.empty()) {
    context.progress.note(
        "no network was given: nothing in this home will be named and its rooms cannot be learned; "
        "give --network FILE or set ROOMWISE_MODELS");
  }

  CommandRun run(context);
  run.working_set_bytes = options.working_set_mb << 20U;
  run.lost = std::make_shared<pipeline::LostPictures>(options.skip_damaged);
  const home::Recording recording{source->info().name, options.recording.string(),
                                  source->info().camera, source->info().frames_remaining};
  recording::DamageTolerantSource frames(*source, options.skip_damaged);
  const auto name_rooms = [&]() -> Expected<void> {
    return labels ? pipeline::name_rooms_if_unnamed(home, *labels) : Expected<void>();
  };
  auto mapped = pipeline::map_recording(frames, recording, home, networks, settings, run, finders,
                                        name_rooms, source->inertial());
  if (!mapped) {
    Error why = std::move(mapped).error();
    if (frames.is_stopped() || run.lost->is_stopped()) why.message += kNamingSkipDamaged;
    return Unexpected(std::move(why));
  }
  const pipeline::MapSummary& summary = *mapped;
  for (const std::string& why : summary.unread) context.progress.note("not compared: " + why);
  if (!summary.finished) {
    return fail_with(
        ErrorCode::kInterrupted,
        "interrupted after {} frames, {} key-frames; go on with: roomwise map {} --home {} "
        "--resume",
        summary.frames, summary.keyframes, shell_word(options.recording), shell_word(options.home));
  }
  if (!options.trajectory.empty()) {
    ROOMWISE_TRY(const auto recordings, home.recordings());
    ROOMWISE_TRY(const recording::Trajectory trajectory,
                 pipeline::stored_trajectory(home, recordings.back().id));
    ROOMWISE_RETURN_IF_ERROR(recording::write_trajectory(options.trajectory, trajectory));
  }

  ROOMWISE_TRY(const auto taught, home.own_things());
  pipeline::OwnThingLook look;
  if (!taught.empty()) {
    ROOMWISE_TRY(look, pipeline::look_for_own_things(home, networks, finders.in_pictures, run));
  }

  Answer answer;
  std::vector<std::string> names, detectors;
  for (const auto& network : networks) names.push_back(network->name());
  ROOMWISE_TRY(const auto stored_finders, home.region_finders());
  for (const auto& [id, finder] : stored_finders) detectors.push_back(finder.name);
  std::vector<std::string> lost;
  for (const auto& [id, why] : run.lost->all()) lost.push_back(why);
  const image::PersonalData& left_out = source->info().personal_data;
  answer.text = to_text(summary, names, detectors) +
                focal_length_text(summary, source->info().camera) +
                (left_out.any() ? "left out    " + left_out_text(left_out) + "\n" : "") +
                damage_text(frames.damage(), "frames that cannot be read") +
                damage_text(lost, "pictures of the map that cannot be read again");
  if (!taught.empty() && look.is_looked_for) {
    answer.text +=
        fmt::format("{} of {} things that were taught are on it\n", look.seen, taught.size());
  } else if (!taught.empty()) {
    answer.text += look.why + "\n";
  }
  answer.json = {{"finished", summary.finished},
                 {"networks", names},
                 {"detectors", detectors},
                 {"frames", summary.frames},
                 {"placed", summary.placed},
                 {"device_motion",
                  {{"frames", summary.with_device_motion},
                   {"alone", summary.motion_alone},
                   {"dropped", summary.motion_dropped},
                   {"by_inertial_sensor", summary.is_by_inertial_sensor},
                   {"felt_up", summary.felt_up},
                   {"contradicted_gravity", summary.contradicted_gravity}}},
                 {"keyframes", summary.keyframes},
                 {"culled", summary.culled},
                 {"edges", summary.edges},
                 {"loops", summary.loops},
                 {"rejected_loops", summary.rejected_edges},
                 {"pieces", summary.components},
                 {"walks", summary.walks},
                 {"joined", summary.is_joined},
                 {"f_before", summary.graph_error_before},
                 {"f_after", summary.graph_error_after},
                 {"landmarks", summary.landmarks},
                 {"landmark_views", summary.landmark_views},
                 {"readout_s", readout_json(summary.readout_s)},
                 {"focal_length", focal_length_json(summary, source->info().camera)},
                 {"objects", summary.objects},
                 {"instances", summary.instances},
                 {"left_out", left_out_json(left_out)},
                 {"home", options.home.string()}};
  ROOMWISE_RETURN_IF_ERROR(add_changes(home, context, answer));
  if (options.skip_damaged) {
    answer.json["damaged"] = frames.damage();
    answer.json["lost_pictures"] = lost;
  }
  add_stages(answer, run.clock);
  answer.json["cpu_s"] = process_cpu_time_s();
  return answer;
}

Expected<Answer> run(const MapOptions& options, Context& context) {
  const bool is_new = !fs::exists(options.home);
  Expected<Answer> answer = map(options, context);
  if (!answer && is_new) pipeline::remove_empty_home(options.home);
  return answer;
}

}  // namespace

void add_map_command(CLI::App& app, Context& context) {
  const auto [command, options] = add_command<MapOptions>(
      app, context, "map",
      "Turn a recording into a home, or add a further walk to one: map, key-frames, what networks "
      "see in them",
      "roomwise map office_walk --home office.home", run);
  command
      ->add_option("RECORDING", options.recording,
                   "Folder or file of any kind that is read (docs/recordings.md)")
      ->required();
  command
      ->add_option("--home", options.home,
                   "Home file to make; to one that is there the recording is added as a further "
                   "walk")
      ->required();
  CLI::Option* resume = command->add_flag(
      "--resume", options.resume, "Go on with a run that was stopped, with its own settings");
  command->get_option("--seed")->excludes(resume);
  const auto settings = std::make_shared<std::vector<const CLI::Option*>>();
  settings->push_back(command->get_option("--seed"));
  add_camera_option(*command, options.camera, "the recording's own");
  command->add_flag(kSkipDamaged, options.skip_damaged,
                    "Leave out frames that cannot be read, and pictures of earlier walks, and name "
                    "them; without it the first such ends the work");
  const auto how = [resume, settings](CLI::Option* option) {
    settings->push_back(option);
    return option->excludes(resume);
  };
  const auto option = [how, &map = *command](const char* name, auto& value, const char* meaning,
                                             const CLI::Validator& check) {
    return how(map.add_option(name, value, meaning)->check(check));
  };
  const auto setting = [&](const char* name, auto& value, const char* meaning,
                           const CLI::Validator& check) {
    option(name, value, meaning, check)->capture_default_str();
  };
  setting("--method", options.method,
          "combined: whole views and features, each checking the other; paper: PnP with RANSAC on "
          "features alone",
          CLI::IsMember({"combined", "paper"}));
  setting("--features", options.features, "surf, sift or orb",
          CLI::IsMember({"surf", "sift", "orb"}));
  how(add_setting(*command, "--keypoints", options.settings.max_keypoints,
                  "Maximum number of key-points in a frame")
          ->check(CLI::Range(1, 1'000'000).description("")));
  setting("--keyframe-translation", options.settings.mapper.keyframe_translation_m,
          "A key-frame after this much motion, m", positive());
  setting("--keyframe-rotation", options.settings.mapper.keyframe_rotation_rad,
          "A key-frame after this much turning, rad", positive());
  setting("--loop-neighbors", options.settings.mapper.loops.neighbors,
          "Key-frames before the last that each new one is compared with", not_negative());
  option("--loop-random", options.loop_random,
         "Earlier key-frames, drawn at random, that each new one is compared with [combined: 2, "
         "paper: 5]",
         not_negative());
  option("--loop-similar", options.loop_similar,
         "Earlier key-frames that look most like it, that each new one is compared with "
         "[combined: 3, paper: 0]",
         not_negative());
  option("--keyframe-reuse", options.reuse,
         "Go on from an earlier key-frame where the camera is nearer to it than this part of a "
         "key-frame's motion, once the map has 600; 0: never [combined: 0.7, paper: 0]",
         CLI::Range(0.0, 1.0));
  add_setting(*command, "--working-set", options.working_set_mb,
              "Memory for what was measured in key-frames, and then for the voxels they are fused "
              "in, MB; the rest waits in a scratch file beside the home. Changes no result");
  how(command->add_flag("--no-bundle-adjustment", options.no_bundle_adjustment,
                        "Leave the map as the pose graph says: no landmarks, no rolling shutter "
                        "(so does --method paper)"));
  how(command->add_flag("--no-upright", options.no_upright,
                        "Do not hold the map upright by level surfaces and walls (so does "
                        "--no-bundle-adjustment)"));
  how(command->add_flag(
      "--no-device-motion", options.no_device_motion,
      "Leave aside what the device says of its own motion (ARKit, odometry.txt, imu.txt; "
      "so does --method paper)"));
  how(command->add_flag("--no-keyframe-culling", options.no_keyframe_culling,
                        "Keep every key-frame of every walk. Without it those go, once a further "
                        "walk is mapped, that add nothing to what the walks before show"));
  setting("--object-score", options.settings.objects.min_score,
          "Minimum score of an object, 0 to 1", CLI::Range(0.0, 1.0));
  add_network_options(*command, options.networks);
  command
      ->add_flag("--no-networks", options.no_networks,
                 "No network looks at the pictures: quicker, but nothing gets a name and no room "
                 "can be learned")
      ->excludes("--network")
      ->excludes("--labels")
      ->excludes("--network-precision");
  command->add_option("--trajectory", options.trajectory,
                      "Also write the walk's trajectory there, in TUM's format");
  options.given_settings = [settings] {
    std::vector<std::string> given;
    for (const CLI::Option* one : *settings) {
      if (one->count() > 0) given.push_back(one->get_name());
    }
    return given;
  };
}

}  // namespace roomwise::app
