#include <pybind11/stl.h>

#include "python/bindings/arrays.h"
#include "python/bindings/bindings.h"
#include "python/bindings/homes.h"
#include "python/bindings/long_work.h"
#include "python/bindings/recordings.h"
#include "roomwise/pipeline/rooms/home_places.h"
#include "roomwise/pipeline/rooms/room_recognizer.h"

namespace roomwise::python {
namespace {

using mapping::Localization;
using pipeline::PictureToLocate;
using rooms::RoomDecision;

// The camera with which a home was mapped first: that of pictures of which none is given.
Expected<geometry::PinholeCamera> camera_of_home(const home::Home& home) {
  ROOMWISE_TRY(const auto recordings, home.recordings());
  if (recordings.empty()) {
    return fail("{}: the home has no map yet; make one with roomwise.map_recording", home.file());
  }
  return recordings.front().recording.camera;
}

PictureToLocate picture_of(const py::object& color, const py::object& depth,
                           const geometry::PinholeCamera& camera) {
  PictureToLocate picture;
  picture.camera = camera;
  picture.color = color_image(color, "color");
  if (!depth.is_none()) picture.depth = depth_image(depth, camera, "depth");
  return picture;
}

// ---- where a picture was taken ----

struct Localizer {
  pipeline::HomeLocalizer localizer;
  geometry::PinholeCamera camera;
};

std::unique_ptr<Localizer> localizer_of(const OpenHome& home, std::uint64_t seed, int threads,
                                        const py::object& progress) {
  const std::size_t count = thread_count(threads);
  return run_long(progress, [&](Progress& shown) -> Expected<std::unique_ptr<Localizer>> {
    ROOMWISE_TRY(const home::Home reader, home.reader());
    ROOMWISE_TRY(const geometry::PinholeCamera camera, camera_of_home(reader));
    pipeline::OwnRunContext run(count, shown);
    mapping::LocalizerOptions options;
    options.seed = seed;
    ROOMWISE_TRY(auto localizer, pipeline::HomeLocalizer::create(reader, options, run));
    return std::unique_ptr<Localizer>(new Localizer{std::move(localizer), camera});
  });
}

Localization locate(const Localizer& self, const py::object& color, const py::object& depth,
                    const py::object& camera) {
  const geometry::PinholeCamera taken_by = camera_of(camera).value_or(self.camera);
  const PictureToLocate picture = picture_of(color, depth, taken_by);
  return run_without_gil([&]() -> Expected<Localization> {
    ROOMWISE_TRY(const auto measured, self.localizer.measure(picture));
    return self.localizer.localizer().locate({measured, taken_by});
  });
}

// What means something only where there is a pose: None elsewhere.
template <typename Make>
auto where_found(const Make& make) {
  return [make](const Localization& found) -> py::object {
    if (!found.found()) return py::none();
    auto made = make(found);
    if constexpr (std::is_base_of_v<py::object, decltype(made)>) {
      return made;
    } else {
      return py::cast(made);
    }
  };
}

void bind_localizer(py::module_& module) {
  py::class_<Localization>(module, "Localization",
                           "Where a picture was taken, or why that is not known.")
      .def_property_readonly("found", &Localization::found)
      .def_property_readonly(
          "status", [](const Localization& self) { return std::string(to_string(self.status)); },
          "For people: what came of it")
      .def_property_readonly("world_from_camera", where_found([](const Localization& f) {
                               return matrix_of(f.world_from_camera);
                             }),
                             "4 x 4 float64 m in the map's world, or None")
      .def_property_readonly(
          "position_sigma_m",
          where_found([](const Localization& f) { return f.position_sigma_m(); }),
          "Standard deviation along the direction that is known worst, m, or None")
      .def_property_readonly("rotation_sigma_rad", where_found([](const Localization& f) {
                               return f.rotation_sigma_rad();
                             }))
      .def_property_readonly("keyframe",
                             where_found([](const Localization& f) { return f.keyframe; }),
                             "Keyframe.id of one that shows the same, or None")
      .def_readonly("inliers", &Localization::inliers, "Features of the picture that agree")
      .def("__repr__", [](const Localization& self) {
        return fmt::format("<roomwise.Localization: {}>", to_string(self.status));
      });
  py::class_<Localizer>(module, "Localizer", "Says where on a home's map a picture was taken.")
      .def(
          "locate", &locate, py::arg("color"), py::arg("depth") = py::none(),
          py::arg("camera") = py::none(),
          "color: (height, width, 3) uint8 or a path. depth: (height, width), uint16 in the "
          "camera's units or float metres with NaN where nothing was measured, or a path; without "
          "it far fewer pictures have an answer. camera: that of the picture (default: of the "
          "home's first walk). Images are copied; the GIL is released. Error where an image is not "
          "of the camera's size. May be called from several threads.");
}

// ---- which room pictures show ----

// `recognizer` points into `networks`.
struct Recognizer {
  pipeline::Networks networks;
  pipeline::RoomRecognizer recognizer;
  std::optional<pipeline::HomePlaces> places;
  std::optional<geometry::PinholeCamera> camera;
};

std::unique_ptr<Recognizer> recognizer_of(const OpenHome& home, const py::object& networks,
                                          bool places, int threads, const py::object& progress) {
  const ChosenNetworks chosen = ChosenNetworks::of(networks);
  const std::size_t count = thread_count(threads);
  return run_long(progress, [&](Progress& shown) -> Expected<std::unique_ptr<Recognizer>> {
    ROOMWISE_TRY(const home::Home reader, home.reader());
    ROOMWISE_TRY(auto loaded, chosen.load(reader, /*also_brought=*/true));
    ROOMWISE_TRY(auto recognizer, pipeline::RoomRecognizer::create(reader, loaded));
    auto made = std::unique_ptr<Recognizer>(
        new Recognizer{std::move(loaded), std::move(recognizer), std::nullopt, std::nullopt});
    if (places) {
      ROOMWISE_TRY(made->camera, camera_of_home(reader));
      pipeline::OwnRunContext run(count, shown);
      ROOMWISE_TRY(auto found, pipeline::HomePlaces::create(reader, {}, run));
      made->places.emplace(std::move(found));
    }
    return made;
  });
}

// The pictures with their depth; none where no depth is given.
std::vector<PictureToLocate> with_depths(const Recognizer& self, const py::sequence& pictures,
                                         const py::object& depths, const py::object& camera) {
  std::vector<PictureToLocate> to_locate;
  if (depths.is_none()) return to_locate;
  if (!self.places) {
    throw py::value_error(
        "depths: this recognizer knows no places; make it with home.recognizer(places=True)");
  }
  if (!py::isinstance<py::sequence>(depths) || py::len(depths) != py::len(pictures)) {
    throw py::value_error(fmt::format(
        "depths: expected a list of {}, one for each picture, or None", py::len(pictures)));
  }
  const geometry::PinholeCamera taken_by = camera_of(camera).value_or(*self.camera);
  const auto given = py::reinterpret_borrow<py::sequence>(depths);
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    to_locate.push_back(picture_of(pictures[i], given[i], taken_by));
  }
  return to_locate;
}

RoomDecision recognize(const Recognizer& self, const py::args& pictures, const py::object& depths,
                       const py::object& camera) {
  if (pictures.empty()) throw py::value_error("pictures: expected one or more; got none");
  std::vector<image::ColorImage> images;
  for (const py::handle picture : pictures) {
    images.push_back(color_image(py::reinterpret_borrow<py::object>(picture), "pictures"));
  }
  const auto to_locate = with_depths(self, pictures, depths, camera);
  return run_without_gil([&]() -> Expected<RoomDecision> {
    if (to_locate.empty()) return self.recognizer.recognize(images);
    const std::span<const PictureToLocate> all(to_locate);
    return self.recognizer.recognize(images, [&] {
      return self.places->look(all.last(std::min<std::size_t>(2, all.size())),
                               self.recognizer.rooms());
    });
  });
}

std::vector<std::pair<std::string, double>> scores_of(const RoomDecision& decision) {
  std::vector<std::pair<std::string, double>> scores;
  for (const rooms::RoomScore& score : decision.rooms) scores.emplace_back(score.room, score.score);
  return scores;
}

void bind_recognizer(py::module_& module) {
  py::class_<RoomDecision>(module, "RoomDecision",
                           "In which room pictures were taken, or why that is not said.")
      .def_property_readonly(
          "verdict", [](const RoomDecision& self) { return std::string(to_string(self.verdict)); },
          "room, either, not sure or none of them")
      .def_property_readonly("room", &RoomDecision::room, "The room that is named, or None")
      .def_property_readonly("rooms", &scores_of,
                             "Every room with its probability, best first; they add up to 1")
      .def_readonly("familiarity", &RoomDecision::familiarity,
                    "Log odds that the pictures show one of the learned rooms")
      .def_readonly("why", &RoomDecision::why, "For people")
      .def_readonly("object", &RoomDecision::object,
                    "The thing that spoke most for the room; empty: none was needed")
      .def("__repr__", [](const RoomDecision& self) {
        return fmt::format("<roomwise.RoomDecision {}: {}>",
                           self.room().value_or(std::string(to_string(self.verdict))), self.why);
      });
  py::class_<Recognizer>(module, "Recognizer", "Says the room that pictures show.")
      .def_property_readonly(
          "rooms", [](const Recognizer& self) { return self.recognizer.rooms(); },
          "Those that were learned")
      .def(
          "recognize", &recognize, py::kw_only(), py::arg("depths") = py::none(),
          py::arg("camera") = py::none(),
          "Of one picture or more of one place, given one after the other: (height, width, 3) "
          "uint8, or paths. depths: one for each (see Localizer.locate), by whose place on the map "
          "the room is found, too. Images are copied; the GIL is released. May be called from "
          "several threads. Error where a picture cannot be read; ValueError where there is none, "
          "or "
          "depths are not as many.");
}

}  // namespace

void bind_questions(py::module_& module) {
  bind_localizer(module);
  bind_recognizer(module);
  const py::object home = module.attr("Home");
  py::class_<OpenHome> home_class(home);
  home_class.def(
      "localizer", &localizer_of, py::arg("seed") = 1, py::arg("threads") = 0,
      py::arg("progress") = py::none(),
      "A Localizer; it measures the key-frames of the largest component anew. progress: as for "
      "map_recording. Error where the home has no map; Ctrl-C stops it.");
  home_class.def(
      "recognizer", &recognizer_of, py::arg("networks") = py::none(), py::arg("places") = false,
      py::arg("threads") = 0, py::arg("progress") = py::none(),
      "A Recognizer of the rooms that were learned. networks: as for map_recording; the "
      "one that the rooms were learned with must be among them. places: also finds "
      "pictures with depth on the map, for which that is measured anew. Error where no rooms "
      "were learned, or their network is not among them.");
}

}  // namespace roomwise::python
