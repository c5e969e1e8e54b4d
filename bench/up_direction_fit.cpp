// How well key-frames' surfaces tell which way is up, and the constants of it
// (mapping::UpMeasurementOptions) fitted to recordings with truth:
//   up_direction_fit RECORDING[=CAMERA] ...
// CAMERA is fr1, fr2, ... as for `roomwise map --camera`. Each recording is left out of a
// fit once. Those whose folder holds a floorplan.json are simulated; these and real ones count as
// much.

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "roomwise/image/resample.h"
#include "roomwise/mapping/backend/up_measurement.h"
#include "roomwise/mapping/graph/up_direction.h"
#include "roomwise/motion/rgbd_pyramid.h"
#include "roomwise/recording/open_recording.h"
#include "roomwise/recording/trajectory_file.h"
#include "true_turning.h"

namespace {

using namespace roomwise;
using Eigen::Vector3d;
using mapping::UpMeasurementOptions;

// A frame at its true pose.
struct View {
  geometry::RigidTransform world_from_camera;
  Vector3d turning_rad_s = Vector3d::Zero();  // camera frame
  std::vector<Eigen::Vector3f> normals;
};

// How far off up was found about one axis, and what was known about it.
struct Residual {
  double off_rad = 0;
  double normals = 0;        // information, in normals
  double turning_rad_s = 0;  // about that axis
};

struct Recording {
  std::string name;
  bool is_simulated = false;
  std::vector<Residual> residuals;
};

constexpr int kEvery = 3;  // frames

// The true pose at a time, and how the camera turned; nothing where truth has none so near.
// Fails where the truth does not tell it.
Expected<std::optional<View>> true_view(const recording::Trajectory& truth, TimestampNs time_ns) {
  constexpr TimestampNs kNear_ns = 20'000'000;
  const auto after =
      std::ranges::lower_bound(truth, time_ns, {}, &recording::StampedPose::timestamp_ns);
  std::optional<View> view;
  TimestampNs nearest_ns = kNear_ns;
  for (auto at = after == truth.begin() ? after : after - 1; at != truth.end() && at <= after;
       ++at) {
    const TimestampNs off_ns = std::abs(at->timestamp_ns - time_ns);
    if (off_ns > nearest_ns) continue;
    nearest_ns = off_ns;
    view = View{at->world_from_camera, Vector3d::Zero(), {}};
    ROOMWISE_TRY(view->turning_rad_s,
                 true_turning_rad_s(truth, static_cast<std::size_t>(at - truth.begin())));
  }
  return view;
}

Expected<std::vector<View>> views_of(const std::filesystem::path& folder,
                                     const recording::RecordingOptions& options) {
  ROOMWISE_TRY(const auto truth, recording::read_truth(folder));
  ROOMWISE_TRY(auto source, recording::open_recording(folder, options));
  std::vector<View> views;
  for (int i = 0;; ++i) {
    ROOMWISE_TRY(const auto frame, source->next());
    if (!frame) return views;
    if (i % kEvery != 0) continue;
    auto found = true_view(truth, frame->timestamp_ns);
    if (!found) return Unexpected(std::move(found).error().with_context(folder.string()));
    std::optional<View> view = *std::move(found);
    if (!view) continue;
    const motion::RgbdPyramid small = motion::make_rgbd_pyramid(
        image::to_gray(frame->color), frame->depth, source->info().camera);
    view->normals =
        mapping::surface_normals(small.levels.front().depth, small.levels.front().camera);
    views.push_back(std::move(*view));
  }
}

// Up is where the surfaces of all views, at their true poses, say it is.
std::vector<Residual> residuals_of(const std::vector<View>& views) {
  mapping::UpDirectionEstimator estimator;
  for (const View& view : views) {
    estimator.add_camera(view.world_from_camera);
    for (const Eigen::Vector3f& normal : view.normals)
      estimator.add_normal(view.world_from_camera.rotation * normal.cast<double>());
  }
  const Vector3d up_world = estimator.estimate().up_world;
  UpMeasurementOptions in_normals;  // information counts normals
  in_normals.normal_sigma_rad = 1;
  in_normals.systematic_sigma_rad = 1e-9;
  in_normals.delay_s = 0;
  std::vector<Residual> residuals;
  for (const View& view : views) {
    const Vector3d up = view.world_from_camera.rotation.conjugate() * up_world;
    const auto measured = mapping::measure_up(view.normals, up, Vector3d::Zero(), in_normals);
    if (!measured) continue;
    const Vector3d off = measured->up_camera.cross(up);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(measured->information);
    for (const int axis : {1, 2}) {  // 0 is up itself
      const Vector3d about = axes.eigenvectors().col(axis);
      residuals.push_back(
          {about.dot(off), axes.eigenvalues()[axis], about.dot(view.turning_rad_s)});
    }
  }
  return residuals;
}

double variance(const Residual& residual, const UpMeasurementOptions& options) {
  return std::pow(options.normal_sigma_rad, 2) / std::max(residual.normals, 1e-3) +
         std::pow(options.systematic_sigma_rad, 2) +
         std::pow(options.delay_s * residual.turning_rad_s, 2);
}

// The mean of -log likelihood, by Student's distribution of four degrees of freedom: a sloping
// thing that is taken for level must not decide.
double surprise(const Recording& recording, const UpMeasurementOptions& options) {
  constexpr double kFreedom = 4;
  double sum = 0;
  for (const Residual& one : recording.residuals) {
    const double squared = variance(one, options);
    sum += 0.5 * std::log(squared) +
           (kFreedom + 1) / 2 * std::log1p(one.off_rad * one.off_rad / squared / kFreedom);
  }
  return sum / static_cast<double>(recording.residuals.size());
}

// Values from the smallest on, each a quarter more than the one before.
std::vector<double> steps(double smallest, double largest) {
  std::vector<double> values;
  for (double value = smallest; value <= largest; value *= 1.25) values.push_back(value);
  return values;
}

// The options with the delay that the recording itself bears out best.
UpMeasurementOptions with_own_delay(const Recording& recording, UpMeasurementOptions options) {
  UpMeasurementOptions best = options;
  double least = std::numeric_limits<double>::infinity();
  for (const double delay_s : steps(0.0005, 0.06)) {
    options.delay_s = delay_s;
    const double found = surprise(recording, options);
    if (found >= least) continue;
    least = found;
    best = options;
  }
  return best;
}

// Simulated and real recordings count as much, together. How far depth lags is each camera's own;
// one that is not known is taken for the worst.
UpMeasurementOptions fit(const std::vector<Recording>& recordings, const Recording* without) {
  std::array<double, 2> weight{};  // by whether it is simulated
  for (const Recording& one : recordings)
    if (&one != without) weight.at(one.is_simulated ? 1 : 0) += 1;
  UpMeasurementOptions best;
  double least = std::numeric_limits<double>::infinity();
  for (const double normal : steps(0.01, 0.1)) {
    for (const double systematic : steps(0.0005, 0.02)) {
      UpMeasurementOptions options;
      options.normal_sigma_rad = normal;
      options.systematic_sigma_rad = systematic;
      double sum = 0, delay_s = 0;
      for (const Recording& one : recordings) {
        if (&one == without) continue;
        const UpMeasurementOptions own = with_own_delay(one, options);
        sum += surprise(one, own) / weight.at(one.is_simulated ? 1 : 0);
        delay_s = std::max(delay_s, own.delay_s);
      }
      if (sum >= least) continue;
      least = sum;
      best = options;
      best.delay_s = delay_s;
    }
  }
  return best;
}

// The share of residuals within so many standard deviations.
double within(const Recording& recording, const UpMeasurementOptions& options, double sigmas) {
  const auto count = std::ranges::count_if(recording.residuals, [&](const Residual& one) {
    return std::abs(one.off_rad) <= sigmas * std::sqrt(variance(one, options));
  });
  return static_cast<double>(count) / static_cast<double>(recording.residuals.size());
}

std::string constants(const UpMeasurementOptions& options) {
  return fmt::format("{:.4f} rad {:.5f} rad {:.4f} s", options.normal_sigma_rad,
                     options.systematic_sigma_rad, options.delay_s);
}

Expected<void> run(int argc, char** argv) {
  if (argc < 2) return fail("usage: up_direction_fit RECORDING[=CAMERA] ...");
  std::vector<Recording> recordings;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const auto equals = argument.find('=');
    const std::filesystem::path folder = argument.substr(0, equals);
    recording::RecordingOptions options;
    if (equals != std::string::npos) {
      ROOMWISE_TRY(options.camera, geometry::camera_preset(argument.substr(equals + 1)));
    }
    ROOMWISE_TRY(const auto views, views_of(folder, options));
    Recording& one = recordings.emplace_back();
    one.name = (folder / "").lexically_normal().parent_path().filename().string();
    one.is_simulated = std::filesystem::exists(folder / "floorplan.json");
    one.residuals = residuals_of(views);
    if (one.residuals.empty()) return fail("{}: no frame shows what is level", folder.string());
    fmt::print("read {}: {} frames\n", one.name, views.size());
  }
  fmt::print("\n{:<28} {:>8} {:>9} {:>8} {:>8}   {}\n", "left out", "frames", "median", "1 sigma",
             "2 sigma", "fitted to the others: a normal, a picture, delay");
  for (const Recording& recording : recordings) {
    const UpMeasurementOptions options = fit(recordings, &recording);
    std::vector<double> off_deg;
    for (const Residual& one : recording.residuals)
      off_deg.push_back(std::abs(one.off_rad) * 180 / std::numbers::pi);
    std::ranges::nth_element(off_deg,
                             off_deg.begin() + static_cast<std::ptrdiff_t>(off_deg.size() / 2));
    fmt::print("{:<28} {:>8} {:>5.2f} deg {:>8.2f} {:>8.2f} {:>7.4f} s   {}\n", recording.name,
               recording.residuals.size() / 2, off_deg[off_deg.size() / 2],
               within(recording, options, 1), within(recording, options, 2),
               with_own_delay(recording, options).delay_s, constants(options));
  }
  fmt::print("{:<28} {:>49}{}\n", "fitted to all", "", constants(fit(recordings, nullptr)));
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  if (const auto done = run(argc, argv); !done) {
    fmt::print(stderr, "up_direction_fit: {}\n", done.error().message);
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}
