#include "roomwise/pipeline/objects/stored_detections.h"

#include <gmock/gmock.h>

#include "roomwise/base/testing/testing.h"
#include "roomwise/home/testing/sample_home.h"

namespace roomwise::pipeline {
namespace {

using ::testing::FieldsAre;
using ::testing::UnorderedElementsAre;

// The names of the regions of key-frame 1, whether they are words, and how they were found.
std::vector<std::tuple<std::string, bool, bool>> names_in(const home::Home& home) {
  const auto looks = StoredDetections::read(home);
  EXPECT_OK(looks);
  std::vector<std::tuple<std::string, bool, bool>> names;
  for (const objects::ObservedKeyframe& keyframe : looks->components().at(1)) {
    if (keyframe.keyframe_id != 1) continue;
    for (const objects::NamedRegion& region : keyframe.regions) {
      const bool by_maps = region.region->source == objects::RegionSource::kActivation;
      names.emplace_back(region.name, region.is_in_vocabulary, by_maps);
    }
  }
  return names;
}

objects::KeyframeDetections look_with(const std::vector<std::string>& labels) {
  objects::KeyframeDetections look = home::testing::sample_look(1);
  look.regions.resize(1);
  const objects::Region region = look.regions.front();
  look.regions.clear();
  for (const std::string& label : labels) {
    look.regions.push_back(region);
    look.regions.back().label = label;
  }
  return look;
}

TEST(StoredDetections, AnActivationFinderStandsBesideTheDetectorAndReplacesItsOlderSelf) {
  const roomwise::testing::ScratchFolder folder;
  auto home = home::Home::create(folder / "a.home");
  ASSERT_OK(home);
  home::testing::fill(*home);
  EXPECT_THAT(names_in(*home),
              UnorderedElementsAre(FieldsAre("sofa", true, false), FieldsAre("bed", true, false)));

  const std::vector<std::string> labels{"table lamp", "radiator", "zebra", "bookcase"};
  const auto first = home->add_region_finder({"net activation", "f00 activation maps 1", labels});
  ASSERT_OK(first);
  ASSERT_OK(home->put_detections(1, *first, look_with({"table lamp", "radiator", "zebra"})));
  EXPECT_THAT(
      names_in(*home),
      UnorderedElementsAre(FieldsAre("sofa", true, false), FieldsAre("bed", true, false),
                           FieldsAre("lamp", true, true), FieldsAre("radiator", false, true)))
      << "a look-alike speaks, a zebra does not";

  const auto second = home->add_region_finder({"net activation", "f00 activation maps 2", labels});
  ASSERT_OK(second);
  EXPECT_THAT(names_in(*home), ::testing::SizeIs(4)) << "it has looked at nothing yet";
  ASSERT_OK(home->put_detections(1, *second, look_with({"bookcase"})));
  EXPECT_THAT(names_in(*home),
              UnorderedElementsAre(FieldsAre("sofa", true, false), FieldsAre("bed", true, false),
                                   FieldsAre("bookcase", true, true)));
}

TEST(StoredDetections, SayWhoDidNotLookAtAKeyframe) {
  using objects::RegionSource;
  const roomwise::testing::ScratchFolder folder;
  auto home = home::Home::create(folder / "a.home");
  ASSERT_OK(home);
  home::testing::fill(*home);
  const auto crops = home->add_region_finder({"crops", "f00 crops 1 f01: 0.1", {"table lamp"}});
  ASSERT_OK(crops);
  ASSERT_OK(home->put_detections(1, *crops, look_with({"table lamp"})));
  const auto looks = StoredDetections::read(*home);
  ASSERT_OK(looks);
  std::size_t others = 0;
  for (const auto& [component, keyframes] : looks->components()) {
    for (const objects::ObservedKeyframe& keyframe : keyframes) {
      EXPECT_FALSE(keyframe.not_asked.contains(RegionSource::kDetector));
      EXPECT_TRUE(keyframe.not_asked.contains(RegionSource::kActivation));
      EXPECT_EQ(keyframe.not_asked.contains(RegionSource::kCrop), keyframe.keyframe_id != 1);
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
