#include "roomwise/service/protocol/messages.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::service {
namespace {

using ::testing::ElementsAre;
using ::testing::ElementsAreArray;
using ::testing::HasSubstr;

template <typename T>
T read_back(const DeviceMessage& message) {
  const auto read = read_device_message(write(message));
  EXPECT_TRUE(read) << write(message);
  return std::get<T>(*read);
}
template <typename T>
T read_back_home(const HomeMessage& message) {
  const auto read = read_home_message(write(message));
  EXPECT_TRUE(read) << write(message);
  return std::get<T>(*read);
}
std::string error_of(std::string_view text) {
  const auto read = read_device_message(text);
  return read ? "" : read.error().message;
}

WatchedWalk watched_walk() {
  return {
      "en", "bed", "on_way", {{12, 1, 2, 90, 0.1}}, 3.2, {{1, 2}, {3, 4}}, {{11, "Turn right."}}};
}

TEST(Messages, HelloComesBack) {
  Hello hello;
  hello.version = 1;
  hello.name = "Anna's \"phone\"";
  hello.kind = DeviceKind::kWearable;
  geometry::PinholeCamera camera = *geometry::camera_preset("fr1");
  hello.camera = DeviceCamera{camera.width, camera.height, camera, true};
  hello.settings = {"de", Distances::kSteps, 0.6, false};
  const auto back = read_back<Hello>(hello);
  EXPECT_EQ(back.name, hello.name);
  EXPECT_EQ(back.kind, DeviceKind::kWearable);
  ASSERT_TRUE(back.camera && back.camera->calibrated);
  EXPECT_EQ(*back.camera->calibrated, camera);
  EXPECT_TRUE(back.camera->has_depth);
  EXPECT_EQ(back.settings, hello.settings);
}

TEST(Messages, ACameraThatIsNotCalibratedHasNoPinhole) {
  const auto read = read_device_message(
      R"({"type":"hello","version":1,"name":"a","kind":"phone","camera":{"width":640,"height":480,"lens":"back camera"}})");
  ASSERT_TRUE(read);
  const auto& camera = std::get<Hello>(*read).camera;
  ASSERT_TRUE(camera);
  EXPECT_FALSE(camera->calibrated);
  EXPECT_FALSE(camera->has_depth);
  EXPECT_EQ(camera->lens, "back camera");
  const auto back = read_device_message(write(DeviceMessage(std::get<Hello>(*read))));
  ASSERT_OK(back);
  EXPECT_EQ(std::get<Hello>(*back).camera->lens, "back camera");
}

TEST(Messages, QuestionsComeBackWithTheirSubject) {
  const Ask ask = read_back<Ask>(Ask{8, 1300.25, Question::kWhereIs, "Mikrowelle \xC3\xBC"});
  EXPECT_EQ(ask.id, 8);
  EXPECT_EQ(ask.t_ms, 1300.25);
  EXPECT_EQ(ask.question, Question::kWhereIs);
  EXPECT_EQ(ask.subject, "Mikrowelle \xC3\xBC");
  const Ask words = read_back<Ask>(Ask{9, 0, Question::kInWords, "where is it?"});
  EXPECT_EQ(words.question, Question::kInWords);
  EXPECT_EQ(words.subject, "where is it?");
  const Ask room = read_back<Ask>(Ask{10, 0, Question::kWhereIs, "kitchen", true});
  EXPECT_TRUE(room.is_room);
  EXPECT_EQ(room.subject, "kitchen");
  EXPECT_EQ(read_back<Ask>(Ask{11, 0, Question::kDescribeRoom, "kitchen"}).subject, "kitchen");
  EXPECT_EQ(read_back<Ask>(Ask{12, 0, Question::kDescribeRoom, ""}).subject, "");
  for (const Question question : {Question::kNameThing, Question::kForgetThing,
                                  Question::kShareThing, Question::kKeepThing}) {
    EXPECT_EQ(read_back<Ask>(Ask{13, 0, question, "my blue mug"}).subject, "my blue mug");
  }
  EXPECT_EQ(read_back<Ask>(Ask{14, 0, Question::kTeachThing, ""}).question, Question::kTeachThing);
  EXPECT_EQ(read_back<Ask>(Ask{16, 0, Question::kMarkSpot, "my chair"}).subject, "my chair");
  EXPECT_EQ(read_back<Ask>(Ask{16, 0, Question::kMarkSpot, ""}).subject, "");
  EXPECT_EQ(read_back<Ask>(Ask{16, 0, Question::kTakeMeBack, ""}).question, Question::kTakeMeBack);
  Ask renamed{17, 0, Question::kRenameSpot, "my chair"};
  renamed.name = "my seat";
  EXPECT_EQ(read_back<Ask>(renamed).name, "my seat");
  Ask chair{18, 0, Question::kTakeMeTo, "chair"};
  chair.in_room = "kitchen";
  EXPECT_EQ(read_back<Ask>(chair).in_room, "kitchen");
  Ask door{18, 0, Question::kTakeMeTo, "door"};
  door.in_room = "kitchen";
  door.to_room = "hall";
  EXPECT_EQ(read_back<Ask>(door).to_room, "hall");
  Ask named{15, 0, Question::kNameThing, "my blue mug"};
  EXPECT_FALSE(read_back<Ask>(named).is_private);
  named.is_private = true;
  EXPECT_TRUE(read_back<Ask>(named).is_private);
  EXPECT_EQ(read_back<Ask>(Ask{13, 0, Question::kWhatIsOn, "table"}).subject, "table");
  EXPECT_EQ(read_back<Ask>(Ask{14, 0, Question::kWhatIsIn, "kitchen"}).subject, "kitchen");
  EXPECT_EQ(read_back<Ask>(Ask{9, 1, Question::kWayTo, "bed"}).subject, "bed");
  EXPECT_EQ(read_back<Ask>(Ask{9, 1, Question::kTakeMeTo, "bed"}).subject, "bed");
  EXPECT_FALSE(read_back<Ask>(Ask{9, 1, Question::kTakeMeTo, "bed"}).is_room);
  Ask out{9, 1, Question::kTakeMeTo, ""};
  out.is_way_out = true;
  EXPECT_TRUE(read_back<Ask>(out).is_way_out);
  EXPECT_THAT(error_of(R"({"type":"ask","id":1,"t":0,"question":"where_is","goal":"moon"})"),
              ::testing::HasSubstr("way_out"));
  const Ask bath = read_back<Ask>(Ask{9, 1, Question::kTakeMeTo, "bath", true});
  EXPECT_EQ(bath.subject, "bath");
  EXPECT_TRUE(bath.is_room);
  EXPECT_EQ(read_back<Ask>(Ask{9, 1, Question::kGuide, "", false, GuideWish::kBlocked}).wish,
            GuideWish::kBlocked);
  EXPECT_EQ(read_back<Ask>(Ask{9, 1, Question::kNameRoom, "kitchen"}).subject, "kitchen");
  EXPECT_TRUE(read_back<Quiet>(Quiet{true}).on);
  EXPECT_TRUE(read_back<Watch>(Watch{true}).on);
}

TEST(Messages, SettingsChangeOnlyWhatTheyName) {
  SpeakingSettings settings{"en", Distances::kMetres, 0.7, true};
  apply(read_back<SettingsChange>(SettingsChange{{}, Distances::kSteps, {}, {}}), settings);
  EXPECT_EQ(settings, (SpeakingSettings{"en", Distances::kSteps, 0.7, true}));
  EXPECT_FALSE(settings.may_watch) << "of who says nothing";
  apply(read_back<SettingsChange>(SettingsChange{{}, {}, {}, {}, true}), settings);
  EXPECT_TRUE(settings.may_watch);
}

TEST(Messages, WhatTheComputerSaysComesBack) {
  const ThingInRooms chair{"chair", {"hall", "kitchen"}};
  const auto welcome = read_back_home<Welcome>(
      Welcome{"Our flat", "device", {"bath"}, {"bed"}, true, false, {}, {chair}});
  EXPECT_THAT(welcome.things_in_rooms, ElementsAre(chair));
  EXPECT_EQ(welcome.home, "Our flat");
  EXPECT_THAT(welcome.rooms, ElementsAre("bath"));
  EXPECT_TRUE(welcome.has_room_classifier);
  EXPECT_FALSE(welcome.can_localize);

  const Seen seen{12.5, "room", "kitchen", 0.98, "looks like it", SeenPosition{1, 2, 3, 90, 0.05}};
  const auto seen_back = read_back_home<Seen>(seen);
  EXPECT_EQ(seen_back.room, "kitchen");
  ASSERT_TRUE(seen_back.position);
  EXPECT_EQ(seen_back.position->heading_degrees, 90);

  const GoalBearing bearing_back =
      read_back_home<GoalBearing>(GoalBearing{12.5, -30, 0.75, 1012.5});
  EXPECT_EQ(bearing_back.bearing_degrees, -30);
  EXPECT_EQ(bearing_back.distance_m, 0.75);
  EXPECT_EQ(bearing_back.valid_until_t_ms, 1012.5);

  PromptMessage prompt;
  prompt.answer_to = 7;
  prompt.text = "You are in the kitchen.";
  prompt.valid_until_t_ms = 4234.5;
  const auto prompt_back = read_back_home<PromptMessage>(prompt);
  EXPECT_EQ(prompt_back.answer_to, 7);
  EXPECT_EQ(prompt_back.text, prompt.text);
  EXPECT_FALSE(prompt_back.based_on_t_ms);
  EXPECT_EQ(prompt_back.valid_until_t_ms, 4234.5);

  EXPECT_EQ(read_back_home<FrameArrived>(FrameArrived{3.5, 2}).dropped, 2U);
  EXPECT_EQ(read_back_home<RecordingState>(RecordingState{7, "saved", "walk", 17, ""}).frames, 17U);
  EXPECT_FALSE(read_back_home<JobState>(JobState{"map", "running", "mapping", 0.4, {}, ""}).left_s);
  const std::map<std::string, std::int64_t> values{{"frames", 9}, {"placed", 7}};
  const auto job =
      read_back_home<JobState>(JobState{"map", "done", "", 1, {}, "well", "mapped", values});
  EXPECT_EQ(job.message, "mapped");
  EXPECT_EQ(job.values, values);
  EXPECT_TRUE(read_back_home<DeviceSeen>(DeviceSeen{3, "phone", true, seen}).seen);
  EXPECT_EQ(read_back_home<ErrorMessage>(ErrorMessage{"no", 4}).answer_to, 4);

  WatchedDevice watched{3, "phone", 12.5, true, {}};
  EXPECT_FALSE(read_back_home<WatchedDevice>(watched).walk);
  watched.walk = watched_walk();
  const auto walk = read_back_home<WatchedDevice>(watched).walk;
  ASSERT_TRUE(walk);
  EXPECT_EQ(walk->language, "en");
  EXPECT_EQ(walk->goal, "bed");
  ASSERT_TRUE(walk->person);
  EXPECT_EQ(walk->person->heading_degrees, 90);
  EXPECT_EQ(walk->left_m, 3.2);
  EXPECT_EQ(walk->way, watched.walk->way);
  ASSERT_EQ(walk->said.size(), 1U);
  EXPECT_EQ(walk->said[0].text, "Turn right.");
}

TEST(Messages, AChangedHomeIsReadAsAWelcome) {
  const auto read = read_home_message(write_home_changed(Welcome{"flat", "helper", {}, {}, 0, 0}));
  ASSERT_TRUE(read);
  EXPECT_EQ(std::get<Welcome>(*read).role, "helper");
}

// docs/protocol.schema.json has every message with just the members that are written.
TEST(Messages, AreAsTheSchemaSays) {
  const auto text = read_text_file(ROOMWISE_PROTOCOL_SCHEMA);
  ASSERT_OK(text);
  const auto schema = nlohmann::json::parse(*text).at("$defs");
  Hello hello;
  hello.version = 1;
  hello.camera = DeviceCamera{640, 480, *geometry::camera_preset("fr1"), true};
  const Seen seen{12.5, "room", "kitchen", 0.98, "", SeenPosition{1, 2, 3, 90, 0.05}};
  Ask out{8, 1, Question::kTakeMeTo, ""};
  out.is_way_out = true;
  PromptMessage prompt;
  prompt.answer_to = 7;
  prompt.based_on_t_ms = 1;
  for (const std::string& written :
       {write(DeviceMessage(hello)), write(DeviceMessage(Ask{8, 1, Question::kWhereIs, "bed"})),
        write(DeviceMessage(Ask{8, 1, Question::kMarkSpot, "my chair"})), write(DeviceMessage(out)),
        write(DeviceMessage(SettingsChange{"de", Distances::kSteps, 0.6, true, true})),
        write(DeviceMessage(Watch{true})), write(DeviceMessage(Quiet{true})),
        write(HomeMessage(Welcome{})), write_home_changed(Welcome{}),
        write(HomeMessage(FrameArrived{})), write(HomeMessage(seen)),
        write(HomeMessage(GoalBearing{})), write(HomeMessage(prompt)),
        write(HomeMessage(RecordingState{})), write(HomeMessage(JobState{})),
        write(HomeMessage(DeviceSeen{3, "a", true, seen})),
        write(HomeMessage(WatchedDevice{3, "a", 1, true, watched_walk()})),
        write(HomeMessage(ErrorMessage{}))}) {
    const auto message = nlohmann::json::parse(written);
    const auto& definition = schema.at(message.at("type").get<std::string>());
    for (const auto& required : definition.at("required")) {
      EXPECT_TRUE(message.contains(required.get<std::string>())) << required << " of " << written;
    }
    for (const auto& [member, value] : message.items()) {
      EXPECT_TRUE(definition.at("properties").contains(member)) << member << " of " << written;
    }
  }
}

TEST(Messages, AnErrorNamesWhatIsWrong) {
  EXPECT_THAT(error_of("{"), HasSubstr("no JSON object"));
  EXPECT_THAT(error_of("[1]"), HasSubstr("no JSON object"));
  EXPECT_THAT(error_of("{}"), HasSubstr("'type' is missing"));
  EXPECT_THAT(error_of(R"({"type":7})"), HasSubstr("'type' must be a text"));
  EXPECT_THAT(error_of(R"({"type":"shout"})"), HasSubstr("'shout'"));
  EXPECT_THAT(error_of(R"({"type":"ask","id":-1,"t":0,"question":"repeat"})"), HasSubstr("'id'"));
  EXPECT_THAT(error_of(R"({"type":"ask","id":1,"t":"x","question":"repeat"})"), HasSubstr("'t'"));
  EXPECT_THAT(error_of(R"({"type":"ask","id":1,"t":1e300,"question":"repeat"})"),
              HasSubstr("'t' must be a number"));
  EXPECT_THAT(error_of(R"({"type":"ask","id":1,"t":0,"question":"why"})"),
              HasSubstr("'where_am_i'"));
  EXPECT_THAT(error_of(R"({"type":"ask","id":1,"t":0,"question":"in_words"})"),
              HasSubstr("'text'"));
  EXPECT_THAT(error_of(R"({"type":"ask","id":1,"t":0,"question":"in_words","text":")" +
                       std::string(501, 'a') + R"("})"),
              HasSubstr("at most 500 bytes"));
  EXPECT_THAT(error_of(R"({"type":"ask","id":1,"t":0,"question":"where_is"})"),
              HasSubstr("'thing' is missing"));
  EXPECT_THAT(error_of(R"({"type":"ask","id":1,"t":0,"question":"where_is","thing":""})"),
              HasSubstr("'thing' must be not empty"));
  EXPECT_THAT(error_of(R"({"type":"ask","id":1,"t":0,"question":"rename_spot","spot":"a"})"),
              HasSubstr("'name' is missing"));
  EXPECT_THAT(error_of(R"({"type":"settings","step_m":-3})"), HasSubstr("'step_m'"));
  EXPECT_THAT(error_of(R"({"type":"quiet","on":1})"), HasSubstr("'on' must be true or false"));
  EXPECT_THAT(
      error_of(
          R"({"type":"hello","version":1,"name":"a","kind":"phone","camera":{"width":640,"height":480,"fx":500}})"),
      HasSubstr("'camera': 'fy' is missing"));
  EXPECT_THAT(error_of(R"({"type":"hello","version":1,"name":")" + std::string(300, 'x') +
                       R"(","kind":"phone"})"),
              HasSubstr("'name'"));
}

TEST(Messages, TheIdOfAQuestionIsKnownThoughTheRestIsWrong) {
  EXPECT_EQ(id_of_ask(R"({"type":"ask","id":8,"t":0,"question":"why"})"), 8);
  EXPECT_FALSE(id_of_ask(R"({"type":"ask","id":"x"})"));
  EXPECT_FALSE(id_of_ask(R"({"type":"quiet","id":8})"));
  EXPECT_FALSE(id_of_ask("{"));
}

TEST(Messages, AWholeNumberMayBeWrittenWithAPoint) {
  EXPECT_EQ(id_of_ask(R"({"type":"ask","id":8.0})"), 8);
  EXPECT_FALSE(id_of_ask(R"({"type":"ask","id":8.5})"));
  EXPECT_FALSE(id_of_ask(R"({"type":"ask","id":1e300})"));
}

TEST(Messages, TheTimeOfAFrameIsKnownThoughTheRestIsWrong) {
  Bytes frame = write(FrameMessage{12.5, Bytes{9}, Bytes{9}});
  frame.push_back(9);  // more than the header tells of
  EXPECT_FALSE(read_frame(frame));
  EXPECT_EQ(time_of_frame(frame), 12.5);
  frame[0] = 'X';
  EXPECT_FALSE(time_of_frame(frame));
  const auto error = read_home_message(write(HomeMessage(ErrorMessage{"no", {}, 12.5})));
  ASSERT_TRUE(error);
  EXPECT_EQ(std::get<ErrorMessage>(*error).t_ms, 12.5);
}

TEST(Messages, ThatAreTooLongAreNotParsed) {
  std::string text = R"({"type":"quiet","on":true)";
  for (int i = 0; text.size() < kMaxTextBytes; ++i) text += fmt::format(R"(,"{}":1)", i);
  EXPECT_THAT(error_of(text + "}"), HasSubstr("at most 16384"));
}

TEST(Messages, AnotherVersionOfTheComputerIsAnError) {
  const auto read = read_home_message(R"({"type":"welcome","version":2})");
  ASSERT_FALSE(read);
  EXPECT_THAT(read.error().message, HasSubstr("version 2"));
}

TEST(Messages, BytesThatAreNoUtf8DoNotThrow) {
  EXPECT_THAT(write(HomeMessage(ErrorMessage{"caf\xE9", {}})), HasSubstr("caf\xEF\xBF\xBD"));
}

// A message with that header and an image of a byte each.
Bytes frame_with(const std::string& header, std::optional<std::uint32_t> told_length = {}) {
  const std::uint32_t length = told_length.value_or(static_cast<std::uint32_t>(header.size()));
  Bytes message{'R', 'W', 'F', '1'};
  for (unsigned i = 0; i < 4; ++i) {
    message.push_back(static_cast<std::uint8_t>(length >> (8 * i)));
  }
  message.insert(message.end(), header.begin(), header.end());
  message.insert(message.end(), {9, 9});
  return message;
}

TEST(Frames, ComeBackWithTheirImages) {
  const Bytes color{1, 2, 3}, depth{4, 5};
  const Bytes message = write(FrameMessage{1234.5, color, depth});
  const auto frame = read_frame(message);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->t_ms, 1234.5);
  EXPECT_THAT(frame->color, ElementsAreArray(color));
  EXPECT_THAT(frame->depth, ElementsAreArray(depth));
  EXPECT_TRUE(read_frame(write(FrameMessage{1, color, {}}))->depth.empty());
}

FrameMessage frame_of_a_phone(const Bytes& color, const Bytes& depth) {
  FrameMessage frame{1234.5, color, depth};
  frame.camera = geometry::PinholeCamera{500, 501, 239.5, 319.5, 480, 640, {}};
  frame.depth_size = ImageSize{90, 160};
  frame.pose = FramePose{"webxr", {{Eigen::Quaterniond(0.6, 0, 0.8, 0), {1, -2, 3}}}};
  frame.pose->motion.up_camera = Eigen::Vector3d(0, -1, 0);
  frame.pose->covariance = 0.01 * Eigen::Matrix<double, 6, 6>::Identity();
  return frame;
}

TEST(Frames, OfVersion2TellCameraDepthAndPose) {
  const Bytes color{1, 2, 3}, depth{4, 5};
  const FrameMessage sent = frame_of_a_phone(color, depth);
  const Bytes message = write(sent);
  const auto frame = read_frame(message);
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_EQ(frame->camera, sent.camera);
  EXPECT_EQ(frame->depth_size, sent.depth_size);
  ASSERT_TRUE(frame->pose);
  EXPECT_EQ(frame->pose->source, "webxr");
  const geometry::DeviceMotion& motion = frame->pose->motion;
  EXPECT_TRUE(motion.world_from_camera.rotation.isApprox(
      sent.pose->motion.world_from_camera.rotation, 1e-12));
  EXPECT_EQ(motion.world_from_camera.translation, Eigen::Vector3d(1, -2, 3));
  EXPECT_TRUE(motion.up_camera->isApprox(*sent.pose->motion.up_camera, 1e-12));
  EXPECT_EQ(*frame->pose->covariance, *sent.pose->covariance);
  for (std::size_t length = 0; length < message.size(); ++length) {
    EXPECT_FALSE(read_frame(std::span(message).first(length))) << length;
  }
}

TEST(Frames, OfVersion1AreReadAsBeforeWhateverElseTheyHold) {
  const auto frame = read_frame(frame_with(R"({"t":1,"color_bytes":1,"depth_bytes":1,"pose":7})"));
  ASSERT_TRUE(frame);
  EXPECT_FALSE(frame->pose);
}

TEST(Frames, WhatVersion2AddsIsRefusedByName) {
  const auto why = [](const std::string& more) {
    const auto frame =
        read_frame(frame_with(R"({"t":1,"color_bytes":1,"depth_bytes":1,)" + more + "}"));
    return frame ? std::string("read") : frame.error().message;
  };
  EXPECT_EQ(why(R"("version":2)"), "read");
  EXPECT_EQ(why(R"("version":2,"pose":null,"camera":null,"depth":null)"), "read");
  EXPECT_THAT(why(R"("version":3)"), HasSubstr("'version' must be a whole number from 1 to 2"));
  EXPECT_THAT(why(R"("version":2,"depth":{"width":0,"height":1})"), HasSubstr("'depth': 'width'"));
  EXPECT_THAT(
      why(R"("version":2,"camera":{"width":640,"height":480,"fx":5,"fy":500,"cx":1,"cy":1})"),
      HasSubstr("'camera'"));
  const auto pose = [&](const std::string& more) {
    return why(R"("version":2,"pose":{"source":"webxr","position":[0,0,0],)" + more + "}");
  };
  EXPECT_EQ(pose(R"("rotation_xyzw":[0,0,0,1])"), "read");
  EXPECT_THAT(pose(R"("rotation_xyzw":[0,0,0])"), HasSubstr("a list of 4 numbers"));
  EXPECT_THAT(pose(R"("rotation_xyzw":[0,0,0,0.5])"),
              HasSubstr("'rotation_xyzw' must be of length 1"));
  EXPECT_THAT(pose(R"("rotation_xyzw":[0,0,0,1],"up":[0,0,0])"), HasSubstr("'up'"));
  EXPECT_THAT(pose(R"("rotation_xyzw":[0,0,0,1],"covariance":[1,2])"), HasSubstr("'covariance'"));
  EXPECT_THAT(
      pose(
          R"("rotation_xyzw":[0,0,0,1],"covariance":[-1,0,0,0,0,0,1,0,0,0,0,1,0,0,0,1,0,0,1,0,1])"),
      HasSubstr("negative variance"));
  EXPECT_THAT(
      why(R"("version":2,"pose":{"source":"webxr","position":[0,1e9,0],"rotation_xyzw":[0,0,0,1]})"),
      HasSubstr("'position'"));
}

// Every frame that is cut short, and every one with more behind it, is refused.
TEST(Frames, OfAnotherLengthAreRefused) {
  const Bytes color{1, 2, 3}, depth{4, 5};
  Bytes message = write(FrameMessage{1234.5, color, depth});
  for (std::size_t length = 0; length < message.size(); ++length) {
    EXPECT_FALSE(read_frame(std::span(message).first(length))) << length;
  }
  message.push_back(0);
  EXPECT_FALSE(read_frame(message));
}

TEST(Frames, AHeaderThatLiesIsRefused) {
  const auto size = [](const std::string& text) { return static_cast<std::uint32_t>(text.size()); };
  const std::string good = R"({"t":1,"color_bytes":1,"depth_bytes":1})";
  EXPECT_TRUE(read_frame(frame_with(good, size(good))));
  EXPECT_FALSE(read_frame(frame_with(good, 0xFFFFFFFF)));
  EXPECT_FALSE(read_frame(frame_with(good, 2049)));
  for (const std::string bad :
       {R"({"t":1,"color_bytes":2,"depth_bytes":1})",
        R"({"t":1,"color_bytes":18446744073709551615,"depth_bytes":3})",
        R"({"t":1,"color_bytes":-1,"depth_bytes":3})", R"({"t":1,"color_bytes":0,"depth_bytes":2})",
        R"({"t":1,"color_bytes":1.5,"depth_bytes":1})", R"({"color_bytes":1,"depth_bytes":1})"}) {
    EXPECT_FALSE(read_frame(frame_with(bad, size(bad)))) << bad;
  }
}

TEST(Frames, LargerThanIsTakenAreRefusedBeforeTheyAreRead) {
  const auto read = read_frame(Bytes(kMaxFrameBytes + 1));
  ASSERT_FALSE(read);
  EXPECT_THAT(read.error().message, HasSubstr("at most"));
}

}  // namespace
}  // namespace roomwise::service
