#include "roomwise/live/device/device.h"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <future>
#include <map>
#include <mutex>
#include <thread>

#include "roomwise/base/testing/testing.h"
#include "roomwise/guide/testing/drawn_floor.h"
#include "roomwise/image/codec.h"
#include "roomwise/live/device/frame_workers.h"
#include "roomwise/pipeline/mapping/map_recording.h"
#include "roomwise/pipeline/rooms/room_learning.h"
#include "roomwise/pipeline/testing/synthetic_walk.h"

namespace roomwise::live {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// Keeps what is sent.
class Wire final : public service::SocketOut {
 public:
  void send_text(std::string text) override {
    if (std::exchange(is_broken, false)) throw std::runtime_error("a fault");
    if (const auto now = std::exchange(on_send, {})) now();
    texts.push_back(std::move(text));
  }
  void close(std::string reason) override { closed = std::move(reason); }

  // The messages of one type since the last call of any kind.
  template <typename T>
  std::vector<T> take() {
    std::vector<T> found;
    for (const std::string& text : std::exchange(texts, {})) {
      const auto message = service::read_home_message(text);
      EXPECT_TRUE(message) << text;
      if (message && std::holds_alternative<T>(*message)) found.push_back(std::get<T>(*message));
    }
    return found;
  }

  std::vector<std::string> texts;
  std::optional<std::string> closed;
  bool is_broken = false;         // for the next message
  std::function<void()> on_send;  // called as the next message is sent, before it is kept
};

class Host final : public DeviceHost {
 public:
  [[nodiscard]] std::shared_ptr<const HomeView> view_for(const service::Identity&) const override {
    return home;
  }
  void has_work(const std::shared_ptr<Device>&) override { ++asked_to_work; }
  void saw(const Device&, const FrameResult& result) override { seen.push_back(result.t_ms); }
  void looked(double, bool well) override {
    looked_well.push_back(well);
    if (on_looked) on_looked();
  }
  void answered(service::Question question, double seconds) override {
    answers.push_back(question);
    EXPECT_GE(seconds, 0);
  }
  void not_recorded(const Error& error) override { not_stored.push_back(error.message); }
  void recorded(const Device&, const service::RecordingState& state) override {
    recordings.push_back(state);
  }
  [[nodiscard]] mapping::LensCalibration lens_of(const Device&) const override { return {}; }

  [[nodiscard]] std::shared_ptr<WalkRecorder> recorder_for(const Device&) override {
    return recorder;
  }
  [[nodiscard]] Expected<void> name_recorded_room(const Device&, const std::string& room) override {
    return recorder ? recorder->name_room(room) : fail("nothing is recorded");
  }

  [[nodiscard]] Expected<void> teach(const std::shared_ptr<Device>&, const std::string& name, bool,
                                     std::vector<objects::ShownThing> shown) override {
    if (name == "chair") return fail_with(ErrorCode::kRefused, "any chair is called so");
    taught.emplace_back(name, shown.size());
    return {};
  }
  [[nodiscard]] Expected<void> change_own_thing(const service::Identity&, const std::string& name,
                                                service::Question) override {
    if (name == "my mug") return {};
    return fail_with(ErrorCode::kRefused, "not taught by this device");
  }

  [[nodiscard]] Expected<void> mark_spot(const service::Identity&, const std::string& name,
                                         const Eigen::Vector3d&) override {
    marked.push_back(name);
    return {};
  }
  [[nodiscard]] Expected<void> change_spot(const service::Identity&, const std::string& name,
                                           const std::optional<std::string>& new_name) override {
    if (new_name == "my desk") return fail_with(ErrorCode::kRefused, "another is called so");
    if (name == "my chair") return {};
    return fail_with(ErrorCode::kRefused, "not marked by this device");
  }
  void erase_forgotten(const service::Identity&, const std::string& name,
                       service::Question) override {
    erased.push_back(name);
  }
  void sets_out(const service::Identity&, const Eigen::Vector3d&) override {}
  [[nodiscard]] std::vector<service::Identity> watchers(const service::Identity&) const override {
    return watching;
  }
  void shows_walk(const service::WatchedDevice& watched,
                  std::span<const service::Identity> /*to*/) override {
    walks_shown.push_back(watched);
  }
  void began_to_watch(Device& helper) override { began.push_back(helper.who().device); }
  void came_anew(const Device& /*device*/) override {}
  void shows_less(const Device& device) override { shown_less.push_back(device.seen()); }
  [[nodiscard]] Expected<std::vector<guide::SeenPerson>> people_in(
      const FrameImages&, const std::optional<geometry::PinholeCamera>&) const override {
    if (!people) return fail("no eyes");
    return *people;
  }

  std::optional<std::vector<guide::SeenPerson>> people;
  std::vector<service::Identity> watching;  // helpers
  std::vector<service::WatchedDevice> walks_shown;
  std::vector<std::int64_t> began;  // to watch
  std::vector<service::DeviceSeen> shown_less;

  std::vector<std::string> marked;
  std::vector<std::string> erased;
  std::vector<std::pair<std::string, std::size_t>> taught;
  std::shared_ptr<WalkRecorder> recorder;
  std::shared_ptr<HomeView> home = std::make_shared<HomeView>();
  int asked_to_work = 0;
  std::vector<double> seen;
  std::vector<bool> looked_well;
  std::function<void()> on_looked;
  std::vector<service::Question> answers;
  std::vector<std::string> not_stored;
  std::vector<service::RecordingState> recordings;
};

class DeviceTest : public ::testing::Test {
 protected:
  static service::Hello hello(bool has_camera = true) {
    service::Hello hello;
    hello.version = 1;
    hello.name = "belt";
    hello.kind = service::DeviceKind::kWearable;
    if (has_camera) hello.camera = service::DeviceCamera{8, 6, {}, false};
    return hello;
  }
  void say(const service::DeviceMessage& message) { device->on_text(write(message)); }
  void show(double t_ms) {
    const Bytes color = image::encode_jpeg(image::ColorImage(8, 6), 90);
    device->on_message(write(service::FrameMessage{t_ms, color, {}}));
  }
  void ask(std::int64_t id, double t_ms, service::Question question, std::string subject = "") {
    say(service::Ask{id, t_ms, question, std::move(subject)});
  }

  Host host;
  std::shared_ptr<Wire> wire = std::make_shared<Wire>();
  std::shared_ptr<Device> device =
      std::make_shared<Device>(service::Identity{3, "belt", service::Role::kDevice}, wire, host);
};

TEST_F(DeviceTest, IsWelcomedWithWhatTheHomeHas) {
  host.home->name = "flat";
  host.home->rooms = {{"bath", "bathroom"}, {"kitchen", "kitchen"}};
  guide::KnownThing bed;
  bed.name = "bed";
  host.home->things = {bed, bed};
  for (const char* const room : {"kitchen", "bath", "kitchen"}) {
    guide::KnownThing& stool = host.home->things.emplace_back();
    stool.name = "stool";
    stool.room = room;
  }
  say(hello());
  const auto welcome = wire->take<service::Welcome>();
  ASSERT_THAT(welcome, SizeIs(1));
  EXPECT_EQ(welcome[0].home, "flat");
  EXPECT_EQ(welcome[0].role, "device");
  EXPECT_THAT(welcome[0].rooms, ::testing::ElementsAre("bath", "kitchen"));
  EXPECT_THAT(welcome[0].things, ::testing::ElementsAre("bed", "stool"));  // each name once
  const service::ThingInRooms stool{"stool", {"bath", "kitchen"}};
  EXPECT_THAT(welcome[0].things_in_rooms, ::testing::ElementsAre(stool));
  EXPECT_FALSE(welcome[0].has_room_classifier);
}

TEST_F(DeviceTest, OfTwoChangesAtOnceTheLaterIsToldLast) {
  say(hello());
  (void)wire->take<service::Welcome>();
  host.home = std::make_shared<HomeView>();
  host.home->name = "older";
  std::thread other;
  wire->on_send = [&] {
    other = std::thread([&] {
      auto newer = std::make_shared<HomeView>();
      newer->name = "newer";
      host.home = newer;
      device->home_changed();
    });
    // However far the other comes meanwhile, it must not overtake.
    for (int i = 0; i < 10'000; ++i) std::this_thread::yield();
  };
  device->home_changed();
  other.join();
  ASSERT_THAT(wire->texts, SizeIs(2));
  EXPECT_THAT(wire->texts[0], HasSubstr("older"));
  EXPECT_THAT(wire->texts[1], HasSubstr("newer"));
}

TEST_F(DeviceTest, AFaultInItsWorkIsReportedAndTheNextFrameIsLookedAt) {
  say(hello());
  std::mutex mutex;
  std::vector<std::string> faults;
  const auto look = [&] {
    FrameWorkers workers(1, [&](const Error& fault) {
      const std::scoped_lock lock(mutex);
      faults.push_back(fault.message);
    });
    std::promise<void> looked;
    host.on_looked = [&] { looked.set_value(); };
    workers.add(device);
    looked.get_future().wait();
  };
  show(100);
  wire->is_broken = true;  // where it is told what is seen
  look();
  EXPECT_THAT(faults, ::testing::ElementsAre(HasSubstr("a fault")));
  show(200);
  look();
  EXPECT_THAT(faults, SizeIs(1));
  EXPECT_THAT(host.looked_well, SizeIs(2));
}

TEST_F(DeviceTest, EveryQuestionIsTimedUntilItsAnswerByWhatItMeans) {
  say(hello());
  ask(1, 100, service::Question::kWhereIs, "bed");
  ask(2, 100, service::Question::kInWords, "where am I?");
  ask(3, 100, service::Question::kInWords, "blorb");  // it is told what can be asked
  show(200);
  ask(4, 200, service::Question::kWhereAmI);  // waits for the frame
  EXPECT_THAT(host.answers,
              ::testing::ElementsAre(service::Question::kWhereIs, service::Question::kWhereAmI,
                                     service::Question::kInWords));
  device->work();
  EXPECT_EQ(host.answers.size(), 4u);
  EXPECT_EQ(host.looked_well.size(), 1u);
}

// A checkered thing in the middle of an even picture of 160x120.
Bytes picture_of_thing(std::uint8_t light) {
  image::ColorImage picture(160, 120, {light, light, light});
  for (int y = 40; y < 80; ++y) {
    for (int x = 60; x < 100; ++x) {
      if ((x / 10 + y / 10) % 2 == 0) picture.at(x, y) = {light, 0, 0};
    }
  }
  return image::encode_png(picture);
}

// Begins to teach a thing to a device with a camera.
class DeviceTeaching : public DeviceTest {
 protected:
  DeviceTeaching() {
    service::Hello with_camera = hello();
    with_camera.camera = service::DeviceCamera{160, 120, {}, false};
    say(with_camera);
    ask(1, 100, service::Question::kTeachThing);
  }
  void show_thing(double t_ms, std::uint8_t light = 200) {
    device->on_message(write(service::FrameMessage{t_ms, picture_of_thing(light), {}}));
  }
  // One a second.
  void show_things(int count) {
    for (int i = 1; i <= count; ++i) {
      show_thing(1000.0 * i);
      device->work();
    }
  }
};

// What the thing before it was shown by does not count.
TEST_F(DeviceTeaching, WhoBeginsAnewShowsAllOfTheThing) {
  show_things(10);
  ask(2, 11'000, service::Question::kTeachThing);
  wire->texts.clear();
  ask(3, 12'000, service::Question::kNameThing, "my mug");
  EXPECT_EQ(wire->take<service::PromptMessage>().at(0).message_id, "teach.more");
  EXPECT_THAT(host.taught, IsEmpty());
}

TEST_F(DeviceTeaching, EndsWhereItIsLeftAloneAndFramesAreLookedAtAgain) {
  const auto told = [&](double t_ms) {
    show_thing(t_ms, 10);
    wire->texts.clear();
    device->work();
    std::vector<std::string> messages;
    for (const auto& prompt : wire->take<service::PromptMessage>()) {
      messages.push_back(prompt.message_id);
    }
    return messages;
  };
  EXPECT_THAT(told(1000), ::testing::ElementsAre("teach.dark"));
  EXPECT_THAT(told(61'001), ::testing::ElementsAre("teach.stopped"));
  EXPECT_THAT(host.looked_well, IsEmpty());
  EXPECT_THAT(told(61'100), IsEmpty());
  EXPECT_THAT(host.looked_well, SizeIs(1));
}

TEST_F(DeviceTeaching, WhoSearchesForANameHasTheirWayLookedAtMeanwhile) {
  show_things(10);
  EXPECT_THAT(host.looked_well, IsEmpty());
  show_thing(200'000);
  device->work();
  EXPECT_THAT(host.looked_well, SizeIs(1));
  ask(2, 200'100, service::Question::kNameThing, "my mug");
  EXPECT_THAT(host.taught, SizeIs(1)) << "what was shown is kept";
}

TEST_F(DeviceTeaching, AFaultWhileAThingIsShownDoesNotEndTheLooking) {
  show_things(4);
  show_thing(5000);
  wire->texts.clear();
  wire->is_broken = true;  // where it is told to go on
  device->work();
  const auto errors = wire->take<service::ErrorMessage>();
  ASSERT_THAT(errors, SizeIs(1));
  EXPECT_THAT(errors[0].text, HasSubstr("internal error, please report it: a fault"));
  ask(2, 5500, service::Question::kStopTeaching);
  show_thing(6000);
  device->work();
  EXPECT_THAT(host.looked_well, ::testing::ElementsAre(true));
}

TEST_F(DeviceTest, IsToldStepByStepHowAThingIsTaught) {
  service::Hello with_camera = hello();
  with_camera.camera = service::DeviceCamera{160, 120, {}, false};
  say(with_camera);
  wire->texts.clear();
  const auto told = [&] {
    std::vector<std::string> messages;
    for (const auto& prompt : wire->take<service::PromptMessage>()) {
      messages.push_back(prompt.message_id);
    }
    return messages;
  };
  const auto show_thing = [&](double t_ms, std::uint8_t light) {
    device->on_message(write(service::FrameMessage{t_ms, picture_of_thing(light), {}}));
    device->work();
  };
  ask(1, 100, service::Question::kTeachThing);
  EXPECT_THAT(told(), ::testing::ElementsAre("teach.begin"));
  show_thing(200, 10);
  EXPECT_THAT(told(), ::testing::ElementsAre("teach.dark"));
  ask(2, 300, service::Question::kNameThing, "my mug");
  EXPECT_THAT(told(), ::testing::ElementsAre("teach.more"));
  for (int i = 1; i <= 10; ++i) show_thing(1000.0 * i, 200);
  EXPECT_THAT(told(), ::testing::ElementsAre("teach.go_on", "teach.enough"));
  // A name that will not do can be mended without showing it again.
  ask(3, 11'000, service::Question::kNameThing, "chair");
  EXPECT_THAT(told(), ::testing::ElementsAre("teach.name"));
  ask(4, 12'000, service::Question::kNameThing, "my mug");
  EXPECT_THAT(told(), ::testing::ElementsAre("teach.learning"));
  EXPECT_THAT(host.taught,
              ::testing::ElementsAre(std::pair<std::string, std::size_t>("my mug", 10)));
  device->was_taught("my mug", true);
  EXPECT_THAT(told(), ::testing::ElementsAre("teach.taught"));
}

TEST_F(DeviceTest, ThatAThingIsKnownHoldsFromNowOnThoughNothingWasHeardForLong) {
  say(hello());
  const auto valid_until_t_ms = [&] {
    device->was_taught("my mug", true);
    return wire->take<service::PromptMessage>().at(0).valid_until_t_ms;
  };
  ask(1, 100, service::Question::kWhichRooms);
  wire->texts.clear();
  const double first = valid_until_t_ms();
  const auto before = std::chrono::steady_clock::now();
  while (std::chrono::steady_clock::now() - before < std::chrono::milliseconds(2)) continue;
  EXPECT_GE(valid_until_t_ms(), first + 1);
}

TEST_F(DeviceTest, WhatItTaughtIsForgottenByAWordAndNothingElse) {
  guide::KnownThing mug;
  mug.name = "my mug";
  host.home->things = {mug};
  say(hello());
  wire->texts.clear();
  ask(1, 100, service::Question::kInWords, "forget my mug");
  ask(2, 200, service::Question::kShareThing, "my mug");
  ask(3, 300, service::Question::kForgetThing, "your mug");
  const auto prompts = wire->take<service::PromptMessage>();
  ASSERT_THAT(prompts, SizeIs(3));
  EXPECT_EQ(prompts[0].text, "My mug is forgotten.");
  EXPECT_EQ(prompts[1].message_id, "own.shared");
  EXPECT_EQ(prompts[2].message_id, "own.not_own");
  EXPECT_THAT(host.erased, ElementsAre("my mug"));
}

TEST_F(DeviceTest, ThatWhatWasForgottenIsNotErasedYetIsSaid) {
  say(hello());
  wire->texts.clear();
  device->was_not_erased("my mug", service::Question::kForgetThing, Error{"the disk is full"});
  device->was_not_erased("", service::Question::kForgetSpot, Error{"the disk is full"});
  const auto prompts = wire->take<service::PromptMessage>();
  ASSERT_THAT(prompts, SizeIs(2));
  EXPECT_EQ(prompts[0].text, "My mug is forgotten, but not erased yet.");
  EXPECT_EQ(prompts[0].replace_key, "teaching")
      << "in the place of what was answered, if that still waits";
  EXPECT_EQ(prompts[1].text, "The remembered place is forgotten, but not erased yet.");
  EXPECT_EQ(prompts[1].replace_key, "spot");
  EXPECT_EQ(prompts[1].because, "the disk is full");
}

TEST_F(DeviceTest, OfThingsInSeveralRoomsItAsksWhichOneIsMeant) {
  const auto answer = [&](std::int64_t id, std::string words) {
    ask(id, 1100, service::Question::kInWords, std::move(words));
    return wire->take<service::PromptMessage>().front();
  };
  for (const char* room : {"hall", "kitchen"}) {
    host.home->rooms.push_back({room, room});
    guide::KnownThing& chair = host.home->things.emplace_back();
    chair.name = "chair";
    chair.room = room;
  }
  say(hello());
  EXPECT_EQ(answer(1, "take me to the chair").text,
            "Chair: in the hall and in the kitchen. Which one?");
  EXPECT_EQ(answer(5, "the third one").message_id, "ask.which_room") << "of two";
  EXPECT_EQ(answer(6, "the left one").message_id, "ask.which_room") << "nobody knows where one is";
  EXPECT_EQ(answer(2, "the one in the kitchen").message_id, "route.no_place");
  EXPECT_EQ(host.answers.back(), service::Question::kTakeMeTo);
  EXPECT_THAT(answer(3, "where is the chair in the hall").text, HasSubstr("in the hall"));
  host.home->things.back().room = "hall";
  EXPECT_NE(answer(4, "take me to the chair").message_id, "ask.which_room")
      << "they stand together";
}

TEST_F(DeviceTest, OfDoorsOfARoomItAsksWhichOneIsMeant) {
  const auto floor = guide::testing::three_rooms().grid();
  host.home->layout = guide::testing::layout_along_x(floor, {"hall", "kitchen", "balcony"});
  for (const char* room : {"balcony", "hall", "kitchen"}) host.home->rooms.push_back({room, room});
  const auto answer = [&](std::int64_t id, std::string words) {
    ask(id, 1100, service::Question::kInWords, std::move(words));
    return wire->take<service::PromptMessage>().front();
  };
  service::Hello greeting = hello();
  greeting.settings.language = "en";
  say(greeting);
  wire->texts.clear();
  EXPECT_EQ(answer(1, "bring me to the kitchen door").text,
            "Doors lead to the balcony and the hall. Which one?");
  EXPECT_EQ(answer(2, "the one to the hall").message_id, "route.no_place");
  EXPECT_EQ(host.answers.back(), service::Question::kTakeMeTo);
  EXPECT_NE(answer(3, "bring me to the hall door").message_id, "ask.which_door") << "it has one";
  const std::map<std::string, std::pair<std::string, std::string>> asked{
      {"de", {"zur Küchentür", "Türen führen zum Balkon und zur Diele. Welche?"}},
      {"es",
       {"llévame a la puerta de la cocina", "Hay puertas hacia el balcón y el vestíbulo. ¿Cuál?"}},
      {"fr",
       {"emmène-moi à la porte de la cuisine",
        "Des portes mènent vers le balcon et le hall. Laquelle ?"}}};
  for (const auto& [language, words] : asked) {
    service::SettingsChange change;
    change.language = language;
    say(change);
    wire->texts.clear();
    EXPECT_EQ(answer(4, words.first).text, words.second);
  }
}

TEST_F(DeviceTest, NothingIsMarkedWhereNobodyKnowsWhereOneStands) {
  const auto answer = [&](std::int64_t id, service::Question question, std::string subject = "") {
    ask(id, 1100, question, std::move(subject));
    return wire->take<service::PromptMessage>().back().message_id;
  };
  say(hello());
  EXPECT_EQ(answer(1, service::Question::kMarkSpot, "my chair"), "device.no_map");
  host.home->walks.emplace_back();
  EXPECT_EQ(answer(2, service::Question::kMarkSpot, "my chair"), "device.no_picture");
  show(1000);
  (void)device->work();
  EXPECT_EQ(answer(3, service::Question::kMarkSpot, "my chair"), "spot.not_sure");
  EXPECT_THAT(host.marked, IsEmpty());
  EXPECT_EQ(answer(4, service::Question::kTakeMeBack), "spot.no_way_back");
}

TEST_F(DeviceTest, WhatItMarkedIsListedRenamedAndForgotten) {
  const auto answer = [&](service::Ask ask) {
    say(ask);
    return wire->take<service::PromptMessage>().back();
  };
  say(hello());
  EXPECT_EQ(answer({1, 0, service::Question::kWhichSpots, ""}).message_id, "spot.none");
  ViewedSpot& spot = host.home->spots.emplace_back();
  spot.stored.name = spot.thing.name = "my chair";
  EXPECT_EQ(answer({2, 0, service::Question::kWhichSpots, ""}).text, "You marked: my chair.");
  service::Ask rename{3, 0, service::Question::kRenameSpot, "my chair"};
  rename.name = "my seat";
  EXPECT_EQ(answer(rename).text, "It is called my seat now.");
  rename.name = "my desk";
  EXPECT_EQ(answer(rename).message_id, "spot.not_yours") << "it is the computer's";
  spot.stored.owner = "3";
  EXPECT_EQ(answer(rename).message_id, "teach.name") << "it is taken";
  rename.name = std::string(61, 'x');
  EXPECT_EQ(answer(rename).message_id, "spot.bad_name");
  EXPECT_EQ(answer({4, 0, service::Question::kInWords, "forget my chair"}).message_id,
            "own.forgotten");
  EXPECT_EQ(answer({5, 0, service::Question::kForgetSpot, "my desk"}).message_id, "spot.not_yours");
  EXPECT_THAT(host.erased, ElementsAre("my chair"));
}

TEST_F(DeviceTest, WhoIsInThePictureIsAnsweredByWhoLooksAtFrames) {
  const auto answer = [&](std::int64_t id, double t_ms, service::Question question) {
    ask(id, t_ms, question);
    EXPECT_THAT(wire->take<service::PromptMessage>(), IsEmpty()) << "not on the socket's thread";
    (void)device->work();
    return wire->take<service::PromptMessage>().front();
  };
  say(hello());
  EXPECT_EQ(answer(1, 1000, service::Question::kWhoIsHere).message_id, "device.no_picture");
  show(2000);
  (void)device->work();
  EXPECT_EQ(answer(2, 2100, service::Question::kWhoIsHere).message_id, "people.cannot");
  host.people.emplace();
  EXPECT_EQ(answer(3, 2100, service::Question::kWhoIsHere).text, "I see nobody in front of you.");
  host.people->push_back({guide::SeenPerson::Side::kLeft, 2.0});
  EXPECT_EQ(answer(4, 2100, service::Question::kWhoIsHere).message_id, "people.left_at");
  EXPECT_EQ(answer(5, 2100, service::Question::kIsItLight).message_id, "light.dark");
  EXPECT_EQ(answer(6, 9000, service::Question::kWhoIsHere).message_id, "device.no_new_picture");
}

TEST_F(DeviceTest, WithoutACameraNothingIsTaught) {
  say(hello(false));
  wire->texts.clear();
  ask(1, 100, service::Question::kTeachThing);
  EXPECT_EQ(wire->take<service::PromptMessage>().at(0).message_id, "teach.no_camera");
}

TEST_F(DeviceTest, WhoIsLedTalksToTheGuide) {
  guide::KnownThing bed;
  bed.name = "bed";
  bed.room = "bedroom";
  host.home->things = {bed};
  say(hello());
  say(service::Ask{1, 100, service::Question::kGuide, "", false, service::GuideWish::kPause});
  EXPECT_EQ(wire->take<service::PromptMessage>().at(0).message_id, "guide.not_running");
  ask(2, 200, service::Question::kTakeMeTo, "bed");
  const auto begun = wire->take<service::PromptMessage>();
  ASSERT_THAT(begun, SizeIs(1));
  EXPECT_EQ(begun[0].answer_to, 2);
  EXPECT_EQ(begun[0].message_id, "route.no_place");
  ask(3, 300, service::Question::kRepeat);
  EXPECT_EQ(wire->take<service::PromptMessage>().at(0).message_id, "route.no_place");
  say(service::Ask{4, 400, service::Question::kGuide, "", false, service::GuideWish::kEnd});
  EXPECT_EQ(wire->take<service::PromptMessage>().at(0).message_id, "guide.ended");
  ask(6, 450, service::Question::kRepeat);
  EXPECT_EQ(wire->take<service::PromptMessage>().at(0).message_id, "repeat.nothing");
  ask(5, 500, service::Question::kTakeMeTo, "piano");
  EXPECT_EQ(wire->take<service::PromptMessage>().at(0).message_id, "where.unknown");
}

TEST_F(DeviceTest, WhoAsksForWhatNobodyKnowsIsLedOnAsBefore) {
  guide::KnownThing bed;
  bed.name = "bed";
  bed.room = "bedroom";
  host.home->things = {bed};
  say(hello());
  ask(1, 100, service::Question::kTakeMeTo, "bed");
  ask(2, 200, service::Question::kTakeMeTo, "piano");
  EXPECT_EQ(wire->take<service::PromptMessage>().back().message_id, "where.unknown");
  ask(3, 300, service::Question::kTakeMeBack);
  EXPECT_EQ(wire->take<service::PromptMessage>().back().message_id, "spot.no_way_back");
  say(service::Ask{4, 400, service::Question::kGuide, "", false, service::GuideWish::kPause});
  EXPECT_EQ(wire->take<service::PromptMessage>().back().message_id, "guide.paused");
}

// ---- helpers who watch ----

class WatchedDeviceTest : public DeviceTest {
 protected:
  WatchedDeviceTest() {
    guide::KnownThing bed;
    bed.name = "bed";
    bed.room = "bedroom";
    host.home->things = {bed};
    host.watching = {{1, "Anna's laptop", service::Role::kHelper}};
    say(hello());
    host.walks_shown.clear();
    wire->texts.clear();
  }
  [[nodiscard]] std::vector<std::string> messages() {
    std::vector<std::string> all;
    for (const auto& prompt : wire->take<service::PromptMessage>())
      all.push_back(prompt.message_id);
    return all;
  }
};

TEST_F(WatchedDeviceTest, WhoSaysNothingOfItIsWatchedByNobody) {
  ask(1, 100, service::Question::kTakeMeTo, "bed");
  for (double t_ms = 200; t_ms < 6000; t_ms += 1000) {
    show(t_ms);
    device->work();
  }
  say(service::Ask{2, 6000, service::Question::kGuide, "", false, service::GuideWish::kEnd});
  ask(3, 6100, service::Question::kTakeMeTo, "bed");
  EXPECT_THAT(host.walks_shown, IsEmpty()) << "nor that they are led";
  EXPECT_THAT(messages(), ::testing::Not(::testing::Contains("watch.by")));
}

TEST_F(WatchedDeviceTest, WhoLetsHelpersWatchIsToldOfThemBeforeTheySeeAnything) {
  say(service::SettingsChange{{}, {}, {}, {}, true});
  ASSERT_THAT(host.walks_shown, SizeIs(1));
  EXPECT_TRUE(host.walks_shown[0].may_watch);
  EXPECT_FALSE(host.walks_shown[0].walk) << "nobody is led";
  ask(1, 100, service::Question::kTakeMeTo, "bed");
  ASSERT_THAT(host.walks_shown, SizeIs(2));
  const auto& walk = host.walks_shown[1].walk;
  ASSERT_TRUE(walk);
  EXPECT_EQ(walk->goal, "bed");
  EXPECT_EQ(walk->said.at(0).text, "I do not know where you stand. Turn slowly.");
  EXPECT_GE(host.walks_shown[1].t_ms, walk->said[0].t_ms);
  const auto prompts = wire->take<service::PromptMessage>();
  ASSERT_THAT(prompts, SizeIs(2));
  EXPECT_EQ(prompts[1].text, "Watching this walk: Anna's laptop.");
  EXPECT_EQ(prompts[1].priority, "notice");
  say(service::Ask{2, 400, service::Question::kGuide, "", false, service::GuideWish::kPause});
  ASSERT_THAT(host.walks_shown, SizeIs(3));
  EXPECT_EQ(host.walks_shown[2].walk->state, "paused");
  EXPECT_EQ(host.walks_shown[2].walk->said.back().text, "Paused.");
  EXPECT_THAT(messages(), ::testing::ElementsAre("guide.paused")) << "told once a walk";
  ask(3, 500, service::Question::kTakeMeTo, "bed");
  EXPECT_THAT(messages(), ::testing::Contains("watch.by")) << "of another walk";
}

TEST_F(WatchedDeviceTest, TheEndIsShownAndNothingAfterIt) {
  say(service::SettingsChange{{}, {}, {}, {}, true});
  ask(1, 100, service::Question::kTakeMeTo, "bed");
  host.walks_shown.clear();
  say(service::Ask{2, 400, service::Question::kGuide, "", false, service::GuideWish::kEnd});
  ASSERT_THAT(host.walks_shown, SizeIs(1));
  EXPECT_EQ(host.walks_shown[0].walk->state, "ended");
  ask(3, 500, service::Question::kWhereAmI);
  for (double t_ms = 600; t_ms < 6000; t_ms += 1000) {
    show(t_ms);
    device->work();
  }
  EXPECT_THAT(host.walks_shown, SizeIs(1));
}

TEST_F(WatchedDeviceTest, AWordEndsItAndAWordLetsThemWatchAgain) {
  say(service::SettingsChange{{}, {}, {}, {}, true});
  ask(1, 100, service::Question::kTakeMeTo, "bed");
  wire->texts.clear();
  host.walks_shown.clear();
  ask(2, 200, service::Question::kInWords, "hide my walk");
  EXPECT_THAT(messages(), ::testing::ElementsAre("watch.hidden"));
  ASSERT_THAT(host.walks_shown, SizeIs(1));
  EXPECT_FALSE(host.walks_shown[0].may_watch);
  EXPECT_FALSE(host.walks_shown[0].walk);
  say(service::Ask{3, 300, service::Question::kGuide, "", false, service::GuideWish::kPause});
  EXPECT_THAT(host.walks_shown, SizeIs(1));
  wire->texts.clear();
  ask(4, 400, service::Question::kShowWalks);
  EXPECT_THAT(messages(), ::testing::ElementsAre("watch.shown", "watch.by"));
  ASSERT_THAT(host.walks_shown, SizeIs(2));
  ASSERT_TRUE(host.walks_shown[1].walk);
  EXPECT_THAT(host.walks_shown[1].walk->said, IsEmpty()) << "what was said while they might not";
}

TEST_F(WatchedDeviceTest, AHelperWhoComesLaterSeesWhatIsAndThePersonIsTold) {
  say(service::SettingsChange{{}, {}, {}, {}, true});
  host.watching.clear();
  ask(1, 100, service::Question::kTakeMeTo, "bed");
  EXPECT_THAT(messages(), ::testing::ElementsAre("route.no_place"));
  const auto page_wire = std::make_shared<Wire>();
  Device page({1, "Anna's laptop", service::Role::kHelper}, page_wire, host);
  device->show_walk_to(page);
  EXPECT_THAT(messages(), ::testing::ElementsAre("watch.by"));
  const auto seen = page_wire->take<service::WatchedDevice>();
  ASSERT_THAT(seen, SizeIs(1));
  EXPECT_TRUE(seen[0].walk);
  say(service::Ask{2, 200, service::Question::kGuide, "", false, service::GuideWish::kEnd});
  device->show_walk_to(page);
  EXPECT_FALSE(page_wire->take<service::WatchedDevice>().at(0).walk) << "it is over";
}

TEST_F(WatchedDeviceTest, AWalkThatNobodySawIsShownToNobodyAfterItsEnd) {
  const auto walk_and_end = [&] {
    ask(1, 100, service::Question::kTakeMeTo, "bed");
    say(service::Ask{2, 200, service::Question::kGuide, "", false, service::GuideWish::kEnd});
  };
  const auto look_on = [&] {
    host.walks_shown.clear();
    wire->texts.clear();
    for (double t_ms = 300; t_ms < 3000; t_ms += 1000) {
      show(t_ms);
      device->work();
    }
    EXPECT_THAT(host.walks_shown, IsEmpty());
    EXPECT_THAT(messages(), ::testing::Not(::testing::Contains("watch.by")));
  };
  walk_and_end();
  say(service::SettingsChange{{}, {}, {}, {}, true});
  look_on();
  const auto watching = std::exchange(host.watching, {});
  walk_and_end();
  host.watching = watching;
  look_on();
}

TEST_F(WatchedDeviceTest, AllWhoWatchAreNamedWhenOneComesToThem) {
  say(service::SettingsChange{{}, {}, {}, {}, true});
  ask(1, 100, service::Question::kTakeMeTo, "bed");
  wire->texts.clear();
  host.watching.push_back({2, "Tom's tablet", service::Role::kHelper});
  say(service::Ask{2, 200, service::Question::kGuide, "", false, service::GuideWish::kPause});
  const auto prompts = wire->take<service::PromptMessage>();
  ASSERT_THAT(prompts, SizeIs(2));
  EXPECT_EQ(prompts[1].text, "Watching this walk: Anna's laptop and Tom's tablet.");
}

TEST_F(WatchedDeviceTest, WhoIsLedHearsThatASettingEndsIt) {
  say(service::SettingsChange{{}, {}, {}, {}, true});
  show(50);
  device->work();
  ask(1, 100, service::Question::kTakeMeTo, "bed");
  wire->texts.clear();
  say(service::SettingsChange{{}, {}, {}, {}, false});
  EXPECT_THAT(messages(), ::testing::ElementsAre("watch.hidden"));
  ASSERT_THAT(host.shown_less, SizeIs(1));
  ASSERT_TRUE(host.shown_less[0].seen);
  EXPECT_FALSE(host.shown_less[0].seen->position) << "helpers are told to forget where it was";
}

TEST_F(WatchedDeviceTest, AnOlderConnectionShowsNothingAnyMore) {
  say(service::SettingsChange{{}, {}, {}, {}, true});
  ask(1, 100, service::Question::kTakeMeTo, "bed");
  device->let_nobody_watch();
  const auto page_wire = std::make_shared<Wire>();
  Device page({1, "Anna's laptop", service::Role::kHelper}, page_wire, host);
  device->show_walk_to(page);
  EXPECT_THAT(page_wire->take<service::WatchedDevice>(), IsEmpty()) << "the newer one tells";
}

TEST_F(DeviceTest, OnlyHelpersMayWatch) {
  say(hello());
  wire->texts.clear();
  say(service::Watch{true});
  EXPECT_EQ(wire->take<service::ErrorMessage>().at(0).text, "only helpers may watch");
  EXPECT_FALSE(device->watches());
  EXPECT_THAT(host.began, IsEmpty());
  const auto page_wire = std::make_shared<Wire>();
  const auto page = std::make_shared<Device>(
      service::Identity{1, "Anna's laptop", service::Role::kHelper}, page_wire, host);
  page->on_text(write(service::DeviceMessage(hello(/*has_camera=*/false))));
  page->on_text(write(service::DeviceMessage(service::Watch{true})));
  EXPECT_TRUE(page->watches());
  EXPECT_THAT(host.began, SizeIs(1));
  page->on_text(write(service::DeviceMessage(service::Watch{false})));
  EXPECT_FALSE(page->watches());
}

TEST_F(DeviceTest, WhatAFrameHasToSayComesBeforeWhatItTold) {
  guide::KnownThing bed;
  bed.name = "bed";
  bed.room = "bedroom";
  host.home->things = {bed};
  say(hello());
  ask(1, 100, service::Question::kTakeMeTo, "bed");
  wire->texts.clear();
  // Nobody knows where it is: so it is told after a while.
  std::vector<std::string> types;
  for (double t_ms = 200; types.size() < 2 && t_ms < 30'000; t_ms += 1000) {
    show(t_ms);
    wire->texts.clear();
    device->work();
    types.clear();
    for (const std::string& text : wire->texts) {
      const auto message = service::read_home_message(text).value();
      types.push_back(std::holds_alternative<service::Seen>(message) ? "seen" : "prompt");
    }
  }
  EXPECT_THAT(types, ::testing::ElementsAre("prompt", "seen"));
}

// A device with depth before a wall.
class DeviceBeforeAWallTest : public DeviceTest {
 protected:
  DeviceBeforeAWallTest() {
    service::Hello with_depth = hello();
    const geometry::PinholeCamera camera{10, 10, 3.5, 2.5, 8, 6, {}, 1000};
    with_depth.camera = service::DeviceCamera{8, 6, camera, true};
    say(with_depth);
  }
  // How often a picture that shows the wall so far away is answered by a hazard.
  std::ptrdiff_t hazards(double t_ms, std::uint16_t distance_mm) {
    image::DepthImage wall(8, 6);
    for (int y = 0; y < 6; ++y) {
      for (int x = 0; x < 8; ++x) wall.at(x, y) = distance_mm;
    }
    const Bytes color = image::encode_jpeg(image::ColorImage(8, 6), 90);
    const Bytes depth = image::encode_png(wall);
    device->on_message(write(service::FrameMessage{t_ms, color, depth}));
    wire->texts.clear();
    device->work();
    return std::ranges::count(wire->take<service::PromptMessage>(), "hazard",
                              &service::PromptMessage::priority);
  }
};

// The guide does not know where they are, so it cannot judge what is in their way.
TEST_F(DeviceBeforeAWallTest, ItIsToldToWhoIsLedWithoutAPlace) {
  guide::KnownThing bed;
  bed.name = "bed";
  bed.room = "bedroom";
  host.home->things = {bed};
  EXPECT_EQ(hazards(1000, 800), 1);
  ask(1, 1100, service::Question::kTakeMeTo, "bed");
  EXPECT_EQ(hazards(1500, 800), 0) << "was just told to turn on the spot";
  EXPECT_EQ(hazards(20'000, 800), 0) << "was just told so once more";
  (void)hazards(39'500, 800);
  EXPECT_EQ(hazards(40'000, 800), 1) << "may walk again";
  say(service::Ask{2, 40'100, service::Question::kGuide, "", false, service::GuideWish::kEnd});
  EXPECT_EQ(hazards(40'500, 800), 1);
}

// Else it would break off every sentence; the queue of a device keeps out what was said just now.
TEST_F(DeviceBeforeAWallTest, ItIsToldNowAndThenAndWhenItComesNearer) {
  constexpr std::uint16_t kFar_mm = 4000;  // not ahead
  EXPECT_EQ(hazards(1000, 800), 1);
  EXPECT_EQ(hazards(2000, 800), 1) << "the first may have been lost";
  for (double t_ms = 3000; t_ms < 8000; t_ms += 500) EXPECT_EQ(hazards(t_ms, 800), 0) << t_ms;
  EXPECT_EQ(hazards(8000, 500), 1) << "nearer";
  for (double t_ms = 9600; t_ms < 20000; t_ms += 800) EXPECT_EQ(hazards(t_ms, 500), 0) << t_ms;
  EXPECT_EQ(hazards(20500, 500), 1) << "after a while";
  for (double t_ms = 21000; t_ms < 24000; t_ms += 500) EXPECT_EQ(hazards(t_ms, kFar_mm), 0);
  EXPECT_EQ(hazards(24000, 800), 1) << "was gone";
}

// A home whose pictures have places on its map, with free floor all around.
class DeviceWithPlacesTest : public DeviceTest {
 protected:
  DeviceWithPlacesTest() {
    const testing::ScratchFolder folder;
    ThreadPool pool(2);
    SilentProgress progress;
    StageClock clock;
    pipeline::RunContext run{pool, progress, clock};
    home::Home home = pipeline::create_home(folder / "a.home").value();
    const pipeline::Networks none;
    pipeline::testing::SyntheticWalk walk(kFrames);
    const geometry::PinholeCamera camera = walk.info().camera;
    EXPECT_OK(pipeline::map_recording(
        walk, {"walk", "made up", camera, walk.info().frames_remaining}, home, none, {}, run));
    LiveMap map;
    map.localizer = std::make_shared<const pipeline::HomeLocalizer>(
        pipeline::HomeLocalizer::create(home, {}, run).value());
    map.floor.emplace(Eigen::Vector2d(-6, -6), 0.05,
                      image::Image<fusion::FloorCell>(240, 240, fusion::FloorCell::kFree));
    host.home->map = std::make_shared<const LiveMap>(std::move(map));
    service::Hello with_camera = hello();
    with_camera.camera = service::DeviceCamera{camera.width, camera.height, camera, false};
    say(with_camera);
  }
  [[nodiscard]] static image::ColorImage picture() {
    pipeline::testing::SyntheticWalk walk(kFrames);
    walk.skip_before(21);
    return walk.next().value().value().color;
  }
  struct Told {
    std::optional<service::GoalBearing> bearing;
    std::optional<service::Seen> seen;
  };
  Told look_at(const image::ColorImage& color, double t_ms) {
    const Bytes jpeg = image::encode_jpeg(color, 95);
    device->on_message(write(service::FrameMessage{t_ms, jpeg, {}}));
    wire->texts.clear();
    device->work();
    Told told;
    for (const std::string& text : std::exchange(wire->texts, {})) {
      const auto message = service::read_home_message(text).value();
      if (const auto* bearing = std::get_if<service::GoalBearing>(&message)) {
        EXPECT_FALSE(told.seen) << "what was seen comes last";
        told.bearing = *bearing;
      }
      if (const auto* seen = std::get_if<service::Seen>(&message)) told.seen = *seen;
    }
    return told;
  }

  static constexpr int kFrames = 60;
};

TEST_F(DeviceWithPlacesTest, WhoIsLedAndCloseToItIsToldWhereTheGoalIsWithEachPictureThatHasAPlace) {
  const Told first = look_at(picture(), 1000);
  ASSERT_TRUE(first.seen && first.seen->position);
  EXPECT_FALSE(first.bearing) << "nobody is led";
  const service::SeenPosition& here = *first.seen->position;
  const double heading_rad = here.heading_degrees * guide::kDegree_rad;
  guide::KnownThing mug;
  mug.name = "mug";
  mug.probability = 0.99;
  mug.position_plan = Eigen::Vector3d(here.x_m + 1.2 * std::cos(heading_rad),
                                      here.y_m + 1.2 * std::sin(heading_rad), 1);
  mug.box_keyframe.size_m = {0.1, 0.1, 0.1};
  host.home->things = {mug};
  ask(1, 1100, service::Question::kTakeMeTo, "mug");
  double t_ms = 1200;
  Told told;
  for (; !told.bearing && t_ms < 20'000; t_ms += 400) told = look_at(picture(), t_ms);
  ASSERT_TRUE(told.bearing);
  EXPECT_EQ(told.bearing->t_ms, t_ms - 400);
  EXPECT_NEAR(told.bearing->distance_m, 1.15, 0.05);
  EXPECT_NEAR(told.bearing->bearing_degrees, 0, 5);
  told = look_at(image::ColorImage(picture().width(), picture().height()), t_ms);
  ASSERT_TRUE(told.seen && !told.seen->position);
  EXPECT_FALSE(told.bearing);
}

TEST_F(DeviceWithPlacesTest, RepeatSaysThatAPlaceWasMarkedAndMarksNoOther) {
  host.home->walks.emplace_back();
  (void)look_at(picture(), 1000);
  const auto answer = [&](double t_ms, service::Question question, std::string subject = "") {
    ask(1, t_ms, question, std::move(subject));
    return wire->take<service::PromptMessage>().back().text;
  };
  const std::string marked = answer(1100, service::Question::kMarkSpot, "my chair");
  EXPECT_EQ(marked, "My chair is marked here.");
  (void)look_at(picture(), 2000);
  EXPECT_EQ(answer(2100, service::Question::kRepeat), marked);
  EXPECT_EQ(answer(20'000, service::Question::kRepeat), "Earlier: " + marked);
  EXPECT_THAT(host.marked, ::testing::ElementsAre("my chair"));
}

TEST_F(DeviceWithPlacesTest, HelpersSeeWhereSomebodyIsOnlyWhereThatPersonSaysSo) {
  host.watching = {{1, "Anna's laptop", service::Role::kHelper}};
  ViewedSpot& spot = host.home->spots.emplace_back();
  spot.stored.name = spot.thing.name = "my chair";
  const Told here = look_at(picture(), 1000);
  ASSERT_TRUE(here.seen && here.seen->position);
  spot.thing.position_plan =
      Eigen::Vector3d(here.seen->position->x_m + 3, here.seen->position->y_m, 1);
  host.walks_shown.clear();
  ask(1, 1100, service::Question::kTakeMeTo, "my chair");
  (void)look_at(picture(), 1400);
  EXPECT_FALSE(device->seen().seen->position);
  say(service::SettingsChange{{}, {}, {}, {}, true});
  (void)look_at(picture(), 1800);
  ASSERT_TRUE(device->seen().seen->position);
  ask(2, 1900, service::Question::kTakeMeTo, "my chair");
  (void)look_at(picture(), 2200);
  say(service::Ask{3, 2300, service::Question::kGuide, "", false, service::GuideWish::kPause});
  const auto& walk = host.walks_shown.back().walk;
  ASSERT_TRUE(walk && walk->person);
  EXPECT_EQ(walk->goal, "my chair");
  EXPECT_NEAR(walk->person->x_m, here.seen->position->x_m, 0.05);
  EXPECT_NEAR(walk->person->heading_degrees, here.seen->position->heading_degrees, 3);
  ASSERT_GE(walk->way.size(), 2U);
  EXPECT_NEAR(walk->way.back().x(), spot.thing.position_plan->x(), 0.5);
  ASSERT_TRUE(walk->left_m);
  EXPECT_NEAR(*walk->left_m, 3, 0.5);
}

TEST_F(DeviceTest, AQuestionInWordsIsAnsweredAsByItsButton) {
  guide::KnownThing bed;
  bed.name = "bed";
  bed.room = "bedroom";
  bed.probability = 0.95;
  host.home->things = {bed};
  host.home->rooms = {{"bedroom", "bedroom"}};
  say(hello());
  const auto answers = [&](std::int64_t id, service::Question question,
                           const std::string& subject) {
    ask(id, 100, question, subject);
    const auto prompts = wire->take<service::PromptMessage>();
    EXPECT_FALSE(prompts.empty());
    for (const auto& prompt : prompts) EXPECT_EQ(prompt.answer_to, id);
    return prompts.empty() ? std::string() : prompts.front().text;
  };
  const std::string by_button = answers(1, service::Question::kWhereIs, "bed");
  EXPECT_EQ(by_button, "The bed is in the bedroom.");
  EXPECT_EQ(answers(2, service::Question::kInWords, "Where is my bed?"), by_button);
  EXPECT_EQ(answers(3, service::Question::kInWords, "say it again"), by_button);
  EXPECT_EQ(answers(4, service::Question::kInWords, "is the window open"), "I cannot tell that.");
  EXPECT_EQ(answers(5, service::Question::kInWords, "yes"), "I did not understand.");
  EXPECT_EQ(answers(6, service::Question::kInWords, "where is the bedrom"),
            "Did you mean the bedroom? Then answer yes.");
  EXPECT_EQ(answers(7, service::Question::kInWords, "yes"),
            "I do not know where you stand. Turn slowly.");
  EXPECT_EQ(answers(8, service::Question::kInWords, "yes"), "I did not understand.")
      << "that was answered";
}

TEST_F(DeviceTest, AnOfferOutlivesWhatIsNotUnderstoodAndANameLastsHalfAMinute) {
  host.home->rooms = {{"bedroom", "bedroom"}};
  say(hello());
  const auto message = [&](std::int64_t id, double t_ms, const std::string& text) {
    ask(id, t_ms, service::Question::kInWords, text);
    return wire->take<service::PromptMessage>().at(0).message_id;
  };
  EXPECT_EQ(message(1, 100, "where is the bedrom"), "ask.did_you_mean");
  EXPECT_EQ(message(2, 200, "hm let me think"), "ask.did_you_mean") << "what can be answered";
  EXPECT_EQ(message(3, 300, "yes"), "route.no_place");
  EXPECT_EQ(message(4, 400, "where is the bedrom"), "ask.did_you_mean");
  EXPECT_EQ(message(5, 500, "no"), "ask.all_right");
  EXPECT_EQ(message(6, 600, "yes"), "ask.not_understood") << "it was declined";
  EXPECT_EQ(message(7, 1'000, "where is the bedroom"), "route.no_place");
  EXPECT_NE(message(8, 31'000, "take me there"), "ask.not_understood");
  EXPECT_EQ(message(9, 61'001, "take me there"), "ask.not_understood");
}

TEST_F(DeviceTest, WhoNeedsHelpHearsThatNobodyIsCalledAndWhatHelps) {
  say(hello());
  const auto said = [&](std::int64_t id, const std::string& text) {
    ask(id, 100, service::Question::kInWords, text);
    std::vector<std::string> texts;
    for (const auto& prompt : wire->take<service::PromptMessage>()) texts.push_back(prompt.text);
    return texts;
  };
  EXPECT_THAT(said(1, "I fell"),
              ElementsAre("I cannot call anybody.", "Say: way out. Then I lead you out."));
  EXPECT_THAT(said(2, "help"),
              ElementsAre("I cannot call anybody.", "Say: way out. Then I lead you out.",
                          "Say: what can I ask. Then I give examples."));
}

TEST_F(DeviceTest, AYesAnswersAnOfferOnlyUntilAnythingElseIsAskedAndWhileItHolds) {
  host.home->rooms = {{"bedroom", "bedroom"}};
  say(hello());
  const auto message = [&](std::int64_t id, double t_ms, service::Question question,
                           const std::string& subject) {
    ask(id, t_ms, question, subject);
    return wire->take<service::PromptMessage>().at(0).message_id;
  };
  const auto offer = [&](std::int64_t id, double t_ms) {
    EXPECT_EQ(message(id, t_ms, service::Question::kInWords, "where is the bedrom"),
              "ask.did_you_mean");
  };
  offer(1, 100);
  EXPECT_EQ(message(2, 1000, service::Question::kInWords, "yes"), "route.no_place");
  offer(3, 2000);
  EXPECT_EQ(message(4, 3000, service::Question::kWhichRooms, ""), "rooms.count");
  EXPECT_EQ(message(5, 4000, service::Question::kInWords, "yes"), "ask.not_understood");
  offer(6, 5000);
  const double holds_ms = guide::kHomeValid_s * 1000;
  EXPECT_EQ(message(7, 5001 + holds_ms, service::Question::kInWords, "yes"), "ask.not_understood");
}

TEST_F(DeviceTest, WhoAsksInWordsToBeLedTalksToTheGuide) {
  guide::KnownThing bed;
  bed.name = "bed";
  bed.room = "bedroom";
  host.home->things = {bed};
  service::Hello german = hello();
  german.settings.language = "de";
  say(german);
  const auto message = [&](std::int64_t id, const std::string& words) {
    ask(id, 100, service::Question::kInWords, words);
    return wire->take<service::PromptMessage>().at(0).message_id;
  };
  EXPECT_EQ(message(1, "Pause"), "guide.not_running");
  EXPECT_EQ(message(2, "Bring mich bitte zum Bett"), "route.no_place");
  EXPECT_EQ(message(3, "warte kurz"), "guide.paused");
  EXPECT_EQ(message(4, "weiter"), "guide.resumed");
  EXPECT_EQ(message(5, "Schluss!"), "guide.ended");
}

TEST_F(DeviceTest, WhoIsLedTakesBackWhereTo) {
  for (const char* name : {"bed", "fridge", "sofa"}) {
    guide::KnownThing& thing = host.home->things.emplace_back();
    thing.name = name;
    thing.room = "bedroom";
  }
  say(hello());
  const auto message = [&](std::int64_t id, const std::string& words) {
    ask(id, 100, service::Question::kInWords, words);
    return wire->take<service::PromptMessage>().at(0).message_id;
  };
  EXPECT_EQ(message(1, "take me to the bed"), "route.no_place");
  EXPECT_EQ(message(2, "no, the sofa"), "route.no_place");
  EXPECT_EQ(host.answers.back(), service::Question::kTakeMeTo);
  EXPECT_EQ(message(3, "no, the frigde"), "ask.did_you_mean") << "a slip changes no goal";
  EXPECT_EQ(message(4, "the second one"), "ask.did_you_mean") << "there is none";
  EXPECT_EQ(message(5, "yes"), "route.no_place");
  EXPECT_EQ(host.answers.back(), service::Question::kTakeMeTo);
  EXPECT_EQ(message(6, "no"), "guide.paused");
  EXPECT_EQ(message(7, "cancel that"), "guide.ended");
}

TEST_F(DeviceTest, ThingsAreNamedInTheLanguageThatIsSpoken) {
  guide::KnownThing bed;
  bed.name = "bed";
  guide::KnownThing own;
  own.name = "Oma's chest";
  host.home->things = {bed, own};
  service::Hello german = hello();
  german.settings.language = "de-AT";
  say(german);
  EXPECT_THAT(wire->take<service::Welcome>()[0].things,
              ::testing::ElementsAre("Bett", "Oma's chest"));
  wire->texts.clear();
  service::SettingsChange english;
  english.language = "en";
  say(english);
  ASSERT_THAT(wire->texts, SizeIs(1));
  EXPECT_THAT(wire->texts.front(), ::testing::HasSubstr(R"("things":["Oma's chest","bed"])"));
  wire->texts.clear();
  say(english);  // nothing new
  EXPECT_THAT(wire->texts, IsEmpty());
}

TEST_F(DeviceTest, MustSayHelloFirst) {
  ask(1, 0, service::Question::kWhereAmI);
  EXPECT_THAT(wire->take<service::ErrorMessage>(), SizeIs(1));
  show(1);
  EXPECT_THAT(wire->take<service::ErrorMessage>(), SizeIs(1));
  EXPECT_EQ(host.asked_to_work, 0);
}

TEST_F(DeviceTest, OfAnotherVersionIsClosed) {
  service::Hello other = hello();
  other.version = 2;
  say(other);
  EXPECT_TRUE(wire->closed);
}

TEST_F(DeviceTest, EveryFrameIsAcknowledgedAndTheNewestLookedAt) {
  say(hello());
  wire->texts.clear();
  show(1);
  show(2);
  show(3);
  const auto arrived = wire->take<service::FrameArrived>();
  ASSERT_THAT(arrived, SizeIs(3));
  EXPECT_EQ(arrived[2].t_ms, 3);
  EXPECT_EQ(arrived[2].dropped, 2U);
  EXPECT_FALSE(device->work());  // nothing came meanwhile
  EXPECT_FALSE(device->work());  // nothing waits
  EXPECT_THAT(host.seen, ::testing::ElementsAre(3));
  EXPECT_EQ(device->dropped(), 2U);
}

TEST_F(DeviceTest, AQuestionWaitsForTheFrameInHand) {
  say(hello());
  show(1000);
  wire->texts.clear();
  ask(7, 1001, service::Question::kWhereAmI);
  EXPECT_THAT(wire->take<service::PromptMessage>(), IsEmpty());
  device->work();
  const auto prompts = wire->take<service::PromptMessage>();
  ASSERT_THAT(prompts, SizeIs(1));
  EXPECT_EQ(prompts[0].answer_to, 7);
  EXPECT_EQ(prompts[0].based_on_t_ms, 1000);
  EXPECT_EQ(prompts[0].message_id, "device.nothing_learned");
  EXPECT_EQ(prompts[0].text, "I have not learned any rooms yet.");
}

TEST_F(DeviceTest, AQuestionWithoutANewPictureIsAnsweredAtOnceAndSaysSo) {
  host.home->walks.emplace_back();
  say(hello());
  show(1000);
  device->work();
  wire->texts.clear();
  ask(8, 1000 + kMaxFrameAge_ms + 1, service::Question::kAroundMe);
  const auto prompts = wire->take<service::PromptMessage>();
  ASSERT_THAT(prompts, SizeIs(1));
  EXPECT_EQ(prompts[0].message_id, "device.no_new_picture");
  EXPECT_FALSE(prompts[0].based_on_t_ms);
  EXPECT_EQ(prompts[0].confidence, "unsure");
}

TEST_F(DeviceTest, WhereAThingIsNeedsNoPicture) {
  guide::KnownThing bed;
  bed.name = "bed";
  bed.probability = 0.99;
  bed.room = "bedroom";
  host.home->things = {bed};
  say(hello(/*has_camera=*/false));
  wire->texts.clear();
  ask(9, 0, service::Question::kWhereIs, "bed");
  const auto prompts = wire->take<service::PromptMessage>();
  ASSERT_THAT(prompts, SizeIs(1));
  EXPECT_EQ(prompts[0].text, "The bed is in the bedroom.");
}

TEST_F(DeviceTest, RepeatAsksTheLastQuestionAnew) {
  say(hello(/*has_camera=*/false));
  wire->texts.clear();
  ask(1, 0, service::Question::kRepeat);
  EXPECT_EQ(wire->take<service::PromptMessage>().at(0).message_id, "repeat.nothing");
  ask(2, 1, service::Question::kWhereIs, "bed");
  EXPECT_EQ(wire->take<service::PromptMessage>().at(0).message_id, "where.unknown");
  guide::KnownThing bed;
  bed.name = "bed";
  bed.probability = 0.99;
  bed.room = "bedroom";
  host.home->things = {bed};
  ask(3, 2, service::Question::kRepeat);
  const auto again = wire->take<service::PromptMessage>();
  ASSERT_THAT(again, SizeIs(1));
  EXPECT_EQ(again[0].answer_to, 3);
  EXPECT_EQ(again[0].message_id, "where.room");  // as it is now
}

TEST_F(DeviceTest, SpeaksTheLanguageThatIsWantedAndEnglishForOthers) {
  service::Hello german = hello(false);
  german.settings.language = "de-AT";
  say(german);
  wire->texts.clear();
  ask(1, 0, service::Question::kWhereIs, "Bett");
  EXPECT_EQ(wire->take<service::PromptMessage>().at(0).language, "de");
  say(service::SettingsChange{"tlh", {}, {}, {}});
  ask(2, 0, service::Question::kWhereIs, "bed");
  EXPECT_EQ(wire->take<service::PromptMessage>().at(0).language, "en");
}

TEST_F(DeviceTest, APictureThatCannotBeReadIsAnErrorAndAnswersWhatWaits) {
  say(hello());
  const Bytes junk{1, 2, 3};
  device->on_message(write(service::FrameMessage{5, junk, {}}));
  ask(4, 6, service::Question::kWhereAmI);
  wire->texts.clear();
  device->work();
  std::vector<std::string> texts = wire->texts;
  const auto errors = wire->take<service::ErrorMessage>();
  ASSERT_THAT(errors, SizeIs(1));
  EXPECT_EQ(errors[0].t_ms, 5) << "which frame it is about";
  wire->texts = std::move(texts);
  EXPECT_THAT(wire->take<service::PromptMessage>(), SizeIs(1));
}

TEST_F(DeviceTest, IsClosedAfterTooManyMessagesThatCannotBeRead) {
  say(hello());
  for (int i = 0; i < 9; ++i) device->on_text("nonsense");
  EXPECT_FALSE(wire->closed);
  device->on_text("nonsense");
  EXPECT_TRUE(wire->closed);
}

TEST_F(DeviceTest, HonestMistakesDoNotCloseItInALongLife) {
  say(hello());
  for (int i = 0; i < 30; ++i) {
    device->on_text("nonsense");
    say(service::Quiet{false});
    ask(i, 0, service::Question::kNameRoom, "kitchen");  // nothing is recorded
  }
  EXPECT_FALSE(wire->closed);
}

TEST_F(DeviceTest, AQuestionThatCannotBeReadIsRefusedByItsId) {
  say(hello());
  wire->texts.clear();
  device->on_text(R"({"type":"ask","id":8,"t":0,"question":"why"})");
  EXPECT_EQ(wire->take<service::ErrorMessage>().at(0).answer_to, 8);
}

TEST_F(DeviceTest, ASecondHelloChangesNothing) {
  say(hello(/*has_camera=*/false));
  say(hello());
  wire->texts.clear();
  show(1);
  EXPECT_THAT(wire->take<service::FrameArrived>(), IsEmpty());
}

TEST_F(DeviceTest, OfTooManyQuestionsTheOldestIsRefused) {
  say(hello());
  show(1);
  wire->texts.clear();
  for (int i = 0; i < 9; ++i) ask(i, 2, service::Question::kWhereAmI);
  const auto refused = wire->take<service::ErrorMessage>();
  ASSERT_THAT(refused, SizeIs(1));
  EXPECT_EQ(refused[0].answer_to, 0);
  device->work();
  EXPECT_THAT(wire->take<service::PromptMessage>(), SizeIs(8));
}

TEST_F(DeviceTest, ThatIsGoneIsNotWorkedFor) {
  say(hello());
  show(1);
  device->on_closed();
  EXPECT_FALSE(device->work());
  EXPECT_THAT(host.seen, IsEmpty());
  EXPECT_FALSE(device->is_here());
}

TEST_F(DeviceTest, RoomsAreNamedWhileAWalkIsRecorded) {
  say(hello());
  wire->texts.clear();
  ask(5, 0, service::Question::kNameRoom, "kitchen");
  const auto refused = wire->take<service::ErrorMessage>();
  ASSERT_THAT(refused, SizeIs(1));
  EXPECT_EQ(refused[0].answer_to, 5);

  const testing::ScratchFolder folder;
  const geometry::PinholeCamera pinhole{8, 8, 3.5, 2.5, 8, 6, {}, 1000};
  const auto recorder = WalkRecorder::begin(folder / "walk", {8, 6, pinhole, true}, 0);
  ASSERT_OK(recorder);
  host.recorder = *recorder;
  device->record_to(*recorder);
  ask(6, 1, service::Question::kNameRoom, "kitchen");
  const auto thanks = wire->take<service::PromptMessage>();
  ASSERT_THAT(thanks, SizeIs(1));
  EXPECT_EQ(thanks[0].message_id, "room.named");
  show(2);  // without depth: it is left out
  ASSERT_THAT(host.recordings, SizeIs(1));
  EXPECT_EQ(host.recordings[0].state, "recording");
  EXPECT_EQ(host.recordings[0].frames, 0U);
  const auto show_damaged = [&](double t_ms) {
    const Bytes color = image::encode_jpeg(image::ColorImage(8, 6), 90), depth{1, 2, 3};
    device->on_message(write(service::FrameMessage{t_ms, color, depth}));
  };
  show_damaged(3);
  ASSERT_THAT(host.recordings, SizeIs(2));
  EXPECT_EQ(host.recordings[1].state, "failed");
  EXPECT_EQ(host.recordings[1].device, 3);
  show_damaged(4);  // not again with every frame
  EXPECT_THAT(host.recordings, SizeIs(2));
  EXPECT_THAT(host.not_stored, SizeIs(1));
  ASSERT_OK((*recorder)->close());
  show(5);
  EXPECT_THAT(host.recordings, SizeIs(2)) << "whoever closed it told so";
  // What failed of one recording is told of the next one, too.
  device->record_to(WalkRecorder::begin(folder / "next", {8, 6, pinhole, true}, 0).value());
  show_damaged(6);
  EXPECT_THAT(host.recordings, SizeIs(3));
}

}  // namespace
}  // namespace roomwise::live
