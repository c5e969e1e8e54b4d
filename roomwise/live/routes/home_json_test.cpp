#include "roomwise/live/routes/home_json.h"

#include <gtest/gtest.h>

#include <numbers>

namespace roomwise::live {
namespace {

TEST(HomeJson, TellsWhatTheNewestWalkChanged) {
  HomeView view;
  EXPECT_TRUE(home_json(view, service::Role::kHelper).at("changes").is_null())
      << "of one walk nothing can have changed";
  view.changes = ViewedChanges{
      2, 1, {{"moved", "chair", "kitchen", 1.5}, {"gone", "vase", std::nullopt, std::nullopt}}};
  const Json changes = home_json(view, service::Role::kHelper).at("changes");
  EXPECT_EQ(changes.at("walk"), 2);
  EXPECT_EQ(changes.at("since"), 1);
  ASSERT_EQ(changes.at("things").size(), 2U);
  EXPECT_EQ(changes.at("things")[0].at("room"), "kitchen");
  EXPECT_EQ(changes.at("things")[0].at("moved_m"), 1.5);
  EXPECT_EQ(changes.at("things")[1].at("what"), "gone");
  EXPECT_TRUE(changes.at("things")[1].at("room").is_null());
}

TEST(HomeJson, DevicesAreNotToldWhatIsTheHelpersAffair) {
  HomeView view;
  view.changes = ViewedChanges{2, 1, {{"moved", "chair", "kitchen", 1.5}}};
  view.walks.emplace_back();
  view.owes_erasing = true;
  const Json of_device = home_json(view, service::Role::kDevice);
  const Json of_helper = home_json(view, service::Role::kHelper);
  for (const char* member : {"recordings", "to_erase", "changes"}) {
    EXPECT_FALSE(of_device.contains(member)) << member;
    EXPECT_TRUE(of_helper.contains(member)) << member;
  }
  EXPECT_EQ(of_device.at("rooms"), of_helper.at("rooms"));
}

TEST(HomeJson, ThePlanIsTurnedAsWasWorkedOutWhenTheMapWasMadeReady) {
  HomeView view;
  EXPECT_EQ(plan_json(view).at("right_degrees"), 0) << "there is no map";
  LiveMap map;
  map.floor.emplace(Eigen::Vector2d(-1, -1), 0.05,
                    image::Image<fusion::FloorCell>(40, 40, fusion::FloorCell::kFree));
  map.right_rad = std::numbers::pi / 6;  // which nothing on this floor says
  view.map = std::make_shared<const LiveMap>(std::move(map));
  EXPECT_NEAR(plan_json(view).at("right_degrees").get<double>(), 30, 1e-9);
}

TEST(HomeJson, TellsOnWhichStoreyAKeyFrameIs) {
  HomeView view;
  for (const double height_m : {1.3, 4.1}) {
    ViewedKeyframe& one = view.keyframes.emplace_back();
    one.on_map = true;
    one.keyframe.pose.world_from_keyframe.translation = {1, 2, height_m};
  }
  LiveMap map;
  view.map = std::make_shared<const LiveMap>(map);
  EXPECT_FALSE(keyframes_json(view).at("keyframes")[0].contains("storey")) << "there is one";
  fusion::Storey upper;
  upper.floor_m = 2.8;
  upper.plan_from_x_m = 10;
  map.frame.storeys = fusion::Storeys({fusion::Storey{}, upper});
  view.map = std::make_shared<const LiveMap>(std::move(map));
  const Json keyframes = keyframes_json(view).at("keyframes");
  EXPECT_EQ(keyframes[0].at("storey"), 0);
  EXPECT_EQ(keyframes[1].at("storey"), 1);
  EXPECT_EQ(keyframes[1].at("position"), Json({1, 2, 4.1})) << "in space, as the cloud";
}

}  // namespace
}  // namespace roomwise::live
