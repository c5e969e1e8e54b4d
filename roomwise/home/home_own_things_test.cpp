// Things that people taught, as a home keeps them.

#include <fstream>
#include <string_view>

#include "roomwise/home/schema.h"
#include "roomwise/home/testing/sample_home.h"

namespace roomwise::home {
namespace {

using ::roomwise::testing::ScratchFolder;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::StartsWith;

constexpr PassphraseCost kQuick{.passes = 1, .memory_bytes = 8192};

Bytes text_bytes(std::string_view text) {
  return {text.begin(), text.end()};
}
// Bytes that stand nowhere else in a home.
std::vector<objects::TaughtView> two_views() {
  return {{text_bytes("\xFF\xD8 a picture of the blue mug from before"), text_bytes("mask one")},
          {text_bytes("\xFF\xD8 a picture of the blue mug from aside"), text_bytes("mask two")}};
}
OwnThing mug() {
  return {.name = "my blue mug", .owner = "7", .is_shared = false, .taught_s = 1700};
}

class OwnThings : public ::testing::Test {
 protected:
  [[nodiscard]] bool file_holds(std::string_view text) const {
    std::string all;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
      all += read_text_file(entry.path()).value();
    }
    return all.find(text) != std::string::npos;
  }
  ScratchFolder folder_;
  std::filesystem::path path_ = folder_.path() / "flat.home";
};

TEST_F(OwnThings, ComeBackAsTheyWereTaught) {
  {
    Home home = Home::create(path_).value();
    ROOMWISE_MUST(home.add_own_thing(mug(), two_views()));
  }
  const Home home = Home::open_read_only(path_).value();
  const auto things = home.own_things().value();
  ASSERT_THAT(things, SizeIs(1));
  EXPECT_EQ(things[0].name, "my blue mug");
  EXPECT_EQ(things[0].owner, "7");
  EXPECT_FALSE(things[0].is_shared);
  EXPECT_EQ(things[0].taught_s, 1700);
  EXPECT_FALSE(things[0].last_seen.is_known());
  EXPECT_EQ(home.own_thing_views(things[0].id).value(), two_views());
}

TEST_F(OwnThings, AreKnownWhollyOrNotAtAll) {
  Home home = Home::create(path_).value();
  OwnThing seen = mug();
  seen.last_seen.keyframe = 99;
  EXPECT_FALSE(home.add_own_thing(seen, two_views())) << "there is no such key-frame";
  EXPECT_TRUE(home.own_things().value().empty());
  EXPECT_OK(home.add_own_thing(mug(), two_views()));
}

TEST_F(OwnThings, ArePrivateToTheirOwnerUntilTheyAreShared) {
  Home home = Home::create(path_).value();
  const OwnThingId id = home.add_own_thing(mug(), two_views()).value();
  EXPECT_TRUE(home.own_things().value()[0].is_known_to("7"));
  EXPECT_FALSE(home.own_things().value()[0].is_known_to("8"));
  ASSERT_OK(home.share_own_thing(id, true));
  EXPECT_TRUE(home.own_things().value()[0].is_known_to("8"));
}

TEST_F(OwnThings, KeepWhereTheyWereSeenLast) {
  Home home = Home::create(path_).value();
  ROOMWISE_MUST(home.add_recording(testing::sample_recording()));
  ROOMWISE_MUST(home.add_network(testing::sample_network()));
  ROOMWISE_MUST(home.commit(testing::sample_commit(1, 1, 0)));
  const OwnThingId id = home.add_own_thing(mug(), two_views()).value();
  const OwnThingSighting seen{1800, "kitchen", 0, Eigen::Vector3d(0.5, 0.25, 2)};
  ASSERT_OK(home.put_own_thing_sighting(id, seen));
  EXPECT_EQ(home.own_things().value()[0].last_seen, seen);
  // With the walk goes the place on its map, and not the thing.
  ASSERT_OK(home.remove_recording(1));
  const OwnThingSighting left{1800, "kitchen", std::nullopt, std::nullopt};
  EXPECT_EQ(home.own_things().value()[0].last_seen, left);
}

TEST_F(OwnThings, NamesThatAreAlikeEmptyOrTooLongAreRefused) {
  Home home = Home::create(path_).value();
  ROOMWISE_MUST(home.add_own_thing(mug(), two_views()));
  const auto refusal = [&](const std::string& name) {
    OwnThing other = mug();
    other.name = name;
    const auto added = home.add_own_thing(other, two_views());
    return added ? std::string("taken") : added.error().message;
  };
  EXPECT_THAT(refusal("My Blue Mug"), StartsWith("there is a thing called My Blue Mug already"))
      << "neither as another keeps it, nor where the home lies";
  EXPECT_THAT(refusal("  "), HasSubstr("needs a name"));
  EXPECT_THAT(refusal(std::string(61, 'a')), HasSubstr("61 bytes long; 60 at most"));
  EXPECT_THAT(refusal("two\nlines"), HasSubstr("one line"));
  EXPECT_THAT(refusal("\xFF\xFE"), HasSubstr("UTF-8"));
  EXPECT_EQ(refusal("my red mug"), "taken");
  EXPECT_THAT(home.own_things().value(), SizeIs(2));
}

TEST_F(OwnThings, AreOfADeviceByItsNumberWhateverItsNameWasWhenTheyWereTaught) {
  Home home = Home::create(path_).value();
  OwnThing old = mug();
  old.owner = "7 Anna's phone";  // as earlier programs kept it
  ROOMWISE_MUST(home.add_own_thing(old, two_views()));
  const OwnThing read = home.own_things().value()[0];
  EXPECT_EQ(read.owner, "7");
  EXPECT_TRUE(read.is_known_to("7"));
  EXPECT_FALSE(read.is_known_to("71"));
}

TEST_F(OwnThings, AreForgottenToTheLastByte) {
  Home home = Home::create(path_).value();
  const OwnThingId id = home.add_own_thing(mug(), two_views()).value();
  EXPECT_TRUE(file_holds("blue mug from before"));
  ASSERT_OK(home.remove_own_thing(id));
  ASSERT_OK(home.erase_removed());
  EXPECT_THAT(home.own_things().value(), IsEmpty());
  EXPECT_FALSE(file_holds("blue mug"));
  EXPECT_FALSE(home.own_thing_views(id).value_or(two_views()).size() > 0);
  EXPECT_THAT(home.share_own_thing(id, true).error().message, HasSubstr("it was forgotten"));
}

TEST_F(OwnThings, AreSealedWithTheHomesPictures) {
  const auto secret =
      std::make_shared<const Passphrase>(Passphrase::from("a secret of many words").value());
  {
    Home home = Home::create(path_).value();
    ROOMWISE_MUST(home.add_own_thing(mug(), two_views()));
    EXPECT_EQ(home.protect(*secret, kQuick).value(), 4U);
    // Also what is taught from then on.
    OwnThing cup = mug();
    cup.name = "my red cup";
    ROOMWISE_MUST(home.add_own_thing(cup, two_views()));
    EXPECT_EQ(home.own_thing_views(2).value(), two_views());
  }
  EXPECT_FALSE(file_holds("picture of the blue mug"));
  EXPECT_FALSE(file_holds("mask one"));
  const Home locked = Home::open_read_only(path_).value();
  EXPECT_THAT(locked.own_things().value(), SizeIs(2));  // their names are told
  EXPECT_THAT(locked.own_thing_views(1).error().message, HasSubstr("protected by a passphrase"));
  const Home open = Home::open_read_only(path_, {secret}).value();
  EXPECT_EQ(open.own_thing_views(1).value(), two_views());
}

TEST_F(OwnThings, OfAHomeThatWasMadeBeforeThemAreNone) {
  {
    Home home = Home::create(path_).value();
    ASSERT_OK(home.database().run_script("DROP TABLE own_thing_views; DROP TABLE own_things;"));
  }
  {
    const Home home = Home::open_read_only(path_).value();
    EXPECT_THAT(home.own_things().value(), IsEmpty());
  }
  Home home = Home::open(path_).value();  // gets the tables
  ROOMWISE_MUST(home.add_own_thing(mug(), two_views()));
  EXPECT_THAT(home.own_things().value(), SizeIs(1));
}

}  // namespace
}  // namespace roomwise::home
