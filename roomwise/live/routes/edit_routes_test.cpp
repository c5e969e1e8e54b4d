#include "roomwise/live/routes/edit_routes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <thread>

#include "roomwise/base/testing/testing.h"
#include "roomwise/fusion/testing/test_scenes.h"
#include "roomwise/image/codec.h"
#include "roomwise/live/routes/home_routes.h"
#include "roomwise/pipeline/rooms/room_learning.h"
#include "roomwise/pipeline/rooms/room_outline.h"
#include "roomwise/pipeline/stored/map_settings.h"

namespace roomwise::live {
namespace {

using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// A home of an empty room of 3 m by 4 m, walked round, one half of which was named kitchen and the
// other bedroom; in it a cup that programs found. The helper's requests are made as the page does.
class EditRoutes : public ::testing::Test {
 protected:
  static constexpr std::size_t kKeyframes = 24;

  void SetUp() override {
    {
      home::Home home = pipeline::create_home(file_).value();
      const geometry::PinholeCamera camera = fusion::testing::small_camera();
      const auto walk = home.add_recording({"walk", "", camera, kKeyframes}).value();
      home::MapCommit step;
      step.recording = walk;
      step.next_frame_index = kKeyframes;
      for (std::size_t i = 0; i < kKeyframes; ++i) {
        const auto pose = truth_from_camera(i);
        const auto picture = fusion::testing::render(room(), pose, camera);
        const auto time_ns = static_cast<TimestampNs>((i + 1) * 1'000'000'000);
        step.keyframes.push_back(
            {{i, i, time_ns},
             {truth_from_camera(0).inverse() * pose, 0},
             {image::encode_png(picture.color), image::encode_png(picture.depth)},
             {},
             {}});
        step.frames.push_back({i, time_ns, home::FramePlace{i, {}}, ""});
      }
      ASSERT_OK(pipeline::store_map_settings(home, {}));
      ASSERT_OK(home.commit(step));
      ASSERT_OK(home.finish_recording(walk));
      const auto labels = recording::RoomLabels::from_ranges(
          {{0, 11, "kitchen", 1}, {12, kKeyframes - 1, "bedroom", 1}});
      ASSERT_OK(pipeline::name_rooms(home, walk, labels.value()));
      objects::Instance cup;
      cup.name = "cup";
      cup.probability = 0.6;
      cup.names = {{"cup", 1.0}};
      cup.keyframe_id = 3;
      cup.picture_box = {1, 2, 30, 40};
      cup.box_keyframe = {{Eigen::Quaterniond::Identity(), Eigen::Vector3d(0, 0, 1)},
                          {0.1, 0.1, 0.1}};
      ASSERT_OK(home.replace_instances(std::span(&cup, 1)));
    }
    open();
  }
  void open() {
    live_.reset();
    live_ = LiveHome::open(file_, networks_, finders_, {}).value();
    live_->jobs().wait();
    ASSERT_TRUE(live_->view()->map) << live_->jobs().state()->text;
    router_.emplace(home_routes(*live_));
  }

  static fusion::testing::Scene room() {
    using Eigen::Vector3d;
    return {fusion::testing::half_space(Vector3d::UnitZ(), 0),
            fusion::testing::half_space(Vector3d::UnitX(), 0),
            fusion::testing::half_space(-Vector3d::UnitX(), -3),
            fusion::testing::half_space(Vector3d::UnitY(), 0),
            fusion::testing::half_space(-Vector3d::UnitY(), -4)};
  }
  // Round the middle of the room, looking outwards and down a little.
  static geometry::RigidTransform truth_from_camera(std::size_t i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / kKeyframes;
    const Eigen::Vector3d out(std::cos(angle), std::sin(angle), 0);
    const Eigen::Vector3d from = Eigen::Vector3d(1.5, 2, 1.4) + 0.6 * out;
    return fusion::testing::looking_at(from, from + out + Eigen::Vector3d(0, 0, -0.6));
  }

  struct Answer {
    int status = 0;
    json body;
  };
  Answer ask(const std::string& method, const std::string& path, const json& body = {},
             const std::string& by = "Anna's phone") {
    service::HttpRequest request;
    request.method = method;
    request.path = path;
    const std::string text = body.is_null() ? "" : body.dump();
    request.body.assign(text.begin(), text.end());
    request.headers["content-type"] = "application/json";
    request.who = service::Identity{1, by, service::Role::kHelper};
    const auto answer = router_->answer(request);
    return {answer.status, json::parse(answer.body, nullptr, false)};
  }
  json edits() { return ask("GET", "/api/edits").body.at("edits"); }
  json things() { return ask("GET", "/api/home").body.at("things"); }
  json thing(const std::string& name) {
    for (const json& one : things()) {
      if (one.at("name") == name) return one;
    }
    return nullptr;
  }
  json cup() { return thing("cup").at("id"); }
  std::vector<std::string> rooms() {
    std::vector<std::string> names;
    const json home = ask("GET", "/api/home").body;
    for (const json& one : home.at("rooms")) names.push_back(one.at("name"));
    return names;
  }

  roomwise::testing::ScratchFolder folder_;
  std::filesystem::path file_ = folder_ / "flat.home";
  pipeline::Networks networks_;
  objects::ObjectFinders finders_;
  std::unique_ptr<LiveHome> live_;
  std::optional<service::Router> router_;
};

TEST_F(EditRoutes, ThePlanHasRoomsAsPolygonsAndTheDoorsBetween) {
  const json plan = ask("GET", "/api/map/plan").body;
  ASSERT_THAT(plan.at("rooms"), SizeIs(2));
  EXPECT_EQ(plan.at("rooms")[0].at("name"), "bedroom");
  EXPECT_GE(plan.at("rooms")[0].at("polygons").at(0).at(0).size(), 4U);
  ASSERT_FALSE(plan.at("doors").empty());
  EXPECT_EQ(plan.at("doors")[0].at("rooms"), json({"bedroom", "kitchen"}));
  EXPECT_TRUE(plan.at("doors")[0].at("door").is_boolean());
  EXPECT_EQ(std::remainder(plan.at("right_degrees").get<double>(), 1), 0) << "whole degrees";
  const auto map = live_->view()->map;
  EXPECT_EQ(map->right_rad,
            pipeline::drawing_direction_rad(map->floor.value(), map->frame.storeys));
}

TEST_F(EditRoutes, WhatTheWalksHaveNotShownIsToldOfEachRoom) {
  const json coverage = ask("GET", "/api/coverage").body;
  EXPECT_TRUE(coverage.at("floor_known"));
  ASSERT_THAT(coverage.at("rooms"), SizeIs(2));
  EXPECT_EQ(coverage.at("rooms")[1],
            json({{"room", "kitchen"},
                  {"pictures", 12},
                  {"walks", {{{"walk", 1}, {"pictures", 12}, {"time", nullptr}}}}}));
  const auto told = [&](const std::string& what, const json& room) {
    json found;
    for (const json& one : coverage.at("missing")) {
      if (one.at("what") == what && one.at("room") == room) found = one;
    }
    return found;
  };
  EXPECT_EQ(told("second walk", "kitchen").at("walk"), 1);
  EXPECT_EQ(told("more pictures", "bedroom").at("pictures"), 12);
  EXPECT_GT(told("more pictures", "bedroom").at("wanted"), 12);
}

TEST_F(EditRoutes, WhatIsMissingIsToldAnewWhenARoomGotAnotherName) {
  EXPECT_EQ(ask("GET", "/api/coverage").body.at("rooms")[0].at("room"), "bedroom");
  ASSERT_EQ(ask("PUT", "/api/rooms/bedroom", {{"name", "attic"}}).status, 200);
  EXPECT_EQ(ask("GET", "/api/coverage").body.at("rooms")[0].at("room"), "attic");
  ASSERT_OK(live_->forget_home());
  EXPECT_THAT(ask("GET", "/api/coverage").body.at("rooms"), IsEmpty());
}

TEST_F(EditRoutes, AThingIsRenamedNotedAndBothAreUndone) {
  EXPECT_EQ(ask("PUT", "/api/things/" + cup().dump(), {{"name", "mug"}}).status, 200);
  const json mug = thing("mug");
  EXPECT_TRUE(mug.at("by_hand"));
  EXPECT_EQ(ask("POST", "/api/edits", {{"what", "note"}, {"thing", mug.at("id")}, {"note", "hot"}},
                "Ben's phone")
                .body,
            json({{"edit", 2}}));
  EXPECT_EQ(thing("mug").at("note"), "hot");
  const json all = edits();
  ASSERT_THAT(all, SizeIs(2));
  EXPECT_EQ(all[0].at("what"), "note") << "the newest first";
  EXPECT_EQ(all[0].at("by"), "Ben's phone");
  EXPECT_EQ(all[1].at("old_name"), "cup");
  EXPECT_EQ(all[1].at("name"), "mug");
  EXPECT_THAT(all[1].at("undo_first").get<std::string>(), HasSubstr("undo that first"));
  const Answer early = ask("DELETE", "/api/edits/1");
  EXPECT_EQ(early.status, 409);
  EXPECT_THAT(early.body.at("error").get<std::string>(), HasSubstr("undo that first"));
  EXPECT_EQ(ask("DELETE", "/api/edits/2").status, 200);
  EXPECT_EQ(ask("DELETE", "/api/edits/1").status, 200);
  EXPECT_FALSE(thing("cup").is_null());
  EXPECT_THAT(edits(), IsEmpty());
}

TEST_F(EditRoutes, ChangesOutliveAComputerThatIsStopped) {
  ASSERT_EQ(ask("PUT", "/api/things/" + cup().dump(), {{"name", "mug"}}).status, 200);
  ASSERT_EQ(ask("POST", "/api/edits",
                {{"what", "add thing"}, {"name", "kettle"}, {"room", "kitchen"}, {"note", "hot"}})
                .status,
            200);
  open();
  EXPECT_FALSE(thing("mug").is_null());
  const json kettle = thing("kettle");
  EXPECT_TRUE(kettle.at("added"));
  EXPECT_EQ(kettle.at("room"), "kitchen");
  EXPECT_EQ(kettle.at("probability"), 1.0);
  EXPECT_EQ(ask("DELETE", "/api/edits/1").status, 200) << "undone on another day";
  EXPECT_FALSE(thing("cup").is_null());
}

TEST_F(EditRoutes, AThingGoesToAnotherRoomOrPlace) {
  ASSERT_EQ(thing("cup").at("room"), "kitchen");
  ASSERT_EQ(
      ask("POST", "/api/edits", {{"what", "move thing"}, {"thing", cup()}, {"room", "bedroom"}})
          .status,
      200);
  EXPECT_EQ(thing("cup").at("room"), "bedroom");
  const json at = thing("cup").at("position");
  ASSERT_EQ(ask("POST", "/api/edits",
                {{"what", "move thing"},
                 {"thing", cup()},
                 {"position", {at[0].get<double>() + 0.1, at[1]}},
                 {"height", 0.5}})
                .status,
            200);
  EXPECT_NEAR(thing("cup").at("position")[0].get<double>(), at[0].get<double>() + 0.1, 1e-9);
  EXPECT_NEAR(thing("cup").at("position")[2].get<double>(), 0.5, 1e-9);
}

TEST_F(EditRoutes, DoublesAreMergedAndWhatIsNotThereIsRemoved) {
  ASSERT_EQ(ask("POST", "/api/edits", {{"what", "add thing"}, {"name", "mug"}, {"room", "kitchen"}})
                .status,
            200);
  ASSERT_EQ(ask("POST", "/api/edits",
                {{"what", "merge things"}, {"thing", cup()}, {"double", thing("mug").at("id")}})
                .status,
            200);
  EXPECT_THAT(things(), SizeIs(1));
  ASSERT_EQ(ask("DELETE", "/api/things/" + cup().dump()).status, 200);
  EXPECT_THAT(things(), IsEmpty());
  ASSERT_EQ(ask("DELETE", "/api/edits/3").status, 200);
  EXPECT_THAT(things(), SizeIs(1));
}

TEST_F(EditRoutes, RoomsAreDividedJoinedDrawnAndTheirBorderMoves) {
  const json middle = ask("GET", "/api/home").body.at("rooms")[0].at("middle");
  const double x = middle[0], y = middle[1];
  const json across{{x - 5, y}, {x + 5, y}};
  EXPECT_EQ(
      ask("POST", "/api/edits",
          {{"what", "divide room"}, {"room", "bedroom"}, {"other_room", "study"}, {"line", across}})
          .status,
      200);
  EXPECT_THAT(rooms(), ElementsAre("bedroom", "kitchen", "study"));
  const json higher{{x - 5, y + 0.2}, {x + 5, y + 0.2}};
  EXPECT_EQ(
      ask("POST", "/api/edits",
          {{"what", "move border"}, {"room", "study"}, {"other_room", "bedroom"}, {"line", higher}})
          .status,
      200);
  EXPECT_EQ(ask("POST", "/api/edits",
                {{"what", "join rooms"}, {"room", "bedroom"}, {"other_room", "study"}})
                .status,
            200);
  EXPECT_THAT(rooms(), ElementsAre("bedroom", "kitchen"));
  const json outline{{x - 0.2, y - 0.2}, {x + 0.2, y - 0.2}, {x + 0.2, y + 0.2}};
  EXPECT_EQ(
      ask("POST", "/api/edits", {{"what", "draw room"}, {"room", "niche"}, {"outline", outline}})
          .status,
      200);
  EXPECT_THAT(rooms(), ElementsAre("bedroom", "kitchen", "niche"));
  EXPECT_EQ(ask("POST", "/api/edits",
                {{"what", "add door"},
                 {"room", "niche"},
                 {"other_room", "kitchen"},
                 {"position", {x, y}}})
                .status,
            200);
  for (int i = 5; i > 0; --i) {
    EXPECT_EQ(ask("DELETE", fmt::format("/api/edits/{}", i)).status, 200) << i;
  }
  EXPECT_THAT(rooms(), ElementsAre("bedroom", "kitchen"));
}

TEST_F(EditRoutes, ARoomThatPhotosShowIsNotJoinedSinceLearningWouldBringItBack) {
  const Bytes photo = image::encode_jpeg(image::ColorImage(200, 200), 90);
  ASSERT_OK(live_->photos().add("bedroom", photo));
  const json join{{"what", "join rooms"}, {"room", "kitchen"}, {"other_room", "bedroom"}};
  const Answer refused = ask("POST", "/api/edits", join);
  EXPECT_EQ(refused.status, 409);
  EXPECT_THAT(refused.body.at("error").get<std::string>(), HasSubstr("take its photos away first"));
  EXPECT_THAT(rooms(), ElementsAre("bedroom", "kitchen"));
  ASSERT_OK(live_->photos().remove("bedroom"));
  EXPECT_EQ(ask("POST", "/api/edits", join).status, 200);
  EXPECT_THAT(rooms(), ElementsAre("kitchen"));
}

TEST_F(EditRoutes, ARemovedRoomComesBackUntilTheHomeIsClosed) {
  ASSERT_EQ(ask("DELETE", "/api/rooms/bedroom").status, 200);
  EXPECT_THAT(rooms(), ElementsAre("kitchen"));
  ASSERT_EQ(ask("DELETE", "/api/edits/1").status, 200);
  EXPECT_THAT(rooms(), ElementsAre("bedroom", "kitchen"));
  ASSERT_EQ(ask("DELETE", "/api/rooms/bedroom").status, 200);
  open();
  EXPECT_THAT(rooms(), ElementsAre("kitchen"));
  EXPECT_THAT(edits(), IsEmpty());
}

TEST_F(EditRoutes, TwoHelpersAtOnceDoNotOverruleEachOther) {
  const json seen_by_both = cup();
  ASSERT_EQ(ask("DELETE", "/api/things/" + seen_by_both.dump(), {}, "Anna's phone").status, 200);
  const Answer late =
      ask("POST", "/api/edits", {{"what", "note"}, {"thing", seen_by_both}, {"note", "hot"}},
          "Ben's phone");
  EXPECT_EQ(late.status, 409);
  EXPECT_THAT(late.body.at("error").get<std::string>(), HasSubstr("look at it anew"));
  EXPECT_THAT(edits(), SizeIs(1));
}

TEST_F(EditRoutes, HelpersWhoChangeThingsInOneMomentWaitForEachOther) {
  constexpr int kEach = 4;
  std::array<std::vector<int>, 2> statuses;
  {
    std::vector<std::thread> helpers;
    for (std::size_t helper = 0; helper < statuses.size(); ++helper) {
      helpers.emplace_back([&, helper] {
        for (int i = 0; i < kEach; ++i) {
          statuses[helper].push_back(
              ask("POST", "/api/edits",
                  {{"what", "add thing"}, {"name", "kettle"}, {"room", "kitchen"}})
                  .status);
        }
      });
    }
    for (std::thread& helper : helpers) helper.join();
  }
  for (const auto& of_helper : statuses) EXPECT_THAT(of_helper, ::testing::Each(200));
  EXPECT_THAT(edits(), SizeIs(2 * kEach));
}

TEST_F(EditRoutes, AQuestionIsTriedFromAPlaceOfTheMap) {
  const Answer asked =
      ask("POST", "/api/ask",
          {{"text", "where is the cup"}, {"place", {1.5, 2}}, {"heading_degrees", 0}});
  EXPECT_EQ(asked.status, 200);
  EXPECT_THAT(asked.body.at("said").at(0).get<std::string>(), HasSubstr("cup"));
  EXPECT_THAT(asked.body.at("way"), IsEmpty());
  EXPECT_EQ(ask("POST", "/api/ask", {{"text", 7}}).status, 400);
  EXPECT_EQ(ask("POST", "/api/ask", {{"text", "hm"}, {"place", {1}}}).status, 400);
  EXPECT_EQ(ask("POST", "/api/ask", {{"text", "hm"}, {"distances", "feet"}}).status, 400);
  EXPECT_THAT(edits(), IsEmpty());
}

TEST_F(EditRoutes, AWalkIsTakenAwayBroughtBackAndErased) {
  const json take{{"what", "take walk away"}, {"walk", 1}};
  const json edit = ask("POST", "/api/edits", take).body.at("edit");
  json home = ask("GET", "/api/home").body;
  EXPECT_THAT(home.at("recordings"), IsEmpty());
  EXPECT_EQ(home.at("to_erase").at("walks"),
            json::array({{{"id", 1}, {"name", "walk"}, {"edit", edit}}}));
  EXPECT_THAT(ask("GET", "/api/map/keyframes").body.at("keyframes"), IsEmpty());
  EXPECT_EQ(ask("POST", "/api/edits", take).status, 409);
  EXPECT_EQ(ask("DELETE", "/api/edits/" + edit.dump()).status, 200);
  home = ask("GET", "/api/home").body;
  EXPECT_THAT(home.at("recordings"), SizeIs(1));
  EXPECT_EQ(home.at("recordings")[0].at("recorded"), nullptr) << "its stamps tell no date";
  ASSERT_EQ(ask("POST", "/api/edits", take).status, 200);
  EXPECT_EQ(ask("POST", "/api/erase").status, 200);
  home = ask("GET", "/api/home").body;
  EXPECT_EQ(home.at("to_erase"),
            json({{"walks", json::array()}, {"rooms", json::array()}, {"owed", false}}));
  EXPECT_THAT(live_->view()->walks, IsEmpty());
}

TEST_F(EditRoutes, BadInputIsToldAndChangesNothing) {
  const auto refused = [&](const json& body, int status, const std::string& why) {
    const Answer answer = ask("POST", "/api/edits", body);
    EXPECT_EQ(answer.status, status) << body;
    EXPECT_THAT(answer.body.at("error").get<std::string>(), HasSubstr(why)) << body;
  };
  refused(json::object(), 400, "'what' is missing");
  refused({{"what", "paint"}}, 409, "'paint' is none");
  refused({{"what", "note"}, {"thing", 99}, {"note", "hot"}}, 409, "no thing 99");
  refused({{"what", "note"}, {"thing", cup()}, {"note", std::string(201, 'x')}}, 409,
          "at most 200");
  refused({{"what", "rename thing"}, {"thing", cup()}, {"name", std::string(61, 'x')}}, 409,
          "at most 60");
  refused({{"what", "add thing"}, {"name", "kettle"}}, 409, "needs a place");
  refused({{"what", "add thing"}, {"name", "kettle"}, {"room", "attic"}}, 409, "no room 'attic'");
  refused({{"what", "add thing"}, {"name", "kettle"}, {"position", {1, "x"}}}, 409, "'position'");
  refused({{"what", "divide room"},
           {"room", "bedroom"},
           {"other_room", "study"},
           {"line", {{90, 90}, {91, 90}}}},
          409, "divides nothing");
  refused({{"what", "divide room"}, {"room", "bedroom"}, {"other_room", "study"}, {"line", {1, 2}}},
          409, "list of points");
  refused({{"what", "draw room"}, {"room", "niche"}, {"outline", {{0, 0}, {1e9, 0}, {1, 1}}}}, 409,
          "list of points");
  EXPECT_EQ(ask("DELETE", "/api/edits/7").status, 409);
  EXPECT_EQ(ask("DELETE", "/api/edits/seven").status, 404);
  EXPECT_THAT(edits(), IsEmpty());
}

}  // namespace
}  // namespace roomwise::live
