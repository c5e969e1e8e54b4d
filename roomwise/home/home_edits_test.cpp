#include "roomwise/home/testing/sample_home.h"

namespace roomwise::home {
namespace {

class HomeEdits : public ::testing::Test {
 protected:
  void SetUp() override { testing::fill(home_); }

  roomwise::testing::ScratchFolder folder_;
  Home home_ = Home::create(folder_ / "a.home").value();
};

TEST_F(HomeEdits, ComeBackAsTheyWere) {
  const auto edits = home_.edits().value();
  ASSERT_EQ(edits.size(), 1U);
  const Edit expected = testing::sample_edit(2);
  const Edit& found = edits[0];
  EXPECT_EQ(found.id, 1);
  EXPECT_EQ(found.made_s, expected.made_s);
  EXPECT_EQ(found.made_by, expected.made_by);
  EXPECT_EQ(found.what, expected.what);
  EXPECT_EQ(found.change, expected.change);
  EXPECT_EQ(found.before, expected.before);
  ASSERT_EQ(found.places.size(), 3U);
  EXPECT_EQ(found.places[0].name, "sofa");
  EXPECT_EQ(found.places[0].keyframe, 2U);
  EXPECT_EQ(found.places[0].picture_box.right, expected.places[0].picture_box.right);
  EXPECT_EQ(found.places[0].box_keyframe.center(), expected.places[0].box_keyframe.center());
  EXPECT_EQ(found.places[0].box_keyframe.size_m, expected.places[0].box_keyframe.size_m);
}

TEST_F(HomeEdits, OneThatIsAddedAndRemovedLeavesTheHomeAsItWasToTheBit) {
  const std::string before = home_.content_digest().value();
  const EditId id = home_.add_edit(testing::sample_edit(1)).value();
  EXPECT_EQ(id, 2);
  EXPECT_NE(home_.content_digest().value(), before);
  ASSERT_OK(home_.remove_edit(id));
  EXPECT_EQ(home_.content_digest().value(), before);
  EXPECT_ERROR(home_.remove_edit(id), "no change 2");
  EXPECT_EQ(home_.add_edit(testing::sample_edit(1)).value(), 3)
      << "who undoes change 2 from an old list undoes nothing else";
}

TEST_F(HomeEdits, OneIsPutInThePlaceOfItself) {
  Edit edit = home_.edits()->front();
  edit.change = "{}";
  edit.places.resize(1);
  ASSERT_OK(home_.replace_edit(edit));
  EXPECT_EQ(home_.edits()->front().change, "{}");
  EXPECT_EQ(home_.edits()->front().places.size(), 1U);
  edit.id = 9;
  EXPECT_ERROR(home_.replace_edit(edit), "no change 9");
}

TEST_F(HomeEdits, StayWithoutAPlaceWhereTheirKeyframesGo) {
  ASSERT_OK(home_.remove_recording(1));
  const auto edits = home_.edits().value();
  ASSERT_EQ(edits.size(), 1U);
  EXPECT_EQ(edits[0].places.at(0).keyframe, std::nullopt);
}

TEST_F(HomeEdits, ThatAreNotFiniteAreRefused) {
  Edit edit = testing::sample_edit(1);
  edit.places[1].box_keyframe.size_m.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_ERROR(home_.add_edit(edit), "place 1 of a change is not finite");
  EXPECT_EQ(home_.edits()->size(), 1U);
}

TEST_F(HomeEdits, AHomeOfBeforeOpensAndHasNone) {
  ASSERT_OK(home_.database().run_script("DROP TABLE edit_places; DROP TABLE edits;"));
  EXPECT_TRUE(home_.edits()->empty());
  { const Home closed = std::move(home_); }
  EXPECT_TRUE(Home::open_read_only(folder_ / "a.home")->edits()->empty());
  Home opened = Home::open(folder_ / "a.home").value();
  EXPECT_OK(opened.add_edit(testing::sample_edit(1)));
}

}  // namespace
}  // namespace roomwise::home
