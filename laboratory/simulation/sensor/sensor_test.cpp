#include "laboratory/simulation/sensor/sensor.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <set>

#include "roomwise/base/testing/testing.h"

namespace roomwise::simulation {
namespace {

constexpr double kDisparity_px_m = 0.075 * 580;  // of a first Kinect

geometry::PinholeCamera small_camera() {
  geometry::PinholeCamera camera;
  camera.fx = camera.fy = 130;
  camera.cx = 79.5;
  camera.cy = 59.5;
  camera.width = 160;
  camera.height = 120;
  camera.depth_units_per_metre = 5000;
  return camera;
}

// A grey wall at 2 m.
RenderedFrame wall(double distance_m = 2, float radiance = 0.18F) {
  const auto camera = small_camera();
  RenderedFrame frame;
  frame.radiance = {camera.width, camera.height, Eigen::Vector3f::Constant(radiance)};
  frame.depth_m = {camera.width, camera.height, static_cast<float>(distance_m)};
  frame.specularity = {camera.width, camera.height, 0.0F};
  frame.albedo = {camera.width, camera.height, 0.6F};
  frame.object = {camera.width, camera.height, std::uint16_t{0}};
  return frame;
}

image::RgbdFrame capture(const RenderedFrame& frame, const SensorOptions& options,
                         const WalkPose& pose = {}, std::uint64_t index = 0,
                         const ColorSettings& settings = {}, std::size_t threads = 2) {
  ThreadPool pool(threads);
  const auto sensor = Sensor::create(small_camera(), options);
  if (!sensor) throw std::runtime_error(sensor.error().message);
  return sensor->capture(frame, pose, index, settings, pool);
}

double share_without_depth(const image::DepthImage& depth) {
  double count = 0;
  for (const auto units : depth.pixels()) count += units == 0 ? 1 : 0;
  return count / static_cast<double>(depth.pixels().size());
}

struct Spread {
  double mean = 0, deviation = 0;
};
template <typename Pixels, typename Value>
Spread spread_of(const Pixels& pixels, const Value& value) {
  double sum = 0, square_sum = 0, count = 0;
  for (const auto& pixel : pixels) {
    const double number = value(pixel);
    sum += number;
    square_sum += number * number;
    ++count;
  }
  const double mean = sum / count;
  return {mean, std::sqrt(std::max(0.0, square_sum / count - mean * mean))};
}

SensorOptions only(const std::function<void(SensorOptions&)>& switch_on) {
  SensorOptions options = SensorOptions::ideal();
  switch_on(options);
  return options;
}

TEST(Sensor, IsExactWithAllEffectsOff) {
  RenderedFrame frame = wall();
  frame.depth_m.at(3, 4) = 0;
  frame.depth_m.at(5, 4) = 0.1234F;
  frame.depth_m.at(6, 4) = 12.5F;
  frame.depth_m.at(7, 4) = 20;  // more than 16 bits hold
  frame.specularity.at(5, 4) = 1;
  frame.radiance.at(8, 4) = {0, 0.5F, 2};
  const auto captured = capture(frame, SensorOptions::ideal());
  EXPECT_EQ(captured.depth.at(0, 0), 10000);
  EXPECT_EQ(captured.depth.at(3, 4), 0);
  EXPECT_EQ(captured.depth.at(5, 4), 617);
  EXPECT_EQ(captured.depth.at(6, 4), 62500);
  EXPECT_EQ(captured.depth.at(7, 4), 0);
  EXPECT_EQ(captured.color.at(0, 0), (Rgb8{118, 118, 118}));
  EXPECT_EQ(captured.color.at(8, 4), (Rgb8{0, 188, 255}));
}

TEST(Sensor, PassesTimeAndNumberOn) {
  WalkPose pose;
  pose.timestamp_ns = 123;
  const auto captured = capture(wall(), {}, pose, 7);
  EXPECT_EQ(captured.timestamp_ns, 123);
  EXPECT_EQ(captured.index, 7U);
}

TEST(Sensor, DepthNoiseGrowsWithTheSquareOfTheDistance) {
  const auto options = only([](auto& o) { o.depth_noise = true; });
  for (const double distance_m : {1.0, 2.0, 4.0}) {
    const auto captured = capture(wall(distance_m), options);
    const Spread spread =
        spread_of(captured.depth.pixels(), [](std::uint16_t units) { return units / 5000.0; });
    const double expected_m = options.depth_noise_m * distance_m * distance_m;
    EXPECT_NEAR(spread.deviation, expected_m, 0.05 * expected_m) << distance_m;
    EXPECT_NEAR(spread.mean, distance_m, 0.1 * expected_m + 1e-4) << distance_m;
  }
}

TEST(Sensor, NoiseWithQuantizationIsAsMeasuredOnAKinect) {
  const auto options = only([](auto& o) { o.depth_noise = o.depth_quantization = true; });
  for (const double distance_m : {1.5, 3.0}) {
    const Spread spread = spread_of(capture(wall(distance_m), options).depth.pixels(),
                                    [](std::uint16_t units) { return units / 5000.0; });
    const double expected_m = 0.0014 * distance_m * distance_m;
    EXPECT_NEAR(spread.deviation, expected_m, 0.15 * expected_m) << distance_m;
  }
}

TEST(Sensor, QuantizesDisparityInEighthsOfAPixel) {
  RenderedFrame frame = wall();
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      frame.depth_m.at(x, y) = 2 + static_cast<float>(y * 160 + x) / (160 * 120);
    }
  }
  const auto captured = capture(frame, only([](auto& o) { o.depth_quantization = true; }));
  const std::set<std::uint16_t> levels(captured.depth.pixels().begin(),
                                       captured.depth.pixels().end());
  EXPECT_NEAR(static_cast<double>(levels.size()), 8 * kDisparity_px_m * (1 / 2.0 - 1 / 3.0), 2);
  for (const auto units : levels) {
    const double steps = 8 * kDisparity_px_m / (units / 5000.0);
    EXPECT_NEAR(steps, std::round(steps), 0.03) << units;
  }
}

TEST(Sensor, NothingIsSeenWhereTheProjectorsLightIsBlocked) {
  RenderedFrame frame = wall(2);
  for (int y = 40; y < 80; ++y) {
    for (int x = 80; x < 120; ++x) frame.depth_m.at(x, y) = 1;
  }
  const auto captured = capture(frame, only([](auto& o) { o.projector_shadow = true; }));
  const int shadow_px = static_cast<int>(0.075 * 130 * (1 / 1.0 - 1 / 2.0));  // 4
  for (int y = 41; y < 79; ++y) {
    for (int x = 80 - shadow_px + 1; x < 80; ++x) EXPECT_EQ(captured.depth.at(x, y), 0) << x;
    EXPECT_EQ(captured.depth.at(80 - shadow_px - 2, y), 10000);
    EXPECT_EQ(captured.depth.at(80, y), 5000);
    EXPECT_EQ(captured.depth.at(120, y), 10000) << "the other side is lit";
  }
  EXPECT_EQ(
      share_without_depth(capture(wall(), only([](auto& o) { o.projector_shadow = true; })).depth),
      0);
}

TEST(Sensor, LosesShinySurfaces) {
  const auto options = only([](auto& o) { o.lost_surfaces = true; });
  const auto lost_at = [&](float specularity) {
    RenderedFrame frame = wall();
    for (float& pixel : frame.specularity.pixels()) pixel = specularity;
    return share_without_depth(capture(frame, options).depth);
  };
  EXPECT_EQ(lost_at(0.04F), 0);
  EXPECT_NEAR(lost_at(0.375F), 0.5, 0.1);  // in the middle between the two shares
  EXPECT_EQ(lost_at(1), 1);
}

TEST(Sensor, LosesDarkSurfacesThatAreFar) {
  const auto options = only([](auto& o) { o.lost_surfaces = true; });
  const auto lost_at = [&](float albedo, double distance_m) {
    RenderedFrame frame = wall(distance_m);
    for (float& pixel : frame.albedo.pixels()) pixel = albedo;
    return share_without_depth(capture(frame, options).depth);
  };
  EXPECT_EQ(lost_at(0.6F, 4.5), 0);
  EXPECT_EQ(lost_at(0.02F, 1), 0);
  EXPECT_GT(lost_at(0.02F, 3.5), 0.4);
  EXPECT_EQ(lost_at(0.01F, 4), 1);
}

TEST(Sensor, LosesSurfacesAtGrazingAngles) {
  const auto options = only([](auto& o) { o.lost_surfaces = true; });
  // A wall along the line of sight, `offset_m` to the right of it, seen in the right half.
  const auto lost_at = [&](double offset_m, int x) {
    const auto camera = small_camera();
    RenderedFrame frame = wall(50);
    for (int y = 0; y < camera.height; ++y) {
      for (int column = 80; column < camera.width; ++column) {
        frame.depth_m.at(column, y) =
            static_cast<float>(offset_m * camera.fx / (column - camera.cx));
      }
    }
    const auto captured = capture(frame, options);
    double lost = 0;
    for (int y = 0; y < camera.height; ++y) lost += captured.depth.at(x, y) == 0 ? 1 : 0;
    return lost / camera.height;
  };
  EXPECT_GT(lost_at(0.05, 84), 0.9) << "at 88 degrees";
  EXPECT_EQ(lost_at(0.5, 140), 0) << "at 65 degrees";
}

TEST(Sensor, OutlinesAreRagged) {
  RenderedFrame frame = wall(2);
  for (int y = 0; y < 120; ++y) {
    for (int x = 80; x < 160; ++x) frame.depth_m.at(x, y) = 3;
  }
  const auto captured = capture(frame, only([](auto& o) { o.edge_jitter = true; }));
  int swapped = 0;
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      const bool is_exact = captured.depth.at(x, y) == (x < 80 ? 10000 : 15000);
      if (x < 79 || x > 80) {
        EXPECT_TRUE(is_exact) << x << ' ' << y;
      } else if (!is_exact) {
        ++swapped;
      }
    }
  }
  // A pixel beside the edge is taken from beyond it where the error exceeds half a pixel:
  // P(0.8 n > 0.5) = 0.27.
  EXPECT_NEAR(swapped / 240.0, 0.27, 0.09);
}

TEST(Sensor, SeesOnlyItsRange) {
  const auto options = only([](auto& o) { o.limited_range = true; });
  EXPECT_EQ(share_without_depth(capture(wall(0.49), options).depth), 1);
  EXPECT_EQ(share_without_depth(capture(wall(0.51), options).depth), 0);
  EXPECT_EQ(share_without_depth(capture(wall(4.99), options).depth), 0);
  EXPECT_EQ(share_without_depth(capture(wall(5.01), options).depth), 1);
}

TEST(Sensor, HighlightsFadeToWhite) {
  auto options = SensorOptions::ideal();
  EXPECT_EQ(capture(wall(2, 1.2F), options).color.at(0, 0).r, 255);
  options.soft_shoulder = true;
  const auto level = [&](float radiance) {
    return capture(wall(2, radiance), options).color.at(0, 0).r;
  };
  EXPECT_EQ(level(0.18F), 118) << "the middle stays as it is";
  EXPECT_LT(level(1.2F), 252);
  EXPECT_GT(level(1.2F), level(1.0F));
  EXPECT_EQ(level(8), 255);
}

TEST(Sensor, ColorNoiseIsThatOfCountingPhotons) {
  const auto options = only([](auto& o) { o.color_noise = true; });
  for (const double amplification : {1.0, 8.0}) {
    ColorSettings settings;
    settings.amplification = amplification;
    const auto captured = capture(wall(2, 0.18F), options, {}, 0, settings);
    const Spread spread =
        spread_of(captured.color.pixels(), [](Rgb8 pixel) { return static_cast<double>(pixel.g); });
    const double noise =
        std::sqrt(0.18 * amplification / 8000 + std::pow(0.0015 * amplification, 2));
    const double levels_per_light =  // slope of sRGB's curve at 0.18
        255 * 1.055 / 2.4 * std::pow(0.18, 1 / 2.4 - 1);
    EXPECT_NEAR(spread.deviation, noise * levels_per_light, 0.1 * noise * levels_per_light + 0.05);
    EXPECT_NEAR(spread.mean, 117.7, 1);
  }
}

// The left half dark, the right half bright.
RenderedFrame step_edge(double distance_m) {
  RenderedFrame frame = wall(distance_m, 0);
  for (int y = 0; y < 120; ++y) {
    for (int x = 80; x < 160; ++x) frame.radiance.at(x, y) = Eigen::Vector3f::Ones();
  }
  return frame;
}

// How many pixels of the middle row are neither dark nor bright.
int grey_pixels(const image::ColorImage& color) {
  int count = 0;
  for (const Rgb8 pixel : color.row(60)) count += pixel.g > 5 && pixel.g < 250 ? 1 : 0;
  return count;
}

WalkPose turning(double angle_rad) {
  WalkPose pose;
  pose.world_from_camera_open.rotation =
      Eigen::AngleAxisd(-angle_rad / 2, Eigen::Vector3d::UnitY());
  pose.world_from_camera_close.rotation =
      Eigen::AngleAxisd(angle_rad / 2, Eigen::Vector3d::UnitY());
  return pose;
}

TEST(Sensor, TurningBlursByTheWayOnTheSensor) {
  const auto options = only([](auto& o) { o.motion_blur = true; });
  EXPECT_EQ(grey_pixels(capture(step_edge(2), options).color), 0) << "at rest";
  const double angle_rad = 10 / small_camera().fx;  // ten pixels
  EXPECT_NEAR(grey_pixels(capture(step_edge(2), options, turning(angle_rad)).color), 10, 2);
  EXPECT_NEAR(grey_pixels(capture(step_edge(0), options, turning(angle_rad)).color), 10, 2)
      << "the sky turns too";
  EXPECT_EQ(grey_pixels(capture(step_edge(2), SensorOptions::ideal(), turning(0.1)).color), 0);
}

TEST(Sensor, SteppingAsideBlursWhatIsNearMost) {
  const auto options = only([](auto& o) { o.motion_blur = true; });
  WalkPose pose;
  pose.world_from_camera_open.translation = {-0.05, 0, 0};
  pose.world_from_camera_close.translation = {0.05, 0, 0};
  EXPECT_NEAR(grey_pixels(capture(step_edge(1), options, pose).color), 13, 2);  // 130 px * 0.1 m
  EXPECT_NEAR(grey_pixels(capture(step_edge(4), options, pose).color), 3, 1);
}

// The pixel sees during the exposure what comes to it, not what goes from it.
TEST(Sensor, BlursAlongTheMotionsDirection) {
  const auto options = only([](auto& o) { o.motion_blur = true; });
  WalkPose pose;  // opens where the frame was drawn, then the camera turns to the right
  pose.world_from_camera_close.rotation =
      Eigen::AngleAxisd(10 / small_camera().fx, Eigen::Vector3d::UnitY());
  const auto captured = capture(step_edge(2), options, pose);
  EXPECT_GT(captured.color.at(75, 60).g, 100) << "the bright half comes in from the right";
  EXPECT_GT(captured.color.at(82, 60).g, 250);
}

TEST(ExposureControl, BringsTheMeanToMidGrey) {
  SensorOptions options;
  options.exposure_errors = options.white_balance_errors = false;
  for (const float radiance : {5.0F, 40.0F, 3000.0F}) {
    ExposureControl control(options);
    const ColorSettings settings = control.next(wall(2, radiance), 0, 0);
    EXPECT_NEAR(radiance * settings.exposure, 0.18, 1e-3);
    EXPECT_NEAR(settings.amplification, std::max(1.0, 30 / static_cast<double>(radiance)), 1e-3);
  }
  ExposureControl control(options);
  const ColorSettings night = control.next(wall(2, 0.1F), 0, 0);
  EXPECT_DOUBLE_EQ(night.amplification, 16) << "no more can be amplified";
  EXPECT_LT(0.1 * night.exposure, 0.02);
}

TEST(ExposureControl, AdaptsOverSomeFrames) {
  SensorOptions options;
  options.exposure_errors = options.white_balance_errors = false;
  ExposureControl control(options);
  const double before = control.next(wall(2, 50), 0, 0).exposure;
  std::vector<double> way;  // to the new exposure, in powers of two: 3 are needed
  for (std::uint64_t i = 1; i <= 20; ++i) {
    const auto time_ns = static_cast<TimestampNs>(i * 100'000'000);
    way.push_back(std::log2(before / control.next(wall(2, 400), time_ns, i).exposure));
  }
  EXPECT_TRUE(std::ranges::is_sorted(way));
  EXPECT_GT(way.front(), 0.2);
  EXPECT_LT(way.front(), 1.2);
  EXPECT_NEAR(way.back(), 3, 0.1);
}

TEST(ExposureControl, LeavesAPartOfALampsWarmth) {
  SensorOptions options;
  options.exposure_errors = options.white_balance_errors = false;
  RenderedFrame frame = wall();
  for (auto& pixel : frame.radiance.pixels()) pixel = {30, 20, 10};
  ExposureControl control(options);
  const Eigen::Vector3f balance = control.next(frame, 0, 0).balance;
  EXPECT_NEAR(30 * balance.x() / 20, std::pow(1.5, 0.25), 0.01);
  EXPECT_NEAR(10 * balance.z() / 20, std::pow(0.5, 0.25), 0.01);
  EXPECT_EQ(balance.y(), 1);
}

TEST(ExposureControl, TakesTheLightsColorFromBrightSurfaces) {
  SensorOptions options;
  options.exposure_errors = options.white_balance_errors = false;
  RenderedFrame frame = wall();
  for (auto& pixel : frame.radiance.pixels()) pixel = {6, 3, 1};  // a wooden floor in white light
  for (int y = 0; y < 40; ++y) {
    for (auto& pixel : frame.radiance.row(y)) pixel = {12, 12, 12};  // a white wall
  }
  ExposureControl control(options);
  const Eigen::Vector3f balance = control.next(frame, 0, 0).balance;
  EXPECT_NEAR(balance.x(), 1, 0.03);
  EXPECT_NEAR(balance.z(), 1, 0.03);
}

TEST(ExposureControl, ErrsNowAndThen) {
  const auto deviation_ev = [](const SensorOptions& options) {
    ExposureControl control(options);
    std::vector<double> errors;
    for (std::uint64_t i = 0; i < 600; ++i) {
      const auto settings = control.next(wall(2, 50), static_cast<TimestampNs>(i) * 200'000'000, i);
      errors.push_back(std::log2(settings.exposure * 50 / 0.18));
    }
    return spread_of(errors, [](double error) { return error; }).deviation;
  };
  SensorOptions options;
  EXPECT_GT(deviation_ev(options), 0.12);
  EXPECT_LT(deviation_ev(options), 0.6);
  options.exposure_errors = false;
  EXPECT_LT(deviation_ev(options), 1e-9);
}

TEST(ExposureControl, DoesNothingWhereItIsOff) {
  ExposureControl control(SensorOptions::ideal());
  const ColorSettings settings = control.next(wall(2, 50), 0, 0);
  EXPECT_EQ(settings.exposure, 1);
  EXPECT_EQ(settings.amplification, 1);
  EXPECT_EQ(settings.balance, Eigen::Vector3f::Ones());
}

TEST(Sensor, SameSeedGivesTheSameBitsAtAnyNumberOfThreads) {
  RenderedFrame frame = step_edge(2);
  for (int y = 30; y < 90; ++y) {
    for (int x = 40; x < 100; ++x) {
      frame.depth_m.at(x, y) = 1.2F;
      frame.specularity.at(x, y) = 0.4F;
    }
  }
  const auto taken = capture(frame, {}, turning(0.05), 3, {}, 1);
  const auto again = capture(frame, {}, turning(0.05), 3, {}, 4);
  EXPECT_EQ(taken.color, again.color);
  EXPECT_EQ(taken.depth, again.depth);

  const auto next = capture(frame, {}, turning(0.05), 4);
  EXPECT_NE(taken.color, next.color);
  EXPECT_NE(taken.depth, next.depth);
  SensorOptions other;
  other.seed = 1;
  const auto reseeded = capture(frame, other, turning(0.05), 3);
  EXPECT_NE(taken.color, reseeded.color);
  EXPECT_NE(taken.depth, reseeded.depth);
}

TEST(Sensor, RefusesOptionsThatMakeNoSense) {
  SensorOptions options;
  options.farthest_m = 0.4;
  EXPECT_ERROR(options.validate(), "range");
  options = {};
  options.depth_noise_m = -1;
  EXPECT_ERROR(Sensor::create(small_camera(), options), "depth_noise_m");
  EXPECT_ERROR(Sensor::create({}, {}), "");
}

}  // namespace
}  // namespace roomwise::simulation
