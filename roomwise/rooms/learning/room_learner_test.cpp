#include "roomwise/rooms/learning/room_learner.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <limits>

#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::rooms {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

const NetworkIdentity kNetwork{"net", "abc123"};

// `count` pictures of a room whose features lie around one axis.
void add_pictures(std::vector<RoomSample>& samples, const std::string& room, std::size_t axis,
                  int count, double noise, std::uint64_t walk = 0) {
  RandomStream random(samples.size() + 1);
  for (int i = 0; i < count; ++i) {
    RoomSample sample{std::vector<float>(8, 0), room, walk};
    for (float& value : sample.features) value = static_cast<float>(noise * random.normal());
    sample.features[axis] += 1;
    samples.push_back(sample);
  }
}

std::vector<RoomSample> home(double noise) {
  std::vector<RoomSample> samples;
  add_pictures(samples, "kitchen", 0, 40, noise);
  add_pictures(samples, "bath", 1, 25, noise);
  add_pictures(samples, "hall", 2, 25, noise);
  return samples;
}

TEST(LearnRooms, LearnsRoomsThatDiffer) {
  const auto learned = learn_rooms(home(0.1), kNetwork);
  ASSERT_OK(learned);
  EXPECT_EQ(learned->classifier.network(), kNetwork);
  EXPECT_EQ(learned->classifier.rooms(), (std::vector<std::string>{"bath", "hall", "kitchen"}));
  const auto scores = learned->classifier.scores(std::vector<float>{5, 0, 0, 0, 0, 0, 0, 0});
  ASSERT_OK(scores);
  EXPECT_EQ(scores->front().room, "kitchen");
  EXPECT_GT(scores->front().score, 0.9);
  EXPECT_EQ(learned->report.held_out, 90u);
  EXPECT_DOUBLE_EQ(learned->report.held_out_precision(), 1);
  EXPECT_DOUBLE_EQ(learned->report.paper_held_out_precision, 1);
  EXPECT_EQ(learned->report.rooms.front(), (LearningReport::RoomCount{"bath", 25, 25, 25}));
  const auto evidence = learned->classifier.evidence(std::vector<float>{5, 0, 0, 0, 0, 0, 0, 0});
  ASSERT_OK(evidence);
  EXPECT_GT(evidence->probabilities[2], 0.9) << "rooms by name";
  EXPECT_EQ(learned->classifier.retrieval().calibration, learned->report.calibration);
  EXPECT_THAT(learned->report.warnings, IsEmpty());
}

TEST(LearnRooms, HoldsOutWholeWalksWhereARoomWasSeenOnSeveral) {
  // On the second walk the rooms look as the other one did on the first: what is learned on one
  // walk is wrong on the other, and a test within each would not see it.
  std::vector<RoomSample> samples;
  add_pictures(samples, "kitchen", 0, 40, 0.05, 1);
  add_pictures(samples, "bath", 1, 40, 0.05, 1);
  add_pictures(samples, "kitchen", 1, 40, 0.05, 2);
  add_pictures(samples, "bath", 0, 40, 0.05, 2);
  const auto learned = learn_rooms(samples, kNetwork);
  ASSERT_OK(learned);
  EXPECT_EQ(learned->report.held_out, 160U);
  EXPECT_LT(learned->report.held_out_precision(), 0.1);
  EXPECT_LT(learned->report.paper_held_out_precision, 0.1);

  // A room that one walk alone showed is held out block by block.
  add_pictures(samples, "hall", 5, 40, 0.05, 2);
  const auto with_hall = learn_rooms(samples, kNetwork);
  ASSERT_OK(with_hall);
  EXPECT_EQ(with_hall->report.rooms[1], (LearningReport::RoomCount{"hall", 40, 40, 40}));
  // So is one of which a second walk shows too little to learn from.
  add_pictures(samples, "hall", 5, 1, 0.05, 3);
  const auto with_one_more = learn_rooms(samples, kNetwork);
  ASSERT_OK(with_one_more);
  EXPECT_EQ(with_one_more->report.rooms[1], (LearningReport::RoomCount{"hall", 41, 41, 41}));
}

TEST(LearnRooms, TheHeldOutTestIsHonest) {
  // Features that say nothing about the room: the classifier may remember them, but what is held
  // out is right by chance only.
  RandomStream random(3);
  std::vector<RoomSample> samples;
  for (int i = 0; i < 100; ++i) {
    RoomSample sample{std::vector<float>(200, 0), i % 2 == 0 ? "bath" : "hall", 0};
    for (float& value : sample.features) value = static_cast<float>(random.normal());
    samples.push_back(sample);
  }
  const auto learned = learn_rooms(samples, kNetwork);
  ASSERT_OK(learned);
  EXPECT_LT(learned->report.held_out_precision(), 0.7);
  EXPECT_LT(learned->report.paper_held_out_precision, 0.7);
}

TEST(LearnRooms, NeighboursOnAWalkAreHeldOutTogether) {
  // Each place of a walk is seen in four pictures in a row, which are equal; places are random.
  // Were single pictures held out, their twins would give the answer away.
  RandomStream random(5);
  std::vector<RoomSample> samples;
  for (const char* room : {"bath", "hall"}) {
    for (int place = 0; place < 10; ++place) {
      RoomSample sample{std::vector<float>(200, 0), room, 0};
      for (float& value : sample.features) value = static_cast<float>(random.normal());
      samples.insert(samples.end(), 4, sample);
    }
  }
  const auto learned = learn_rooms(samples, kNetwork);
  ASSERT_OK(learned);
  EXPECT_LT(learned->report.held_out_precision(), 0.75);
  EXPECT_LT(learned->report.paper_held_out_precision, 0.75);
}

TEST(LearnRooms, TheStrongestOfEquallyGoodWeightDecaysIsChosen) {
  LearningOptions options;
  options.weight_decays = {1e-4, 1e-2, 1e-3};
  const auto learned = learn_rooms(home(0.1), kNetwork, options);
  ASSERT_OK(learned);
  EXPECT_DOUBLE_EQ(learned->report.weight_decay, 1e-2);
}

TEST(LearnRooms, WarnsOfARoomWithFewPictures) {
  auto samples = home(0.1);
  add_pictures(samples, "attic", 3, 6, 0.1);
  const auto learned = learn_rooms(samples, kNetwork);
  ASSERT_OK(learned);
  ASSERT_EQ(learned->report.warnings.size(), 1u);
  EXPECT_THAT(learned->report.warnings[0], HasSubstr("\"attic\" has only 6 pictures"));
}

TEST(LearnRooms, ARoomSeenOnShortVisitsIsHeldOutEvenly) {
  // One picture a stay: every round still has pictures of the room to learn from.
  std::vector<RoomSample> samples;
  add_pictures(samples, "hall", 0, 20, 0.1);
  for (std::uint64_t stay = 0; stay < 5; ++stay) {
    add_pictures(samples, "bath", 1, 1, 0.1, stay);
  }
  EXPECT_OK(learn_rooms(samples, kNetwork));
}

TEST(LearnRooms, TheOrderOfRoomsDoesNotCount) {
  const auto samples = home(0.3);
  auto other_order = samples;
  std::ranges::stable_sort(other_order, {}, &RoomSample::room);
  const std::vector<float> picture = {0.5F, 0.5F, 0.4F, 0, 0, 0, 0, 0};
  const auto first = learn_rooms(samples, kNetwork)->classifier.scores(picture);
  const auto second = learn_rooms(other_order, kNetwork)->classifier.scores(picture);
  for (std::size_t i = 0; i < first->size(); ++i) {
    EXPECT_EQ((*first)[i].room, (*second)[i].room);
    EXPECT_NEAR((*first)[i].score, (*second)[i].score, 1e-3);
  }
}

TEST(LearnRooms, FewPicturesOfManyFeaturesAreLearnedInTheirOwnSpace) {
  // More features than pictures takes another path than fewer: padding with zeros, which carry
  // nothing, must not change what is learned.
  const auto samples = home(0.3);
  auto padded = samples;
  for (RoomSample& sample : padded) sample.features.resize(300, 0);
  const auto narrow = learn_rooms(samples, kNetwork);
  const auto wide = learn_rooms(padded, kNetwork);
  ASSERT_OK(narrow);
  ASSERT_OK(wide);
  EXPECT_EQ(narrow->report.weight_decay, wide->report.weight_decay);
  EXPECT_EQ(narrow->report.rooms, wide->report.rooms);
  const Eigen::MatrixXf& weights = narrow->classifier.regression().weights();
  EXPECT_TRUE(weights.isApprox(wide->classifier.regression().weights().leftCols(8), 0.01F));
}

TEST(LearnRooms, SameSamplesSameBits) {
  const auto samples = home(0.5);
  EXPECT_EQ(learn_rooms(samples, kNetwork)->classifier.to_bytes(),
            learn_rooms(samples, kNetwork)->classifier.to_bytes());
}

TEST(LearnRooms, RefusesWhatCannotBeLearned) {
  EXPECT_ERROR(learn_rooms({}, kNetwork), "at least two rooms");
  std::vector<RoomSample> samples;
  add_pictures(samples, "hall", 0, 20, 0.1);
  EXPECT_ERROR(learn_rooms(samples, kNetwork), "hall alone");
  add_pictures(samples, "bath", 1, 4, 0.1);
  EXPECT_ERROR(learn_rooms(samples, kNetwork), "room \"bath\" has 4 pictures");
  add_pictures(samples, "bath", 1, 4, 0.1);
  EXPECT_OK(learn_rooms(samples, kNetwork));
  auto shorter = samples;
  shorter[21].features.pop_back();
  EXPECT_ERROR(learn_rooms(shorter, kNetwork), "picture 21 (bath) has 7 features");
  auto infinite = samples;
  infinite[3].features[2] = std::numeric_limits<float>::infinity();
  EXPECT_ERROR(learn_rooms(infinite, kNetwork), "picture 3 (hall)");
  auto nameless = samples;
  nameless[2].room.clear();
  EXPECT_ERROR(learn_rooms(nameless, kNetwork), "picture 2 names no room");
}

TEST(LearningOptions, NamesTheFieldThatIsWrong) {
  EXPECT_OK(LearningOptions{}.validate());
  LearningOptions options;
  options.folds = 1;
  EXPECT_ERROR(options.validate(), "folds");
  options = {};
  options.weight_decays = {};
  EXPECT_ERROR(options.validate(), "weight_decays");
  options = {};
  options.weight_decays = {-1};
  EXPECT_ERROR(options.validate(), "weight_decays");
  options = {};
  options.min_pictures = 3;
  EXPECT_ERROR(options.validate(), "min_pictures");
}

// Variants that give the answer away, of another room's looks: held out with their picture they
// cannot help its test; and they must not be tested themselves.
TEST(LearnRooms, VariantsAreHeldOutWithTheirPicture) {
  RandomStream random(6);
  std::vector<RoomSample> samples;
  for (int i = 0; i < 100; ++i) {
    RoomSample sample{std::vector<float>(200, 0), i % 2 == 0 ? "bath" : "hall"};
    for (float& value : sample.features) value = static_cast<float>(random.normal());
    sample.variants.assign(3, sample.features);
    samples.push_back(sample);
  }
  const auto learned = learn_rooms(samples, kNetwork);
  ASSERT_OK(learned);
  EXPECT_EQ(learned->report.held_out, 100u);
  EXPECT_EQ(learned->report.rooms.front().pictures, 50u);
  EXPECT_LT(learned->report.held_out_precision(), 0.7);
  EXPECT_LT(learned->report.paper_held_out_precision, 0.7);
}

TEST(LearnRooms, VariantsAreLearnedFrom) {
  // By day the rooms differ in axes 0 and 1; in the variants, by night, in axes 4 and 5.
  std::vector<RoomSample> samples;
  add_pictures(samples, "bath", 0, 30, 0.05);
  add_pictures(samples, "hall", 1, 30, 0.05);
  const std::vector<float> night{0, 0, 0, 0, 1, 0, 0, 0};
  std::vector<RoomSample> varied = samples;
  for (RoomSample& sample : varied) {
    sample.variants = {std::vector<float>(8, 0)};
    sample.variants.front()[sample.room == "bath" ? 4 : 5] = 1;
  }
  const auto scores = learn_rooms(varied, kNetwork)->classifier.scores(night);
  EXPECT_EQ(scores->front().room, "bath");
  EXPECT_GT(scores->front().score, 0.9);
  varied[3].variants.front().pop_back();
  EXPECT_ERROR(learn_rooms(varied, kNetwork), "a variant of picture 3 (bath) has 7 features");
}

TEST(LearnRooms, TheNumberOfThreadsChangesNoBit) {
  const auto samples = home(0.5);
  ThreadPool pool(3);
  EXPECT_EQ(learn_rooms(samples, kNetwork, {}, &pool)->classifier.to_bytes(),
            learn_rooms(samples, kNetwork)->classifier.to_bytes());
}

}  // namespace
}  // namespace roomwise::rooms
