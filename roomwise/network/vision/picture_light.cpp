#include "roomwise/network/vision/picture_light.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace roomwise::network {
namespace {

using image::ColorImage;
using Light = std::array<float, 3>;  // linear red, green, blue; white is 1
using LightImage = image::Image<Light>;

constexpr double kNeutralKelvin = 6504;  // the white of sRGB

double srgb_of(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

double linear_of(double srgb) {
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

const std::array<float, 256>& linear_of_bytes() {
  static const std::array<float, 256> kTable = [] {
    std::array<float, 256> table{};
    for (std::size_t i = 0; i < table.size(); ++i) {
      table[i] = static_cast<float>(linear_of(static_cast<double>(i) / 255));
    }
    return table;
  }();
  return kTable;
}

// The byte of a linear value, by a table: near black, where sRGB is steepest, a byte takes 20 of
// its entries.
class ToneCurve {
 public:
  explicit ToneCurve(double gamma) : bytes_(kSteps + 1) {
    for (std::size_t i = 0; i < bytes_.size(); ++i) {
      const double srgb = srgb_of(static_cast<double>(i) / kSteps);
      bytes_[i] = static_cast<std::uint8_t>(255 * std::pow(srgb, gamma) + 0.5);
    }
  }
  [[nodiscard]] std::uint8_t operator()(float linear) const {
    return bytes_[static_cast<std::size_t>(std::clamp(linear, 0.0F, 1.0F) * kSteps + 0.5F)];
  }
  // The curve of sRGB alone.
  static const ToneCurve& standard() {
    static const ToneCurve curve(1);
    return curve;
  }

 private:
  static constexpr std::size_t kSteps = 65'535;
  std::vector<std::uint8_t> bytes_;
};

// Linear RGB of a glowing body of this temperature, of luminance 1. Its place in CIE's xy diagram
// is the cubic fit to the Planckian locus of Kim et al. (US patent 7,024,034, 2002), here for 1667
// to 25,000 K.
std::array<double, 3> glow(double kelvin) {
  const double t = 1000 / kelvin;
  const double x = kelvin <= 4000 ? ((-0.2661239 * t - 0.2343589) * t + 0.8776956) * t + 0.179910
                                  : ((-3.0258469 * t + 2.1070379) * t + 0.2226347) * t + 0.240390;
  double y = ((3.0817580 * x - 5.87338670) * x + 3.75112997) * x - 0.37001483;
  if (kelvin <= 2222) {
    y = ((-1.1063814 * x - 1.34811020) * x + 2.18555832) * x - 0.20219683;
  } else if (kelvin <= 4000) {
    y = ((-0.9549476 * x - 1.37418593) * x + 2.09137015) * x - 0.16748867;
  }
  const double big_x = x / y;
  const double big_z = (1 - x - y) / y;
  return {3.2406 * big_x - 1.5372 - 0.4986 * big_z, -0.9689 * big_x + 1.8758 + 0.0415 * big_z,
          0.0557 * big_x - 0.2040 + 1.0570 * big_z};
}

LightImage to_light(const ColorImage& image, const std::array<double, 3>& gains) {
  std::array<std::array<float, 256>, 3> tables{};
  for (std::size_t c = 0; c < tables.size(); ++c) {
    std::ranges::transform(linear_of_bytes(), tables[c].begin(),
                           [&](float linear) { return static_cast<float>(linear * gains[c]); });
  }
  LightImage light(image.width(), image.height());
  std::ranges::transform(image.pixels(), light.pixels().begin(), [&](Rgb8 pixel) {
    return Light{tables[0][pixel.r], tables[1][pixel.g], tables[2][pixel.b]};
  });
  return light;
}

// The weights of a Gaussian at 0, 1, 2 ... pixels from its middle; with both sides they sum to 1.
std::vector<float> gaussian(double sigma_px) {
  std::vector<double> weights;
  double sum = 0;
  for (int i = 0; i <= static_cast<int>(std::ceil(3 * sigma_px)); ++i) {
    weights.push_back(std::exp(-0.5 * i * i / (sigma_px * sigma_px)));
    sum += i == 0 ? weights.back() : 2 * weights.back();
  }
  std::vector<float> normal;
  for (const double weight : weights) normal.push_back(static_cast<float>(weight / sum));
  return normal;
}

// One line of pixels, `stride` apart, blurred; the edge continues.
void blur_line(Light* pixels, std::size_t count, std::size_t stride,
               const std::vector<float>& weights, std::vector<Light>& line) {
  const auto reach = weights.size() - 1;
  line.resize(count + 2 * reach);
  for (std::size_t i = 0; i < line.size(); ++i) {
    const std::size_t from = i < reach ? 0 : std::min(i - reach, count - 1);
    line[i] = pixels[from * stride];
  }
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t middle = i + reach;
    for (std::size_t c = 0; c < 3; ++c) {
      float sum = weights[0] * line[middle][c];
      for (std::size_t k = 1; k <= reach; ++k) {
        sum += weights[k] * (line[middle - k][c] + line[middle + k][c]);
      }
      pixels[i * stride][c] = sum;
    }
  }
}

void blur(LightImage& light, double sigma_px) {
  const std::vector<float> weights = gaussian(sigma_px);
  const auto width = static_cast<std::size_t>(light.width());
  const auto height = static_cast<std::size_t>(light.height());
  std::vector<Light> line;
  for (std::size_t y = 0; y < height; ++y) {
    blur_line(light.pixels().data() + y * width, width, 1, weights, line);
  }
  for (std::size_t x = 0; x < width; ++x) {
    blur_line(light.pixels().data() + x, height, width, weights, line);
  }
}

// Nearly normal, of standard deviation 1: the sum of the four 16-bit parts of one random word, each
// even with a variance of (2^32 - 1) / 12.
float nearly_normal(RandomStream& random) {
  const std::uint64_t word = random.next();
  const auto sum = (word & 0xffff) + (word >> 16 & 0xffff) + (word >> 32 & 0xffff) + (word >> 48);
  return (static_cast<float>(sum) - 131'070.0F) / 37'837.23F;
}

// Photons that are counted: the variance grows with the light. A hundredth of white's is there in
// the dark, too.
void add_noise(LightImage& light, double noise, std::uint64_t seed) {
  RandomStream random(seed);
  const auto sigma = static_cast<float>(noise);
  for (Light& pixel : light.pixels()) {
    for (float& value : pixel) {
      value += sigma * std::sqrt(value + 0.01F) * nearly_normal(random);
    }
  }
}

}  // namespace

std::array<double, 3> light_color(double lamp_mired, double tint_stops) {
  const auto neutral = glow(kNeutralKelvin);
  const auto lamp = glow(1e6 / (1e6 / kNeutralKelvin + lamp_mired));
  std::array<double, 3> color{lamp[0] / neutral[0], lamp[1] / neutral[1] * std::exp2(tint_stops),
                              lamp[2] / neutral[2]};
  const double luminance = 0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2];
  for (double& value : color) value /= luminance;
  return color;
}

void change_light(ColorImage& image, const PictureVariation& variation) {
  const bool same_color = variation.lamp_mired == 0 && variation.tint_stops == 0;
  if (image.empty() || (same_color && variation.exposure_stops == 0 && variation.blur == 0 &&
                        variation.noise == 0 && variation.gamma_stops == 0)) {
    return;
  }
  std::array<double, 3> gains = same_color
                                    ? std::array<double, 3>{1, 1, 1}
                                    : light_color(variation.lamp_mired, variation.tint_stops);
  for (double& gain : gains) gain *= std::exp2(variation.exposure_stops);
  LightImage light = to_light(image, gains);
  const double sigma_px = variation.blur * std::max(image.width(), image.height());
  if (sigma_px > 0) blur(light, sigma_px);
  if (variation.noise > 0) add_noise(light, variation.noise, variation.noise_seed);
  const auto encode = [&](const ToneCurve& curve) {
    std::ranges::transform(light.pixels(), image.pixels().begin(), [&](const Light& pixel) {
      return Rgb8{curve(pixel[0]), curve(pixel[1]), curve(pixel[2])};
    });
  };
  encode(variation.gamma_stops == 0 ? ToneCurve::standard()
                                    : ToneCurve(std::exp2(variation.gamma_stops)));
}

}  // namespace roomwise::network
