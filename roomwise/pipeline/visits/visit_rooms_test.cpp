#include "roomwise/pipeline/visits/visit_rooms.h"

#include <gmock/gmock.h>

#include "roomwise/home/testing/sample_home.h"
#include "roomwise/pipeline/rooms/room_learning.h"

namespace roomwise::pipeline {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::SizeIs;

// A home of a hall and a kitchen with six pictures of each of five views, by day. Features lie
// along an axis of their room; other light adds some of a further axis, which is the same in both
// rooms.
class VisitRoomsTest : public ::testing::Test {
 protected:
  static constexpr std::size_t kHall = 0, kKitchen = 1;

  void SetUp() override {
    home_.emplace(home::Home::create(folder_ / "a.home").value());
    ROOMWISE_MUST(home_->add_recording(home::testing::sample_recording()));
    ROOMWISE_MUST(home_->add_network({"net", "c0ffee", {}, 8}));
    for (home::KeyframeId id = 0; id < 60; ++id) {
      home::MapCommit step = home::testing::sample_commit(1, 1, id);
      step.keyframes[0].predictions = {{1, {features(id < 30 ? kHall : kKitchen, 0, id / 6), {}}}};
      step.keyframes[0].observations.clear();
      ROOMWISE_MUST(home_->commit(step));
    }
    ROOMWISE_MUST(
        home_->replace_rooms(std::vector<rooms::Room>{{"hall", "hall"}, {"kitchen", "kitchen"}}));
    ROOMWISE_MUST(home_->replace_room_ranges(1, {{0, 89, "hall", 1}, {90, 179, "kitchen", 1}}));
    ASSERT_OK(learn_rooms_from_keyframes(*home_, {}, {}, {}, run_));
  }

  static std::vector<float> features(std::size_t room, double light, std::uint64_t seed) {
    RandomStream random(seed);
    std::vector<float> features(8, 0.05F);
    features[room] = 4;
    features[2] = static_cast<float>(light);
    for (float& value : features) value += static_cast<float>(0.4 * random.uniform());
    return features;
  }
  [[nodiscard]] rooms::RoomClassifier classifier() const {
    const auto record = home_->room_classifier().value();
    return with_visit_pictures(*home_, *rooms::RoomClassifier::from_bytes(record->classifier))
        .value();
  }
  // What a visit by this light sees, of which picture and place say these rooms.
  static RoomObservation look(std::uint64_t seed, double light,
                              std::optional<std::size_t> by_picture,
                              std::optional<std::size_t> by_place) {
    RoomObservation look{
        fmt::format("picture {} by light {}", seed, light), {by_picture, by_place}, {}};
    if (!look.agreement.is_agreed()) return look;
    look.picture = home::VisitPicture{.keyframe = 0,
                                      .timestamp_ns = static_cast<TimestampNs>(seed),
                                      .picture_digest = look.picture_digest,
                                      .room = *by_place == kHall ? "hall" : "kitchen",
                                      .network_fingerprint = "c0ffee",
                                      .features = features(*by_place, light, seed)};
    return look;
  }
  // Five pictures of each room.
  static std::vector<RoomObservation> visit(double light) {
    std::vector<RoomObservation> looks;
    for (std::uint64_t i = 0; i < 10; ++i) {
      looks.push_back(look(1000 + i, light, i % 2, i % 2));
    }
    return looks;
  }
  Expected<RoomUpdate> refresh(std::span<const RoomObservation> looks,
                               const rooms::VisitLearningOptions& options = {}) const {
    ROOMWISE_TRY(const auto before, home_->visit_pictures());
    return refresh_rooms(classifier(), looks, before, options);
  }
  void take(const RoomUpdate& update) {
    home::HomeChanges changes;
    changes.pictures = update.pictures;
    ASSERT_OK(home_->apply_changes(changes));
  }
  [[nodiscard]] std::vector<home::VisitId> visits_of(const std::string& room) const {
    std::vector<home::VisitId> visits;
    const auto pictures = home_->visit_pictures().value();
    for (const home::VisitPicture& picture : pictures) {
      if (picture.room == room) visits.push_back(picture.visit);
    }
    return visits;
  }

  roomwise::testing::ScratchFolder folder_;
  std::optional<home::Home> home_;
  ThreadPool pool_{2};
  SilentProgress progress_;
  StageClock clock_;
  RunContext run_{pool_, progress_, clock_};
};

TEST_F(VisitRoomsTest, AVisitInOtherLightIsKnownBetterAfterwardsAndDayAsWellAsBefore) {
  const rooms::RoomClassifier before = classifier();
  const auto update = refresh(visit(3));
  ASSERT_OK(update);
  ASSERT_TRUE(update->pictures);
  EXPECT_THAT(update->rooms, SizeIs(2));
  EXPECT_EQ(update->rooms[kHall].agreed, 5U);
  EXPECT_GT(update->rooms[kHall].learned, 0U);
  EXPECT_EQ(update->rooms[kHall].learned + update->rooms[kKitchen].learned,
            update->pictures->size());
  take(*update);
  const rooms::RoomClassifier after = classifier();
  EXPECT_EQ(after.retrieval().calibration, before.retrieval().calibration);
  for (const std::size_t room : {kHall, kKitchen}) {
    const auto night = features(room, 3, 77);
    EXPECT_GT(after.evidence(night)->familiarity, before.evidence(night)->familiarity);
    Eigen::Index best = 0;
    after.evidence(night)->probabilities.maxCoeff(&best);
    EXPECT_EQ(static_cast<std::size_t>(best), room);
    const auto day = features(room, 0, 78);
    EXPECT_GE(after.evidence(day)->familiarity, before.evidence(day)->familiarity - 1e-6);
  }
}

TEST_F(VisitRoomsTest, TheSameWalkOnceMoreChangesNothing) {
  const auto walk = visit(3);
  ASSERT_TRUE(refresh(walk)->pictures);
  take(*refresh(walk));
  const auto again = refresh(walk);
  ASSERT_OK(again);
  EXPECT_TRUE(again->was_learned);
  EXPECT_FALSE(again->pictures);
  // What is lost of it can be learned again; what is left of it counts.
  auto rest = home_->visit_pictures().value();
  const std::size_t all = rest.size();
  ASSERT_GT(all, 1U);
  rest.erase(rest.begin());
  ASSERT_OK(home_->replace_visit_pictures(rest));
  const auto mended = refresh(walk);
  ASSERT_OK(mended);
  ASSERT_TRUE(mended->pictures);
  EXPECT_THAT(*mended->pictures, SizeIs(all));
  // Nor does a walk that shows all as it was learned.
  const auto by_day =
      refresh(std::vector{look(2, 0, kHall, kHall), look(7, 0, kKitchen, kKitchen)});
  ASSERT_OK(by_day);
  EXPECT_FALSE(by_day->was_learned);
  EXPECT_FALSE(by_day->pictures);
}

TEST_F(VisitRoomsTest, NothingThatIsUnsureOrContradictoryIsLearned) {
  const std::vector<RoomObservation> looks{look(1, 3, kHall, kKitchen), look(2, 3, {}, kKitchen),
                                           look(3, 3, kHall, {}), look(4, 3, {}, {})};
  const auto update = refresh(looks);
  ASSERT_OK(update);
  EXPECT_FALSE(update->pictures);
  EXPECT_EQ(update->contradictory, 1U);
  EXPECT_EQ(update->unsure, 3U);
  EXPECT_EQ(update->rooms[kHall].agreed + update->rooms[kKitchen].agreed, 0U);
}

TEST_F(VisitRoomsTest, TheOldestVisitsPicturesGoFirst) {
  const rooms::VisitLearningOptions options{.max_of_visit = 2, .max_of_room = 3};
  for (const double light : {3.0, 9.0, 27.0}) {
    const auto update = refresh(visit(light), options);
    ASSERT_OK(update);
    ASSERT_EQ(update->rooms[kHall].learned, 2U) << light;
    EXPECT_EQ(update->rooms[kHall].outdated, light < 5 ? 0U : light < 10 ? 1U : 2U);
    take(*update);
  }
  EXPECT_EQ(visits_of("hall"), (std::vector<home::VisitId>{2, 3, 3}));
  EXPECT_EQ(visits_of("kitchen"), (std::vector<home::VisitId>{2, 3, 3}));
  // The pictures that the rooms were learned from are all still there.
  EXPECT_EQ(classifier().retrieval().gallery.projections().rows(), 60 + 6);
}

TEST_F(VisitRoomsTest, WhatAnotherNetworkSawIsNeitherComparedNorForgotten) {
  auto other = *look(1, 3, kHall, kHall).picture;
  other.network_fingerprint = "0ther";
  other.features = {1, 2};
  other.visit = 0;
  other.picture_digest = visit(3).front().picture_digest;  // of the walk that comes again
  home::HomeChanges changes;
  changes.pictures = std::vector{other};
  ASSERT_OK(home_->apply_changes(changes));
  EXPECT_EQ(classifier().retrieval().gallery.projections().rows(), 60);
  const auto update = refresh(visit(3), {.max_of_visit = 1, .max_of_room = 1});
  ASSERT_OK(update);
  ASSERT_TRUE(update->pictures);
  EXPECT_EQ(update->pictures->front().network_fingerprint, "0ther");
  EXPECT_THAT(*update->pictures, SizeIs(3));
}

TEST_F(VisitRoomsTest, LearningAnewKeepsWhatStillAgreesAndForgetsTheRest) {
  const auto record = home_->room_classifier().value();
  const auto by_the_helper = *rooms::RoomClassifier::from_bytes(record->classifier);
  auto walk = visit(0.3);
  walk.push_back(look(1, 30, kHall, kHall));  // a light in which nothing is seen
  take(*refresh(walk));
  const auto learned = home_->visit_pictures().value();
  std::vector<home::VisitPicture> named;
  for (const home::VisitPicture& picture : learned) {
    const auto evidence = *by_the_helper.evidence(picture.features);
    if (evidence.familiarity >= 0) named.push_back(picture);
  }
  ASSERT_FALSE(named.empty());
  ASSERT_LT(named.size(), learned.size());
  auto report = learn_rooms_from_keyframes(*home_, {}, {}, {}, run_);
  ASSERT_OK(report);
  EXPECT_EQ(*home_->visit_pictures(), named);
  EXPECT_THAT(report->warnings,
              Contains(HasSubstr("pictures of later visits do not look like these rooms")));
  // The helper finds that both rooms have each other's name.
  ASSERT_OK(home_->replace_room_ranges(1, {{0, 89, "kitchen", 1}, {90, 179, "hall", 1}}));
  report = learn_rooms_from_keyframes(*home_, {}, {}, {}, run_);
  ASSERT_OK(report);
  EXPECT_THAT(*home_->visit_pictures(), SizeIs(0));
  EXPECT_THAT(report->warnings,
              Contains(HasSubstr(fmt::format("{} pictures of later visits", named.size()))));
}

TEST_F(VisitRoomsTest, PicturesAreJoinedAlongTheWalkAndPlacesAreNot) {
  const std::vector<std::string> names{"hall", "kitchen"};
  const auto seen = [&](double hall, double hall_by_place, TimestampNs timestamp_ns) {
    SeenPicture one;
    one.picture.timestamp_ns = timestamp_ns;
    one.evidence = {Eigen::Vector2d(hall, 1 - hall), 8};
    one.place = {Eigen::Vector2d(hall_by_place, 1 - hall_by_place), 5, ""};
    return one;
  };
  constexpr TimestampNs kSecond_ns = 1'000'000'000;
  // One picture alone would be too unsure; after a walk of sure ones it is the hall.
  const std::vector<SeenPicture> walk{
      seen(0.999, 0.99, 0),
      seen(0.999, 0.99, kSecond_ns),
      seen(0.6, 0.99, 2 * kSecond_ns),
      seen(0.999, 0.5, 3 * kSecond_ns),   // near a door
      seen(0.999, 0.01, 4 * kSecond_ns),  // its place is in the kitchen
      seen(0.4, 0.99,
           5 * kSecond_ns)};  // it looks like the kitchen, though the walk was in the hall
  const auto looks = observations_along_walk(
      rooms::RoomStream(rooms::RoomTopology(names), rooms::RoomModel{}), names, walk, {});
  ASSERT_EQ(looks.size(), walk.size());
  EXPECT_TRUE(looks[1].agreement.is_agreed());
  ASSERT_TRUE(looks[2].agreement.is_agreed());
  EXPECT_EQ(looks[2].picture->room, "hall");
  EXPECT_EQ(looks[2].picture->timestamp_ns, 2 * kSecond_ns);
  EXPECT_FALSE(looks[3].picture);
  EXPECT_TRUE(looks[4].agreement.is_contradictory());
  EXPECT_FALSE(looks[4].picture);
  EXPECT_FALSE(looks[5].picture);
}

TEST_F(VisitRoomsTest, SaysWhyRoomsCannotBeRefreshed) {
  EXPECT_EQ(*why_rooms_cannot_be_refreshed(*home_), "");
  ASSERT_OK(home_->forget_learned_rooms());
  EXPECT_THAT(*why_rooms_cannot_be_refreshed(*home_), HasSubstr("no rooms were learned"));
}

}  // namespace
}  // namespace roomwise::pipeline
