#include "roomwise/pipeline/objects/stored_detections.h"

#include <gmock/gmock.h>

#include "roomwise/base/testing/testing.h"
#include "roomwise/home/testing/sample_home.h"

namespace roomwise::pipeline {
namespace {

using ::testing::FieldsAre;
using ::testing::UnorderedElementsAre;

// The classes of the detections of key-frame 1, whether they are words, and by region proposals.
std::vector<std::tuple<std::string, bool, bool>> names_in(const home::Home& home) {
  const auto components = observed_keyframes(home);
  EXPECT_OK(components);
  std::vector<std::tuple<std::string, bool, bool>> names;
  for (const objects::ObservedKeyframe& keyframe : components->at(1)) {
    if (keyframe.keyframe_id != 1) continue;
    for (const objects::Detection& detection : keyframe.detections) {
      const bool is_closer = detection.source == objects::DetectionSource::kProposal;
      names.emplace_back(detection.class_name, detection.is_in_vocabulary, is_closer);
    }
  }
  return names;
}

objects::KeyframeDetections look_with(const std::vector<std::string>& labels) {
  objects::KeyframeDetections look = home::testing::sample_look(1);
  look.detections.resize(1);
  const objects::Detection detection = look.detections.front();
  look.detections.clear();
  for (const std::string& label : labels) {
    look.detections.push_back(detection);
    look.detections.back().label = label;
  }
  return look;
}

TEST(StoredDetections, CloserLooksStandBesideTheDetectorAndReplaceTheirOlderSelf) {
  const roomwise::testing::ScratchFolder folder;
  auto home = home::Home::create(folder / "a.home");
  ASSERT_OK(home);
  home::testing::fill(*home);
  EXPECT_THAT(names_in(*home),
              UnorderedElementsAre(FieldsAre("sofa", true, false), FieldsAre("bed", true, false)));

  const std::vector<std::string> labels{"table lamp", "radiator", "zebra", "bookcase"};
  const auto first = home->add_region_finder({"region proposals", " proposals 1", labels});
  ASSERT_OK(first);
  ASSERT_OK(home->put_detections(1, *first, look_with({"table lamp", "radiator", "zebra"})));
  EXPECT_THAT(
      names_in(*home),
      UnorderedElementsAre(FieldsAre("sofa", true, false), FieldsAre("bed", true, false),
                           FieldsAre("lamp", true, true), FieldsAre("radiator", false, true)))
      << "a look-alike speaks, a zebra does not";

  const auto second = home->add_region_finder({"region proposals", " proposals 2", labels});
  ASSERT_OK(second);
  EXPECT_THAT(names_in(*home), ::testing::SizeIs(4)) << "it has looked at nothing yet";
  ASSERT_OK(home->put_detections(1, *second, look_with({"bookcase"})));
  EXPECT_THAT(names_in(*home),
              UnorderedElementsAre(FieldsAre("sofa", true, false), FieldsAre("bed", true, false),
                                   FieldsAre("bookcase", true, true)));
}

TEST(StoredDetections, WhatAnEarlierProgramFoundByActivationMapsCountsNoMore) {
  const roomwise::testing::ScratchFolder folder;
  auto home = home::Home::create(folder / "a.home");
  ASSERT_OK(home);
  home::testing::fill(*home);
  const auto maps = home->add_region_finder({"maps", "f00 activation maps 1", {"table lamp"}});
  ASSERT_OK(maps);
  ASSERT_OK(home->put_detections(1, *maps, look_with({"table lamp"})));
  EXPECT_THAT(names_in(*home),
              UnorderedElementsAre(FieldsAre("sofa", true, false), FieldsAre("bed", true, false)));
}

TEST(StoredDetections, SayWhoDidNotLookAtAKeyframe) {
  using objects::DetectionSource;
  const roomwise::testing::ScratchFolder folder;
  auto home = home::Home::create(folder / "a.home");
  ASSERT_OK(home);
  home::testing::fill(*home);
  const auto maps = home->add_region_finder({"region proposals", " proposals 1", {"table lamp"}});
  ASSERT_OK(maps);
  ASSERT_OK(home->put_detections(1, *maps, look_with({"table lamp"})));
  const auto components = observed_keyframes(*home);
  ASSERT_OK(components);
  std::size_t others = 0;
  for (const auto& [component, keyframes] : *components) {
    for (const objects::ObservedKeyframe& keyframe : keyframes) {
      EXPECT_FALSE(keyframe.sources_not_run.contains(DetectionSource::kDetector));
      EXPECT_EQ(keyframe.sources_not_run.contains(DetectionSource::kProposal),
                keyframe.keyframe_id != 1);
      others += keyframe.keyframe_id != 1 ? 1 : 0;
    }
  }
  EXPECT_GT(others, 0U);
}

TEST(StoredDetections, ANetworkThatWasInterruptedTakesNothingAway) {
  const roomwise::testing::ScratchFolder folder;
  auto home = home::Home::create(folder / "a.home");
  ASSERT_OK(home);
  home::testing::fill(*home);
  const rooms::Concepts concepts = rooms::Concepts::standard();
  const auto said = [&] { return said_of_pictures(*home, concepts.vocabulary, 0.1).value(); };
  const auto before = said();
  ASSERT_EQ(before.size(), 4U);
  ASSERT_EQ(before.at(0).size(), 1U);
  EXPECT_EQ(before.at(0)[0].object, "bed") << "a studio couch";

  const auto newer = home->add_network({"newer", "beef", {"table lamp", "zebra"}, 3});
  ASSERT_OK(newer);
  EXPECT_EQ(said().size(), 4U) << "it has looked at nothing yet";
  ASSERT_OK(home->put_prediction(2, *newer, {{0, 0, 0}, {0.9F, 0.1F}}));
  const auto after = said();
  EXPECT_EQ(after.size(), 4U);
  ASSERT_EQ(after.at(0).size(), 1U);
  EXPECT_EQ(after.at(0)[0].object, "bed");
  ASSERT_EQ(after.at(2).size(), 1U);
  EXPECT_EQ(after.at(2)[0].object, "lamp");
}

}  // namespace
}  // namespace roomwise::pipeline
