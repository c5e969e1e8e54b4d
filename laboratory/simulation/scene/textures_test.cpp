#include "laboratory/simulation/scene/textures.h"

#include <gmock/gmock.h>

#include <cmath>

#include "laboratory/simulation/scene/color_math.h"
#include "laboratory/simulation/scene/mip_texture.h"
#include "laboratory/simulation/scene/picture_art.h"

namespace roomwise::simulation {
namespace {

constexpr std::array kMaterials{Material::kPaint,  Material::kWallpaper, Material::kPlaster,
                                Material::kTiles,  Material::kBoards,    Material::kParquet,
                                Material::kCarpet, Material::kStone};

Finish finish_of(Material material, std::uint64_t seed) {
  Finish finish;
  finish.material = material;
  finish.color = {190, 160, 120};
  finish.accent = {90, 60, 40};
  finish.seed = seed;
  return finish;
}

// How much the pattern differs between neighbouring samples of a 2 m square, relative to its mean.
double roughness(const FinishTexture& texture, float footprint_m) {
  double sum = 0, mean = 0;
  int count = 0;
  for (float y = 0.003F; y < 2; y += footprint_m) {
    float last = -1;
    for (float x = 0.007F; x < 2; x += footprint_m) {
      const float value = luminance(texture.look({x, y}, footprint_m).albedo);
      if (last >= 0) sum += static_cast<double>((value - last) * (value - last));
      mean += static_cast<double>(value);
      last = value;
      ++count;
    }
  }
  return std::sqrt(sum / count) / (mean / count);
}

TEST(Textures, FadeToTheirMeanWhereTheyAreSeenSmall) {
  for (const Material material : kMaterials) {
    for (std::uint64_t seed = 0; seed < 8; ++seed) {
      const FinishTexture texture(finish_of(material, seed));
      // A sample of 25 cm holds about one tile or board: what is left is tone, not lines.
      EXPECT_LT(roughness(texture, 0.25F), 0.16) << static_cast<int>(material) << ' ' << seed;
    }
  }
}

TEST(Textures, MeanAlbedoIsAboutTheMeanOfThePattern) {
  for (const Material material : kMaterials) {
    for (std::uint64_t seed = 0; seed < 8; ++seed) {
      const FinishTexture texture(finish_of(material, seed));
      double sum = 0;
      int count = 0;
      for (float y = 0; y < 3; y += 0.0371F) {
        for (float x = 0; x < 3; x += 0.0353F, ++count) {
          sum += static_cast<double>(luminance(texture.look({x, y}, 0.002F).albedo));
        }
      }
      const auto mean = static_cast<double>(luminance(texture.mean_albedo()));
      EXPECT_NEAR(sum / count, mean, 0.15 * mean) << static_cast<int>(material) << ' ' << seed;
    }
  }
}

TEST(Textures, AlbedoStaysPhysical) {
  for (const Material material : kMaterials) {
    Finish finish = finish_of(material, 3);
    finish.color = {250, 250, 250};
    const FinishTexture texture(finish);
    for (float x = -3; x < 3; x += 0.0117F) {
      const Eigen::Vector3f albedo = texture.look({x, 0.7F * x}, 0.002F).albedo;
      EXPECT_GE(albedo.minCoeff(), 0);
      EXPECT_LE(albedo.maxCoeff(), 0.901F);
    }
  }
}

TEST(Textures, SeedsDiffer) {
  const FinishTexture a(finish_of(Material::kBoards, 1)), b(finish_of(Material::kBoards, 2));
  EXPECT_NE(a.look({0.3F, 0.4F}, 0.001F).albedo, b.look({0.3F, 0.4F}, 0.001F).albedo);
}

TEST(MipTexture, TopLeftPixelIsAtTheHighEndOfV) {
  image::ColorImage picture(2, 2);
  picture.at(0, 0) = {255, 0, 0};
  picture.at(1, 1) = {0, 0, 255};
  const MipTexture texture(picture);
  EXPECT_EQ(texture.color({0.25F, 0.75F}, 0), Eigen::Vector3f(1, 0, 0));
  EXPECT_EQ(texture.color({0.75F, 0.25F}, 0), Eigen::Vector3f(0, 0, 1));
  // It repeats.
  EXPECT_EQ(texture.color({-1.75F, 3.75F}, 0), Eigen::Vector3f(1, 0, 0));
}

TEST(MipTexture, SeenSmallIsItsMean) {
  image::ColorImage picture(64, 32);
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 64; ++x) picture.at(x, y) = (x + y) % 2 == 0 ? Rgb8{200, 200, 200} : Rgb8{};
  }
  const MipTexture texture(picture);
  EXPECT_EQ(texture.color({0.3F, 0.6F}, 1000), texture.mean());
}

TEST(PictureArt, SeedsGiveDifferentPicturesOfPhysicalColours) {
  std::vector<float> lights;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    float sum = 0;
    for (float v = 0.02F; v < 1; v += 0.05F) {
      for (float u = 0.02F; u < 1; u += 0.05F) {
        const Eigen::Vector3f color = picture_color(seed, u, v);
        EXPECT_GE(color.minCoeff(), 0);
        EXPECT_LE(color.maxCoeff(), 0.9F);
        sum += luminance(color);
      }
    }
    EXPECT_THAT(lights, ::testing::Not(::testing::Contains(sum)));
    lights.push_back(sum);
  }
}

}  // namespace
}  // namespace roomwise::simulation
