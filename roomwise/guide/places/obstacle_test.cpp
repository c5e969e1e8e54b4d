#include "roomwise/guide/places/obstacle.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <functional>

#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::guide {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

geometry::PinholeCamera small_camera() {
  return {.fx = 262,
          .fy = 262,
          .cx = 159.5,
          .cy = 119.5,
          .width = 320,
          .height = 240,
          .distortion = {},
          .depth_units_per_metre = 1000};
}

// A camera 1.3 m above the floor that looks down by that angle, and what it sees of boxes and the
// floor. World: x right, y ahead, z up; the person stands at the origin.
class View {
 public:
  explicit View(double pitch_rad = 0)
      : world_from_camera_(Eigen::AngleAxisd(-pitch_rad, Vector3d::UnitX()) *
                           Eigen::AngleAxisd(-std::numbers::pi / 2, Vector3d::UnitX())) {
    options.up_camera = world_from_camera_.inverse() * Vector3d::UnitZ();
  }

  void add_box(const Vector3d& least, const Vector3d& most) { boxes_.push_back({least, most}); }
  [[nodiscard]] image::DepthImage depth() const {
    image::DepthImage image(camera.width, camera.height);
    for (int y = 0; y < camera.height; ++y) {
      for (int x = 0; x < camera.width; ++x) {
        const Vector3d ray = world_from_camera_ * camera.unproject({x, y}, 1);
        const double depth_m = nearest(ray);
        if (depth_m < 8) image.at(x, y) = static_cast<std::uint16_t>(std::lround(1000 * depth_m));
      }
    }
    return image;
  }
  [[nodiscard]] std::vector<Vector2d> obstacles() const {
    return obstacles_seen(depth(), camera, options).value();
  }
  [[nodiscard]] std::optional<double> obstacle_m() const {
    const auto obstacle = nearest_ahead(obstacles());
    return obstacle ? std::optional(obstacle->ahead_left_m.x()) : std::nullopt;
  }

  geometry::PinholeCamera camera = small_camera();
  ObstacleOptions options;

 private:
  struct Box {
    Vector3d least, most;
  };
  [[nodiscard]] double nearest(const Vector3d& ray) const {
    const Vector3d eye(0, 0, options.camera_height_m);
    double nearest = ray.z() < 0 ? -eye.z() / ray.z() : 1e9;
    for (const Box& box : boxes_) {
      const Eigen::Array3d a = (box.least - eye).array() / ray.array();
      const Eigen::Array3d b = (box.most - eye).array() / ray.array();
      const double from = a.min(b).maxCoeff();
      if (from > 0 && from < a.max(b).minCoeff()) nearest = std::min(nearest, from);
    }
    return nearest;
  }

  Eigen::Quaterniond world_from_camera_;
  std::vector<Box> boxes_;
};

TEST(ObstacleTest, AWallAheadIsMeasured) {
  View view;
  view.add_box({-2, 0.8, 0}, {2, 0.9, 2.5});
  ASSERT_TRUE(view.obstacle_m());
  EXPECT_NEAR(*view.obstacle_m(), 0.8, 0.021);
}

TEST(ObstacleTest, WhatIsFarOrBesideOrAboveOrLowIsNoObstacle) {
  View far;
  far.add_box({-2, 1.2, 0}, {2, 1.3, 2.5});
  EXPECT_EQ(far.obstacle_m(), std::nullopt);
  View beside;
  beside.add_box({0.35, 0.4, 0}, {0.6, 3, 2.5});
  beside.add_box({-0.6, 0.4, 0}, {-0.35, 3, 2.5});
  EXPECT_EQ(beside.obstacle_m(), std::nullopt);
  View above(-0.5);
  above.add_box({-1, 0.7, 1.95}, {1, 0.9, 2.2});
  EXPECT_EQ(above.obstacle_m(), std::nullopt);
  View low(0.9);
  low.add_box({-1, 0.7, 0}, {1, 0.9, 0.1});
  EXPECT_EQ(low.obstacle_m(), std::nullopt);
}

TEST(ObstacleTest, TheFloorIsNoObstacleHoweverTheCameraIsHeld) {
  for (const double pitch_rad : {0.0, 0.3, 0.6, 0.9, 1.5}) {
    EXPECT_EQ(View(pitch_rad).obstacle_m(), std::nullopt) << pitch_rad;
  }
}

TEST(ObstacleTest, ABoxOnTheFloorIsSeenByACameraThatLooksDown) {
  View view(0.7);
  view.add_box({-0.2, 0.7, 0}, {0.2, 1.1, 0.4});
  ASSERT_TRUE(view.obstacle_m());
  EXPECT_NEAR(*view.obstacle_m(), 0.7, 0.025);
}

TEST(ObstacleTest, AThinPostIsAnObstacle) {
  View view;
  view.add_box({0.05, 0.6, 0}, {0.09, 0.64, 2});
  ASSERT_TRUE(view.obstacle_m());
  EXPECT_NEAR(*view.obstacle_m(), 0.6, 0.021);
}

TEST(ObstacleTest, TellsWhereOnTheFloorThingsStandToBothSides) {
  View view;
  view.add_box({-0.6, 1.0, 0}, {-0.5, 1.1, 1.6});  // to the left
  view.add_box({0.6, 1.5, 0}, {0.7, 1.6, 1.6});
  const auto obstacles = view.obstacles();
  const auto left_of = [&](double side) {
    return std::ranges::count_if(obstacles, [&](const Vector2d& p) { return side * p.y() > 0; });
  };
  EXPECT_GT(left_of(1), 0);
  EXPECT_GT(left_of(-1), 0);
  for (const Vector2d& place : obstacles) {
    const bool is_left = place.y() > 0;
    EXPECT_NEAR(place.x(), is_left ? 1.0 : 1.5, 0.11) << place.transpose();
    EXPECT_NEAR(place.y(), is_left ? 0.55 : -0.65, 0.06) << place.transpose();
  }
}

TEST(ObstacleTest, AShelfAtTheHeightOfAHeadIsSeenThoughItIsThin) {
  View view(-0.3);
  view.add_box({-0.5, 0.8, 1.7}, {0.5, 1.1, 1.74});
  ASSERT_TRUE(view.obstacle_m());
  EXPECT_NEAR(*view.obstacle_m(), 0.8, 0.05);
}

TEST(ObstacleTest, SingleWrongPixelsAreNone) {
  View view;
  view.add_box({-2, 0.8, 0}, {2, 0.9, 2.5});
  image::DepthImage depth = view.depth();
  RandomStream random(1);
  for (auto& pixel : depth.pixels()) {
    if (random.uniform() < 0.01) pixel = static_cast<std::uint16_t>(300 + random.index(300));
    if (random.uniform() < 0.3) pixel = 0;
  }
  const auto seen = obstacles_seen(depth, view.camera, view.options).value();
  const auto obstacle = nearest_ahead(seen);
  ASSERT_TRUE(obstacle);
  EXPECT_NEAR(obstacle->ahead_left_m.x(), 0.8, 0.1);
  EXPECT_GT(obstacle->ahead_left_m.x(), 0.69);
  EXPECT_THAT(obstacles_seen(image::DepthImage(320, 240), view.camera).value(), IsEmpty());
}

TEST(ObstacleTest, SaysWhatIsWrong) {
  EXPECT_ERROR(obstacles_seen(image::DepthImage(32, 24), small_camera()),
               "32x24 pixels; the camera 320x240");
  ObstacleOptions options;
  options.up_camera = Vector3d(0, -2, 0);
  EXPECT_ERROR(obstacles_seen(image::DepthImage(320, 240), small_camera(), options),
               "up_camera has the length 2");
}

TEST(ObstacleTest, IsOnASideWhereNoneOfItIsInTheMiddle) {
  using Side = ObstacleAhead::Side;
  const auto side_of = [](const std::vector<Vector2d>& places) {
    return nearest_ahead(places).value().side;
  };
  EXPECT_EQ(side_of({{0.6, 0.25}, {0.7, 0.15}}), Side::kLeft);
  EXPECT_EQ(side_of({{0.6, -0.25}, {0.7, -0.15}}), Side::kRight);
  EXPECT_EQ(side_of({{0.6, -0.25}, {0.6, -0.15}, {0.6, -0.05}}), Side::kAhead) << "half the body";
  EXPECT_EQ(side_of({{0.6, 0.25}, {0.7, -0.25}}), Side::kAhead) << "on both sides";
  EXPECT_EQ(side_of({{0.6, 0.25}, {0.7, 0.5}, {0.7, -0.5}}), Side::kLeft) << "others are beside";
  EXPECT_EQ(side_of({{0.5, 0.25}, {0.85, 0}}), Side::kAhead) << "somebody stands behind it";
  EXPECT_EQ(nearest_ahead({}), std::nullopt);
}

TEST(ObstacleTest, IsSpokenWithItsSideAndWhatTheMapHasThere) {
  const MessageCatalogue catalogue = MessageCatalogue::built_in();
  KnownThing table;
  table.name = "table";
  using Side = ObstacleAhead::Side;
  const auto said = [&](const char* language, Side side, const KnownThing* thing) {
    return hazard_prompt({{0.7, 0}, side}, thing, {&catalogue, {language}}, 0).text;
  };
  EXPECT_EQ(said("en", Side::kLeft, nullptr), "Obstacle ahead, to the left.");
  EXPECT_EQ(said("en", Side::kAhead, &table), "Table ahead.");
  EXPECT_EQ(said("en", Side::kRight, &table), "Table ahead, to the right.");
  EXPECT_EQ(said("de", Side::kLeft, &table), "Vorsicht, Tisch vorn links.");
  EXPECT_EQ(said("es", Side::kLeft, &table), "Cuidado, mesa delante a la izquierda.");
  EXPECT_EQ(said("fr", Side::kLeft, &table), "Attention, table devant à gauche.");
}

TEST(ObstacleTest, IsSpokenAsAHazard) {
  const MessageCatalogue catalogue = MessageCatalogue::built_in();
  const Prompt prompt = hazard_prompt({{0.7, 0}}, nullptr, {&catalogue, {}}, 0);
  EXPECT_EQ(prompt.text, "Obstacle ahead.");
  EXPECT_EQ(prompt.priority, Priority::kHazard);
  EXPECT_EQ(prompt.sound, Sound::kAlert);
  EXPECT_EQ(prompt.valid_until_ns, 1'000'000'000);
}

}  // namespace
}  // namespace roomwise::guide
