#include "roomwise/live/home_json.h"

#include <gtest/gtest.h>

namespace roomwise::live {
namespace {

TEST(HomeJson, TellsWhatTheNewestWalkChanged) {
  HomeView view;
  EXPECT_TRUE(home_json(view).at("changes").is_null()) << "of one walk nothing can have changed";
  view.changes = ViewedChanges{
      2, 1, {{"moved", "chair", "kitchen", 1.5}, {"gone", "vase", std::nullopt, std::nullopt}}};
  const Json changes = home_json(view).at("changes");
  EXPECT_EQ(changes.at("walk"), 2);
  EXPECT_EQ(changes.at("since"), 1);
  ASSERT_EQ(changes.at("things").size(), 2U);
  EXPECT_EQ(changes.at("things")[0].at("room"), "kitchen");
  EXPECT_EQ(changes.at("things")[0].at("moved_m"), 1.5);
  EXPECT_EQ(changes.at("things")[1].at("what"), "gone");
  EXPECT_TRUE(changes.at("things")[1].at("room").is_null());
}

}  // namespace
}  // namespace roomwise::live
