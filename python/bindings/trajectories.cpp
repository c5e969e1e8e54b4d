#include "python/bindings/trajectories.h"

#include <pybind11/stl.h>

#include "python/bindings/bindings.h"
#include "roomwise/evaluation/errors/trajectory_error.h"
#include "roomwise/recording/open_recording.h"

namespace roomwise::python {
namespace {

using evaluation::AbsoluteTrajectoryError;
using evaluation::ErrorStatistics;
using evaluation::PositionPair;
using evaluation::RelativePoseError;
using recording::StampedPose;

Trajectory trajectory_of(const py::object& timestamps_ns, const py::object& positions,
                         const py::object& quaternions) {
  const auto times = whole_array(timestamps_ns, {-1}, "(N,)", "timestamps_ns");
  const py::ssize_t count = times.shape(0);
  const auto places = real_array(positions, {count, 3}, fmt::format("({}, 3)", count), "positions");
  const auto turns =
      real_array(quaternions, {count, 4}, fmt::format("({}, 4)", count), "quaternions");
  Trajectory trajectory;
  for (py::ssize_t i = 0; i < count; ++i) {
    const Eigen::Map<const Eigen::Vector3d> place(places.data(i));
    const Eigen::Map<const Eigen::Vector4d> xyzw(turns.data(i));
    const bool is_later = i == 0 || times.at(i) > times.at(i - 1);
    if (!is_later || !place.allFinite() || !xyzw.allFinite() || !(xyzw.norm() > 1e-6)) {
      throw py::value_error(
          fmt::format("pose {}: expected a later time than the one before, a finite place and a "
                      "quaternion that has a length",
                      i));
    }
    trajectory.poses.push_back(
        {times.at(i),
         {Eigen::Quaterniond(xyzw[3], xyzw[0], xyzw[1], xyzw[2]).normalized(), place}});
  }
  return trajectory;
}

// One member of every pose, shown where it lies: `width` numbers a pose.
template <typename T>
py::array member_view(const py::object& self, const T* first, py::ssize_t width) {
  const auto& poses = self.cast<const Trajectory&>().poses;
  const auto count = static_cast<py::ssize_t>(poses.size());
  constexpr auto kStride = static_cast<py::ssize_t>(sizeof(StampedPose));
  if (width == 1) return view(first, {count}, {kStride}, self);
  return view(first, {count, width}, {kStride, py::ssize_t{sizeof(T)}}, self);
}

py::array timestamps_of(const py::object& self) {
  const auto& poses = self.cast<const Trajectory&>().poses;
  return member_view(self, poses.empty() ? nullptr : &poses.front().timestamp_ns, 1);
}

py::array positions_of(const py::object& self) {
  const auto& poses = self.cast<const Trajectory&>().poses;
  return member_view(
      self, poses.empty() ? nullptr : poses.front().world_from_camera.translation.data(), 3);
}

py::array quaternions_of(const py::object& self) {
  const auto& poses = self.cast<const Trajectory&>().poses;
  return member_view(
      self, poses.empty() ? nullptr : poses.front().world_from_camera.rotation.coeffs().data(), 4);
}

py::array_t<double> poses_of(const Trajectory& trajectory) {
  std::vector<geometry::RigidTransform> poses;
  for (const StampedPose& pose : trajectory.poses) poses.push_back(pose.world_from_camera);
  return matrices_of(poses);
}

// A column of the pairs, where it lies.
py::array places_of(const py::object& self, Eigen::Vector3d PositionPair::*place) {
  const auto& pairs = self.cast<const AbsoluteTrajectoryError&>().pairs;
  return view(pairs.empty() ? nullptr : (pairs.front().*place).data(),
              {static_cast<py::ssize_t>(pairs.size()), 3},
              {py::ssize_t{sizeof(PositionPair)}, py::ssize_t{sizeof(double)}}, self);
}

RelativePoseError relative_pose_error(const Trajectory& truth, const Trajectory& estimate,
                                      double delta, const std::string& unit,
                                      double max_time_difference_s) {
  evaluation::RelativePoseErrorOptions options;
  options.delta = delta;
  options.max_time_difference_s = max_time_difference_s;
  if (unit == "frames") {
    options.unit = evaluation::RelativePoseErrorOptions::Unit::kFrames;
  } else if (unit != "seconds") {
    throw py::value_error(fmt::format("unit = '{}' must be 'seconds' or 'frames'", unit));
  }
  return run_without_gil(
      [&] { return evaluation::relative_pose_error(truth.poses, estimate.poses, options); });
}

void bind_errors(py::module_& module) {
  py::class_<ErrorStatistics>(module, "ErrorStatistics",
                              "Of many errors, in the unit of what they are of.")
      .def_readonly("rmse", &ErrorStatistics::rmse)
      .def_readonly("mean", &ErrorStatistics::mean)
      .def_readonly("median", &ErrorStatistics::median)
      .def_readonly("std", &ErrorStatistics::std)
      .def_readonly("min", &ErrorStatistics::min)
      .def_readonly("max", &ErrorStatistics::max);
  py::class_<AbsoluteTrajectoryError>(
      module, "AbsoluteTrajectoryError",
      "The ATE of the TUM RGB-D benchmark; truth, estimate and timestamps_ns are read-only views.")
      .def_readonly("error_m", &AbsoluteTrajectoryError::error_m, "ErrorStatistics of distances, m")
      .def_readonly("best_scale", &AbsoluteTrajectoryError::best_scale,
                    "What the estimate's lengths must be multiplied by to fit best")
      .def_readonly("scaled_rmse_m", &AbsoluteTrajectoryError::scaled_rmse_m,
                    "The RMSE with that done, m")
      .def_property_readonly(
          "truth_from_estimate",
          [](const AbsoluteTrajectoryError& error) { return matrix_of(error.truth_from_estimate); },
          "4 x 4: the rigid transform that moves the estimate onto the truth")
      .def_property_readonly(
          "timestamps_ns",
          [](const py::object& self) {
            const auto& pairs = self.cast<const AbsoluteTrajectoryError&>().pairs;
            return view(pairs.empty() ? nullptr : &pairs.front().timestamp_ns,
                        {static_cast<py::ssize_t>(pairs.size())},
                        {py::ssize_t{sizeof(PositionPair)}}, self);
          },
          "(N,) int64: when the truth was there")
      .def_property_readonly(
          "truth", [](const py::object& self) { return places_of(self, &PositionPair::truth); },
          "(N, 3) m, in the truth's frame")
      .def_property_readonly(
          "estimate",
          [](const py::object& self) { return places_of(self, &PositionPair::estimate); },
          "(N, 3) m, aligned: in the truth's frame");
  py::class_<RelativePoseError>(
      module, "RelativePoseError",
      "The RPE of the TUM RGB-D benchmark: drift over a distance in time.")
      .def_readonly("count", &RelativePoseError::count, "Pairs of poses that were compared")
      .def_readonly("translation_m", &RelativePoseError::translation_m)
      .def_readonly("rotation_deg", &RelativePoseError::rotation_deg);
  module.def(
      "absolute_trajectory_error",
      [](const Trajectory& truth, const Trajectory& estimate, double max_time_difference_s) {
        return run_without_gil([&] {
          return evaluation::absolute_trajectory_error(truth.poses, estimate.poses,
                                                       max_time_difference_s);
        });
      },
      py::arg("truth"), py::arg("estimate"), py::arg("max_time_difference_s") = 0.02,
      "Pairs poses by time, moves the estimate onto the truth as a rigid body (Horn), and gives "
      "what "
      "stays. Error where the two do not overlap in time, fewer than three pairs are found, or "
      "they "
      "lie on one line.");
  module.def("relative_pose_error", &relative_pose_error, py::arg("truth"), py::arg("estimate"),
             py::arg("delta") = 1.0, py::arg("unit") = "seconds",
             py::arg("max_time_difference_s") = 0.02,
             "How far the estimated movement over `delta` ('seconds' or 'frames') differs from the "
             "true one. Error where no two poses are that far apart.");
}

}  // namespace

void bind_trajectories(py::module_& module) {
  py::class_<Trajectory>(
      module, "Trajectory",
      "Where a camera was, in the order of time: world_from_camera takes points of the camera "
      "frame "
      "(x right, y down, z forward; m) to the world. Its arrays are read-only views, not copies.")
      .def(py::init(&trajectory_of), py::arg("timestamps_ns"), py::arg("positions"),
           py::arg("quaternions"),
           "Of arrays: (N,) whole ns, strictly increasing; (N, 3) m; (N, 4) x y z w. They are "
           "copied. ValueError names the pose that is none.")
      .def_static(
          "read",
          [](const py::object& path) {
            return Trajectory{value_of(recording::read_trajectory(path_of(path, "path")))};
          },
          py::arg("path"),
          "TUM's format, a line a pose: timestamp tx ty tz qx qy qz qw. Error names the line that "
          "is wrong.")
      .def(
          "write",
          [](const Trajectory& self, const py::object& path) {
            value_of(recording::write_trajectory(path_of(path, "path"), self.poses));
          },
          py::arg("path"), "In TUM's format. Error where it cannot be written.")
      .def("__len__", [](const Trajectory& self) { return self.poses.size(); })
      .def("__repr__",
           [](const Trajectory& self) {
             return fmt::format("<roomwise.Trajectory of {} poses>", self.poses.size());
           })
      .def_property_readonly("timestamps_ns", &timestamps_of, "(N,) int64 ns, a view")
      .def_property_readonly("positions", &positions_of, "(N, 3) float64 m in the world, a view")
      .def_property_readonly("quaternions", &quaternions_of,
                             "(N, 4) float64 x y z w of world_from_camera, a view")
      .def_property_readonly("world_from_camera", &poses_of, "(N, 4, 4) float64, made anew");
  module.def(
      "read_truth",
      [](const py::object& path) {
        return Trajectory{value_of(recording::read_truth(path_of(path, "path")))};
      },
      py::arg("path"),
      "Where the camera truly was: of a text file in TUM's format that; of a recording its "
      "groundtruth.txt, or what the device itself wrote. Error where there is neither.");
  bind_errors(module);
}

}  // namespace roomwise::python
