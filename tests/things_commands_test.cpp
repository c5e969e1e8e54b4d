// Commands about things and what they tell, with a detector that sees one in the middle of every
// picture.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "made_up_detector.h"
#include "made_up_recording.h"
#include "roomwise/base/file.h"
#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/home/home.h"
#include "roomwise/image/codec.h"
#include "roomwise/network/testing/tiny_network.h"
#include "roomwise/network/testing/word_networks.h"
#include "roomwise/recording/tum_writer.h"
#include "run_program.h"

namespace roomwise {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::ProgramResult;
using testing::ScratchFolder;

// A classifier of two labels that says the first of every place of every picture.
std::string classifier_of_the_first(float logit) {
  testing::TinyGraph graph;
  graph.nodes = {
      testing::layer("AveragePool", {"picture"}, {"map"},
                     {testing::attribute("kernel_shape", std::vector<std::int64_t>{32, 32}),
                      testing::attribute("strides", std::vector<std::int64_t>{32, 32})}),
      testing::node("GlobalAveragePool", "map", "pooled"),
      testing::node("Flatten", "pooled", "means"),
      testing::layer("Gemm", {"means", "weights", "logits"}, {"scores"})};
  graph.constants = {testing::tensor("weights", {3, 2}, std::vector<float>(6, 0.F)),
                     testing::tensor("logits", {2}, std::vector<float>{logit, 0})};
  graph.input = {1, 3, 64, 64};
  graph.outputs = {{"scores", {1, 2}}};
  return testing::onnx(graph);
}

class ThingsCommandsTest : public ::testing::Test {
 protected:
  static constexpr int kFrames = 48;

  static void SetUpTestSuite() {
    folder_ = std::make_unique<ScratchFolder>();
    EXPECT_OK(testing::write_made_up_recording(path("walk"), kFrames));
    EXPECT_OK(testing::write_made_up_recording(path("visit"), kFrames));
    EXPECT_OK(write_noise(path("elsewhere")));
    const std::string networks = path("data/roomwise/networks/");
    EXPECT_OK(testing::write_detector_of_the_middle(networks));
    EXPECT_OK(write_file(path("colors.onnx"), testing::mean_color_network()));
    EXPECT_OK(write_file(path("colors.card.json"), R"({"input": {"width": 6, "height": 4}})"));
    mapped_ = result_of({"map", path("walk"), "--home", path("mapped.home"), "--network",
                         path("colors.onnx"), "--keyframe-translation", "0.02"});
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static std::string path(const std::string& name) { return *folder_ / name; }
  static json result_of(const std::vector<std::string>& arguments) {
    return testing::result_of(arguments, path("data"));
  }
  static ProgramResult run(const std::vector<std::string>& arguments) {
    return testing::run_roomwise(arguments, path("data"));
  }
  static std::string copy_of_home(const std::string& name) {
    std::filesystem::copy_file(path("mapped.home"), path(name));
    return path(name);
  }
  static std::vector<std::string> update(const std::string& home,
                                         std::vector<std::string> more = {}) {
    more.insert(more.begin(), {"update", "--home", home, "--network", path("colors.onnx")});
    return more;
  }
  static std::string digest_of(const std::string& home) {
    return result_of({"info", "--digest", home}).at("content_sha256");
  }
  // Pictures of nothing, at any distance.
  static Expected<void> write_noise(const std::filesystem::path& folder) {
    geometry::PinholeCamera camera = *geometry::camera_preset("fr1");
    ROOMWISE_TRY(const auto writer, recording::TumWriter::create(folder, camera));
    RandomStream random(1);
    for (std::uint64_t i = 0; i < 4; ++i) {
      image::RgbdFrame frame;
      frame.index = i;
      frame.timestamp_ns = static_cast<TimestampNs>(i + 1) * 100'000'000;
      frame.color = image::ColorImage(camera.width, camera.height);
      frame.depth = image::DepthImage(camera.width, camera.height);
      for (Rgb8& pixel : frame.color.pixels()) {
        pixel = {static_cast<std::uint8_t>(random.index(256)), 100, 50};
      }
      for (std::uint16_t& depth : frame.depth.pixels()) {
        depth = static_cast<std::uint16_t>(5000 + random.index(9000));
      }
      ROOMWISE_RETURN_IF_ERROR(writer->write(frame));
    }
    return writer->close();
  }

  inline static std::unique_ptr<ScratchFolder> folder_;
  inline static json mapped_;
};

TEST_F(ThingsCommandsTest, MapNamesTheNetworksThatLookedAndTheDetectors) {
  EXPECT_EQ(mapped_.at("networks"), json({"colors"}));
  EXPECT_EQ(mapped_.at("detectors"), json({"middle"}));
}

// ---- objects find-word ----

TEST_F(ThingsCommandsTest, AWordThatNoLabelHasIsLookedForInPictures) {
  const std::vector<std::string> look{"objects", "find-word", "red", "--home",
                                      copy_of_home("words.home")};
  EXPECT_THAT(run(look).errors,
              AllOf(HasSubstr("no pair of networks that compares pictures with words is here"),
                    HasSubstr(path("data/roomwise/networks"))));
  const std::string networks = path("words/roomwise/networks");
  std::filesystem::create_directories(networks);
  ASSERT_OK(network::testing::write_word_networks(networks));
  const json looked = testing::result_of(look, path("words"));
  EXPECT_EQ(looked["word"], "red");
  EXPECT_EQ(looked["found"].get<bool>(), looked["false_alarms"].get<double>() <= 0.02);
  EXPECT_GT(looked["places"], 0);
  EXPECT_EQ(looked["places"].get<int>() % 10, 0);
  // By what is kept now.
  EXPECT_EQ(testing::result_of(look, path("words")), looked);
  EXPECT_THAT(testing::run_roomwise(look, path("words")).output,
              HasSubstr(looked["found"].get<bool>()
                            ? "red: found in 45 of 45 pictures; likeliest in key-frame "
                            : "red: not found in 45 of 45 pictures; likeliest in key-frame "));
  EXPECT_EQ(looked["pictures"], 45);
  EXPECT_EQ(looked["pictures_of_home"], 45);
}

// ---- objects find ----

TEST_F(ThingsCommandsTest, AClassifierBesideADetectorLooksCloser) {
  const std::string networks = path("with-closer/roomwise/networks/");
  std::filesystem::create_directories(networks);
  std::filesystem::copy(path("data/roomwise/networks"), networks);
  const auto write_classifier = [&](const std::string& name, const std::string& labels,
                                    float logit) {
    EXPECT_OK(write_file(networks + name + ".onnx", classifier_of_the_first(logit)));
    EXPECT_OK(
        write_file(networks + name + ".card.json",
                   R"({"task": "classify", "input": {"width": 64, "height": 64}, "labels": ")" +
                       name + R"(.txt"})"));
    EXPECT_OK(write_file(networks + name + ".txt", labels));
  };
  const std::string home = copy_of_home("closer.home");
  const std::vector<std::string> find{"objects", "find", "--home", home};
  const auto finders = [&] { return home::Home::open_read_only(home)->region_finders().value(); };
  write_classifier("animals", "zebra\ntabby\n", 6);
  testing::result_of(find, path("with-closer"));
  EXPECT_EQ(finders().size(), 1U) << "it names nothing of a home, and is passed over";
  write_classifier("shelves", "bookcase\nbed\n", 5);
  testing::result_of(find, path("with-closer"));
  ASSERT_EQ(finders().size(), 2U) << "the detector's detections were there";
  EXPECT_EQ(finders().rbegin()->second.name, "region proposals");
  const auto found = home::Home::open_read_only(home);
  ASSERT_OK(found);
  EXPECT_EQ(result_of({"info", home}).at("detectors"), "middle, region proposals");
  EXPECT_EQ(found->detections(finders().rbegin()->first)->size(), found->keyframes()->size());

  const std::string digest = digest_of(home);
  testing::result_of(find, path("with-closer"));
  EXPECT_EQ(digest_of(home), digest) << "all was looked at";
}

// ---- somebody's own kinds ----

TEST(OwnKinds, StandInANewHomesVocabularyAndTheirFaultsAreNamed) {
  const ScratchFolder folder;
  std::filesystem::create_directories(folder / "roomwise");
  const auto write = [&](const std::string& rows) {
    EXPECT_OK(write_file(folder / "roomwise/kinds.json", R"({"kinds": [)" + rows + "]}"));
  };
  const std::vector<std::string> list{"concepts", "list"};
  write(R"({"name": "walking frame", "labels": ["walker"], "moves": true})");
  EXPECT_THAT(testing::result_of(list, folder.path().string()).dump(), HasSubstr("walking frame"));
  write(R"({"name": "walking frame", "moves": "often"})");
  const ProgramResult wrong = testing::run_roomwise(list, folder.path().string());
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_THAT(wrong.errors, AllOf(HasSubstr("kinds.json"), HasSubstr("row 1")));
}

// ---- objects list --past ----

TEST_F(ThingsCommandsTest, WhatStandsThereNoMoreIsListed) {
  const std::string home = copy_of_home("past.home");
  const std::vector<std::string> list{"objects", "list", "--past", "--home", home};
  const json none = result_of(list);
  EXPECT_EQ(none.at("past").size(), 0U);
  EXPECT_EQ(none.at("visits").size(), 0U);
  EXPECT_THAT(run(list).output, HasSubstr("no later walk noticed"));
  {
    auto opened = home::Home::open(home);
    ASSERT_OK(opened);
    const auto things = opened->instances();
    ASSERT_OK(things);
    ASSERT_FALSE(things->empty());
    home::HomeChanges changes;
    changes.visit = {"Sunday", "recordings/sunday", 9'000'000'000, 10'000'000'000, 48, 40};
    changes.kept.assign(things->begin() + 1, things->end());
    changes.past.push_back({.instance = things->front(),
                            .reason = home::PastReason::kMoved,
                            .first_seen_ns = 1'500'000'000,
                            .last_seen_ns = 4'250'000'000});
    ASSERT_OK(opened->apply_changes(changes));
  }
  const json found = result_of(list);
  ASSERT_EQ(found.at("past").size(), 1U);
  const json& past = found.at("past")[0];
  EXPECT_EQ(past.at("name"), "toilet seat") << "the detector's toilet";
  EXPECT_EQ(past.at("became"), "moved");
  EXPECT_EQ(past.at("first_seen_s"), 1.5);
  EXPECT_EQ(past.at("last_seen_s"), 4.25);
  EXPECT_EQ(past.at("position_world_m").size(), 3U);
  ASSERT_EQ(found.at("visits").size(), 1U);
  EXPECT_EQ(found.at("visits")[0].at("visit"), past.at("noticed_by"));
  EXPECT_EQ(found.at("visits")[0].at("name"), "Sunday");
  EXPECT_EQ(found.at("visits")[0].at("placed"), 40);
  const std::string text = run(list).output;
  EXPECT_THAT(text,
              AllOf(HasSubstr("toilet seat"), HasSubstr("moved"),
                    HasSubstr("seen from 1.500000 to 4.250000 s"), HasSubstr("noticed by Sunday")));
  EXPECT_EQ(result_of({"objects", "list", "--home", home}).at("objects").size(),
            mapped_.at("instances").get<std::size_t>() - 1);
  EXPECT_EQ(run({"objects", "list", "--past", "--rule", "paper", "--home", home}).exit_code, 2);
}

// ---- objects history ----

TEST_F(ThingsCommandsTest, WhatBecameOfThingsIsToldWalkByWalk) {
  const std::string home = copy_of_home("history.home");
  const json told = result_of({"objects", "history", "--home", home});
  EXPECT_EQ(told.at("walks").size(), 1U);
  EXPECT_EQ(told.at("changed_by_newest").size(), 0U);
  ASSERT_EQ(told.at("things").size(), mapped_.at("instances").get<std::size_t>());
  const json& thing = told.at("things")[0];
  EXPECT_FALSE(thing.at("gone"));
  EXPECT_EQ(thing.at("walks")[0].at("what"), "found");
  EXPECT_EQ(thing.at("last_seen").at("walk"), told.at("walks")[0]);
  EXPECT_THAT(run({"objects", "history", "--home", home}).output,
              AllOf(HasSubstr("toilet seat"), HasSubstr("found by"),
                    HasSubstr("one walk alone is on the map")));
  const json listed = result_of({"objects", "list", "--home", home}).at("objects")[0];
  EXPECT_EQ(listed.at("last_seen"), thing.at("last_seen"));
  EXPECT_EQ(listed.at("walks"), thing.at("walks"));
  EXPECT_EQ(result_of({"objects", "history", "--home", home, "toilet seat"}).at("things").size(),
            told.at("things").size());
  const ProgramResult none = run({"objects", "history", "--home", home, "dragon"});
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.errors, HasSubstr("no walk showed a thing called dragon"));
}

// ---- optimize ----

TEST_F(ThingsCommandsTest, ThingsAreJoinedAnewWhereOptimizingMovesKeyframes) {
  const std::string home = copy_of_home("moved.home");
  const std::vector<std::string> list{"objects", "list", "--home", home};
  const json before = result_of(list).at("objects");
  ASSERT_GE(before.size(), 1U);
  {
    // The key-frames lie far apart, and so does the thing from where each shows it.
    auto opened = home::Home::open(home);
    ASSERT_OK(opened);
    std::map<home::KeyframeId, home::KeyframePose> poses;
    const std::vector<home::Keyframe> keyframes = opened->keyframes().value();
    for (const home::Keyframe& keyframe : keyframes) {
      poses[keyframe.id] = keyframe.pose;
      poses[keyframe.id].world_from_keyframe.translation.x() += static_cast<double>(keyframe.id);
    }
    ASSERT_OK(opened->replace_poses(poses));
    auto things = opened->instances().value();
    things.resize(1);
    things[0].box_keyframe.world_from_box.translation.z() += 2;
    ASSERT_OK(opened->replace_instances(things));
  }
  const json optimised = result_of({"optimize", "--home", home});
  EXPECT_EQ(optimised.at("instances"), before.size());
  const json after = result_of(list).at("objects");
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < after.size(); ++i) {
    EXPECT_EQ(after[i].at("name"), before[i].at("name"));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(after[i].at("position_world_m")[axis].get<double>(),
                  before[i].at("position_world_m")[axis].get<double>(), 0.05);
    }
  }
}

// ---- concepts, of a home that is protected ----

TEST_F(ThingsCommandsTest, WordsOfAProtectedHomeAreEditedWithItsPassphraseOrNotAtAll) {
  const std::string home = copy_of_home("sealed.home");
  ASSERT_OK(write_file(path("phrase"), std::string_view("open sesame\n")));
  const std::vector<std::string> phrase{"--passphrase-file", path("phrase")};
  const auto with_phrase = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), phrase.begin(), phrase.end());
    return arguments;
  };
  result_of(with_phrase({"protect", home}));
  const auto state = [&] {
    return result_of(with_phrase({"info", "--digest", home})).at("content_sha256");
  };
  const json before = state();
  const std::vector<std::string> add{"concepts", "add",         "--home",      home,
                                     "--object", "toilet seat", "--room-type", "spa"};
  const ProgramResult refused = run(add);
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.errors, HasSubstr("are protected by a passphrase"));
  EXPECT_EQ(state(), before) << "no word without the things that it means";
  const json added = result_of(with_phrase(add));
  EXPECT_TRUE(added.at("room_types").contains("spa"));
  EXPECT_NE(state(), before);
}

// ---- update ----

TEST_F(ThingsCommandsTest, AWalkThatFindsAllAsItWasLeavesTheHomeAsItWas) {
  ASSERT_GE(mapped_.at("instances"), 1);
  const std::string home = copy_of_home("same.home");
  const std::string digest = digest_of(home);
  const json found = result_of(update(home, {path("visit")}));
  EXPECT_EQ(found.at("frames"), kFrames);
  EXPECT_GE(found.at("placed"), kFrames / 2);
  EXPECT_EQ(found.at("changed"), false);
  EXPECT_EQ(found.at("written"), false);
  EXPECT_TRUE(found.at("unnamed").empty()) << found.at("unnamed");
  ASSERT_EQ(found.at("things").size(), mapped_.at("instances"));
  const json& thing = found.at("things")[0];
  EXPECT_TRUE(thing.at("what") == "there" || thing.at("what") == "not looked at") << thing;
  EXPECT_EQ(thing.at("before"), thing.at("now"));
  EXPECT_EQ(digest_of(home), digest);

  const ProgramResult text = run(update(home, {path("visit")}));
  EXPECT_EQ(text.exit_code, 0) << text.errors;
  EXPECT_THAT(text.output, HasSubstr("pictures of the visit were found on the map"));
  EXPECT_THAT(text.output, HasSubstr("nothing changed; the home is as it was"));
}

TEST_F(ThingsCommandsTest, OnlyEveryKthPictureIsLookedAt) {
  const std::string home = copy_of_home("every.home");
  EXPECT_EQ(result_of(update(home, {path("visit"), "--every", "4"})).at("frames"), kFrames / 4);
  EXPECT_EQ(run(update(home, {path("visit"), "--every", "0"})).exit_code, 2);
}

TEST_F(ThingsCommandsTest, ADryRunWritesNothing) {
  const std::string home = copy_of_home("dry.home");
  const Bytes before = read_file(home).value();
  result_of(update(home, {path("visit"), "--dry-run"}));
  EXPECT_TRUE(read_file(home).value() == before);
}

TEST_F(ThingsCommandsTest, SaysWhyRoomsStayAsTheyAre) {
  const std::string home = copy_of_home("rooms.home");
  const json unlearned = result_of(update(home, {path("visit")})).at("rooms");
  EXPECT_THAT(unlearned.at("why_not").get<std::string>(), HasSubstr("no rooms were learned yet"));
  EXPECT_THAT(run(update(home, {path("visit")})).output,
              HasSubstr("the rooms are known as before: no rooms were learned yet"));
  result_of({"rooms", "learn", "--home", home, "--network", path("colors.onnx")});
  const json nowhere = result_of(update(home, {path("visit")})).at("rooms");
  EXPECT_THAT(nowhere.at("why_not").get<std::string>(), HasSubstr("does not show where they lie"))
      << "there is only a wall";
  EXPECT_TRUE(result_of(update(home, {path("visit"), "--without-rooms"})).at("rooms").is_null());
  EXPECT_THAT(run(update(home, {path("visit"), "--without-rooms"})).output,
              Not(HasSubstr("the rooms")));
  const ProgramResult without_network = run({"update", "--home", home, path("visit")});
  EXPECT_EQ(without_network.exit_code, 1);
  EXPECT_THAT(without_network.errors, HasSubstr("learned with the network colors"));
}

TEST_F(ThingsCommandsTest, UpdateSaysWhatIsWrong) {
  const std::string home = copy_of_home("wrong.home");
  const auto errors_of = [](const std::vector<std::string>& arguments) {
    const ProgramResult result = run(arguments);
    EXPECT_EQ(result.exit_code, 1) << result.output;
    return result.errors;
  };
  EXPECT_THAT(errors_of(update(path("no.home"), {path("visit")})), HasSubstr("no such file"));
  EXPECT_FALSE(std::filesystem::exists(path("no.home")));
  EXPECT_THAT(errors_of(update(home, {path("nowhere")})), HasSubstr("nowhere"));
  EXPECT_THAT(errors_of(update(home, {path("elsewhere")})),
              AllOf(HasSubstr("only 0 of 4 frames were found on the map"),
                    HasSubstr("is it the same home?")));
  const ProgramResult no_detector =
      testing::run_roomwise(update(home, {path("visit"), "--without-rooms"}));
  EXPECT_EQ(no_detector.exit_code, 1);
  EXPECT_THAT(no_detector.errors, HasSubstr("no detector is here"));
  EXPECT_EQ(run({"update", path("visit")}).exit_code, 2) << "--home is missing";
}

TEST_F(ThingsCommandsTest, AHomeWithoutAMapCannotBeBroughtUpToDate) {
  for (const std::string room : {"attic", "cellar"}) {
    std::filesystem::create_directories(path("photos/" + room));
    for (int i = 0; i < 6; ++i) {
      const std::string photo = fmt::format("photos/{}/{}.jpg", room, i);
      const auto picture = std::filesystem::directory_iterator(path("walk/rgb"))->path();
      std::filesystem::copy_file(picture, path(photo));
    }
  }
  const std::string home = path("photos.home");
  result_of({"rooms", "learn", "--home", home, "--photos", path("photos"), "--network",
             path("colors.onnx")});
  const ProgramResult result = run(update(home, {path("visit")}));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.errors, HasSubstr("photos.home: has no map"));
}

// ---- rooms types ----

TEST_F(ThingsCommandsTest, TheTypeThatThingsTellIsTakenOnceItIsAccepted) {
  const std::string home = copy_of_home("types.home");
  result_of({"rooms", "name", "--home", home, "--frames", "0-47=small room"});
  const auto type_of = [&](const json& rooms) {
    for (const json& room : rooms) {
      if (room.at("room") == "small room") return room;
    }
    return json();
  };
  const json proposed = type_of(result_of({"rooms", "types", "--home", home}).at("rooms"));
  ASSERT_FALSE(proposed.is_null());
  EXPECT_EQ(proposed.at("type"), "small room");
  EXPECT_EQ(proposed.at("taken"), false);
  EXPECT_EQ(proposed.at("guesses")[0].at("type"), "toilet") << proposed;
  EXPECT_GE(proposed.at("guesses")[0].at("probability"), 0.8);
  const std::vector<std::string> accept{"rooms", "types", "--home", home, "--accept"};
  const ProgramResult taken = run(accept);
  EXPECT_EQ(taken.exit_code, 0) << taken.errors;
  EXPECT_THAT(taken.output, HasSubstr("; taken"));
  const json after = type_of(result_of(accept).at("rooms"));
  EXPECT_EQ(after.at("type"), "toilet");
  EXPECT_EQ(after.at("taken"), false) << "its type is known now";
}

TEST_F(ThingsCommandsTest, RoomTypesSayWhatIsWrong) {
  const ProgramResult result = run({"rooms", "types", "--home", path("no.home"), "--accept"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.errors, HasSubstr("no such file"));
}

// ---- things ----

// A checkered thing in the middle of an even picture.
Expected<void> write_picture_of_thing(const std::string& file, std::uint8_t light) {
  image::ColorImage picture(160, 120, {light, light, light});
  for (int y = 40; y < 80; ++y) {
    for (int x = 60; x < 100; ++x) {
      if ((x / 10 + y / 10) % 2 == 0) picture.at(x, y) = {light, 0, 0};
    }
  }
  return write_file(file, image::encode_png(picture));
}

TEST_F(ThingsCommandsTest, AThingIsTaughtListedSharedAndForgotten) {
  const std::string home = copy_of_home("taught.home");
  std::vector<std::string> teach{"things", "teach",     "my blue mug",       "--home",
                                 home,     "--network", path("colors.onnx"), "--private"};
  for (int i = 0; i < 3; ++i) {
    teach.push_back(path(fmt::format("mug{}.png", i)));
    ASSERT_OK(write_picture_of_thing(teach.back(), static_cast<std::uint8_t>(200 + i)));
  }
  const std::string dark = path("dark.png");
  ASSERT_OK(write_picture_of_thing(dark, 10));
  std::vector<std::string> with_dark = teach;
  with_dark.push_back(dark);
  const json taught = result_of(with_dark);
  EXPECT_EQ(taught.at("thing").at("name"), "my blue mug");
  EXPECT_EQ(taught.at("refused")[0].at("why"), "dark");
  EXPECT_THAT(run(teach).errors, HasSubstr("there is a thing called my blue mug already"));
  const json things = result_of({"things", "list", "--home", home}).at("things");
  ASSERT_EQ(things.size(), 1U);
  EXPECT_EQ(things[0].at("shared"), false);
  EXPECT_EQ(result_of({"things", "share", "my blue mug", "--home", home}).at("shared"), true);
  EXPECT_EQ(result_of({"things", "forget", "my blue mug", "--home", home}).at("forgotten"),
            "my blue mug");
  EXPECT_TRUE(result_of({"things", "list", "--home", home}).at("things").empty());
  EXPECT_THAT(read_text_file(home).value(), Not(HasSubstr("my blue mug")));
}

// A red thing of large patches, at a place of a picture: the walls are grey and finely patterned.
void draw_red_thing(image::ColorImage& picture, int left, int top) {
  RandomStream random(7);
  constexpr int kPatch = 20, kPatches = 4;
  for (int row = 0; row < kPatches; ++row) {
    for (int column = 0; column < kPatches; ++column) {
      const auto red = static_cast<std::uint8_t>(90 + random.index(166));
      for (int y = 0; y < kPatch; ++y) {
        for (int x = 0; x < kPatch; ++x) {
          picture.at(left + column * kPatch + x, top + row * kPatch + y) = {red, 0, 20};
        }
      }
    }
  }
}

TEST_F(ThingsCommandsTest, ALaterWalkShowsWhereTaughtThingsAre) {
  const std::string home = copy_of_home("shown.home");
  std::vector<std::string> teach{"things", "teach",     "my quilt",         "--home",
                                 home,     "--network", path("colors.onnx")};
  for (int i = 0; i < 3; ++i) {
    image::ColorImage picture(160, 120, {200, 200, 200});
    draw_red_thing(picture, 40 + 4 * i, 20);
    teach.push_back(path(fmt::format("quilt{}.png", i)));
    ASSERT_OK(write_file(teach.back(), image::encode_png(picture)));
  }
  result_of(teach);
  const json without = result_of(update(home, {path("visit")})).at("own_things");
  EXPECT_EQ(without, json({{"taught", 1}, {"seen", 0}, {"why_not", nullptr}}));

  std::filesystem::copy(path("visit"), path("with_quilt"),
                        std::filesystem::copy_options::recursive);
  for (const auto& entry : std::filesystem::directory_iterator(path("with_quilt/rgb"))) {
    auto picture = image::decode_color(read_file(entry.path()).value()).value();
    draw_red_thing(picture, picture.width() / 2, picture.height() / 2);
    ASSERT_OK(write_file(entry.path(), image::encode_png(picture)));
  }
  const Bytes before = read_file(home).value();
  const json dry = result_of(update(home, {path("with_quilt"), "--dry-run"}));
  EXPECT_EQ(dry.at("own_things").at("seen"), 1);
  EXPECT_TRUE(read_file(home).value() == before);
  const ProgramResult text = run(update(home, {path("with_quilt"), "--without-rooms"}));
  EXPECT_THAT(text.output, HasSubstr("1 of 1 things that were taught are on it"));
  const json thing = result_of({"things", "list", "--home", home}).at("things")[0];
  EXPECT_FALSE(thing.at("keyframe").is_null()) << thing;

  {
    home::Home later = home::Home::open(home).value();
    const home::OwnThing quilt = later.own_things()->at(0);
    ASSERT_OK(later.put_own_thing_sighting(quilt.id, {4'000'000'000, "attic", {}, {}}));
  }
  const json again = result_of(update(home, {path("with_quilt"), "--without-rooms"}));
  EXPECT_EQ(again.at("own_things").at("seen"), 1);
  EXPECT_EQ(again.at("written"), false) << "the home knows of a later sighting";

  const json unread = result_of(
      {"update", "--home", home, "--network", path("none.onnx"), "--without-rooms", path("visit")});
  EXPECT_EQ(unread.at("frames"), kFrames);
  EXPECT_THAT(unread.at("own_things").at("why_not").get<std::string>(), HasSubstr("none.onnx"));
}

TEST_F(ThingsCommandsTest, TeachingSaysWhatIsWrong) {
  const std::string home = copy_of_home("not_taught.home"), picture = path("dark_alone.png");
  ASSERT_OK(write_picture_of_thing(picture, 10));
  const auto errors_of = [&](const std::string& name) {
    return run({"things", "teach", name, picture, "--home", home, "--network", path("colors.onnx")})
        .errors;
  };
  EXPECT_THAT(errors_of("my mug"), HasSubstr("0 pictures show it well enough; 3 are needed"));
  EXPECT_THAT(errors_of("bed"), HasSubstr("such as \"my bed\""));
  EXPECT_THAT(run({"things", "forget", "my mug", "--home", home}).errors,
              HasSubstr("nobody taught it a thing called my mug"));
}

}  // namespace
}  // namespace roomwise
