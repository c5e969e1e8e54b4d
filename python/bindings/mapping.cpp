#include <pybind11/stl.h>

#include <algorithm>

#include "networks.h"
#include "open_home.h"
#include "python/bindings/arrays.h"
#include "python/bindings/bindings.h"
#include "python/bindings/homes.h"
#include "python/bindings/long_work.h"
#include "python/bindings/recordings.h"
#include "roomwise/pipeline/mapping/map_recording.h"
#include "roomwise/pipeline/rooms/picture_features.h"
#include "roomwise/pipeline/rooms/room_learning.h"
#include "roomwise/pipeline/rooms/walk_into_home.h"
#include "roomwise/pipeline/stored/lost_pictures.h"
#include "roomwise/recording/damage_tolerant_source.h"
#include "roomwise/recording/open_recording.h"

namespace roomwise::python {
namespace {

namespace fs = std::filesystem;
using pipeline::MapSummary;
using rooms::LearningReport;

// ---- map_recording ----

struct MapRequest {
  fs::path recording;
  fs::path home;
  std::optional<geometry::PinholeCamera> camera;
  ChosenNetworks networks;
  bool resume = false;
  bool skip_damaged = false;
  home::OpenOptions open;
  std::size_t threads = 1;
  pipeline::MapSettings settings;  // of a home that has none yet
};

struct MapReport {
  MapSummary summary;
  std::vector<std::string>
      damaged;  // the errors of frames, and of the map's pictures, that were left out
};

// Of a recording that says its rooms itself.
Expected<std::optional<recording::RoomLabels>> rooms_of(const fs::path& recording) {
  const fs::path file = recording / "rooms.txt";
  if (!fs::exists(file)) return std::nullopt;
  ROOMWISE_TRY(recording::RoomLabels labels, recording::RoomLabels::read(file));
  return labels;
}

Expected<MapReport> map_into(home::Home& home, recording::Recording& source,
                             const MapRequest& request,
                             const std::optional<recording::RoomLabels>& rooms, Progress& shown) {
  ROOMWISE_TRY(const auto stored, pipeline::stored_map_settings(home));
  ROOMWISE_TRY(const pipeline::Networks networks,
               request.networks.load(home, /*also_brought=*/false));
  objects::ObjectFinders finders;
  if (request.networks.are_installed) {
    ROOMWISE_TRY(finders, app::load_object_finders());
  }
  pipeline::OwnRunContext run(request.threads, shown);
  run.lost = std::make_shared<pipeline::LostPictures>(request.skip_damaged);
  const home::Recording recording{source.info().name, request.recording.string(),
                                  source.info().camera, source.info().frames_remaining};
  recording::DamageTolerantSource frames(source, request.skip_damaged);
  auto mapped = pipeline::map_recording(
      frames, recording, home, networks, stored.value_or(request.settings), run, finders,
      // What a person named since is kept.
      [&] { return rooms ? pipeline::name_rooms_if_unnamed(home, *rooms) : Expected<void>(); },
      source.inertial());
  if (!mapped && (frames.is_stopped() || run.lost->is_stopped())) {
    mapped.error().message += "; give skip_damaged=True to go on without it";
  }
  ROOMWISE_TRY(MapSummary summary, std::move(mapped));
  if (!summary.finished) {
    return fail_with(ErrorCode::kInterrupted,
                     "interrupted after {} frames, {} key-frames; go on with resume=True",
                     summary.frames, summary.keyframes);
  }
  MapReport report{std::move(summary), frames.damage()};
  for (const auto& [id, why] : run.lost->all()) report.damaged.push_back(why);
  return report;
}

Expected<MapReport> map(const MapRequest& request, Progress& shown) {
  // The recording is looked at before a home is made: a wrong path leaves nothing behind.
  recording::RecordingOptions how{.camera = request.camera};
  if (!how.camera && request.resume && fs::exists(request.home)) {
    ROOMWISE_TRY(const home::Home home, home::Home::open_read_only(request.home, request.open));
    ROOMWISE_TRY(const auto walks, home.recordings());
    if (!walks.empty()) how.camera = walks.back().recording.camera;
  }
  ROOMWISE_TRY(const auto source, recording::open_recording(request.recording, how));
  ROOMWISE_TRY(const auto rooms, rooms_of(request.recording));
  ROOMWISE_TRY(home::Home home,
               pipeline::make_or_open_home(
                   {request.home, request.recording, request.open, request.resume, "resume=True"}));
  return map_into(home, *source, request, rooms, shown);
}

pipeline::MapSettings settings_of(const std::string& method, const std::string& features,
                                  bool bundle_adjustment, bool device_motion, std::uint64_t seed) {
  pipeline::MapSettings settings;
  settings.mapper = mapping::MapperOptions::of(value_of(mapping::parse_mapping_method(method)));
  settings.mapper.device_motion = device_motion;
  settings.mapper.seed = seed;
  settings.features = value_of(features::parse_feature_kind(features));
  settings.bundle_adjustment = bundle_adjustment;
  return settings;
}

MapReport map_recording(const py::object& path, const py::object& home, const py::object& camera,
                        const py::object& networks, bool resume, const std::string& method,
                        const std::string& features, bool bundle_adjustment, bool device_motion,
                        bool skip_damaged, std::uint64_t seed, int threads,
                        const py::object& passphrase, const py::object& progress) {
  MapRequest request;
  request.recording = path_of(path, "path");
  request.home = path_of(home, "home");
  request.camera = camera_of(camera);
  request.networks = ChosenNetworks::of(networks);
  request.resume = resume;
  request.skip_damaged = skip_damaged;
  request.open = open_options(passphrase);
  request.threads = thread_count(threads);
  request.settings = settings_of(method, features, bundle_adjustment, device_motion, seed);
  return run_long(progress, [&](Progress& shown) {
    const bool is_new = !fs::exists(request.home);
    Expected<MapReport> report = map(request, shown);
    if (!report && is_new) pipeline::remove_empty_home(request.home);
    return report;
  });
}

// ---- learn_rooms ----

LearningReport learn_rooms(const py::object& home, const py::object& labels,
                           const std::string& walk, const std::string& visits,
                           const std::vector<std::string>& rooms, int variants,
                           const py::object& networks, int threads, const py::object& passphrase,
                           const py::object& progress) {
  const fs::path file = path_of(home, "home");
  const fs::path labels_file = labels.is_none() ? fs::path() : path_of(labels, "labels");
  const home::OpenOptions open = open_options(passphrase);
  const ChosenNetworks chosen = ChosenNetworks::of(networks);
  const std::size_t count = thread_count(threads);
  if (variants < 0 || variants > pipeline::kMaxVariants) {
    throw py::value_error(
        fmt::format("variants = {} must be between 0 and {}", variants, pipeline::kMaxVariants));
  }
  pipeline::RoomSelection selection;
  selection.rooms = rooms;
  if (!visits.empty()) selection.stays = value_of(pipeline::parse_stays(visits));
  return run_long(progress, [&](Progress& shown) -> Expected<LearningReport> {
    ROOMWISE_TRY(home::Home opened, home::Home::open(file, open));
    pipeline::RoomLearning learning{.variants = variants};
    if (!walk.empty() || !labels_file.empty()) {
      ROOMWISE_TRY(const home::RecordingId id, app::find_walk(opened, walk));
      if (!walk.empty()) learning.walks.push_back(id);
      if (!labels_file.empty()) {
        ROOMWISE_TRY(const auto read, recording::RoomLabels::read(labels_file));
        ROOMWISE_RETURN_IF_ERROR(pipeline::name_rooms(opened, id, read));
      }
    }
    pipeline::Networks looking;  // what they saw in the key-frames themselves is stored
    if (variants > 0) {
      ROOMWISE_TRY(looking, chosen.load(opened, /*also_brought=*/true));
    }
    pipeline::OwnRunContext run(count, shown);
    return pipeline::learn_rooms_from_keyframes(opened, selection, learning, looking, run);
  });
}

template <typename Member>
auto of_summary(Member MapSummary::*member) {
  return [member](const MapReport& report) { return report.summary.*member; };
}

void bind_map_report(py::module_& module) {
  py::class_<MapReport>(module, "MapReport", "What mapping a recording came to.")
      .def_property_readonly("frames", of_summary(&MapSummary::frames))
      .def_property_readonly("placed", of_summary(&MapSummary::placed),
                             "Frames that have a pose in the largest component")
      .def_property_readonly("keyframes", of_summary(&MapSummary::keyframes), "Of this walk")
      .def_property_readonly("edges", of_summary(&MapSummary::edges), "Of the pose graph")
      .def_property_readonly("loops", of_summary(&MapSummary::loops),
                             "Returns to a place: edges over more than ten key-frames")
      .def_property_readonly("rejected_edges", of_summary(&MapSummary::rejected_edges),
                             "That contradicted the others and were left out")
      .def_property_readonly("components", of_summary(&MapSummary::components))
      .def_property_readonly("walks", of_summary(&MapSummary::walks), "In the home")
      .def_property_readonly("is_joined", of_summary(&MapSummary::is_joined),
                             "The walk shares a component with an earlier one, where there is one")
      .def_property_readonly("objects", of_summary(&MapSummary::instances))
      .def_property_readonly("error_before", of_summary(&MapSummary::graph_error_before),
                             "F of the pose graph")
      .def_property_readonly("error_after", of_summary(&MapSummary::graph_error_after))
      .def_property_readonly("landmarks", of_summary(&MapSummary::landmarks),
                             "0 where the bundle was not adjusted")
      .def_property_readonly("readout_s", of_summary(&MapSummary::readout_s),
                             "Of the camera's rolling shutter, s, or None")
      .def_readonly("damaged", &MapReport::damaged, "Errors of the frames that were left out")
      .def("__repr__", [](const MapReport& report) {
        return fmt::format("<roomwise.MapReport: {} of {} frames placed, {} key-frames>",
                           report.summary.placed, report.summary.frames, report.summary.keyframes);
      });
}

void bind_learning_report(py::module_& module) {
  py::class_<LearningReport>(module, "LearningReport", "How well rooms were learned.")
      .def_property_readonly(
          "rooms",
          [](const LearningReport& report) {
            std::map<std::string, std::size_t> pictures;
            for (const auto& room : report.rooms) pictures[room.room] = room.pictures;
            return pictures;
          },
          "Pictures of each room")
      .def_readonly("held_out", &LearningReport::held_out, "Pictures tested while held out")
      .def_readonly("held_out_correct", &LearningReport::held_out_correct,
                    "Of these, named rightly")
      .def_readonly("min_probability", &LearningReport::min_probability,
                    "From which on a room is named")
      .def_readonly("warnings", &LearningReport::warnings);
}

}  // namespace

void bind_mapping(py::module_& module) {
  bind_map_report(module);
  bind_learning_report(module);
  module.def(
      "map_recording", &map_recording, py::arg("path"), py::arg("home"), py::kw_only(),
      py::arg("camera") = py::none(), py::arg("networks") = py::none(), py::arg("resume") = false,
      py::arg("method") = "combined", py::arg("features") = "surf",
      py::arg("bundle_adjustment") = true, py::arg("device_motion") = true,
      py::arg("skip_damaged") = false, py::arg("seed") = 1, py::arg("threads") = 0,
      py::arg("passphrase") = py::none(), py::arg("progress") = py::none(),
      "Maps a recording into a home file, which is made, or takes it as a further walk (with its "
      "own "
      "settings: method, features, bundle_adjustment, device_motion and seed then do not count). "
      "networks: files or names; None: those installed, detectors too; []: none, so that nothing "
      "is "
      "named. A rooms.txt in the recording names the rooms. progress(work, done, total, note) is "
      "called on this thread; what it raises stops the work, as Ctrl-C does: the home keeps what "
      "was "
      "mapped, and resume=True goes on from there. Networks look in floats unless the home allowed "
      "8 bits before. The same seed gives the same bits at any number of threads (0: all). Error "
      "where the "
      "recording cannot be read, or the home has it already.");
  module.def(
      "learn_rooms", &learn_rooms, py::arg("home"), py::kw_only(), py::arg("labels") = py::none(),
      py::arg("walk") = "", py::arg("visits") = "", py::arg("rooms") = std::vector<std::string>{},
      py::arg("variants") = 2, py::arg("networks") = py::none(), py::arg("threads") = 0,
      py::arg("passphrase") = py::none(), py::arg("progress") = py::none(),
      "Learns a mapped home's rooms from its key-frames. labels: a rooms.txt that names the rooms "
      "of "
      "the walk first. walk: its name (default: all that are named). visits: '1', '2-', '1,4-' "
      "(default: all). rooms: their names (default: all). variants: varied copies of each picture "
      "that are learned from, too, for which a network runs. Error where there are too few rooms "
      "or "
      "pictures.");
}

}  // namespace roomwise::python
