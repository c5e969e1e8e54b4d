#include "roomwise/home/testing/sample_home.h"

namespace roomwise::home {
namespace {

class HomeVisits : public ::testing::Test {
 protected:
  void SetUp() override { testing::fill(home_); }

  roomwise::testing::ScratchFolder folder_;
  Home home_ = Home::create(folder_ / "a.home").value();
};

TEST_F(HomeVisits, WhatAVisitChangedComesBackAsItWas) {
  const HomeChanges expected = testing::sample_changes();
  const auto visits = home_.visits().value();
  ASSERT_EQ(visits.size(), 2U);
  EXPECT_EQ(visits.at(1), expected.visit);

  const auto instances = home_.instances().value();
  ASSERT_EQ(instances.size(), 2U);
  EXPECT_EQ(instances[0].visit, 0);
  EXPECT_TRUE(instances[0].surface_keyframe.empty());
  EXPECT_EQ(instances[1].visit, 1) << "the second visit kept it";
  EXPECT_EQ(instances[1].surface_keyframe, expected.arrived[0].surface_keyframe);
  EXPECT_EQ(instances[1].picture_box.area(), 0);

  const auto past = home_.past_instances().value();
  ASSERT_EQ(past.size(), 2U);
  const objects::Instance sample = testing::sample_instance(0);
  EXPECT_EQ(past[0].instance.name, sample.name);
  EXPECT_EQ(past[0].instance.probability, sample.probability);
  EXPECT_EQ(past[0].instance.observations, sample.observations);
  EXPECT_EQ(past[0].instance.expected, sample.expected);
  EXPECT_EQ(past[0].instance.keyframe_id, sample.keyframe_id);
  EXPECT_EQ(past[0].instance.picture_box.right, sample.picture_box.right);
  EXPECT_EQ(past[0].instance.box_keyframe.center(), sample.box_keyframe.center());
  EXPECT_EQ(past[0].instance.box_keyframe.size_m, sample.box_keyframe.size_m);
  EXPECT_EQ(past[0].instance.sigma_m, sample.sigma_m);
  EXPECT_EQ(past[0].instance.visit, 0);
  EXPECT_EQ(past[0].reason, PastReason::kMoved);
  EXPECT_EQ(past[0].first_seen_ns, expected.past[0].first_seen_ns);
  EXPECT_EQ(past[0].last_seen_ns, expected.past[0].last_seen_ns);
  EXPECT_EQ(past[0].noticed_by, 1);
  EXPECT_EQ(past[1].reason, PastReason::kRemoved);
  EXPECT_EQ(past[1].noticed_by, 2);
  EXPECT_EQ(past[1].instance.visit, 1) << "which visit had brought it";
}

TEST_F(HomeVisits, TheirPicturesComeBackWithTheVisitThatBroughtThem) {
  const auto pictures = home_.visit_pictures().value();
  ASSERT_EQ(pictures.size(), 2U);
  VisitPicture expected = testing::sample_visit_picture(2);
  expected.visit = 1;
  EXPECT_EQ(pictures[0], expected) << "the second visit kept it";
  expected = testing::sample_visit_picture(3);
  expected.visit = 2;
  EXPECT_EQ(pictures[1], expected);
  // A visit that says nothing of pictures leaves them.
  HomeChanges changes = testing::sample_changes();
  changes.pictures.reset();
  ASSERT_OK(home_.apply_changes(changes));
  EXPECT_EQ(home_.visit_pictures().value(), pictures);
}

TEST_F(HomeVisits, PicturesGoWithTheirVisitTheirKeyframeAndWhatWasLearned) {
  const auto visits_of_pictures = [&] {
    std::vector<VisitId> visits;
    const auto pictures = home_.visit_pictures().value();
    for (const VisitPicture& one : pictures) visits.push_back(one.visit);
    return visits;
  };
  ASSERT_OK(home_.database().run("DELETE FROM past_instances"));
  ASSERT_OK(home_.database().run("DELETE FROM visits WHERE visit_id = 2"));
  EXPECT_EQ(visits_of_pictures(), std::vector<VisitId>{1});
  const auto stored = home_.visit_pictures().value();
  ASSERT_OK(home_.remove_recording(1));
  EXPECT_EQ(visits_of_pictures(), std::vector<VisitId>());
  EXPECT_ERROR(home_.replace_visit_pictures(stored), "a.home");
}

TEST_F(HomeVisits, PicturesAreForgottenWithTheLearnedRooms) {
  ASSERT_OK(home_.forget_learned_rooms());
  EXPECT_TRUE(home_.visit_pictures()->empty());
}

TEST_F(HomeVisits, AreStoredWholeOrNotAtAll) {
  const std::string digest = home_.content_digest().value();
  HomeChanges changes = testing::sample_changes();
  changes.past[0].instance.box_keyframe.size_m.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_ERROR(home_.apply_changes(changes), "past instance 'sofa' is not finite");
  changes = testing::sample_changes();
  changes.past[0].instance.keyframe_id = 99;
  EXPECT_ERROR(home_.apply_changes(changes), "a.home");
  changes = testing::sample_changes();
  changes.pictures->front().keyframe = 99;
  EXPECT_ERROR(home_.apply_changes(changes), "a.home");
  EXPECT_EQ(home_.content_digest().value(), digest);
}

TEST_F(HomeVisits, GoWithTheirKeyframes) {
  ASSERT_OK(home_.remove_recording(1));
  EXPECT_TRUE(home_.past_instances()->empty());
  EXPECT_TRUE(home_.instances()->empty());
  EXPECT_EQ(home_.database().get<int>("SELECT count(*) FROM instance_names").value(), 0);
}

}  // namespace
}  // namespace roomwise::home
