#include "python/bindings/homes.h"

#include <pybind11/stl.h>

#include "command.h"
#include "networks.h"
#include "open_home.h"
#include "python/bindings/arrays.h"
#include "python/bindings/bindings.h"
#include "python/bindings/graphs.h"
#include "python/bindings/long_work.h"
#include "python/bindings/recordings.h"
#include "python/bindings/trajectories.h"
#include "roomwise/pipeline/mapping/map_cloud.h"
#include "roomwise/pipeline/objects/home_things.h"
#include "roomwise/pipeline/stored/keyframe_images.h"
#include "roomwise/pipeline/stored/map_settings.h"
#include "roomwise/pipeline/stored/stored_map.h"
#include "roomwise/pipeline/stored/stored_rooms.h"

namespace roomwise::python {
namespace {

// ---- values, as Python sees them ----

struct Walk {
  home::StoredRecording stored;
};

struct RoomStay {
  home::RecordingId walk = 0;
  recording::RoomRange range;
};
struct Room {
  std::string name;
  std::string type;
  std::vector<RoomStay> visits;
};

struct HomeObject {
  objects::Instance instance;
  home::KeyframePose pose;  // of its key-frame
  std::optional<std::string> room;
};

struct PointCloud {
  pipeline::MapCloud map;
};

// ---- what a home is asked ----

std::unique_ptr<OpenHome> open(const py::object& path, const py::object& passphrase) {
  const std::filesystem::path file = path_of(path, "path");
  const home::OpenOptions options = open_options(passphrase);
  // Boxed, since a Home can be moved, and not assigned.
  return run_without_gil([&]() -> Expected<std::unique_ptr<OpenHome>> {
    ROOMWISE_TRY(home::Home home, home::Home::open_read_only(file, options));
    return std::unique_ptr<OpenHome>(new OpenHome{file, options, std::move(home)});
  });
}

std::vector<Walk> walks_of(const OpenHome& self) {
  std::vector<Walk> walks;
  for (auto& stored : value_of(self.home.recordings())) walks.push_back({std::move(stored)});
  return walks;
}

std::optional<home::RecordingId> walk_of(const OpenHome& self, const py::object& walk) {
  if (walk.is_none()) return std::nullopt;
  if (py::isinstance<Walk>(walk)) return walk.cast<const Walk&>().stored.id;
  if (!py::isinstance<py::str>(walk)) {
    throw py::type_error("walk: expected a Walk of this home, its name, or None for all");
  }
  return value_of(app::find_walk(self.home, walk.cast<std::string>()));
}

std::vector<Room> rooms_of(const OpenHome& self) {
  std::vector<Room> rooms;
  for (const rooms::Room& room : value_of(self.home.rooms())) {
    rooms.push_back({room.name, room.type, {}});
  }
  for (const home::StoredRecording& walk : value_of(self.home.recordings())) {
    const recording::RoomLabels labels = value_of(self.home.room_ranges(walk.id));
    for (const recording::RoomRange& range : labels.ranges()) {
      const auto room = std::ranges::find(rooms, range.room, &Room::name);
      if (room != rooms.end()) room->visits.push_back({walk.id, range});
    }
  }
  return rooms;
}

std::vector<HomeObject> objects_of(const OpenHome& self) {
  std::map<home::KeyframeId, home::KeyframePose> poses;
  for (const home::Keyframe& keyframe : value_of(self.home.keyframes())) {
    poses[keyframe.id] = keyframe.pose;
  }
  const auto learned_rooms = value_of(self.home.keyframe_rooms());
  const auto named_rooms = value_of(pipeline::rooms_of_keyframes(self.home));
  std::vector<HomeObject> objects;
  for (pipeline::HomeThing& instance : value_of(pipeline::find_home_things(self.home)).things) {
    auto room = pipeline::room_of_thing(std::nullopt, instance.keyframe_id, nullptr, named_rooms,
                                        instance.room);
    const auto learned = learned_rooms.find(instance.keyframe_id);
    if (!room && learned != learned_rooms.end() && !learned->second.empty()) {
      room = learned->second.front().room;
    }
    const home::KeyframePose pose = poses.at(instance.keyframe_id);
    objects.push_back({std::move(instance), pose, std::move(room)});
  }
  return objects;
}

Frame frame_of(const OpenHome& self, home::KeyframeId id) {
  const auto keyframes = value_of(self.home.keyframes());
  if (id >= keyframes.size()) {
    raise({fmt::format("{}: has no key-frame {}; it has {}", self.home.file(), id,
                       keyframes.size())});
  }
  const home::Keyframe& keyframe = keyframes[id];
  Frame frame;
  frame.camera = value_of(pipeline::recording_cameras(self.home)).at(keyframe.recording);
  frame.frame.index = keyframe.frame_index;
  frame.frame.timestamp_ns = keyframe.timestamp_ns;
  const home::KeyframeImages images = value_of(self.home.images(id));
  auto decoded = run_without_gil([&] { return pipeline::decode(images, frame.camera); });
  frame.frame.color = std::move(decoded.color);
  frame.frame.depth = std::move(decoded.depth);
  return frame;
}

Trajectory home_trajectory(const OpenHome& self, const py::object& walk) {
  const auto chosen = walk_of(self, walk);
  return {run_long([&](Progress&) -> Expected<recording::Trajectory> {
    ROOMWISE_TRY(const home::Home home, self.reader());
    return pipeline::stored_trajectory(home, chosen);
  })};
}

PointCloud cloud_of(const OpenHome& self, double voxel_size_m, int threads,
                    const py::object& progress) {
  require_positive(voxel_size_m, "voxel_size_m");
  const std::size_t count = thread_count(threads);
  return {run_long(progress, [&](Progress& shown) -> Expected<pipeline::MapCloud> {
    ROOMWISE_TRY(const home::Home home, self.reader());
    pipeline::OwnRunContext run(count, shown);
    return pipeline::build_map_cloud(home, voxel_size_m, run);
  })};
}

PoseGraph home_graph(const OpenHome& self) {
  const auto settings = value_of(pipeline::stored_map_settings(self.home));
  if (!settings) {
    raise({fmt::format("{}: the home has no map yet; make one with roomwise.map_recording",
                       self.home.file())});
  }
  return {value_of(pipeline::stored_pose_graph(self.home, settings->solver))};
}

// ---- declarations ----

void bind_walk(py::module_& module) {
  py::class_<Walk>(module, "Walk", "A walk through the home with an RGB-D camera.")
      .def_property_readonly("id", [](const Walk& self) { return self.stored.id; })
      .def_property_readonly("name", [](const Walk& self) { return self.stored.recording.name; })
      .def_property_readonly(
          "path", [](const Walk& self) { return self.stored.recording.folder; },
          "Where it was read from, as the user gave it")
      .def_property_readonly("camera",
                             [](const Walk& self) { return self.stored.recording.camera; })
      .def_property_readonly(
          "finished", [](const Walk& self) { return self.stored.finished; },
          "All its frames are stored and its map is optimised")
      .def_property_readonly(
          "readout_s", [](const Walk& self) { return self.stored.readout_s; },
          "Of its camera's rolling shutter, s, or None")
      .def("__repr__", [](const Walk& self) {
        return fmt::format("<roomwise.Walk {} '{}'>", self.stored.id, self.stored.recording.name);
      });
}

void bind_keyframe(py::module_& module) {
  py::class_<home::Keyframe>(module, "Keyframe", "A frame that the map keeps.")
      .def_readonly("id", &home::Keyframe::id, "0, 1, 2, ... in the order of time")
      .def_readonly("walk", &home::Keyframe::recording, "Walk.id")
      .def_readonly("frame_index", &home::Keyframe::frame_index, "Frame.index")
      .def_readonly("timestamp_ns", &home::Keyframe::timestamp_ns)
      .def_property_readonly(
          "component", [](const home::Keyframe& self) { return self.pose.component; },
          "Poses of one component share a world; the largest is 0")
      .def_property_readonly(
          "world_from_camera",
          [](const home::Keyframe& self) { return matrix_of(self.pose.world_from_keyframe); },
          "4 x 4 float64, m");
}

void bind_room(py::module_& module) {
  py::class_<RoomStay>(module, "RoomVisit", "Frames of a walk that were taken in a room.")
      .def_readonly("walk", &RoomStay::walk, "Walk.id")
      .def_property_readonly("first_frame",
                             [](const RoomStay& self) { return self.range.first_frame; })
      .def_property_readonly(
          "last_frame", [](const RoomStay& self) { return self.range.last_frame; }, "Included")
      .def_property_readonly(
          "visit", [](const RoomStay& self) { return self.range.stay; },
          "Which visit of the room on that walk, from 1");
  py::class_<Room>(module, "Room", "A room of the home, as its walks were named.")
      .def_readonly("name", &Room::name)
      .def_readonly("type", &Room::type, "kitchen, bedroom, ...")
      .def_readonly("visits", &Room::visits)
      .def("__repr__",
           [](const Room& self) { return fmt::format("<roomwise.Room {}>", self.name); });
}

geometry::OrientedBox box_of(const HomeObject& self) {
  return self.instance.box_world(self.pose.world_from_keyframe);
}

void bind_object(py::module_& module) {
  py::class_<HomeObject>(module, "HomeObject", "A thing of the home, joined from many key-frames.")
      .def_property_readonly("name", [](const HomeObject& self) { return self.instance.name; })
      .def_property_readonly(
          "probability", [](const HomeObject& self) { return self.instance.probability; },
          "That it is there and is called so, 0 to 1")
      .def_property_readonly(
          "names", [](const HomeObject& self) { return self.instance.names; },
          "What it may be called, by probability; they sum to 1")
      .def_property_readonly(
          "center", [](const HomeObject& self) { return vector_of(box_of(self).center()); },
          "(3,) m in the world of its component")
      .def_property_readonly(
          "world_from_box",
          [](const HomeObject& self) { return matrix_of(box_of(self).world_from_box); },
          "4 x 4: z of the box is up, its origin in the middle")
      .def_property_readonly(
          "size_m", [](const HomeObject& self) { return vector_of(box_of(self).size_m); },
          "(3,) edge lengths along x, y, z of the box")
      .def_property_readonly(
          "sigma_m", [](const HomeObject& self) { return vector_of(self.instance.sigma_m); },
          "(3,) standard deviation of the middle along them, m")
      .def_property_readonly(
          "keyframe", [](const HomeObject& self) { return self.instance.keyframe_id; },
          "Keyframe.id of the one that shows it best")
      .def_property_readonly(
          "observations", [](const HomeObject& self) { return self.instance.observations; },
          "Key-frames that saw it")
      .def_property_readonly(
          "expected", [](const HomeObject& self) { return self.instance.expected; },
          "Key-frames that should have")
      .def_property_readonly("component",
                             [](const HomeObject& self) { return self.pose.component; })
      .def_readonly(
          "room", &HomeObject::room,
          "That somebody put it in; else in which its key-frame was taken, by the names of its "
          "walk, else as the learned rooms say; or None. On whose floor it stands tells "
          "`roomwise export json`")
      .def("__repr__", [](const HomeObject& self) {
        return fmt::format("<roomwise.HomeObject {} {:.2f}>", self.instance.name,
                           self.instance.probability);
      });
}

void bind_cloud(py::module_& module) {
  py::class_<PointCloud>(module, "PointCloud",
                         "The map as points. Its arrays are read-only views that keep it alive.")
      .def_property_readonly(
          "points",
          [](const py::object& self) {
            const auto& points = self.cast<const PointCloud&>().map.cloud.points;
            static_assert(sizeof(Eigen::Vector3f) == 3 * sizeof(float));
            return view(points.empty() ? nullptr : points.front().data(),
                        {static_cast<py::ssize_t>(points.size()), 3},
                        {py::ssize_t{sizeof(Eigen::Vector3f)}, py::ssize_t{sizeof(float)}}, self);
          },
          "(N, 3) float32 m in the world of the largest component: a view")
      .def_property_readonly(
          "colors",
          [](const py::object& self) {
            const auto& colors = self.cast<const PointCloud&>().map.cloud.colors;
            return view(colors.empty() ? nullptr : &colors.front().r,
                        {static_cast<py::ssize_t>(colors.size()), 3}, {3, 1}, self);
          },
          "(N, 3) uint8 R G B: a view")
      .def_property_readonly(
          "up", [](const PointCloud& self) { return vector_of(self.map.up.up_world); },
          "(3,) the direction up, unit length")
      .def("__len__", [](const PointCloud& self) { return self.map.cloud.size(); });
}

void bind_home(py::module_& module) {
  py::class_<OpenHome>(module, "Home",
                       "A home file, open for reading; each call sees one state of it, also while "
                       "another program writes.")
      .def_property_readonly("path", [](const OpenHome& self) { return self.path.string(); })
      .def_property_readonly(
          "is_locked", [](const OpenHome& self) { return self.home.is_locked(); },
          "Protected, and opened without its passphrase: its pictures cannot be read")
      .def_property_readonly("walks", &walks_of, "list of Walk, as they were added")
      .def_property_readonly(
          "keyframes", [](const OpenHome& self) { return value_of(self.home.keyframes()); },
          "list of Keyframe, by id")
      .def_property_readonly("rooms", &rooms_of, "list of Room, by name")
      .def_property_readonly("objects", &objects_of, "list of HomeObject")
      .def("frame", &frame_of, py::arg("keyframe"),
           "The Frame that a key-frame (its id) was made of. Error where there is no such "
           "key-frame, and where its pictures are sealed or damaged.")
      .def("trajectory", &home_trajectory, py::arg("walk") = py::none(),
           "The poses of all frames that the largest component places, or of those of one walk (a "
           "Walk or its name): a Trajectory in the world of that component, m. Error where the "
           "home has no such walk.")
      .def("cloud", &cloud_of, py::arg("voxel_size_m") = 0.02, py::arg("threads") = 0,
           py::arg("progress") = py::none(),
           "The largest component as a PointCloud, one point a voxel of voxel_size_m; empty where "
           "nothing is mapped. threads: 0 for all. progress: as for map_recording. Error where "
           "pictures are sealed or damaged; Ctrl-C stops it.")
      .def("pose_graph", &home_graph,
           "The PoseGraph of the map as it is, in m, without the loops that contradict it. Error "
           "where "
           "the home has no map.")
      .def("__repr__", [](const OpenHome& self) {
        return fmt::format("<roomwise.Home {}>", self.path.string());
      });
  module.def(
      "open_home", &open, py::arg("path"), py::arg("passphrase") = py::none(),
      "Opens a home file for reading. passphrase: of a protected home; without it all but its "
      "pictures can be read. Error where it is no home, or damaged.");
}

}  // namespace

home::OpenOptions open_options(const py::object& passphrase) {
  if (passphrase.is_none()) return {};
  if (!py::isinstance<py::str>(passphrase)) {
    throw py::type_error("passphrase: expected a str, or None");
  }
  return {std::make_shared<home::Passphrase>(
      value_of(home::Passphrase::from(passphrase.cast<std::string>())))};
}

ChosenNetworks ChosenNetworks::of(const py::object& networks) {
  if (networks.is_none()) return {};
  ChosenNetworks chosen{.are_installed = false, .files = {}};
  if (is_path(networks) || !py::isinstance<py::sequence>(networks)) {
    throw py::type_error(
        "networks: expected a list of files or names, an empty one for none, or None for the "
        "installed ones");
  }
  for (const py::handle network : networks) {
    chosen.files.push_back(path_of(py::reinterpret_borrow<py::object>(network), "networks"));
  }
  return chosen;
}

Expected<pipeline::Networks> ChosenNetworks::load(const home::Home& home, bool also_brought) const {
  if (!are_installed && files.empty()) return pipeline::Networks{};
  app::NetworkOptions options;
  options.files = files;
  return app::load_networks(options, &home, also_brought);
}

std::size_t thread_count(int threads) {
  if (threads < 0 || threads > static_cast<int>(app::kMaxThreads)) {
    throw py::value_error(
        fmt::format("threads = {} must be 1 to {}, or 0 for all", threads, app::kMaxThreads));
  }
  return threads == 0 ? ThreadPool::default_size() : static_cast<std::size_t>(threads);
}

void bind_homes(py::module_& module) {
  bind_walk(module);
  bind_keyframe(module);
  bind_room(module);
  bind_object(module);
  bind_cloud(module);
  bind_home(module);
}

}  // namespace roomwise::python
