#include <algorithm>
#include <cmath>

#include "laboratory/simulation/sensor/sensor.h"
#include "roomwise/base/random.h"

namespace roomwise::simulation {
namespace {

constexpr double kMidGrey = 0.18;  // where the mean of a scene is to lie
constexpr int kMeteringStep_px = 4;
constexpr float kDarkestMetered = 1e-4F;

// Time constants of the control, s, and of its slow errors.
constexpr double kExposureTime_s = 0.5, kBalanceTime_s = 1.5, kErrorTime_s = 4;
constexpr double kExposureErrorEv = 0.2, kBalanceError = 0.03;
// Now and then the control is misled (a lamp, a flicker) and has to find back.
constexpr double kSlipsPerSecond = 0.05, kSmallestSlipEv = 0.5, kLargestSlipEv = 1.1;

// Cameras leave some of a lamp's warmth in the picture.
constexpr double kBalanceStrength = 0.75;
constexpr double kMaxBalance = 1.0;  // log

constexpr std::uint64_t kErrorStream = 0xE8905u;

struct Metering {
  double mean_ev = 0;                               // log2 of the mean radiance
  Eigen::Vector2d color = Eigen::Vector2d::Zero();  // log of red and blue against green
};

double metered_luminance(const Eigen::Vector3f& radiance) {
  return radiance.dot(Eigen::Vector3f(0.2126F, 0.7152F, 0.0722F));
}

template <typename Body>
void for_metered_pixels(const image::Image<Eigen::Vector3f>& radiance, const Body& body) {
  for (int y = 0; y < radiance.height(); y += kMeteringStep_px) {
    for (int x = 0; x < radiance.width(); x += kMeteringStep_px) body(radiance.at(x, y));
  }
}

Metering meter(const image::Image<Eigen::Vector3f>& radiance) {
  double sum_ev = 0, count = 0;
  for_metered_pixels(radiance, [&](const Eigen::Vector3f& pixel) {
    sum_ev += std::log2(std::max<double>(metered_luminance(pixel), kDarkestMetered));
    ++count;
  });
  Metering metering;
  metering.mean_ev = count > 0 ? sum_ev / count : 0;
  // The light's colour by the grey-world assumption, in which bright surfaces count most ("shades
  // of grey", Finlayson and Trezzi 2004). Windows and lamps themselves say nothing of the light
  // that falls on things.
  constexpr double kNorm = 5;
  const double brightest = 4 * std::exp2(metering.mean_ev);
  Eigen::Vector3d sum = Eigen::Vector3d::Constant(1e-12);
  for_metered_pixels(radiance, [&](const Eigen::Vector3f& pixel) {
    if (metered_luminance(pixel) < brightest)
      sum += pixel.cast<double>().array().pow(kNorm).matrix();
  });
  metering.color =
      Eigen::Vector2d(std::log(sum.x() / sum.y()), std::log(sum.z() / sum.y())) / kNorm;
  return metering;
}

// How much of the way to its goal a control goes in a time.
double approach(double elapsed_s, double time_constant_s) {
  return 1 - std::exp(-elapsed_s / time_constant_s);
}

// One step of an error that wanders about zero (Ornstein and Uhlenbeck).
double wander(double error, double elapsed_s, double deviation, RandomStream& random) {
  const double kept = std::exp(-elapsed_s / kErrorTime_s);
  return kept * error + std::sqrt(1 - kept * kept) * deviation * random.normal();
}

}  // namespace

void ExposureControl::drift(double elapsed_s, std::uint64_t index) {
  RandomStream random(options_.seed, {index, kErrorStream});
  if (options_.exposure_errors) {
    exposure_error_ev_ = wander(exposure_error_ev_, elapsed_s, kExposureErrorEv, random);
    if (random.uniform() < approach(elapsed_s, 1 / kSlipsPerSecond)) {
      const double slip_ev =
          kSmallestSlipEv + (kLargestSlipEv - kSmallestSlipEv) * random.uniform();
      exposure_ev_ += random.uniform() < 0.5 ? slip_ev : -slip_ev;
    }
  }
  if (options_.white_balance_errors) {
    for (double& error : balance_error_) error = wander(error, elapsed_s, kBalanceError, random);
  }
}

ColorSettings ExposureControl::next(const RenderedFrame& frame, TimestampNs timestamp_ns,
                                    std::uint64_t index) {
  const Metering metering = meter(frame.radiance);
  const double goal_ev = std::log2(kMidGrey) - metering.mean_ev;
  const Eigen::Vector2d goal =
      (-kBalanceStrength * metering.color).cwiseMax(-kMaxBalance).cwiseMin(kMaxBalance);
  constexpr double kLongAgo_s = 1e3;  // before the first frame
  const double elapsed_s =
      has_started_ ? kSecondsPerNs * static_cast<double>(timestamp_ns - last_timestamp_ns_)
                   : kLongAgo_s;
  has_started_ = true;
  last_timestamp_ns_ = timestamp_ns;
  exposure_ev_ += approach(elapsed_s, kExposureTime_s) * (goal_ev - exposure_ev_);
  balance_ += approach(elapsed_s, kBalanceTime_s) * (goal - balance_);
  drift(std::min(elapsed_s, kErrorTime_s), index);

  ColorSettings settings;
  settings.exposure = options_.exposure;
  if (options_.auto_exposure) {
    const double unamplified = kMidGrey / options_.unamplified_radiance;
    settings.exposure = std::min(std::exp2(exposure_ev_ + exposure_error_ev_),
                                 unamplified * options_.max_amplification);
    settings.amplification = std::max(1.0, settings.exposure / unamplified);
  }
  if (options_.auto_white_balance) {
    const Eigen::Vector2d log_balance = balance_ + balance_error_;
    settings.balance =
        Eigen::Vector3d(std::exp(log_balance.x()), 1, std::exp(log_balance.y())).cast<float>();
  }
  return settings;
}

}  // namespace roomwise::simulation
