// PnP with RANSAC by Roomwise and by OpenCV on the same matches:
//   motion_benchmark
// Matches are made up, with known motion and share of outliers, and those of real frames a few
// apart (recordings are looked for in ROOMWISE_DATA; truth is theirs). Both have the same
// threshold, most iterations and confidence. Matching is not counted.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <functional>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "roomwise/image/resample.h"
#include "roomwise/motion/motion_estimator.h"
#include "roomwise/pipeline/stored/map_settings.h"
#include "roomwise/pipeline/stored/measured_frame_reader.h"
#include "roomwise/recording/open_recording.h"
#include "roomwise/recording/trajectory_file.h"

namespace {

using namespace roomwise;
using geometry::PinholeCamera;
using geometry::RigidTransform;
using Observations = std::vector<motion::PointObservation>;

// Matches, and the motion behind them.
struct Trial {
  Observations observations;
  RigidTransform reference_from_current;
  std::uint64_t seed = 0;
};
struct Trials {
  std::string name;
  PinholeCamera camera;
  std::vector<Trial> trials;
};

struct Way {
  std::string name;
  std::function<std::optional<RigidTransform>(const Trial&, const PinholeCamera&)> solve;
};

std::optional<RigidTransform> by_roomwise(const Trial& trial, const PinholeCamera& camera) {
  const motion::MotionOutcome outcome =
      motion::estimate_motion(trial.observations, camera, {}, RandomStream(trial.seed));
  if (!outcome.found()) return std::nullopt;
  return outcome.pose.reference_from_current;
}

// What OpenCV is told too: pixels, and no depth of the current frame.
std::optional<RigidTransform> by_roomwise_without_depth(const Trial& trial,
                                                        const PinholeCamera& camera) {
  Trial blind = trial;
  for (motion::PointObservation& observation : blind.observations) observation.depth_current_m = 0;
  return by_roomwise(blind, camera);
}

std::optional<RigidTransform> by_opencv(const Trial& trial, const PinholeCamera& camera,
                                        int method) {
  const motion::MotionOptions options;
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> pixels;
  for (const motion::PointObservation& each : trial.observations) {
    points.emplace_back(each.point_reference.x(), each.point_reference.y(),
                        each.point_reference.z());
    pixels.emplace_back(each.pixel_current.x(), each.pixel_current.y());
  }
  const cv::Matx33d matrix(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
  cv::Vec3d turn, shift;
  std::vector<int> inliers;
  if (!cv::solvePnPRansac(points, pixels, matrix, cv::noArray(), turn, shift, false,
                          options.max_iterations, static_cast<float>(options.inlier_px),
                          options.confidence, inliers, method)) {
    return std::nullopt;
  }
  const Eigen::Vector3d axis(turn[0], turn[1], turn[2]);
  const Eigen::AngleAxisd rotation(axis.norm(), axis.stableNormalized());
  return RigidTransform{Eigen::Quaterniond(rotation), {shift[0], shift[1], shift[2]}}.inverse();
}

std::vector<Way> ways() {
  return {{"Roomwise", by_roomwise},
          {"Roomwise, pixels alone", by_roomwise_without_depth},
          {"OpenCV, default (iterative)",
           [](const Trial& trial, const PinholeCamera& camera) {
             return by_opencv(trial, camera, cv::SOLVEPNP_ITERATIVE);
           }},
          {"OpenCV, P3P", [](const Trial& trial, const PinholeCamera& camera) {
             return by_opencv(trial, camera, cv::SOLVEPNP_P3P);
           }}};
}

// 300 matches of points 1 to 4 m away, 0.7 px of noise, disparities as noisy.
Trial made_up(const PinholeCamera& camera, double outliers, std::uint64_t seed) {
  constexpr int kMatches = 300;
  constexpr double kNoise_px = 0.7;
  constexpr double kStereo_px_m = 40;
  RandomStream random(seed);
  geometry::Vector6d twist;
  for (double& value : twist) value = 0.12 * random.normal();
  Trial trial{{}, RigidTransform::exp(twist), seed};
  const auto anywhere = [&] {
    return Eigen::Vector2d(camera.width * random.uniform(), camera.height * random.uniform());
  };
  const auto noise = [&] { return kNoise_px * random.normal(); };
  for (int i = 0; i < kMatches; ++i) {
    const Eigen::Vector2d pixel = anywhere();
    const double depth_m = 1 + 3 * random.uniform();
    const Eigen::Vector3d point =
        trial.reference_from_current * camera.unproject_undistorted(pixel, depth_m);
    const bool wrong = i < outliers * kMatches;
    const double measured_m = kStereo_px_m / (kStereo_px_m / depth_m + noise());
    trial.observations.push_back(
        {point, wrong ? anywhere() : Eigen::Vector2d(pixel + Eigen::Vector2d(noise(), noise())),
         wrong ? 1 + 3 * random.uniform() : measured_m});
  }
  return trial;
}

Trials made_up_trials(double outliers) {
  Trials trials{fmt::format("made up, {:.0f} % outliers", 100 * outliers),
                geometry::camera_preset("fr3").value(),
                {}};
  for (std::uint64_t seed = 1; seed <= 100; ++seed)
    trials.trials.push_back(made_up(trials.camera, outliers, seed));
  return trials;
}

// The pose whose time is nearest, where that is near.
std::optional<RigidTransform> pose_at(const recording::Trajectory& truth, TimestampNs time_ns) {
  constexpr TimestampNs kNear_ns = 20'000'000;
  const auto nearest = std::ranges::min_element(
      truth, {}, [&](const auto& pose) { return std::abs(pose.timestamp_ns - time_ns); });
  if (nearest == truth.end() || std::abs(nearest->timestamp_ns - time_ns) > kNear_ns)
    return std::nullopt;
  return nearest->world_from_camera;
}

// Each pair of frames `apart` from each other, of which the first is a multiple of `every`.
Expected<Trials> real_trials(const std::filesystem::path& folder,
                             const std::optional<PinholeCamera>& camera, std::size_t apart,
                             std::size_t every) {
  ROOMWISE_TRY(const auto source, recording::open_recording(folder, {.camera = camera}));
  ROOMWISE_TRY(const auto truth, recording::read_trajectory(folder / "groundtruth.txt"));
  const pipeline::MapSettings settings;
  const auto extractor = features::make_extractor(settings.features, settings.max_keypoints);
  Trials trials{fmt::format("{}, {} frames apart", folder.filename().string(), apart),
                source->info().camera,
                {}};
  std::optional<motion::MeasuredFeatures> reference;
  std::optional<RigidTransform> reference_pose;
  for (std::size_t i = 0;; ++i) {
    ROOMWISE_TRY(const auto frame, source->next());
    if (!frame) return trials;
    if (i % every != 0 && i % every != apart) continue;
    auto measured = motion::measure_features(extractor->extract(image::to_gray(frame->color)),
                                             frame->depth, trials.camera, settings.depth);
    const auto pose = pose_at(truth, frame->timestamp_ns);
    if (i % every == 0) {
      reference = std::move(measured);
      reference_pose = pose;
    } else if (pose && reference_pose) {
      auto matches = motion::match_points(*reference, measured, motion::MotionOptions{}.matching);
      // OpenCV wants five at least; fewer than these are none to us either.
      if (static_cast<int>(matches.size()) < motion::MotionOptions{}.min_matches) continue;
      trials.trials.push_back({std::move(matches), reference_pose->inverse() * *pose, i});
    }
  }
}

std::string median_and_range(std::vector<double> values, int decimals) {
  if (values.empty()) return "-";
  std::ranges::sort(values);
  return fmt::format("{:.{}f} ({:.{}f} to {:.{}f})", values[values.size() / 2], decimals,
                     values.front(), decimals, values.back(), decimals);
}

void print_row(const Trials& trials, const Way& way) {
  // Farther from the truth than this is wrong.
  constexpr double kRight_m = 0.1;
  constexpr double kRight_rad = 0.05;
  std::vector<double> cpu_ms, angle_mrad, distance_mm;
  int wrong = 0;
  for (const Trial& trial : trials.trials) {
    const std::clock_t start = std::clock();
    const auto found = way.solve(trial, trials.camera);
    cpu_ms.push_back(1000.0 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
    if (!found) continue;
    const RigidTransform error = trial.reference_from_current.inverse() * *found;
    if (!(error.angle_rad() < kRight_rad && error.distance_m() < kRight_m)) {
      ++wrong;
      continue;
    }
    angle_mrad.push_back(1000 * error.angle_rad());
    distance_mm.push_back(1000 * error.distance_m());
  }
  fmt::print("| {} | {} | {} of {} | {} | {} | {} | {} |\n", trials.name, way.name,
             angle_mrad.size(), trials.trials.size(), wrong, median_and_range(cpu_ms, 2),
             median_and_range(angle_mrad, 1), median_and_range(distance_mm, 1));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1) {
    fmt::print(stderr, "'{}' is one argument too many; usage: motion_benchmark\n", argv[1]);
    return 2;
  }
  cv::setNumThreads(1);
  std::vector<Trials> all;
  for (const double outliers : {0.2, 0.5, 0.7}) all.push_back(made_up_trials(outliers));
  if (const char* data = std::getenv("ROOMWISE_DATA"); data != nullptr) {
    const std::filesystem::path folder(data);
    for (auto& trials : {real_trials(folder / "rgbd_dataset_freiburg1_rpy",
                                     geometry::camera_preset("fr1").value(), 10, 14),
                         real_trials(folder / "office_walk", std::nullopt, 3, 7)}) {
      if (!trials) {
        fmt::print(stderr, "{}\n", trials.error().message);
        return 1;
      }
      all.push_back(*trials);
    }
  }
  fmt::print("Median (range) over the trials; errors over the right ones.\n\n");
  fmt::print(
      "| matches | solver | right | wrong | CPU-ms | rotation error, mrad | translation error, mm "
      "|\n| --- | --- | --- | --- | --- | --- | --- |\n");
  for (const Trials& trials : all) {
    for (const Way& way : ways()) print_row(trials, way);
  }
  return 0;
}
