#include "roomwise/evaluation/drawing/map_drawing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <vector>

#include "roomwise/evaluation/testing/test_markup.h"

namespace roomwise::evaluation {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// 10 m x 6 m at 100 px a metre, world x to the right and y up.
TopView plain_view() {
  TopView view;
  view.picture = image::ColorImage(1000, 600, {200, 200, 200});
  view.pixels_per_metre = 100;
  view.pixel_from_world_linear << 100, 0, 0, 0, -100, 0;
  view.pixel_from_world_offset = {0, 600};
  return view;
}

const std::vector<MapKeyFrame> kWalk = {{{1, 1, 0}, "hall"},    {{2, 1, 0}, "hall"},
                                        {{3, 1, 0}, "kitchen"}, {{4, 1, 0}, "kitchen"},
                                        {{5, 1, 0}, ""},        {{6, 1, 0}, "hall"}};

TEST(MapDrawing, DrawsEachStretchInTheStyleOfItsRoom) {
  const std::string svg = draw_map(plain_view(), kWalk, {}).element();
  // Each stretch runs on to the first key-frame of the next room.
  EXPECT_THAT(svg,
              HasSubstr("points=\"100,500 200,500 300,500\" fill=\"none\" class=\"path room-0\""));
  EXPECT_THAT(svg,
              HasSubstr("points=\"300,500 400,500 500,500\" fill=\"none\" class=\"path room-1\""));
  EXPECT_THAT(svg, HasSubstr("points=\"500,500 600,500\" fill=\"none\" class=\"path room-none\""));
  EXPECT_EQ(count_of(svg, "class=\"key-frame "), kWalk.size() + 3);  // and three in the legend
  // The name on the map and in the legend; the tips of the ruler are 1 m apart.
  EXPECT_EQ(count_of(svg, ">hall<"), 2);
  EXPECT_EQ(count_of(svg, ">kitchen<"), 2);
  EXPECT_EQ(count_of(svg, ">no room named<"), 1);
  EXPECT_THAT(svg, HasSubstr("x1=\"24\" y1=\"626\" x2=\"124\" y2=\"626\" class=\"ruler\""));
}

TEST(MapDrawing, RoomsHaveTheirColoursByNameWhicheverWasEnteredFirst) {
  std::vector<MapKeyFrame> back = kWalk;
  std::ranges::reverse(back);
  back.erase(back.begin());  // it begins in no room, then the kitchen
  EXPECT_THAT(draw_map(plain_view(), back, {}).element(),
              HasSubstr("class=\"path room-1\" stroke-dasharray=\"16 7\""));
}

TEST(MapDrawing, DrawsNoLineFromOneWalkToTheNext) {
  std::vector<MapKeyFrame> walks = kWalk;
  walks.front().begins_walk = walks[2].begins_walk = true;
  const std::string svg = draw_map(plain_view(), walks, {}).element();
  EXPECT_THAT(svg, HasSubstr("points=\"100,500 200,500\" fill=\"none\" class=\"path room-0\""));
  EXPECT_THAT(svg, Not(HasSubstr("200,500 300,500")));
  EXPECT_EQ(count_of(svg, "class=\"casing\""), 2);
}

TEST(MapDrawing, RoomsOfOneColourDifferInTheirDashes) {
  std::vector<MapKeyFrame> walk;
  for (int i = 0; i < 20; ++i) walk.push_back({{0.4 * i, 2, 0}, "room " + std::to_string(i)});
  const std::string svg = draw_map(plain_view(), walk, {}).element();
  std::set<std::string> styles;
  for (std::size_t i = svg.find("class=\"path"); i != std::string::npos;
       i = svg.find("class=\"path", i + 1)) {
    styles.insert(svg.substr(i, svg.find("/>", i) - i));
  }
  EXPECT_EQ(styles.size(), 20);
}

TEST(MapDrawing, NumbersObjectsAndNamesThemWhereThereIsRoom) {
  std::vector<MapObject> objects = {{"bed <1>", {5, 3, 1}}, {"lamp", {9.95, 3, 0}}};
  const std::string svg = draw_map(plain_view(), {}, objects).element();
  EXPECT_THAT(svg, HasSubstr("<circle cx=\"500\" cy=\"300\""));
  EXPECT_THAT(svg, HasSubstr(">1</text>"));
  EXPECT_THAT(svg, HasSubstr(">2</text>"));
  EXPECT_THAT(svg, HasSubstr(">bed &lt;1&gt;<"));
  EXPECT_THAT(svg,
              HasSubstr(">lamp<"));  // to the left of its marker: the picture ends at the right

  // Ten objects at one place: all numbered, their names not on top of each other.
  const std::vector<MapObject> crowd(10, {"wardrobe", {5, 3, 0}});
  const std::string crowded = draw_map(plain_view(), {}, crowd).element();
  EXPECT_EQ(count_of(crowded, "class=\"object\""), 10);
  EXPECT_LE(count_of(crowded, ">wardrobe<"), 4);
  EXPECT_GE(count_of(crowded, ">wardrobe<"), 1);
}

TEST(MapDrawing, MarksWhatLiesBeyondThePictureAtItsRim) {
  const std::vector<MapObject> beyond = {{"chair", {5, -0.4, 0}}, {"plant", {12, 7, 0}}};
  const std::string svg = draw_map(plain_view(), {}, beyond).element();
  EXPECT_THAT(svg, HasSubstr("<circle cx=\"500\" cy=\"585\"")) << "not over the legend";
  EXPECT_THAT(svg, HasSubstr("<circle cx=\"985\" cy=\"15\""));
}

TEST(MapDrawing, HoldsItsPicture) {
  const std::string svg = draw_map(plain_view(), kWalk, {}).element();
  EXPECT_THAT(svg, HasSubstr("href=\"data:image/jpeg;base64,"));
  EXPECT_THAT(svg, HasSubstr("Map from above: 6 key-frames, 2 named rooms, objects: 0"));
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
}

}  // namespace
}  // namespace roomwise::evaluation
