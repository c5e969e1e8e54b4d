#include "roomwise/guide/places/places.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "roomwise/guide/words/message_catalogue.h"
#include "roomwise/guide/words/wording.h"

namespace roomwise::guide {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr double kNorth = std::numbers::pi / 2;

TEST(PlacesTest, HoursGoClockwiseFromStraightAhead) {
  const Pose pose{Vector2d(1, 1), kNorth, 0.02};
  EXPECT_EQ(bearing_of(Vector2d(1, 3), pose).hour, 12);
  EXPECT_EQ(bearing_of(Vector2d(3, 1), pose).hour, 3);
  EXPECT_EQ(bearing_of(Vector2d(1, -1), pose).hour, 6);
  EXPECT_EQ(bearing_of(Vector2d(-1, 1), pose).hour, 9);
  EXPECT_EQ(bearing_of(Vector2d(2, 1 + std::sqrt(3.0)), pose).hour, 1);
  EXPECT_EQ(bearing_of(Vector2d(0, 1 + std::sqrt(3.0)), pose).hour, 11);
}

// Whatever the heading and the turn, also past a full circle.
TEST(PlacesTest, HoursTurnWithTheHeading) {
  for (int heading = -24; heading <= 24; ++heading) {
    const Pose pose{Vector2d::Zero(), heading * std::numbers::pi / 6 + 0.05, 0};
    for (int hour = 1; hour <= 12; ++hour) {
      const double angle = pose.heading_rad - hour * std::numbers::pi / 6;
      const Vector2d point = 2 * Vector2d(std::cos(angle), std::sin(angle));
      EXPECT_EQ(bearing_of(point, pose).hour, hour);
    }
  }
}

TEST(PlacesTest, DistancesGoToTheNearSide) {
  const Pose pose{Vector2d::Zero(), 0, 0.02};
  KnownThing bed;
  EXPECT_FALSE(bearing_of(bed, pose));
  bed.position_plan = Vector3d(3, 0, 0.3);
  bed.box_keyframe.size_m = Vector3d(2, 1.6, 0.5);
  EXPECT_DOUBLE_EQ(bearing_of(bed, pose)->distance_m, 2.2);
  bed.position_plan = Vector3d(0.5, 0, 0.3);
  EXPECT_DOUBLE_EQ(bearing_of(bed, pose)->distance_m, 0);
  EXPECT_TRUE(bearing_of(bed, pose)->is_close());
}

TEST(PlacesTest, AVaguePoseTellsNoHourOfWhatIsNear) {
  const Pose pose{Vector2d::Zero(), 0, 0.3};
  EXPECT_FALSE(bearing_of(Vector2d(1, 0), pose).is_sure);
  EXPECT_TRUE(bearing_of(Vector2d(2, 0), pose).is_sure);
  EXPECT_EQ((UserLocation{Pose{Vector2d::Zero(), 0, 0.6}, "hall"}.sure_pose()), nullptr);
  EXPECT_NE((UserLocation{Pose{Vector2d::Zero(), 0, 0.4}, "hall"}.sure_pose()), nullptr);
  EXPECT_EQ((UserLocation{std::nullopt, "hall"}.sure_pose()), nullptr);
}

std::vector<rooms::Doorway> doorways(
    const std::vector<std::pair<std::string, std::string>>& joined) {
  std::vector<rooms::Doorway> doors;
  for (const auto& [a, b] : joined) {
    rooms::Doorway door;
    door.rooms = {a, b};
    doors.push_back(door);
  }
  return doors;
}

TEST(PlacesTest, TheWayBetweenRoomsHasTheFewestDoors) {
  const auto doors = doorways({{"bath", "corridor"},
                               {"bedroom", "corridor"},
                               {"corridor", "kitchen"},
                               {"bedroom", "study"},
                               {"kitchen", "pantry"},
                               {"attic", "loft"}});
  EXPECT_THAT(way_between_rooms("bath", "pantry", doors),
              ElementsAre("bath", "corridor", "kitchen", "pantry"));
  EXPECT_THAT(way_between_rooms("study", "bath", doors),
              ElementsAre("study", "bedroom", "corridor", "bath"));
  EXPECT_THAT(way_between_rooms("bath", "bath", doors), ElementsAre("bath"));
  EXPECT_THAT(way_between_rooms("bath", "attic", doors), IsEmpty());
  EXPECT_THAT(way_between_rooms("bath", "nowhere", doors), IsEmpty());
  const auto both = doorways({{"a", "y"}, {"y", "z"}, {"a", "x"}, {"x", "z"}});
  EXPECT_THAT(way_between_rooms("z", "a", both), ElementsAre("z", "x", "a"));
}

TEST(WordingTest, DistancesInStepsAndMetres) {
  const MessageCatalogue catalogue = MessageCatalogue::built_in();
  const Wording steps{&catalogue, {"en", DistanceUnit::kSteps, 0.6}};
  EXPECT_EQ(steps.distance(0.1), "1 step");
  EXPECT_EQ(steps.distance(1.9), "3 steps");
  const Wording metres{&catalogue, {"de", DistanceUnit::kMetres, 0.6}};
  EXPECT_EQ(metres.distance(0.1), "0,5 Meter");
  EXPECT_EQ(metres.distance(1.1), "ein Meter");
  EXPECT_EQ(metres.distance(2.3), "2,5 Meter");
}

TEST(WordingTest, RefusesStylesThatNobodyHas) {
  const MessageCatalogue catalogue = MessageCatalogue::built_in();
  EXPECT_TRUE(SpeakingStyle{}.validate(catalogue).has_value());
  const auto italian = SpeakingStyle{"it", DistanceUnit::kSteps, 0.7}.validate(catalogue);
  ASSERT_FALSE(italian.has_value());
  EXPECT_EQ(italian.error().message,
            "language \"it\" is not spoken; expected one of de, en, es, fr");
  EXPECT_FALSE((SpeakingStyle{"en", DistanceUnit::kSteps, 0.0}.validate(catalogue).has_value()));
  EXPECT_FALSE((SpeakingStyle{"en", DistanceUnit::kSteps, NAN}.validate(catalogue).has_value()));
}

}  // namespace
}  // namespace roomwise::guide
