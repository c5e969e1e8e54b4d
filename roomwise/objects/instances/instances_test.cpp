#include "roomwise/objects/instances/instances.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <ranges>

#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/objects/testing/test_room.h"

namespace roomwise::objects {
namespace {

using Eigen::Vector3d;
using testing::TestRoom;

const TestRoom::Thing kBed{"bed", {0.5, 0.2, 0.25}, {2.0, 1.4, 0.5}};
const TestRoom::Thing kChair{"chair", {-0.5, 0, 0.4}, {0.45, 0.45, 0.8}};
const TestRoom::Thing kOtherChair{"chair", {0.2, 0, 0.4}, {0.45, 0.45, 0.8}};

std::vector<std::string> names_in(const TestRoom& room) {
  std::vector<std::string> names;
  for (const Instance& instance : room.instances()) names.push_back(instance.name);
  return names;
}
using Names = std::vector<std::string>;

// What a thing is found to be when it is looked at from all sides; empty where it is not found.
std::string name_of(const TestRoom::Thing& thing, int looks, double radius_m) {
  TestRoom room;
  room.things = {thing};
  room.look_around(thing.center, looks, radius_m);
  const Names names = names_in(room);
  return names.empty() ? "" : names[0];
}

TEST(FindInstances, OneBedSeenFromAllSidesIsOne) {
  TestRoom room;
  room.things = {kBed};
  room.look_around(kBed.center, 10, 2.2);
  const auto instances = room.instances();
  ASSERT_EQ(instances.size(), 1U);
  EXPECT_EQ(instances[0].name, "bed");
  EXPECT_EQ(instances[0].observations, 10);
  EXPECT_EQ(instances[0].expected, 10);
  EXPECT_GT(instances[0].probability, 0.95);
  const geometry::OrientedBox box = room.box_of(instances[0]);
  EXPECT_LT((box.center() - kBed.center).norm(), 0.06);
  const double longer = std::max(box.size_m.x(), box.size_m.y());
  const double shorter = std::min(box.size_m.x(), box.size_m.y());
  EXPECT_NEAR(longer, 2.0, 0.12);
  EXPECT_NEAR(shorter, 1.4, 0.12);
  EXPECT_NEAR(box.size_m.z(), 0.5, 0.06);
  EXPECT_LT(instances[0].sigma_m.maxCoeff(), 0.1);
  const Vector3d up = box.world_from_box.rotation * Vector3d::UnitZ();
  EXPECT_GT(up.z(), 0.9999) << "the box stands upright";
}

TEST(FindInstances, TwoChairsBesideEachOtherStayTwo) {
  TestRoom room;
  room.things = {kChair, kOtherChair};
  room.look_around({-0.15, 0, 0.4}, 12);
  const auto instances = room.instances();
  ASSERT_EQ(instances.size(), 2U);
  std::vector<double> x;
  for (const Instance& instance : instances) {
    EXPECT_EQ(instance.name, "chair");
    x.push_back(room.box_of(instance).center().x());
  }
  std::ranges::sort(x);
  EXPECT_NEAR(x[0], kChair.center.x(), 0.08);
  EXPECT_NEAR(x[1], kOtherChair.center.x(), 0.08);
}

TEST(FindInstances, HangsOnNoOrder) {
  TestRoom room;
  room.things = {kChair, kOtherChair};
  room.look_around({-0.15, 0, 0.4}, 8);
  const auto before = room.instances();
  std::vector<ObservedKeyframe> shuffled = room.keyframes();
  for (ObservedKeyframe& keyframe : shuffled) std::ranges::reverse(keyframe.detections);
  RandomStream random(3, {});
  for (std::size_t i = shuffled.size(); i > 1; --i) {
    std::swap(shuffled[i - 1], shuffled[static_cast<std::size_t>(random.index(i))]);
  }
  const auto after = find_instances(shuffled, {Vector3d::UnitZ(), 0}, {});
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < after.size(); ++i) {
    EXPECT_EQ(after[i].keyframe_id, before[i].keyframe_id);
    EXPECT_EQ(after[i].observations, before[i].observations);
    EXPECT_NEAR(after[i].probability, before[i].probability, 1e-9);
    EXPECT_LT((after[i].box_keyframe.center() - before[i].box_keyframe.center()).norm(), 1e-4);
  }
}

TEST(FindInstances, WhatIsSeenTooSeldomIsNoInstance) {
  TestRoom room;
  room.things = {kChair};
  room.look_around(kChair.center, 2, 1.8, 0, 0.4);
  EXPECT_TRUE(room.instances().empty());
  // Four see it now, but forty more look there too and see nothing that looks like one.
  room.look_around(kChair.center, 2, 1.8, 1, 0.4);
  EXPECT_EQ(room.instances().size(), 1U);
  room.look_around(kChair.center, 40, 1.8, 0, 1.4, /*finds=*/false);
  EXPECT_TRUE(room.instances().empty());
}

TEST(FindInstances, ExpectsNothingOfKeyframesThatCannotSeeIt) {
  TestRoom room;
  room.things = {kChair, {"wall", {0.6, 0, 1.3}, {0.1, 4, 2.6}}};
  room.look_around(kChair.center, 4, 1.5, 2.5, 1);
  for (int i = 0; i < 6; ++i) {
    room.look({2.2, 0.1 * i, 1.4}, kChair.center, /*finds=*/false);  // behind the wall
    room.look({-2, 0.1 * i, 1.4}, {-2.9, 2, 1}, /*finds=*/false);    // looks away
  }
  const auto instances = room.instances();
  const auto chair = std::ranges::find(instances, "chair", &Instance::name);
  ASSERT_NE(chair, instances.end());
  EXPECT_EQ(chair->expected, 4);
}

TEST(FindInstances, NamesCompete) {
  TestRoom room;
  room.things = {kBed};
  room.look_around(kBed.center, 8, 2.2);
  room.look({2.4, 1.5, 1.4}, kBed.center, true, "sofa");
  room.look({-1.4, 1.5, 1.4}, kBed.center, true, "sofa");
  const auto instances = room.instances();
  ASSERT_EQ(instances.size(), 1U);
  EXPECT_EQ(instances[0].name, "bed");
  EXPECT_NEAR(instances[0].names.at("bed"), 0.8, 0.01);
  EXPECT_NEAR(instances[0].names.at("sofa"), 0.2, 0.01);
  EXPECT_LT(instances[0].probability, 0.81);
}

TEST(FindInstances, ActivationMapsFindWhatTheyShowFromAllSides) {
  TestRoom room;
  room.source = DetectionSource::kActivation;
  room.things = {kChair};
  room.look_around(kChair.center, 10);
  const auto instances = room.instances();
  ASSERT_EQ(instances.size(), 1U);
  EXPECT_EQ(instances[0].observations, 10);
  EXPECT_GT(instances[0].probability, 0.8);
}

TEST(FindInstances, WhatActivationMapsShowNowAndThenIsNothing) {
  const auto things_by = [](DetectionSource source, int missed) {
    TestRoom room;
    room.source = source;
    room.things = {kChair};
    room.look_around(kChair.center, 8, 1.8, 0, 1);
    room.look_around(kChair.center, missed, 1.8, 0.1, 0.8, /*finds=*/false);
    return room.instances().size();
  };
  EXPECT_EQ(things_by(DetectionSource::kDetector, 16), 1U);
  EXPECT_EQ(things_by(DetectionSource::kActivation, 16), 0U);
  EXPECT_EQ(things_by(DetectionSource::kActivation, 4), 1U) << "in two pictures of three";
}

// Of a chair that four pictures show, and so many more should have.
double probability_by(DetectionSource source, int missed) {
  TestRoom room;
  room.source = source;
  room.things = {kChair};
  room.look_around(kChair.center, 4, 1.8, 0, 1);
  if (missed > 0) room.look_around(kChair.center, missed, 1.8, 0.1, 0.8, /*finds=*/false);
  const auto instances = room.instances({.min_probability = 0});
  return instances.size() == 1 ? instances[0].probability : 0;
}

TEST(FindInstances, CropsSpeakForAThingAsADetectorDoesAndMoreAgainstIt) {
  EXPECT_EQ(probability_by(DetectionSource::kCrop, 0),
            probability_by(DetectionSource::kDetector, 0));
  EXPECT_GT(probability_by(DetectionSource::kDetector, 6), 0.8);
  EXPECT_GT(probability_by(DetectionSource::kCrop, 2), 0.8);
  EXPECT_LT(probability_by(DetectionSource::kCrop, 6), 0.7);
}

TEST(FindInstances, WhoDidNotLookMissesNothing) {
  TestRoom room;
  room.source = DetectionSource::kCrop;
  room.things = {kChair};
  room.look_around(kChair.center, 4, 1.8, 0, 1);
  room.look_around(kChair.center, 6, 1.8, 0.1, 0.8, /*finds=*/false);
  const auto missed = [&] {
    const auto instances = room.instances({.min_probability = 0});
    return instances.size() == 1 ? instances[0].expected - instances[0].observations : -1;
  };
  EXPECT_GT(missed(), 3);
  for (ObservedKeyframe& keyframe : room.keyframes()) {
    if (keyframe.detections.empty()) keyframe.sources_not_run = {DetectionSource::kDetector};
  }
  EXPECT_GT(missed(), 3) << "the crops were shown them";
  for (ObservedKeyframe& keyframe : room.keyframes()) {
    if (keyframe.detections.empty()) keyframe.sources_not_run = {DetectionSource::kCrop};
  }
  EXPECT_EQ(missed(), 0);
}

TEST(FindInstances, AToiletMustBeSurerThanAChair) {
  const auto found_as = [](const std::string& name, const InstanceOptions& options) {
    TestRoom room;
    room.things = {{name, {0, 0, 0.4}, {0.5, 0.7, 0.8}}};
    room.look_around({0, 0, 0.4}, 3, 1.8, 0, 1);
    room.look_around({0, 0, 0.4}, 8, 1.8, 0.1, 0.8, /*finds=*/false);
    return room.instances(options).size();
  };
  EXPECT_EQ(found_as("chair", {}), 1U);
  EXPECT_EQ(found_as("toilet seat", {}), 0U);
  EXPECT_EQ(found_as("toilet seat", {.min_probability_of = {}}), 1U);
  InstanceOptions wrong;
  wrong.min_probability_of["chair"] = 2;
  EXPECT_ERROR(wrong.validate(), "chair");
}

TEST(FindInstances, CropsAloneFindOnlyWhatLooksAsItsKindDoes) {
  const auto baths_by = [](DetectionSource source) {
    TestRoom room;
    room.source = source;
    room.things = {{"bath", {0, 0, 0.2}, {0.5, 0.5, 0.4}}};  // a basket
    room.look_around({0, 0, 0.2}, 10);
    return room.instances().size();
  };
  EXPECT_EQ(baths_by(DetectionSource::kDetector), 1U);
  EXPECT_EQ(baths_by(DetectionSource::kCrop), 0U);
}

TEST(FindInstances, WhatCropsAloneShowBesideASurerOneOfItsNameIsThatOne) {
  const auto lamps_by = [](DetectionSource source, double apart_m) {
    TestRoom room;
    const Vector3d lamp(0, 0, 0.6), beside(0, 0.2 + apart_m, 0.6);
    room.things = {{"lamp", lamp, {0.2, 0.2, 0.5}}};
    room.look_around(lamp, 10, 1.5);
    room.source = source;
    room.things = {{"lamp", beside, {0.2, 0.2, 0.5}}};
    room.look_around(beside, 8, 1.5);
    return room.instances().size();
  };
  EXPECT_EQ(lamps_by(DetectionSource::kDetector, 0.12), 2U);
  EXPECT_EQ(lamps_by(DetectionSource::kCrop, 0.12), 1U);
  EXPECT_EQ(lamps_by(DetectionSource::kCrop, 0.6), 2U) << "not beside it";
}

TEST(FindInstances, ActivationMapsNameADetectorsThingOnlyWhereTheyStandByThemselves) {
  const auto names_after = [](int looks) {
    TestRoom room;
    room.things = {kBed};
    room.look_around(kBed.center, 4, 2.2);
    room.source = DetectionSource::kActivation;
    for (int i = 0; i < looks; ++i) {
      const double angle = 0.2 + 2 * std::numbers::pi * i / looks;
      room.look(kBed.center + Vector3d(2.2 * std::cos(angle), 2.2 * std::sin(angle), 1),
                kBed.center, true, "wardrobe");
    }
    const auto instances = room.instances();
    return instances.size() == 1 ? instances[0].names : std::map<std::string, double>();
  };
  EXPECT_EQ(names_after(5), (std::map<std::string, double>{{"bed", 1}}));
  const auto names = names_after(16);
  ASSERT_TRUE(names.contains("wardrobe"));
  EXPECT_GT(names.at("wardrobe"), names.at("bed"));
}

TEST(FindInstances, ALookAlikeTakesTheNameAway) {
  TestRoom room;
  room.things = {{"toilet seat", {0, 0, 0.35}, {0.6, 0.4, 0.7}}};
  room.look_around({0, 0, 0.35}, 4);
  ASSERT_EQ(room.instances().size(), 1U);
  room.source = DetectionSource::kActivation;
  for (int i = 0; i < 16; ++i) {
    const double angle = 0.2 + 2 * std::numbers::pi * i / 16;
    room.look({1.8 * std::cos(angle), 1.8 * std::sin(angle), 1.3}, {0, 0, 0.35}, true, "radiator");
    room.keyframes().back().detections.back().is_in_vocabulary = false;
  }
  EXPECT_TRUE(room.instances().empty()) << "neither a toilet seat nor a radiator";
}

TEST(FindInstances, ActivationMapsSeeNoWardrobeInADoor) {
  const auto wardrobes = [](double depth_m) {
    TestRoom room;
    room.source = DetectionSource::kActivation;
    room.things = {{"wardrobe", {2.99 - depth_m / 2, 0, 1}, {depth_m, 1, 2}}};  // at the wall
    room.look_around({2.4, 0, 0.8}, 12, 2.0, 2.4, 1.5);
    return room.instances().size();
  };
  EXPECT_EQ(wardrobes(0.5), 1U);
  EXPECT_EQ(wardrobes(0.05), 0U);
}

TEST(FindInstances, NothingIsCalledWhatIsNeverAsLarge) {
  const auto names_after = [](int as_toilet, int as_bath) {
    TestRoom room;
    room.things = {{"bath", {0, 0, 0.3}, {1.7, 0.8, 0.6}}};
    for (int i = 0; i < as_toilet + as_bath; ++i) {
      const double angle = 2 * std::numbers::pi * i / (as_toilet + as_bath);
      room.look({2.2 * std::cos(angle), 2.2 * std::sin(angle), 1.3}, {0, 0, 0.3}, true,
                i < as_toilet ? "toilet seat" : "bath");
    }
    return names_in(room);
  };
  EXPECT_EQ(names_after(10, 0), Names());
  EXPECT_EQ(names_after(12, 4), Names{"bath"}) << "twelve mistakes hardly count";
  EXPECT_EQ(names_after(30, 2), Names()) << "too few say so";
}

TEST(FindInstances, NothingIsCalledWhatIsNeverAsSmall) {
  const auto found = [](const TestRoom::Thing& thing) { return name_of(thing, 6, 1.8); };
  EXPECT_EQ(found({"bottle", {0, 0, 0.5}, {0.1, 0.1, 0.3}}), "bottle");
  EXPECT_EQ(found({"bottle", {0, 0, 0.5}, {0.15, 0.15, 0.1}}), "") << "a cup";
  EXPECT_EQ(found({"toilet seat", {0, 0, 0.4}, {0.4, 0.65, 0.8}}), "toilet seat");
  EXPECT_EQ(found({"toilet seat", {0, 0, 0.35}, {0.3, 0.3, 0.7}}), "") << "a bin";
}

TEST(FindInstances, WhatIsALittleTooLargeForAllItsNamesKeepsTheOneThatNearlyFits) {
  const auto found = [](const TestRoom::Thing& thing) { return name_of(thing, 8, 2.3); };
  EXPECT_EQ(found({"bed", {0, 0, 0.25}, {2.7, 1.6, 0.5}}), "bed") << "with what stands at its foot";
  EXPECT_EQ(found({"bed", {0, 0, 0.25}, {3.4, 1.6, 0.5}}), "");
  EXPECT_EQ(found({"bottle", {0, 0, 0.9}, {0.38, 0.19, 0.3}}), "")
      << "of what stands on things little is touched";
}

TEST(FindInstances, AChairThatWasMeasuredIsNotSwallowedByTwoThatPicturesTakeForOne) {
  TestRoom room;
  room.things = {{"chair", {0, 0, 0.4}, {1.5, 0.45, 0.8}}};
  room.look_around({0, 0, 0.4}, 30);
  EXPECT_TRUE(room.instances().empty()) << "no chair is as long";
  room.things = {{"chair", {-0.5, 0, 0.4}, {0.45, 0.45, 0.8}}};
  room.source = DetectionSource::kProposal;
  room.look_around({-0.5, 0, 0.4}, 8);
  const auto instances = room.instances();
  ASSERT_EQ(instances.size(), 1U);
  EXPECT_EQ(instances[0].name, "chair");
  EXPECT_NEAR(room.box_of(instances[0]).center().x(), -0.5, 0.1);
}

TEST(FindInstances, TwoTakenForOneThatIsNearlyAChairDoNotTakeThePlaceOfOneThatWasMeasured) {
  TestRoom room;
  room.things = {{"chair", {0, 0, 0.4}, {1.32, 0.45, 0.8}}};
  room.look_around({0, 0, 0.4}, 30);
  EXPECT_EQ(room.instances().size(), 1U) << "nearly as long as chairs are at most";
  room.things = {{"chair", {-0.4, 0, 0.4}, {0.45, 0.45, 0.8}}};
  room.source = DetectionSource::kProposal;
  room.look_around({-0.4, 0, 0.4}, 8);
  const auto instances = room.instances();
  ASSERT_EQ(instances.size(), 1U);
  EXPECT_NEAR(room.box_of(instances[0]).center().x(), -0.4, 0.15);
}

TEST(FindInstances, TwoThatWereMeasuredBesideEachOtherStayTwo) {
  TestRoom room;
  room.source = DetectionSource::kProposal;
  for (const double x : {-0.28, 0.28}) {
    room.things = {{"chair", {x, 0, 0.4}, {0.45, 0.45, 0.8}}};
    room.look_around(room.things[0].center, 8);
  }
  EXPECT_EQ(room.instances().size(), 2U) << "though no picture shows both";
}

TEST(FindInstances, BoxesOfAChairThatWasMeasuredAreNotOfTheOneBesideIt) {
  const TestRoom::Thing left{"chair", {-0.3, 0, 0.4}, {0.45, 0.45, 0.8}};
  const TestRoom::Thing right{"chair", {0.3, 0, 0.4}, {0.45, 0.45, 0.8}};
  TestRoom room;
  const auto look_at = [&](const TestRoom::Thing& thing, int looks, double first_rad) {
    room.things = {thing};
    room.look_around({0, 0, 0.4}, looks, 1.8, first_rad);
  };
  look_at({"chair", {0, 0, 0.4}, {1.05, 0.45, 0.8}}, 4, 0);  // both, taken for one
  look_at(left, 6, 0.2);
  look_at(right, 6, 0.4);
  EXPECT_EQ(room.instances().size(), 1U) << "no picture shows two";
  room.source = DetectionSource::kProposal;
  look_at(left, 8, 0.1);
  std::vector<double> x;
  for (const Instance& one : room.instances()) x.push_back(room.box_of(one).center().x());
  std::ranges::sort(x);
  ASSERT_EQ(x.size(), 2U);
  EXPECT_NEAR(x[0], left.center.x(), 0.08);
  EXPECT_GT(x[1], 0);
}

TEST(FindInstances, ABedsHeadIsNoChair) {
  const auto names_with = [](const TestRoom::Thing& beside, const TestRoom::Thing& whole) {
    TestRoom room;
    room.things = {whole};
    room.look_around(whole.center, 12, 2.2);
    room.things = {beside};
    room.look_around(beside.center, 6, 1.6);
    return names_in(room);
  };
  const TestRoom::Thing bed{"bed", {0, 0, 0.3}, {2.0, 1.4, 0.6}};
  EXPECT_EQ(names_with({"chair", {-0.65, 0, 0.3}, {0.6, 0.9, 0.6}}, bed), Names{"bed"});
  EXPECT_EQ(names_with({"chair", {-1.45, 0, 0.4}, {0.5, 0.5, 0.8}}, bed), (Names{"bed", "chair"}))
      << "at its side";
  const TestRoom::Thing table{"table", {0, 0, 0.37}, {2.0, 1.4, 0.75}};
  EXPECT_EQ(names_with({"chair", {-0.65, 0, 0.3}, {0.6, 0.9, 0.6}}, table),
            (Names{"chair", "table"}))
      << "chairs stand under tables";
}

TEST(FindInstances, ABottleIsAsHighAsPicturesShowItToBe) {
  TestRoom room;
  room.things = {{"bottle", {0, 0, 0.55}, {0.1, 0.1, 0.1}}};  // of its glass depth shows little
  room.look_around({0, 0, 0.55}, 6, 0.9);
  ASSERT_FALSE(room.keyframes()[0].detections.empty());
  EXPECT_TRUE(room.instances().empty()) << "a cup";
  for (ObservedKeyframe& keyframe : room.keyframes()) {
    for (network::PixelBox& box : keyframe.detections | std::views::transform(&Detection::box)) {
      box.top -= 0.8F * (box.bottom - box.top);
    }
  }
  const auto instances = room.instances();
  ASSERT_EQ(instances.size(), 1U);
  const geometry::OrientedBox box = room.box_of(instances[0]);
  EXPECT_NEAR(box.size_m.z(), 0.27, 0.06);
  EXPECT_NEAR(box.center().z() - box.size_m.z() / 2, 0.5, 0.03) << "it stands where it stood";
}

TEST(FindInstances, WhatIsCalledABottleAndIsThickIsAVase) {
  const auto found = [](double foot_m, double thick_m, double high_m) {
    return name_of({"bottle", {0, 0, foot_m + high_m / 2}, {thick_m, thick_m, high_m}}, 8, 1.5);
  };
  EXPECT_EQ(found(0.7, 0.1, 0.3), "bottle");
  EXPECT_EQ(found(0.7, 0.16, 0.3), "bottle") << "a canister";
  EXPECT_EQ(found(0.7, 0.25, 0.4), "vase");
  EXPECT_EQ(found(0, 0.25, 0.4), "") << "a bin";
  EXPECT_EQ(found(0.7, 0.25, 0.7), "") << "a plant's stem, a lamp";
  TestRoom room;
  room.things = {{"bottle", {0, 0, 0.9}, {0.25, 0.25, 0.4}}};
  room.look_around({0, 0, 0.9}, 8, 1.5);
  const auto instances = room.instances();
  ASSERT_EQ(instances.size(), 1U);
  EXPECT_TRUE(instances[0].names.contains("bottle")) << "by which its surface is collected";
  EXPECT_NEAR(instances[0].names.at("vase") + instances[0].names.at("bottle"), 1, 1e-9);
}

TEST(FindInstances, ALowFridgeGivesWayToAnotherName) {
  const auto name_at = [](double height_m) {
    TestRoom room;
    room.things = {{"fridge", {0, 0, height_m / 2}, {0.7, 0.7, height_m}}};
    const Vector3d middle = room.things[0].center;
    room.look_around(middle, 6);
    room.look({1.8, 0.5, 1.5}, middle, true, "stove");
    room.look({0.5, 1.8, 1.5}, middle, true, "stove");
    const auto instances = room.instances();
    return instances.size() == 1 ? instances[0].name : "";
  };
  EXPECT_EQ(name_at(1.4), "fridge");
  EXPECT_EQ(name_at(0.9), "stove") << "as kitchen cabinets are";
}

TEST(FindInstances, AProposalCountsByItsBestViewsAlone) {
  EXPECT_EQ(probability_by(DetectionSource::kProposal, 0),
            probability_by(DetectionSource::kDetector, 0));
  EXPECT_EQ(probability_by(DetectionSource::kProposal, 12),
            probability_by(DetectionSource::kProposal, 0));
  EXPECT_LT(probability_by(DetectionSource::kDetector, 12),
            probability_by(DetectionSource::kDetector, 0));
}

TEST(FindInstances, WhatCloserLooksSayCountsTwiceForAName) {
  const auto name_after = [](int as_bed) {
    TestRoom room;
    room.things = {kBed};
    for (int i = 0; i < as_bed + 4; ++i) {
      const double angle = 2 * std::numbers::pi * i / (as_bed + 4);
      const Vector3d from(2.2 * std::cos(angle), 2.2 * std::sin(angle), 1.0);
      room.source = i < as_bed ? DetectionSource::kDetector : DetectionSource::kProposal;
      room.look(kBed.center + from, kBed.center, true, i < as_bed ? "bed" : "sofa");
    }
    const auto instances = room.instances();
    return instances.size() == 1 ? instances[0].name : "";
  };
  EXPECT_EQ(name_after(6), "sofa");
  EXPECT_EQ(name_after(10), "bed");
}

TEST(FindInstances, AFewBoxesThatAgreeWithAProposalTakeNothingFromIt) {
  TestRoom room;
  room.things = {kChair};
  room.source = DetectionSource::kProposal;
  room.look_around(kChair.center, 6, 1.8, 0, 1);
  room.source = DetectionSource::kDetector;
  room.look_around(kChair.center, 2, 1.8, 0.2, 0.4);
  room.look_around(kChair.center, 20, 1.8, 0.1, 0.8, /*finds=*/false);
  const auto instances = room.instances();
  ASSERT_EQ(instances.size(), 1U);
  EXPECT_GT(instances[0].probability, 0.9) << "though twenty pictures show no box";
}

TEST(FindInstances, AProposalThatThePictureCutsOnThreeSidesCounts) {
  const auto found_by = [](DetectionSource source) {
    TestRoom room;
    room.source = source;
    room.things = {{"wardrobe", {2.5, 0, 1.1}, {0.6, 2.0, 2.2}}};
    for (const double y : {-0.2, 0.0, 0.2, 0.4}) room.look({0.6, y, 1.3}, {2.5, 0, 1.0});
    return room.instances().size();
  };
  EXPECT_EQ(found_by(DetectionSource::kDetector), 0U)
      << "what fills the picture is not known whole";
  EXPECT_EQ(found_by(DetectionSource::kProposal), 1U) << "its box is known in space";
}

TEST(FindInstances, TwoOfOneNameInOnePlaceAreOne) {
  TestRoom room;
  room.things = {{"bed", {0, 0, 0.25}, {2.0, 1.4, 0.5}}, {"bed", {0.2, 0, 0.3}, {1.3, 1.1, 0.6}}};
  room.look_around({0, 0, 0.3}, 12, 2.2);
  const auto instances = room.instances();
  ASSERT_EQ(instances.size(), 1U);
  EXPECT_EQ(instances[0].observations, 12);
}

TEST(FindInstances, WhatReachesIntoASurerOneOfItsNameIsThatOne) {
  const auto beds_apart = [](double apart_m) {
    TestRoom room;
    room.things = {{"bed", {-0.6, 0, 0.25}, {2.0, 1.4, 0.5}},
                   {"bed", {apart_m - 0.6, 0, 0.3}, {1.0, 1.4, 0.6}}};
    room.look_around({0, 0, 0.3}, 12, 2.2);
    for (int i = 0; i < 3; ++i) room.look({-2.2, 0.3 * i, 1.4}, {-1.2, 0, 0.3});
    return room.instances();
  };
  EXPECT_EQ(beds_apart(1.7).size(), 2U) << "beside each other";
  const auto instances = beds_apart(1.25);  // a quarter of the smaller one
  ASSERT_EQ(instances.size(), 1U);
  EXPECT_GE(instances[0].observations, 12) << "the one that more pictures show";
}

TEST(FindInstances, TheShadeAndTheFootOfALampAreOne) {
  const auto things_aside = [](const std::string& name, double aside_m, double top_m = 1.3) {
    TestRoom room;
    room.things = {{name, {0, 0, top_m}, {0.3, 0.3, 0.3}},
                   {name, {aside_m, 0, 0.35}, {0.3, 0.3, 0.3}}};
    room.look_around({0, 0, 0.8}, 12, 2.2);
    for (int i = 0; i < 3; ++i) room.look({-1.2, 0.2 * i, 1.5}, {0, 0, top_m});  // the upper
    return room.instances().size();
  };
  EXPECT_EQ(things_aside("lamp", 0.1), 1U);
  EXPECT_EQ(things_aside("lamp", 0.4), 1U) << "the shade hangs on an arm";
  EXPECT_EQ(things_aside("lamp", 0.4, 0.5), 2U) << "beside each other";
  EXPECT_EQ(things_aside("lamp", 0.6), 2U);
  EXPECT_EQ(things_aside("lamp", 0.1, 2.4), 2U) << "one hangs from the ceiling";
  EXPECT_EQ(things_aside("vase", 0.1), 2U) << "on the boards of a shelf";
}

TEST(FindInstances, AMicrowaveBesideASurerOneIsAnOven) {
  const auto things_apart = [](const std::string& name, double apart_m, int looks = 5) {
    TestRoom room;
    room.things = {{name, {0, 0, 1.0}, {0.5, 0.4, 0.3}}};
    room.look_around({0, 0, 1.0}, 10);
    room.things = {{name, {apart_m, 0, 1.0}, {0.5, 0.4, 0.3}}};
    room.look_around({apart_m, 0, 1.0}, looks);
    return room.instances().size();
  };
  EXPECT_EQ(things_apart("microwave", 1.1), 1U);
  EXPECT_EQ(things_apart("microwave", 1.1, 8), 2U) << "many pictures show either";
  EXPECT_EQ(things_apart("microwave", 1.4), 2U) << "its middle is over a metre from the other";
  EXPECT_EQ(things_apart("plant", 0.8), 2U);
}

TEST(FindInstances, AVaseInAPlantIsItsPot) {
  const auto things_with = [](const std::string& name) {
    TestRoom room;
    room.things = {{name, {0, 0, 0.4}, {0.4, 0.4, 0.8}}, {"vase", {0.17, 0, 0.2}, {0.1, 0.3, 0.3}}};
    room.look_around({0, 0, 0.5}, 12);
    return room.instances().size();
  };
  EXPECT_EQ(things_with("plant"), 1U);
  EXPECT_EQ(things_with("lamp"), 2U);
}

TEST(FindInstances, AThingOnAnotherStaysItself) {
  TestRoom room;
  room.things = {{"table", {0, 0, 0.35}, {1.2, 0.8, 0.7}},
                 {"vase", {0.1, 0, 0.85}, {0.15, 0.15, 0.3}}};
  room.look_around({0, 0, 0.6}, 10);
  const auto instances = room.instances();
  ASSERT_EQ(instances.size(), 2U);
  EXPECT_EQ(instances[0].name, "table");
  EXPECT_EQ(instances[1].name, "vase");
  EXPECT_LT((room.box_of(instances[1]).center() - Vector3d(0.1, 0, 0.85)).norm(), 0.05);
}

TEST(FindInstances, ALoopClosureJoinsWhatDriftHadSplit) {
  TestRoom room;
  room.things = {kChair};
  room.look_around(kChair.center, 5, 1.8, 0, 2);
  room.look_around(kChair.center, 5, 1.8, 2, 2);
  const std::vector<ObservedKeyframe> right = room.keyframes();
  // The second pass has drifted by a metre.
  for (std::size_t i = 5; i < 10; ++i) {
    room.keyframes()[i].world_from_camera.translation += Vector3d(1, 0.2, 0);
  }
  EXPECT_EQ(room.instances().size(), 2U);
  room.keyframes() = right;
  const auto instances = room.instances();
  ASSERT_EQ(instances.size(), 1U);
  EXPECT_EQ(instances[0].observations, 10);
  // The whole map moves: the things move with it, the same as seen from their key-frames.
  const geometry::RigidTransform moved{
      Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vector3d::UnitZ())), {4, -2, 0}};
  for (ObservedKeyframe& keyframe : room.keyframes()) {
    keyframe.world_from_camera = moved * keyframe.world_from_camera;
  }
  const auto after = room.instances();
  ASSERT_EQ(after.size(), 1U);
  EXPECT_LT((room.box_of(after[0]).center() - moved * kChair.center).norm(), 0.08);
}

TEST(FindLevel, FindsTheFloor) {
  TestRoom room;
  room.things = {kBed};
  for (int i = 0; i < 8; ++i) {
    room.look({-1.5, 0.2 * i, 1.4}, {1, 0.3 * i, 0.2});
  }
  const geometry::RigidTransform tilted{
      Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Vector3d(1, 0.2, 0).normalized())), {1, 2, 3}};
  const Vector3d up = tilted.rotation * Vector3d::UnitZ();
  for (ObservedKeyframe& keyframe : room.keyframes()) {
    keyframe.world_from_camera = tilted * keyframe.world_from_camera;
  }
  const GroundPlane level = fit_ground_plane(room.keyframes());
  EXPECT_GT(level.up_world.dot(up), 0.9995);
  EXPECT_NEAR(level.height_m(tilted * Vector3d(0, 0, 0)), 0, 0.04);
  EXPECT_NEAR(level.height_m(tilted * Vector3d(0, 0, 1)), 1, 0.05);
}

TEST(InstanceOptions, NamesTheFieldThatIsWrong) {
  EXPECT_OK(InstanceOptions{}.validate());
  InstanceOptions options;
  options.min_score = 2;
  EXPECT_ERROR(options.validate(), "min_score");
  options = {};
  options.max_range_m = 0;
  EXPECT_ERROR(options.validate(), "max_range_m");
  options = {};
  options.min_observations = 0;
  EXPECT_ERROR(options.validate(), "min_observations");
  options = {};
  options.min_probability = -1;
  EXPECT_ERROR(options.validate(), "min_probability");
}

}  // namespace
}  // namespace roomwise::objects
