#include "python/bindings/recordings.h"

#include <pybind11/stl.h>

#include <cmath>

#include "python/bindings/bindings.h"
#include "python/bindings/trajectories.h"
#include "roomwise/recording/camera_file.h"
#include "roomwise/recording/open_recording.h"

namespace roomwise::python {
namespace {

using geometry::PinholeCamera;

// A recording, shared with those that go through it.
using SharedRecording = std::shared_ptr<recording::Recording>;

PinholeCamera camera_of_numbers(double fx, double fy, double cx, double cy, int width, int height,
                                double depth_units_per_metre, std::array<double, 5> distortion) {
  PinholeCamera camera;
  camera.fx = fx;
  camera.fy = fy;
  camera.cx = cx;
  camera.cy = cy;
  camera.width = width;
  camera.height = height;
  camera.depth_units_per_metre = depth_units_per_metre;
  const auto [k1, k2, p1, p2, k3] = distortion;
  camera.distortion = {k1, k2, p1, p2, k3};
  value_of(camera.validate());
  return camera;
}

py::array_t<double> matrix_of_camera(const PinholeCamera& camera) {
  py::array_t<double> matrix({3, 3});
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(matrix.mutable_data()) << camera.fx, 0,
      camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
  return matrix;
}

Frame frame_at(const SharedRecording& recording, std::size_t place) {
  auto frame = run_without_gil([&] { return recording->frame(recording->frames()[place]); });
  return {*std::move(frame), recording->info().camera};
}

// Goes through a recording from its first frame on.
struct FrameIterator {
  SharedRecording recording;
  std::size_t place = 0;
};

SharedRecording read_recording(const py::object& path, const py::object& camera,
                               double tolerance_s) {
  recording::RecordingOptions options;
  options.camera = camera_of(camera);
  if (!(tolerance_s > 0 && tolerance_s < 1e6)) {
    throw py::value_error(
        fmt::format("tolerance_s = {} must be above 0 and below 1e6", tolerance_s));
  }
  options.tolerance_ns = static_cast<TimestampNs>(std::llround(tolerance_s * 1e9));
  const std::filesystem::path file = path_of(path, "path");
  return run_without_gil([&] { return recording::open_recording(file, options); });
}

void bind_camera(py::module_& module) {
  py::class_<PinholeCamera>(
      module, "Camera",
      "A pinhole camera with Brown's lens distortion, whose depth image is registered to its "
      "colour "
      "image. Pixel (0, 0) is the centre of the top left pixel; the camera frame has x right, y "
      "down, z forward.")
      .def(py::init(&camera_of_numbers), py::arg("fx"), py::arg("fy"), py::arg("cx"), py::arg("cy"),
           py::arg("width"), py::arg("height"), py::arg("depth_units_per_metre") = 1000.0,
           py::arg("distortion") = std::array<double, 5>{},
           "Focal lengths and principal point in px; distortion k1 k2 p1 p2 k3. Error says which "
           "value cannot be.")
      .def_static(
          "named", [](const std::string& name) { return value_of(geometry::camera_preset(name)); },
          py::arg("name"),
          "fr1, fr2, fr3 (TUM's calibrations), kinect-v1 or xtion; Error at another name.")
      .def_static(
          "read",
          [](const py::object& path) {
            return value_of(recording::read_camera(path_of(path, "path")));
          },
          py::arg("path"), "A camera.txt; Error names the line and the value that is wrong.")
      .def_readonly("fx", &PinholeCamera::fx)
      .def_readonly("fy", &PinholeCamera::fy)
      .def_readonly("cx", &PinholeCamera::cx)
      .def_readonly("cy", &PinholeCamera::cy)
      .def_readonly("width", &PinholeCamera::width)
      .def_readonly("height", &PinholeCamera::height)
      .def_readonly("depth_units_per_metre", &PinholeCamera::depth_units_per_metre)
      .def_property_readonly(
          "distortion",
          [](const PinholeCamera& camera) {
            const geometry::LensDistortion& lens = camera.distortion;
            return std::tuple(lens.k1, lens.k2, lens.p1, lens.p2, lens.k3);
          },
          "k1, k2, p1, p2, k3")
      .def_property_readonly("matrix", &matrix_of_camera, "3 x 3 float64, px")
      .def(
          "__eq__", [](const PinholeCamera& a, const PinholeCamera& b) { return a == b; },
          py::is_operator())
      .def("__repr__", [](const PinholeCamera& camera) {
        return fmt::format("<roomwise.Camera {} x {}, f {:g} {:g}, c {:g} {:g} px>", camera.width,
                           camera.height, camera.fx, camera.fy, camera.cx, camera.cy);
      });
}

void bind_frame(py::module_& module) {
  py::class_<Frame>(module, "Frame",
                    "One moment of an RGB-D camera. Its images are read-only views of memory that "
                    "the frame owns and they keep alive; copy() what is to be changed.")
      .def_property_readonly(
          "color",
          [](const py::object& self) { return view(self.cast<const Frame&>().frame.color, self); },
          "(height, width, 3) uint8, R G B: a view")
      .def_property_readonly(
          "depth",
          [](const py::object& self) { return view(self.cast<const Frame&>().frame.depth, self); },
          "(height, width) uint16 along the optical axis, in the camera's depth_units_per_metre, 0 "
          "where nothing was measured: a view")
      .def_property_readonly(
          "depth_m",
          [](const Frame& self) {
            return depth_in_metres(self.frame.depth, self.camera.depth_units_per_metre);
          },
          "(height, width) float32 m, NaN where nothing was measured: made anew at each call")
      .def_property_readonly(
          "camera", [](const Frame& self) { return self.camera; }, "Camera: the intrinsics")
      .def_property_readonly(
          "index", [](const Frame& self) { return self.frame.index; },
          "The colour image's place in the recording's list, from 0")
      .def_property_readonly(
          "timestamp_ns", [](const Frame& self) { return self.frame.timestamp_ns; },
          "Of the colour image, ns since the recording's epoch")
      .def_property_readonly(
          "time_s", [](const Frame& self) { return seconds_between(0, self.frame.timestamp_ns); },
          "The same in s, rounded to a float")
      .def_property_readonly(
          "device_pose",
          [](const Frame& self) -> py::object {
            const auto& motion = self.frame.device_motion;
            if (!motion) return py::none();
            return matrix_of(motion->world_from_camera);
          },
          "4 x 4 world_from_camera as the device itself tells it, or None")
      .def("__repr__", [](const Frame& self) {
        return fmt::format("<roomwise.Frame {} at {} s, {} x {}>", self.frame.index,
                           format_timestamp(self.frame.timestamp_ns), self.frame.color.width(),
                           self.frame.color.height());
      });
}

void bind_recording(py::module_& module) {
  py::class_<recording::Recording, SharedRecording>(
      module, "Recording",
      "An RGB-D recording on the disk, of any kind that Roomwise reads: a sequence of Frame. "
      "Images "
      "are decoded when a frame is asked for, without the GIL.")
      .def("__len__", [](const recording::Recording& self) { return self.frames().size(); })
      .def(
          "__getitem__",
          [](const SharedRecording& self, py::ssize_t i) {
            const auto count = static_cast<py::ssize_t>(self->frames().size());
            if (i < -count || i >= count) {
              throw py::index_error(fmt::format("frame {} of {}: the recording has {} frames", i,
                                                self->info().name, count));
            }
            return frame_at(self, static_cast<std::size_t>(i < 0 ? i + count : i));
          },
          py::arg("i"),
          "The i-th frame that has depth. Error, naming its file, where an image cannot be read.")
      .def(
          "__iter__", [](const SharedRecording& self) { return FrameIterator{self}; },
          "From the first frame on, each time. After an Error it goes on with the next frame.")
      .def_property_readonly("name",
                             [](const recording::Recording& self) { return self.info().name; })
      .def_property_readonly("kind", &recording::Recording::kind, "For people: 'TUM folder'")
      .def_property_readonly("camera",
                             [](const recording::Recording& self) { return self.info().camera; })
      .def_property_readonly("notes", &recording::Recording::notes,
                             "For people: what was chosen among several streams, or passed over")
      .def_property_readonly(
          "device_trajectory",
          [](const recording::Recording& self) { return Trajectory{self.device_poses()}; },
          "Where the device says that it was; empty where it wrote nothing")
      .def("__repr__", [](const recording::Recording& self) {
        return fmt::format("<roomwise.Recording {}: {}, {} frames>", self.info().name, self.kind(),
                           self.frames().size());
      });
  py::class_<FrameIterator>(module, "FrameIterator", "Goes through a recording.")
      .def("__iter__", [](FrameIterator& self) -> FrameIterator& { return self; })
      .def("__next__", [](FrameIterator& self) {
        if (self.place >= self.recording->frames().size()) throw py::stop_iteration();
        return frame_at(self.recording, self.place++);
      });
  module.def(
      "read_recording", &read_recording, py::arg("path"), py::arg("camera") = py::none(),
      py::arg("tolerance_s") = 0.02,
      "Opens a recording of any kind that is read (docs/recordings.md). camera: a Camera, the name "
      "of a preset or the path of a camera.txt, in place of what the recording says. tolerance_s: "
      "a "
      "colour and a depth image less than this apart make a frame. Error where nothing is there or "
      "no kind fits.");
}

}  // namespace

std::optional<PinholeCamera> camera_of(const py::object& camera) {
  if (camera.is_none()) return std::nullopt;
  if (py::isinstance<PinholeCamera>(camera)) return camera.cast<PinholeCamera>();
  if (!is_path(camera)) {
    throw py::type_error(
        fmt::format("camera: expected a Camera, the name of a preset or the path of a camera.txt; "
                    "got {}",
                    std::string(py::str(py::type::of(camera).attr("__name__")))));
  }
  return value_of(recording::resolve_camera(path_of(camera, "camera").string()));
}

void bind_recordings(py::module_& module) {
  bind_camera(module);
  bind_frame(module);
  bind_recording(module);
}

}  // namespace roomwise::python
