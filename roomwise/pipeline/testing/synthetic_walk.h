#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "roomwise/base/file.h"
#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/home/home.h"
#include "roomwise/network/vision/classifier.h"
#include "roomwise/recording/frame_source.h"
#include "roomwise/recording/trajectory_file.h"

// A made-up home for tests: not part of the product.
namespace roomwise::pipeline::testing {

// A walk that looks around inside a box with mosaic walls: exact images, depth and poses.
class SyntheticWalk final : public recording::FrameSource {
 public:
  explicit SyntheticWalk(int frames, double step_rad = 0.05, double first_rad = 0)
      : frames_(frames), step_rad_(step_rad), first_rad_(first_rad) {
    info_.name = "synthetic walk";
    info_.camera = {260, 260, 159.5, 119.5, 320, 240, {}, 1000};
    info_.frames_remaining = static_cast<std::uint64_t>(frames);
  }

  [[nodiscard]] const recording::SourceInfo& info() const override { return info_; }
  void skip_before(std::uint64_t index) override {
    next_ = std::min(static_cast<int>(index), frames_);
    info_.frames_remaining = static_cast<std::uint64_t>(frames_ - next_);
  }
  [[nodiscard]] Expected<std::optional<image::RgbdFrame>> next() override {
    if (next_ == frames_) return std::nullopt;
    if (next_ == fail_at) return fail("frame {} is damaged", next_);
    --*info_.frames_remaining;
    return render(next_++);
  }

  void take_camera(const geometry::PinholeCamera& camera) { info_.camera = camera; }

  // Frame i's true pose; the world is the first camera's frame where the walk begins at 0 rad.
  [[nodiscard]] geometry::RigidTransform world_from_camera(int frame) const {
    const auto pose = [&](double angle) {
      return geometry::RigidTransform{
          Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY())),
          {0.5 * std::sin(angle), 0.06 * std::sin(3 * angle), 0.3 * std::cos(angle)}};
    };
    return pose(0).inverse() * pose(first_rad_ + step_rad_ * frame);
  }
  [[nodiscard]] recording::Trajectory truth() const {
    recording::Trajectory truth;
    for (int i = 0; i < frames_; ++i) truth.push_back({timestamp_ns(i), world_from_camera(i)});
    return truth;
  }

  int fail_at = -1;  // the frame at which next() gives an error
  TimestampNs begins_ns = 1'000'000'000;
  int home = 0;  // the walls of each have mosaics of their own
  // But for this one, which looks like the first home's.
  std::optional<int> wall_of_first_home;
  Eigen::Array3d half_m{2.4, 1.4, 2.1};  // from the middle of the box to its walls

 private:
  TimestampNs timestamp_ns(int frame) const { return begins_ns + frame * 33'333'333LL; }

  // The colour of a wall at (u, v), m: blocks of three sizes, each with a shade of its own.
  [[nodiscard]] Rgb8 mosaic(int wall, double u, double v) const {
    double shade = 0;
    const int of_home = wall == wall_of_first_home ? 0 : home;
    for (const double size_m : {0.11, 0.27, 0.71}) {
      const auto cell = [&](double x) {
        return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(x / size_m)) + 1000);
      };
      shade += RandomStream(static_cast<std::uint64_t>(wall + 6 * of_home), {cell(u), cell(v)})
                   .uniform() /
               3;
    }
    const auto level = [&](double least, double most) {
      return static_cast<std::uint8_t>(least + (most - least) * shade);
    };
    // Each wall has a tint, so that a network can tell where it looks.
    return {level(wall % 2 == 0 ? 60 : 0, 255), level(wall % 3 == 0 ? 60 : 0, 220),
            level(10, wall < 2 ? 250 : 160)};
  }

  [[nodiscard]] image::RgbdFrame render(int index) const {
    const geometry::PinholeCamera& camera = info_.camera;
    image::RgbdFrame frame{static_cast<std::uint64_t>(index),
                           timestamp_ns(index),
                           image::ColorImage(camera.width, camera.height),
                           image::DepthImage(camera.width, camera.height),
                           {},
                           {}};
    const geometry::RigidTransform world_from = world_from_camera(index);
    for (int y = 0; y < camera.height; ++y) {
      for (int x = 0; x < camera.width; ++x) {
        const Eigen::Array3d ray = (world_from.rotation * camera.unproject({x, y}, 1.0)).array();
        const Eigen::Array3d origin = world_from.translation.array();
        // The nearest wall ahead on each axis.
        const Eigen::Array3d distance = (ray.sign() * half_m - origin) / ray;
        Eigen::Index axis = 0;
        const double z_m = distance.minCoeff(&axis);
        const Eigen::Array3d point = origin + z_m * ray;
        const int wall = static_cast<int>(2 * axis) + (ray[axis] > 0 ? 1 : 0);
        frame.color.at(x, y) = mosaic(wall, point[(axis + 1) % 3], point[(axis + 2) % 3]);
        frame.depth.at(x, y) =
            static_cast<std::uint16_t>(std::lround(camera.depth_units_per_metre * z_m));
      }
    }
    return frame;
  }

  int frames_;
  double step_rad_, first_rad_;
  int next_ = 0;
  recording::SourceInfo info_;
};

// Sees the mean colours of a 2x2 grid, and, with labels, which of them is strongest.
class ColorNetwork final : public network::Classifier {
 public:
  explicit ColorNetwork(std::vector<std::string> labels = {}) : labels_(std::move(labels)) {}

  [[nodiscard]] const std::string& name() const override { return name_; }
  [[nodiscard]] const std::string& fingerprint() const override { return fingerprint_; }
  [[nodiscard]] const std::vector<std::string>& labels() const override { return labels_; }
  [[nodiscard]] std::size_t feature_size() const override { return 12; }
  [[nodiscard]] Expected<network::Prediction> predict(
      const image::ColorImage& image) const override {
    network::Prediction prediction;
    prediction.features.assign(12, 0.0F);
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) {
        const std::size_t cell =
            (2 * y >= image.height() ? 6U : 0U) + (2 * x >= image.width() ? 3U : 0U);
        const Rgb8 color = image.at(x, y);
        prediction.features[cell] += static_cast<float>(color.r);
        prediction.features[cell + 1] += static_cast<float>(color.g);
        prediction.features[cell + 2] += static_cast<float>(color.b);
      }
    }
    if (!labels_.empty()) {
      prediction.scores.assign(labels_.size(), 0.1F / static_cast<float>(labels_.size()));
      prediction.scores[0] = 0.9F;
    }
    return prediction;
  }

 private:
  std::string name_ = "color network";
  std::vector<std::string> labels_;
  std::string fingerprint_ = labels_.empty() ? "c0102" : "c0103";
};

// The pictures of a home's key-frames, listed as in the recording that it was mapped from.
inline void write_mapped_pictures(const home::Home& home, const std::filesystem::path& folder) {
  std::string list, depths;
  const std::vector<home::Keyframe> keyframes = home.keyframes().value();
  for (const home::Keyframe& keyframe : keyframes) {
    for (std::size_t next = static_cast<std::size_t>(std::ranges::count(list, '\n'));
         next <= keyframe.frame_index; ++next) {
      list += fmt::format("{0}.0 {0}.png\n", next);
    }
    const auto picture = folder / fmt::format("{}.png", keyframe.frame_index);
    const home::KeyframeImages images = home.images(keyframe.id).value();
    EXPECT_OK(write_file(picture, images.color));
    EXPECT_OK(write_file(folder / fmt::format("{}.depth.png", keyframe.frame_index), images.depth));
    depths += fmt::format("{0}.0 {0}.depth.png\n", keyframe.frame_index);
  }
  EXPECT_OK(write_file(folder / "rgb.txt", std::string_view(list)));
  EXPECT_OK(write_file(folder / "depth.txt", std::string_view(depths)));
}

}  // namespace roomwise::pipeline::testing
