#include "roomwise/home/testing/sample_home.h"

namespace roomwise::home {
namespace {

class HomeInstances : public ::testing::Test {
 protected:
  void SetUp() override { testing::fill(home_); }

  roomwise::testing::ScratchFolder folder_;
  Home home_ = Home::create(folder_ / "a.home").value();
};

TEST_F(HomeInstances, LooksComeBackAsTheyWere) {
  const auto looks = home_.detections(1).value();
  ASSERT_EQ(looks.size(), 2U);
  const objects::KeyframeDetections& look = looks.at(1);
  const objects::KeyframeDetections expected = testing::sample_look(1);
  EXPECT_EQ(look.coarse_depth, expected.coarse_depth);
  ASSERT_EQ(look.detections.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(look.detections[i].label, expected.detections[i].label);
    EXPECT_EQ(look.detections[i].score, expected.detections[i].score);
    EXPECT_EQ(look.detections[i].box.left, expected.detections[i].box.left);
    EXPECT_EQ(look.detections[i].box.bottom, expected.detections[i].box.bottom);
    EXPECT_EQ(look.detections[i].surface, expected.detections[i].surface);
  }
}

TEST_F(HomeInstances, ALookReplacesTheOneBefore) {
  objects::KeyframeDetections nothing = testing::sample_look(1);
  nothing.detections.clear();
  ASSERT_OK(home_.put_detections(1, 1, nothing));
  EXPECT_TRUE(home_.detections(1)->at(1).detections.empty());
  EXPECT_EQ(home_.looked_at(1).value(), (std::set<KeyframeId>{1, 2}))
      << "it was looked at all the same";
  EXPECT_ERROR(home_.put_detections(99, 1, nothing), "a.home");
  EXPECT_ERROR(home_.put_detections(1, 99, nothing), "a.home");
}

TEST_F(HomeInstances, AFinderIsKnownByItsFingerprint) {
  EXPECT_EQ(home_.add_region_finder({"finder", "f1nd", {"couch", "bed"}}).value(), 1);
  EXPECT_EQ(home_.add_region_finder({"other", "0ther", {"couch"}}).value(), 2);
  EXPECT_ERROR(home_.add_region_finder({"finder", "f1nd", {"couch"}}), "other labels");
  EXPECT_EQ(home_.add_region_finder({"new name", "f1nd", {"couch", "bed"}}).value(), 1);
  EXPECT_EQ(home_.region_finders()->at(1).name, "new name");
  EXPECT_EQ(home_.region_finders()->at(2).labels, std::vector<std::string>{"couch"});
}

TEST_F(HomeInstances, InstancesComeBackAsTheyWere) {
  const auto instances = home_.instances().value();
  ASSERT_EQ(instances.size(), 2U);
  const objects::Instance expected = testing::sample_instance(2);
  const objects::Instance& found = instances[1];
  EXPECT_EQ(found.name, expected.name);
  EXPECT_EQ(found.probability, expected.probability);
  EXPECT_EQ(found.names, expected.names);
  EXPECT_EQ(found.observations, expected.observations);
  EXPECT_EQ(found.expected, expected.expected);
  EXPECT_EQ(found.keyframe_id, expected.keyframe_id);
  EXPECT_EQ(instances[0].picture_box.top, expected.picture_box.top);
  EXPECT_EQ(found.box_keyframe.size_m, expected.box_keyframe.size_m);
  EXPECT_EQ(found.box_keyframe.center(), expected.box_keyframe.center());
  EXPECT_EQ(found.sigma_m, expected.sigma_m);
}

TEST_F(HomeInstances, GoWithTheirKeyframes) {
  ASSERT_OK(home_.remove_recording(1));
  EXPECT_TRUE(home_.detections(1)->empty());
  EXPECT_TRUE(home_.instances()->empty());
  EXPECT_EQ(home_.database().get<int>("SELECT count(*) FROM instance_names").value(), 0);
}

TEST_F(HomeInstances, ABoxMustBeFinite) {
  objects::Instance instance = testing::sample_instance(1);
  instance.box_keyframe.size_m.x() = std::numeric_limits<double>::infinity();
  EXPECT_ERROR(home_.replace_instances(std::vector{instance}), "not finite");
  EXPECT_EQ(home_.instances()->size(), 2U) << "an error changes nothing";
}

}  // namespace
}  // namespace roomwise::home
