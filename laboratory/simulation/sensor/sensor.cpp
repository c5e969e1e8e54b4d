#include "laboratory/simulation/sensor/sensor.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "laboratory/simulation/sensor/depth_sensor.h"
#include "laboratory/simulation/sensor/motion_blur.h"
#include "roomwise/base/random.h"

namespace roomwise::simulation {
namespace {

constexpr std::uint64_t kColorStream = 0xC0107u;

// Electrons of a full pixel, and the noise of reading one, as a share of that.
constexpr float kFullWell = 8000;
constexpr float kReadNoise = 0.0015F;

// The tone curve is tabulated up to this many times white, by steps finer than a grey level.
constexpr float kBrightestLight = 8;
constexpr std::size_t kToneSteps = 1U << 16U;

double shoulder(double light) {
  constexpr double kKnee = 0.6;
  if (light <= kKnee) return light;
  return kKnee + (1 - kKnee) * (1 - std::exp(-(light - kKnee) / (1 - kKnee)));
}

double srgb_of(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

std::vector<std::uint8_t> tone_table(bool soft_shoulder) {
  std::vector<std::uint8_t> table(kToneSteps);
  for (std::size_t i = 0; i < kToneSteps; ++i) {
    const double light = (static_cast<double>(i) + 0.5) * kBrightestLight / kToneSteps;
    const double tone = srgb_of(std::min(1.0, soft_shoulder ? shoulder(light) : light));
    table[i] = static_cast<std::uint8_t>(std::lround(255 * tone));
  }
  return table;
}

// Close to a standard normal number and much cheaper: the sum of four uniform ones, from one draw.
float nearly_normal(RandomStream& random) {
  const std::uint64_t bits = random.next();
  const auto part = [&](unsigned shift) {
    return static_cast<float>((bits >> shift) & 0xFFFFU) / 65535.0F;
  };
  const float sum = part(0) + part(16) + part(32) + part(48);
  return (sum - 2) * std::sqrt(3.0F);  // the sum's variance is 4/12
}

// Photons are counted with the square root of their number as error; amplifying makes few of them
// look like many.
float noise_of(float light, float amplification) {
  const float shot = std::max(light, 0.0F) * amplification / kFullWell;
  const float read = kReadNoise * amplification;
  return std::sqrt(shot + read * read);
}

}  // namespace

SensorOptions SensorOptions::ideal() {
  SensorOptions options;
  for (bool* effect : {&options.auto_exposure, &options.exposure_errors,
                       &options.auto_white_balance, &options.white_balance_errors,
                       &options.soft_shoulder, &options.motion_blur, &options.color_noise,
                       &options.depth_noise, &options.depth_quantization, &options.projector_shadow,
                       &options.lost_surfaces, &options.edge_jitter, &options.limited_range}) {
    *effect = false;
  }
  return options;
}

Expected<void> SensorOptions::validate() const {
  if (!(exposure > 0)) return fail("exposure is {}; it must be positive", exposure);
  if (!(unamplified_radiance > 0)) {
    return fail("unamplified_radiance is {}; it must be positive", unamplified_radiance);
  }
  if (!(max_amplification >= 1)) {
    return fail("max_amplification is {}; it must be at least 1", max_amplification);
  }
  if (!(depth_noise_m >= 0)) {
    return fail("depth_noise_m is {}; it must not be negative", depth_noise_m);
  }
  if (!(nearest_m >= 0 && farthest_m > nearest_m)) {
    return fail("the range is {} m to {} m; it must begin at 0 or later and end after that",
                nearest_m, farthest_m);
  }
  return {};
}

Expected<Sensor> Sensor::create(const geometry::PinholeCamera& camera,
                                const SensorOptions& options) {
  ROOMWISE_RETURN_IF_ERROR(camera.validate());
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  return Sensor(camera, options);
}

Sensor::Sensor(const geometry::PinholeCamera& camera, const SensorOptions& options)
    : camera_(camera),
      options_(options),
      rays_(camera.width, camera.height, Eigen::Vector2f::Zero()),
      tone_of_light_(tone_table(options.soft_shoulder)) {
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      rays_.at(x, y) = camera.unproject({x, y}, 1).head<2>().cast<float>();
    }
  }
}

image::RgbdFrame Sensor::capture(const RenderedFrame& frame, const WalkPose& pose,
                                 std::uint64_t index, const ColorSettings& settings,
                                 ThreadPool& pool) const {
  image::RgbdFrame captured;
  captured.index = index;
  captured.timestamp_ns = pose.timestamp_ns;
  captured.depth = measure_depth(frame, camera_, rays_, options_, index, pool);
  captured.color = image::ColorImage(camera_.width, camera_.height);
  std::optional<MotionBlur> blur;
  if (options_.motion_blur) blur.emplace(frame, pose, camera_, rays_);
  const Eigen::Vector3f gain = static_cast<float>(settings.exposure) * settings.balance;
  const auto amplification = static_cast<float>(settings.amplification);
  const auto tone = [&](float light) {
    const float step = std::clamp(light * (kToneSteps / kBrightestLight), 0.0F, kToneSteps - 1.0F);
    return tone_of_light_[static_cast<std::size_t>(step)];
  };
  pool.parallel_for(static_cast<std::size_t>(camera_.height), [&](std::size_t row) {
    RandomStream random(options_.seed, {index, row, kColorStream});
    const int y = static_cast<int>(row);
    for (int x = 0; x < camera_.width; ++x) {
      Eigen::Vector3f light =
          gain.cwiseProduct(blur ? blur->light_at(x, y) : frame.radiance.at(x, y));
      if (options_.color_noise) {
        for (float& channel : light) {
          channel += noise_of(channel, amplification) * nearly_normal(random);
        }
      }
      captured.color.at(x, y) = {tone(light.x()), tone(light.y()), tone(light.z())};
    }
  });
  return captured;
}

}  // namespace roomwise::simulation
