#include "roomwise/live/home/live_home.h"

#include <gmock/gmock.h>
#include <zip.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <future>
#include <nlohmann/json.hpp>
#include <thread>

#include "roomwise/base/testing/full_disk.h"
#include "roomwise/guide/answers/spot_prompts.h"
#include "roomwise/image/codec.h"
#include "roomwise/live/home/home_backup.h"
#include "roomwise/live/routes/home_routes.h"
#include "roomwise/pipeline/edits/walk_edits.h"
#include "roomwise/pipeline/testing/synthetic_walk.h"
#include "roomwise/recording/tum_writer.h"

namespace roomwise::live {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;
using ::testing::StartsWith;

constexpr int kFrames = 60;

class WaitingWire final : public service::SocketOut {
 public:
  void send_text(std::string text) override {
    if (const auto now = std::exchange(on_send, {})) now();
    const std::scoped_lock lock(mutex_);
    texts_.push_back(std::move(text));
    came_.notify_all();
  }
  void close(std::string) override {}
  // The next message of the type that `fits`; waits for it.
  template <typename T>
  T next(const std::function<bool(const T&)>& fits = [](const T&) { return true; }) {
    std::unique_lock lock(mutex_);
    std::optional<T> found;
    const auto take = [&] {
      while (!found && !texts_.empty()) {
        const auto message = service::read_home_message(texts_.front());
        texts_.pop_front();
        if (!message || !std::holds_alternative<T>(*message)) continue;
        if (fits(std::get<T>(*message))) found = std::get<T>(*message);
      }
      return found.has_value();
    };
    if (!came_.wait_for(lock, std::chrono::minutes(2), take)) {
      throw std::runtime_error("the message did not come");
    }
    return *found;
  }

  // Of the messages that came and were not taken.
  template <typename T>
  [[nodiscard]] int count(const std::function<bool(const T&)>& fits = [](const T&) {
    return true;
  }) {
    const std::scoped_lock lock(mutex_);
    return static_cast<int>(std::ranges::count_if(texts_, [&](const std::string& text) {
      const auto message = service::read_home_message(text);
      return message && std::holds_alternative<T>(*message) && fits(std::get<T>(*message));
    }));
  }

  std::function<void()> on_send;  // called as the next message is sent, before it is kept

 private:
  std::mutex mutex_;
  std::condition_variable came_;
  std::deque<std::string> texts_;
};

// A home that is recorded, mapped, named and learned from the synthetic walk, over the interfaces
// that devices and the helper's page use.
class LiveHomeTest : public ::testing::Test {
 protected:
  LiveHomeTest() {
    networks.push_back(std::make_unique<pipeline::testing::ColorNetwork>(
        std::vector<std::string>{"studio couch", "lamp"}));
  }
  void open() {
    LiveHomeOptions options;
    options.work_places = work_places;
    options.clock = [this] {
      if (const auto now = on_clock.exchange(nullptr)) (*now)();
      return std::int64_t{0};
    };
    options.log = [this](std::string_view line) {
      if (on_log) on_log(line);
      const std::scoped_lock lock(log_mutex);
      logged.emplace_back(line);
    };
    auto opened = LiveHome::open(file, networks, finders, options);
    ASSERT_OK(opened);
    home = *std::move(opened);
  }
  // Whatever is closed next leaves the home as it is.
  void open_as_if_to_be_killed() {
    LiveHomeOptions options;
    options.erases_removed = false;
    home = LiveHome::open(file, networks, finders, options).value();
  }
  static Expected<home::EditId> take_first_walk_away(home::Home& home, const HomeView&,
                                                     const pipeline::EditAuthor& author) {
    return pipeline::take_walk_away(home, author, 1);
  }
  struct Client {
    std::shared_ptr<WaitingWire> wire = std::make_shared<WaitingWire>();
    std::unique_ptr<service::SocketSession> session;
  };
  Client connect(std::int64_t device, service::Role role) {
    Client client;
    client.session = home->connect({device, "client", role}, client.wire);
    service::Hello hello;
    hello.version = 1;
    hello.name = "client";
    hello.kind = service::DeviceKind::kWearable;
    const geometry::PinholeCamera camera = walk.info().camera;
    hello.camera = service::DeviceCamera{camera.width, camera.height, camera, true};
    client.session->on_text(write(service::DeviceMessage(hello)));
    return client;
  }
  static Bytes message_of(const image::RgbdFrame& frame) {
    const Bytes color = image::encode_jpeg(frame.color, 95);
    const Bytes depth = image::encode_png(frame.depth);
    return write(
        service::FrameMessage{static_cast<double>(frame.timestamp_ns) / 1e6, color, depth});
  }
  void record_the_walk() {
    const Client belt = connect(7, service::Role::kDevice);
    ASSERT_OK(home->begin_recording(7, "first walk"));
    record_the_rest(belt);
  }
  // Pictures in which there is nothing.
  void send_covered(const Client& belt) {
    for (int i = 1; i <= 3; ++i) {
      auto frame = pipeline::testing::SyntheticWalk(1).next().value().value();
      frame.timestamp_ns = i * 100'000'000;
      frame.color = image::ColorImage(frame.color.width(), frame.color.height());
      belt.session->on_message(message_of(frame));
    }
  }
  // To the end of the walk, and until all of it is mapped.
  void record_the_rest(const Client& belt, const std::string& message = "mapped") {
    while (auto frame = walk.next().value()) belt.session->on_message(message_of(*frame));
    ASSERT_OK(home->end_recording());
    home->jobs().wait();
    ASSERT_EQ(home->jobs().state()->state, "done") << home->jobs().state()->text;
    EXPECT_THAT(home->jobs().state()->text, HasSubstr(fmt::format("of {} pictures", kFrames)));
    EXPECT_EQ(home->jobs().state()->message, message);
    EXPECT_EQ(home->jobs().state()->values.at("pictures"), kFrames);
    belt.session->on_closed();
  }
  void learn_two_rooms() {
    ASSERT_OK(home->name_rooms(1, {{0, 29, "kitchen", 1}, {30, kFrames - 1, "bedroom", 1}}));
    ASSERT_OK(home->learn());
    home->jobs().wait();
    ASSERT_EQ(home->jobs().state()->state, "done") << home->jobs().state()->text;
    EXPECT_EQ(home->jobs().state()->message, "learned");
    EXPECT_EQ(home->jobs().state()->values.at("rooms"), 2);
  }
  // What needs one waits, as does making the map ready.
  [[nodiscard]] WorkPlaces::Place take_the_place() {
    return work_places->take(WorkPlaces::Urgency::kAnswersWait, SilentProgress()).value();
  }
  [[nodiscard]] std::string bytes_of_home() const {
    std::string all;
    for (const char* suffix : {"", "-wal"}) {
      std::ifstream in(file.string() + suffix, std::ios::binary);
      all.append(std::istreambuf_iterator<char>(in), {});
    }
    return all;
  }

  testing::ScratchFolder folder;
  std::filesystem::path file = folder / "flat.home";
  pipeline::testing::SyntheticWalk walk{kFrames};
  pipeline::Networks networks;
  objects::ObjectFinders finders;
  std::mutex log_mutex;
  std::vector<std::string> logged;
  std::function<void(std::string_view)> on_log;
  std::atomic<const std::function<void()>*> on_clock = nullptr;  // when it is next asked the time
  std::shared_ptr<WorkPlaces> work_places = std::make_shared<WorkPlaces>(1);
  std::unique_ptr<LiveHome> home;  // last: it logs to its end
};

TEST_F(LiveHomeTest, FromAnEmptyHomeToAnAnswer) {
  open();
  EXPECT_EQ(home->view()->name, "flat");
  record_the_walk();
  EXPECT_TRUE(std::filesystem::exists(folder / "flat.home.walks/first walk/rgb.txt"));
  ASSERT_THAT(home->view()->walks, SizeIs(1));
  EXPECT_TRUE(home->view()->walks[0].stored.finished);
  EXPECT_TRUE(calendar_time(home->view()->keyframes.front().keyframe.timestamp_ns).has_value())
      << "whatever the device's clock begins with, it is known of what day the walk is";
  ASSERT_TRUE(home->view()->map);
  EXPECT_GT(home->view()->map->clouds->fine.size(), 1000U);
  EXPECT_GT(home->view()->map->clouds->coarse.size(), 1000U);
  learn_two_rooms();
  ASSERT_TRUE(home->view()->recognizer);

  Client belt = connect(7, service::Role::kDevice);
  const auto welcome = belt.wire->next<service::Welcome>();
  EXPECT_TRUE(welcome.has_room_classifier);
  EXPECT_TRUE(welcome.can_localize);
  pipeline::testing::SyntheticWalk again(kFrames);
  const auto frame = again.next().value();
  belt.session->on_message(message_of(*frame));
  belt.session->on_text(write(service::DeviceMessage(service::Ask{
      1, static_cast<double>(frame->timestamp_ns) / 1e6, service::Question::kWhereAmI, ""})));
  const auto seen = belt.wire->next<service::Seen>();
  EXPECT_EQ(seen.room, "kitchen");
  ASSERT_TRUE(seen.position);  // the first camera's: the origin lies under it
  EXPECT_NEAR(seen.position->x_m, 0, 0.05);
  EXPECT_NEAR(seen.position->y_m, 0, 0.05);
  const auto prompt = belt.wire->next<service::PromptMessage>();
  EXPECT_EQ(prompt.answer_to, 1);
  EXPECT_THAT(prompt.message_id, ::testing::StartsWith("room."));
  belt.session->on_closed();

  // The helper's page: pictures, a test picture, what was recognised.
  EXPECT_OK(home->keyframe_picture(0));
  const auto tested = home->test_picture(image::encode_jpeg(frame->color, 95));
  ASSERT_OK(tested);
  EXPECT_EQ(tested->rooms[0].room, "kitchen");
  EXPECT_THAT(home->recognitions().newest_first(), SizeIs(1));

  // The home that is opened again is the same.
  home.reset();
  open();
  home->jobs().wait();
  EXPECT_TRUE(home->view()->map);
  EXPECT_TRUE(home->view()->recognizer);
}

TEST_F(LiveHomeTest, OpensThoughWhatItKnewOfPhonesLensesIsDamaged) {
  open();
  EXPECT_FALSE(home->why_lenses_are_new());
  home.reset();
  ASSERT_OK(write_file(file.string() + ".lenses.json", std::string_view("{\"lenses\": [{\"dev")));
  open();
  ASSERT_TRUE(home->why_lenses_are_new());
  EXPECT_THAT(*home->why_lenses_are_new(), HasSubstr("flat.home.lenses.json: is damaged"));
}

TEST_F(LiveHomeTest, RoomsAreRenamedAndWhatWasLearnedGoesOn) {
  open();
  record_the_walk();
  learn_two_rooms();
  home.reset();
  const auto rooms_of_visits = [&] {
    std::vector<std::string> rooms;
    const auto pictures = home::Home::open_read_only(file)->visit_pictures().value();
    for (const home::VisitPicture& picture : pictures) rooms.push_back(picture.room);
    return rooms;
  };
  {
    home::HomeChanges later;
    later.pictures.emplace();
    for (const std::string room : {"kitchen", "bedroom"}) {
      later.pictures->push_back({.picture_digest = room,
                                 .room = room,
                                 .network_fingerprint = networks[0]->fingerprint(),
                                 .features = std::vector<float>(12, 1)});
    }
    ASSERT_OK(home::Home::open(file)->apply_changes(later));
  }
  open();
  home->jobs().wait();  // until the map is ready
  ASSERT_TRUE(home->view()->recognizer) << home->view()->why_no_recognizer;
  ASSERT_OK(home->change_room("kitchen", "cook's corner", "kitchen"));
  EXPECT_EQ(home->view()->walks[0].labels.ranges()[0].room, "cook's corner");
  EXPECT_THAT(home->view()->recognizer->rooms(), Contains("cook's corner"));
  EXPECT_THAT(home->view()->recognizer->rooms(), Not(Contains("kitchen")));
  EXPECT_ERROR(home->change_room("kitchen", "x", {}), "no room 'kitchen'");
  EXPECT_ERROR(home->change_room("bedroom", "cook's corner", {}), "already");
  EXPECT_THAT(rooms_of_visits(), ::testing::ElementsAre("cook's corner", "bedroom"));

  ASSERT_OK(home->forget_room("bedroom"));
  EXPECT_THAT(home->view()->rooms, SizeIs(1));
  EXPECT_THAT(home->view()->walks[0].labels.ranges(), SizeIs(1));
  EXPECT_FALSE(home->view()->recognizer) << "it would tell of a room that is none";
  ASSERT_OK(home->undo(home->view()->edits.front().edit.id));
  EXPECT_TRUE(home->view()->recognizer) << "until the home is closed all can come back";
  EXPECT_THAT(rooms_of_visits(), ::testing::ElementsAre("cook's corner", "bedroom"));
  ASSERT_OK(home->forget_room("bedroom"));
  home.reset();
  EXPECT_THAT(rooms_of_visits(), IsEmpty());
}

TEST_F(LiveHomeTest, WhatIsForgottenDoesNotWaitForTheMapToBeReady) {
  open();
  record_the_walk();
  learn_two_rooms();
  home.reset();
  open();  // begins to make the map ready
  ASSERT_OK(home->forget_room("bedroom"));
  home->jobs().wait();
  EXPECT_TRUE(home->view()->map) << "that was gone on with";
  EXPECT_THAT(home->view()->rooms, SizeIs(1));
  home.reset();
  open();
  ASSERT_OK(home->forget_walk(1));
  home->jobs().wait();
  EXPECT_THAT(home->view()->walks, IsEmpty());
  EXPECT_FALSE(home->view()->map);
}

TEST_F(LiveHomeTest, AForgottenWalkLeavesNothingInTheFiles) {
  open();
  record_the_walk();
  learn_two_rooms();
  const Bytes picture = home->keyframe_picture(0).value();
  // From the middle of the picture: SQLite stores long values in pieces of a page.
  const std::string trace(picture.begin() + static_cast<std::ptrdiff_t>(picture.size() / 2),
                          picture.begin() + static_cast<std::ptrdiff_t>(picture.size() / 2) + 64);
  ASSERT_THAT(bytes_of_home(), HasSubstr(trace));
  ASSERT_OK(home->forget_walk(1));
  EXPECT_THAT(bytes_of_home(), Not(HasSubstr(trace)));
  EXPECT_THAT(home->view()->walks, IsEmpty());
  EXPECT_FALSE(home->view()->map);
  EXPECT_FALSE(home->view()->recognizer);
  EXPECT_FALSE(std::filesystem::exists(folder / "flat.home.walks/first walk"));
  EXPECT_THAT(home->view()->rooms, SizeIs(2));  // their names are not the walk's
  EXPECT_THAT(bytes_of_home(), HasSubstr("kitchen"));
  ASSERT_OK(home->forget_home());
  EXPECT_THAT(home->view()->rooms, IsEmpty());
}

TEST_F(LiveHomeTest, WhatIsForgottenAndNotErasedIsErasedWhenTheHomeIsOpened) {
  open();
  home.reset();
  ASSERT_OK(home::Home::open(file)->owe_erasing());  // as where the program was killed before
  open();
  EXPECT_FALSE(home::Home::open_read_only(file)->owes_erasing().value());
}

TEST_F(LiveHomeTest, AWalkThatIsTakenAwayComesBackUntilItIsErased) {
  open();
  record_the_walk();
  const Bytes picture = home->keyframe_picture(0).value();
  const std::string trace(picture.begin() + static_cast<std::ptrdiff_t>(picture.size() / 2),
                          picture.begin() + static_cast<std::ptrdiff_t>(picture.size() / 2) + 64);
  const home::EditId edit = home->edit("Anna", take_first_walk_away).value();
  EXPECT_ERROR(home->keyframe_picture(0), "is taken away");
  EXPECT_THAT(home->view()->walks_taken_away(), ::testing::ElementsAre(1));
  ASSERT_OK(home->undo(edit));
  ASSERT_OK(home->keyframe_picture(0));

  ASSERT_OK(home->edit("Anna", take_first_walk_away));
  ASSERT_THAT(bytes_of_home(), HasSubstr(trace)) << "it can come back";
  ASSERT_OK(home->erase_now());
  home->jobs().wait();
  EXPECT_THAT(bytes_of_home(), Not(HasSubstr(trace)));
  EXPECT_FALSE(std::filesystem::exists(folder / "flat.home.walks/first walk"));
  EXPECT_THAT(home->view()->walks, IsEmpty());
  EXPECT_THAT(home->view()->edits, IsEmpty());
}

TEST_F(LiveHomeTest, AWalkThatIsTakenAwayGoesWhenTheHomeIsClosedAndIsNotMappedAgain) {
  open();
  record_the_walk();
  ASSERT_OK(home->edit("Anna", take_first_walk_away));
  home.reset();
  EXPECT_FALSE(std::filesystem::exists(folder / "flat.home.walks/first walk"));
  open();
  home->jobs().wait();
  EXPECT_THAT(home->view()->walks, IsEmpty());
}

TEST_F(LiveHomeTest, WhatCanComeBackWaitsThoughTheProgramWasKilled) {
  open_as_if_to_be_killed();
  record_the_walk();
  learn_two_rooms();
  const home::EditId taken = home->edit("Anna", take_first_walk_away).value();
  ASSERT_OK(home->forget_room("kitchen"));
  home.reset();
  open();
  EXPECT_THAT(home->view()->walks_taken_away(), ::testing::ElementsAre(1));
  ASSERT_OK(home->undo(taken));
  EXPECT_OK(home->keyframe_picture(0));
  EXPECT_TRUE(std::filesystem::exists(folder / "flat.home.walks/first walk/rgb.txt"));
  home->jobs().wait();  // the map is made ready again
  ASSERT_OK(home->undo(home->view()->edits.front().edit.id));
  EXPECT_THAT(home->view()->rooms, SizeIs(2));
}

TEST_F(LiveHomeTest, ErasingAWalkThatAKillCutShortIsGoneOnWith) {
  open_as_if_to_be_killed();
  record_the_walk();
  ASSERT_OK(home->edit({}, take_first_walk_away));  // as erase_walk() begins
  home.reset();
  open();
  home->jobs().wait();
  EXPECT_FALSE(std::filesystem::exists(folder / "flat.home.walks/first walk"));
  EXPECT_THAT(home->view()->walks, IsEmpty());
  EXPECT_THAT(home->view()->edits, IsEmpty());
  EXPECT_FALSE(home->view()->owes_erasing);
}

TEST_F(LiveHomeTest, AWalkThatIsForgottenWhileTheHomeIsClosedIsNotMappedAgain) {
  open_as_if_to_be_killed();
  record_the_walk();
  ASSERT_OK(home->edit("Anna", take_first_walk_away));
  home.reset();
  EXPECT_TRUE(std::filesystem::exists(folder / "flat.home.walks/first walk"));
  {
    home::Home closed = home::Home::open(file).value();
    ASSERT_OK(pipeline::forget_taken_walks(closed));  // as by `roomwise edit forget`
    ASSERT_OK(closed.erase_removed());
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "flat.home.walks/first walk"));
  open();
  home->jobs().wait();
  EXPECT_THAT(home->view()->walks, IsEmpty());
}

TEST_F(LiveHomeTest, ErasingThatIsOwedIsDoneWithTheNextChange) {
  open();
  record_the_walk();
  ASSERT_OK(home->edit("Anna", [](home::Home& open, const HomeView&, const auto&) {
    return open.owe_erasing().map([] { return home::EditId{}; });
  }));
  EXPECT_FALSE(home->view()->owes_erasing) << "done with the change itself";
  EXPECT_FALSE(home::Home::open_read_only(folder / "flat.home")->owes_erasing().value());
}

TEST_F(LiveHomeTest, AFurtherWalkJoinsTheMapAndIsForgottenAlone) {
  open();
  record_the_walk();
  walk = pipeline::testing::SyntheticWalk(kFrames, 0.045, 0.2);
  const Client belt = connect(7, service::Role::kDevice);
  ASSERT_OK(home->begin_recording(7, "second walk"));
  record_the_rest(belt);
  ASSERT_THAT(home->view()->walks, SizeIs(2));
  EXPECT_TRUE(std::ranges::all_of(home->view()->keyframes, &ViewedKeyframe::on_map));
  ASSERT_OK(home->name_rooms(2, {{0, 29, "kitchen", 1}, {30, kFrames - 1, "bedroom", 1}}));
  ASSERT_OK(home->learn());
  home->jobs().wait();
  ASSERT_EQ(home->jobs().state()->state, "done") << home->jobs().state()->text;

  ASSERT_OK(home->forget_walk(1));
  home->jobs().wait();
  ASSERT_THAT(home->view()->walks, SizeIs(1));
  EXPECT_EQ(home->view()->walks[0].stored.recording.name, "second walk");
  EXPECT_TRUE(home->view()->map) << "of what is left";
  EXPECT_FALSE(std::filesystem::exists(folder / "flat.home.walks/first walk"));
  EXPECT_TRUE(std::filesystem::exists(folder / "flat.home.walks/second walk"));
}

TEST_F(LiveHomeTest, AFurtherWalkJoinsAMapOfWhichAPictureCannotBeReadAgain) {
  open();
  record_the_walk();
  home.reset();
  ASSERT_OK(home::Home::open(file)->database().run(
      "UPDATE keyframe_images SET color = x'00' WHERE keyframe_id = 0"));
  open();
  home->jobs().wait();
  walk = pipeline::testing::SyntheticWalk(kFrames, 0.045, 0.2);
  const Client belt = connect(7, service::Role::kDevice);
  ASSERT_OK(home->begin_recording(7, "second walk"));
  logged.clear();
  record_the_rest(belt, "mapped_damaged");
  EXPECT_EQ(home->jobs().state()->values.at("damaged"), 1);
  EXPECT_TRUE(std::ranges::all_of(home->view()->keyframes, &ViewedKeyframe::on_map));
  const std::scoped_lock lock(log_mutex);
  const auto names_it = [](const std::string& line) {
    return line.find("key-frame 0: ") != std::string::npos;
  };
  EXPECT_EQ(std::ranges::count_if(logged, names_it), 1) << "named once";
}

TEST_F(LiveHomeTest, OfThreeWalksAllAreForgottenWithTheHome) {
  open();
  record_the_walk();
  for (const std::string name : {"second walk", "third walk"}) {
    walk = pipeline::testing::SyntheticWalk(kFrames, 0.045, name == "third walk" ? 0.4 : 0.2);
    const Client belt = connect(7, service::Role::kDevice);
    ASSERT_OK(home->begin_recording(7, name));
    record_the_rest(belt);
  }
  ASSERT_THAT(home->view()->walks, SizeIs(3));
  home.reset();
  open();  // it is being made ready: forgetting stops that
  ASSERT_OK(home->forget_walk(2));
  ASSERT_THAT(home->view()->walks, SizeIs(2));
  ASSERT_OK(home->forget_home());
  home->jobs().wait();
  EXPECT_THAT(home->view()->walks, IsEmpty());
  EXPECT_THAT(home->view()->keyframes, IsEmpty());
  EXPECT_FALSE(std::filesystem::exists(folder / "flat.home.walks"));
}

TEST_F(LiveHomeTest, NobodyWaitsWhileWhatIsMissingIsWorkedOut) {
  open();
  record_the_walk();
  learn_two_rooms();
  const Bytes picture = home->keyframe_picture(0).value();
  home.reset();
  // It is damaged, and that is told while others ask.
  std::string bytes = bytes_of_home();
  const auto middle = picture.begin() + static_cast<std::ptrdiff_t>(picture.size() / 2);
  const std::size_t at = bytes.find(std::string(middle, middle + 64));
  ASSERT_NE(at, std::string::npos);
  bytes[at] = static_cast<char>(~bytes[at]);
  std::ofstream(file, std::ios::binary) << bytes;
  open();
  home->jobs().wait();
  std::optional<bool> must_others_wait;
  on_log = [&](std::string_view line) {
    if (!line.starts_with("what is missing failed")) return;
    const auto asked = std::async(std::launch::async, [&] { return home->coverage(); }).get();
    must_others_wait = asked && *asked == nullptr;
  };
  EXPECT_ERROR(home->coverage(), "is damaged");
  EXPECT_EQ(must_others_wait, true);
  home.reset();
}

TEST_F(LiveHomeTest, LearningNeedsAWalk) {
  open();
  EXPECT_ERROR(home->learn(), "holds no walk to learn from");
  EXPECT_FALSE(home->jobs().state()) << "nothing was begun";
}

TEST(OwnSightings, AreDueOnceTheyAreNewerThanWhatTheHomeHasAndThatIsOldEnough) {
  const std::map<home::OwnThingId, OwnSighting> sightings{
      {1, {100, {}, {}, 90}},  // seen since it was written, and that is long ago
      {2, {100, {}, {}, 95}},  // written a short while ago
      {3, {50, {}, {}, 50}},   // written as it is
      {4, {100, {}, {}, 0}}};  // never written
  const auto due = due_sightings(sightings, 90);
  EXPECT_THAT(due, ::testing::ElementsAre(::testing::Key(1), ::testing::Key(4)));
  EXPECT_THAT(due_sightings({}, 90), IsEmpty());
}

TEST(OwnSightings, NameNoRoomThatIsGone) {
  HomeView now;
  now.rooms = {{"galley", "kitchen"}, {"hall", "hall"}};
  const auto room_of = [&](std::optional<std::string> room) {
    return without_gone_room({100, std::move(room), Eigen::Vector3d(1, 2, 3), 0}, now).room;
  };
  EXPECT_EQ(room_of("galley"), "galley");
  EXPECT_EQ(room_of("kitchen"), std::nullopt) << "it is called galley now";
  EXPECT_EQ(room_of({}), std::nullopt);
  EXPECT_TRUE(without_gone_room({100, "kitchen", Eigen::Vector3d(1, 2, 3), 0}, now).place_plan)
      << "the place is what it was";
}

TEST_F(LiveHomeTest, EverythingThatIsForgottenLeavesNothingInTheFiles) {
  {
    home::Home made = pipeline::create_home(file, {}).value();
    ASSERT_OK(made.add_own_thing({.name = "my heirloom", .owner = "7", .is_shared = false},
                                 std::vector<objects::TaughtView>{{Bytes(99, 1), Bytes(9, 1)}}));
  }
  open();
  record_the_walk();
  ASSERT_OK(home->name_rooms(1, {{0, 29, "scullery", 1}, {30, kFrames - 1, "solarium", 1}}));
  ASSERT_OK(home->learn());
  home->jobs().wait();
  const auto depth_of_home = [&] {
    const auto images = home::Home::open_read_only(file)->images(0).value();
    const auto middle = images.depth.begin() + static_cast<std::ptrdiff_t>(images.depth.size() / 2);
    return std::string(middle, middle + 64);
  };
  const auto holds = [&](const std::string& trace) {
    return bytes_of_home().find(trace) != std::string::npos;
  };
  const std::string depth = depth_of_home();
  for (const std::string& trace :
       {depth, std::string("scullery"), std::string("solarium"), std::string("heirloom")}) {
    ASSERT_TRUE(holds(trace));
  }
  ASSERT_OK(home->forget_room("solarium"));
  home.reset();
  EXPECT_FALSE(holds("solarium")) << "once the home is closed";
  EXPECT_TRUE(holds("scullery"));
  open();
  home->jobs().wait();
  ASSERT_OK(home->forget_home());
  EXPECT_FALSE(holds("scullery"));
  EXPECT_FALSE(holds("heirloom"));
  EXPECT_FALSE(holds(depth));
  EXPECT_FALSE(holds("first walk"));
  EXPECT_FALSE(std::filesystem::exists(folder / "flat.home.walks"));
}

TEST_F(LiveHomeTest, OfARoomThatIsForgottenNoPictureIsKept) {
  open();
  record_the_walk();
  learn_two_rooms();
  const Client page = connect(1, service::Role::kHelper);
  const Client belt = connect(7, service::Role::kDevice);
  const auto look = [&] {
    belt.session->on_message(message_of(*pipeline::testing::SyntheticWalk(kFrames).next().value()));
    return page.wire
        ->next<service::DeviceSeen>([](const service::DeviceSeen& one) { return bool(one.seen); })
        .seen->room;
  };
  // While the change is made.
  const std::function<void()> meanwhile = [&] { EXPECT_EQ(look(), "kitchen"); };
  on_clock = &meanwhile;
  ASSERT_OK(home->forget_room("kitchen"));
  EXPECT_EQ(on_clock.load(), nullptr);
  EXPECT_THAT(home->recognitions().newest_first(), IsEmpty());
  belt.session->on_closed();
  page.session->on_closed();
}

TEST_F(LiveHomeTest, ThingsAreCorrectedAndRemoved) {
  open();
  record_the_walk();
  EXPECT_ERROR(home->rename_thing(99, "sofa"), "no thing 99");
  EXPECT_ERROR(home->forget_thing(99), "no thing 99");
  EXPECT_ERROR(home->rename_thing(0, ""), "empty");
}

TEST_F(LiveHomeTest, RecordingIsRefusedWhereItCouldNotBeMapped) {
  open();
  EXPECT_ERROR(home->begin_recording(7, "walk"), "not connected");
  const Client belt = connect(7, service::Role::kDevice);
  for (const char* name : {"../walk", "a/b", ".hidden", ""}) {
    EXPECT_FALSE(home->begin_recording(7, name)) << name;
  }
  EXPECT_ERROR(home->end_recording(), "nothing is being recorded");
  ASSERT_OK(home->begin_recording(7, "walk"));
  EXPECT_ERROR(home->begin_recording(7, "other"), "being recorded");
  EXPECT_ERROR(home->forget_home(), "being recorded");
  belt.session->on_closed();
}

// A device that is locked may wait for the list of devices: to tell helpers where it is.
TEST_F(LiveHomeTest, ARecordingBeginsWhileItsDeviceIsLocked) {
  open();
  record_the_walk();
  home.reset();
  const auto place = take_the_place();
  Client belt;
  std::thread device;
  std::promise<void> locked;
  bool has_begun = false;
  // Once the device has been found, making the map ready is stopped.
  on_log = [&](std::string_view line) {
    if (!line.starts_with("job prepare: stopped")) return;
    device = std::thread([&] {
      belt.wire->on_send = [&] {  // under the device's lock
        locked.set_value();
        const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(20);
        while (!has_begun && std::chrono::steady_clock::now() < until) {
          has_begun = std::filesystem::exists(folder / "flat.home.walks/second walk");
        }
      };
      service::SettingsChange german;
      german.language = "de";
      belt.session->on_text(write(service::DeviceMessage(german)));
    });
    locked.get_future().wait();
  };
  open();
  belt = connect(7, service::Role::kDevice);
  EXPECT_OK(home->begin_recording(7, "second walk"));
  device.join();
  EXPECT_TRUE(has_begun);
  belt.session->on_closed();
  home.reset();
}

// What was recorded when the computer died is in its folder, and a device that comes back goes on.
TEST_F(LiveHomeTest, ADeviceThatComesBackGoesOnRecording) {
  open();
  Client belt = connect(7, service::Role::kDevice);
  ASSERT_OK(home->begin_recording(7, "walk"));
  for (int i = 0; i < 3; ++i) belt.session->on_message(message_of(**walk.next()));
  const Client old = std::exchange(belt, connect(7, service::Role::kDevice));
  old.session->on_message(message_of(**walk.next()));  // was still on its way
  for (int i = 0; i < 2; ++i) {
    auto frame = **walk.next();
    frame.timestamp_ns = i * 1'000'000;  // its clock began anew
    belt.session->on_message(message_of(frame));
  }
  old.session->on_closed();
  belt.session->on_closed();
  // The same device with another camera: its frames would make a wrong map.
  Client other{std::make_shared<WaitingWire>(), nullptr};
  other.session = home->connect({7, "client", service::Role::kDevice}, other.wire);
  service::Hello hello;
  hello.version = 1;
  geometry::PinholeCamera camera = walk.info().camera;
  camera.fx += 20;
  hello.camera = service::DeviceCamera{camera.width, camera.height, camera, true};
  other.session->on_text(write(service::DeviceMessage(hello)));
  const auto told = other.wire->next<service::RecordingState>();
  EXPECT_EQ(told.state, "failed");
  EXPECT_THAT(told.text, HasSubstr("another camera"));
  other.session->on_message(message_of(**walk.next()));
  other.session->on_closed();
  home.reset();
  std::ifstream list(folder / "flat.home.walks/walk/rgb.txt");
  const std::string text{std::istreambuf_iterator<char>(list), {}};
  EXPECT_EQ(std::ranges::count(text, '\n') - std::ranges::count(text, '#'), 5) << text;
}

// The computer stopped while a walk was recorded, and nobody ended the recording.
TEST_F(LiveHomeTest, AWalkThatWasRecordedAndNotMappedIsMappedAtTheNextStart) {
  open();
  Client belt = connect(7, service::Role::kDevice);
  ASSERT_OK(home->begin_recording(7, "walk"));
  while (auto frame = walk.next().value()) belt.session->on_message(message_of(*frame));
  home.reset();
  open();
  home->jobs().wait();
  EXPECT_EQ(home->jobs().state()->state, "done") << home->jobs().state()->text;
  EXPECT_THAT(home->view()->walks, SizeIs(1));
}

TEST_F(LiveHomeTest, TheWalksOfAHomeThatWasRestoredAreItsOwn) {
  open();
  record_the_walk();
  home.reset();
  ASSERT_OK(back_up(home::Home::open_read_only(file).value(), folder / "backup"));
  ASSERT_OK(restore(folder / "backup", folder / "house.home"));
  for (const std::string name : {"./flat.home", "house.home"}) {
    file = folder / name;
    open();
    home->jobs().wait();
    EXPECT_EQ(home->jobs().state()->kind, "prepare") << name << ": nothing is mapped again";
    EXPECT_THAT(home->view()->walks, SizeIs(1));
    home.reset();
  }
  open();
  ASSERT_OK(home->forget_walk(1));
  EXPECT_FALSE(std::filesystem::exists(folder / "house.home.walks/first walk"));
  EXPECT_TRUE(std::filesystem::exists(folder / "flat.home.walks/first walk"));
}

TEST_F(LiveHomeTest, AWalkWhosePicturesWereRemovedLendsItsNameToNoOther) {
  open();
  record_the_walk();
  std::filesystem::remove_all(folder / "flat.home.walks");
  const Client belt = connect(7, service::Role::kDevice);
  EXPECT_ERROR(home->begin_recording(7, "first walk"), "knows a walk 'first walk' already");
}

TEST_F(LiveHomeTest, AWalkThatCannotBeMappedKeepsBackNoOther) {
  const auto walks = folder / "flat.home.walks";
  std::filesystem::create_directory(walks);
  const auto store = [&](const std::string& name, bool is_covered) {
    auto writer = recording::TumWriter::create(walks / name, walk.info().camera).value();
    pipeline::testing::SyntheticWalk frames(kFrames);
    while (auto frame = frames.next().value()) {
      if (is_covered) frame->color = image::ColorImage(frame->color.width(), frame->color.height());
      ASSERT_OK(writer->write(*frame));
    }
    ASSERT_OK(writer->close());
  };
  store("older", false);
  store("newer", true);
  std::filesystem::last_write_time(
      walks / "older/rgb.txt",
      std::filesystem::last_write_time(walks / "newer/rgb.txt") - std::chrono::hours(1));
  open();
  home->jobs().wait();
  EXPECT_EQ(home->jobs().state()->state, "failed");
  EXPECT_THAT(home->jobs().state()->text, HasSubstr("newer: no frame has enough features"));
  ASSERT_THAT(home->view()->walks, SizeIs(1));
  EXPECT_EQ(home->view()->walks[0].stored.recording.name, "older");
  EXPECT_TRUE(home->view()->map);
  EXPECT_TRUE(home->walk_waits());
}

TEST_F(LiveHomeTest, AWalkIsMappedWhileItIsRecorded) {
  open();
  const Client page = connect(1, service::Role::kHelper);
  const Client belt = connect(7, service::Role::kDevice);
  ASSERT_OK(home->begin_recording(7, "walk"));
  for (int i = 0; i < kFrames - 5; ++i) belt.session->on_message(message_of(**walk.next()));
  // Its first key-frames are there before its last frame is.
  const auto mapped = page.wire->next<service::JobState>([](const service::JobState& job) {
    return job.stage == "mapping" && job.text.find("key-frames") != std::string::npos;
  });
  EXPECT_EQ(mapped.kind, "map");
  EXPECT_EQ(mapped.state, "running");
  EXPECT_ERROR(home->learn(), "busy");
  record_the_rest(belt);
}

TEST_F(LiveHomeTest, WhatCannotBeDoneInsteadOfMakingTheMapReadyHasThatGoneOnWith) {
  open();
  record_the_walk();
  home.reset();
  {
    const auto place = take_the_place();
    open();
    const auto expect_gone_on_with = [&] {
      EXPECT_TRUE(home->jobs().running());
      EXPECT_EQ(home->jobs().state()->kind, "prepare");
    };
    const Client belt = connect(7, service::Role::kDevice);
    EXPECT_ERROR(home->begin_recording(7, "first walk"), "already");
    expect_gone_on_with();
    EXPECT_ERROR(home->go_on_mapping(), "no walk waits");
    expect_gone_on_with();
    belt.session->on_closed();
    ASSERT_OK(home->learn());
  }
  home->jobs().wait();
  EXPECT_EQ(home->jobs().state()->message, "no_room_named");
  ASSERT_TRUE(home->view()->map);
  EXPECT_TRUE(home->view()->map->clouds);
}

TEST_F(LiveHomeTest, AWalkThatCannotBeMappedLeavesTheMapThatIsThere) {
  open();
  record_the_walk();
  const Client belt = connect(7, service::Role::kDevice);
  ASSERT_OK(home->begin_recording(7, "covered"));
  send_covered(belt);
  ASSERT_OK(home->end_recording());
  home->jobs().wait();
  EXPECT_EQ(home->jobs().state()->state, "failed");
  EXPECT_THAT(home->jobs().state()->text, HasSubstr("is the lens covered"));
  EXPECT_THAT(home->view()->walks, SizeIs(1));
  ASSERT_TRUE(home->view()->map);
  EXPECT_TRUE(home->view()->map->clouds);
  belt.session->on_closed();
}

// What was stopped is gone on with when the recording ends, or at the next start.
TEST_F(LiveHomeTest, AMapThatWasStoppedWhileItIsRecordedIsGoneOnWith) {
  open();
  Client belt = connect(7, service::Role::kDevice);
  ASSERT_OK(home->begin_recording(7, "walk"));
  for (int i = 0; i < kFrames / 2; ++i) belt.session->on_message(message_of(**walk.next()));
  EXPECT_TRUE(home->jobs().stop());
  home->jobs().wait();
  EXPECT_EQ(home->jobs().state()->state, "stopped");
  EXPECT_ERROR(home->go_on_mapping(), "'walk' is being recorded");
  record_the_rest(belt);
  EXPECT_FALSE(home->walk_waits());
  EXPECT_ERROR(home->go_on_mapping(), "no walk waits");
}

TEST_F(LiveHomeTest, AWalkWhoseMappingFailsWhileItIsRecordedIsMappedAtItsEnd) {
  open();
  const auto camera = folder / "flat.home.walks/walk/camera.txt";
  const auto aside = folder / "camera.txt";
  std::promise<void> failed, has_ended;
  std::atomic<bool> has_begun = false;
  on_log = [&](std::string_view line) {
    if (line.starts_with("job map: begun") && !has_begun.exchange(true)) {
      std::filesystem::rename(camera, aside);
    }
    if (!line.starts_with("job map: failed")) return;
    std::filesystem::rename(aside, camera);
    failed.set_value();
    has_ended.get_future().wait();
  };
  const Client belt = connect(7, service::Role::kDevice);
  ASSERT_OK(home->begin_recording(7, "walk"));
  belt.session->on_message(message_of(**walk.next()));  // which mapping waits for
  failed.get_future().wait();
  while (auto frame = walk.next().value()) belt.session->on_message(message_of(*frame));
  EXPECT_OK(home->end_recording()) << "the job is not over yet";
  has_ended.set_value();
  home->jobs().wait();
  EXPECT_EQ(home->jobs().state()->message, "mapped") << home->jobs().state()->text;
  EXPECT_THAT(home->view()->walks, SizeIs(1));
  belt.session->on_closed();
  home.reset();
}

TEST_F(LiveHomeTest, NamesOfRoomsThatCannotBeReadCostNoWalk) {
  open();
  const Client belt = connect(7, service::Role::kDevice);
  ASSERT_OK(home->begin_recording(7, "walk"));
  ASSERT_OK(write_file(folder / "flat.home.walks/walk/rooms.txt", std::string_view("nonsense")));
  while (auto frame = walk.next().value()) belt.session->on_message(message_of(*frame));
  ASSERT_OK(home->end_recording());
  home->jobs().wait();
  EXPECT_EQ(home->jobs().state()->state, "failed");
  EXPECT_THAT(home->jobs().state()->text, HasSubstr("rooms.txt"));
  ASSERT_THAT(home->view()->walks, SizeIs(1));
  EXPECT_TRUE(home->view()->walks[0].stored.finished);
  EXPECT_TRUE(home->view()->map);
  belt.session->on_closed();
}

TEST_F(LiveHomeTest, WhatPeopleNamedBeforeAWalkWasMappedToItsEndStays) {
  open();
  const Client page = connect(1, service::Role::kHelper);
  const Client belt = connect(7, service::Role::kDevice);
  ASSERT_OK(home->begin_recording(7, "walk"));
  belt.session->on_text(
      write(service::DeviceMessage(service::Ask{1, 0, service::Question::kNameRoom, "kitchen"})));
  for (int i = 0; i < kFrames - 5; ++i) belt.session->on_message(message_of(**walk.next()));
  page.wire->next<service::JobState>([](const service::JobState& job) {
    return job.stage == "mapping" && job.text.find("key-frames") != std::string::npos;
  });
  ASSERT_TRUE(home->jobs().stop());
  home->jobs().wait();
  ASSERT_OK(home->name_rooms(1, {{0, 9, "parlour", 1}}));
  record_the_rest(belt);
  ASSERT_THAT(home->view()->walks[0].labels.ranges(), SizeIs(1));
  EXPECT_EQ(home->view()->walks[0].labels.ranges()[0].room, "parlour");
}

// A phone's browser knows how it moved; mapping takes it, though the walk is mapped as it comes.
TEST_F(LiveHomeTest, WhatADeviceTellsOfItsMotionReachesTheMap) {
  open();
  const Client phone = connect(7, service::Role::kDevice);
  ASSERT_OK(home->begin_recording(7, "walk"));
  for (int i = 0; auto frame = walk.next().value(); ++i) {
    const Bytes color = image::encode_jpeg(frame->color, 95);
    const Bytes depth = image::encode_png(frame->depth);
    service::FrameMessage message{static_cast<double>(frame->timestamp_ns) / 1e6, color, depth};
    message.camera = walk.info().camera;
    message.pose = service::FramePose{"webxr", {walk.world_from_camera(i)}};
    phone.session->on_message(write(message));
  }
  ASSERT_OK(home->end_recording());
  home->jobs().wait();
  ASSERT_EQ(home->jobs().state()->state, "done") << home->jobs().state()->text;
  const auto frames = home::Home::open_read_only(file)->frames(1).value();
  ASSERT_THAT(frames, SizeIs(kFrames));
  EXPECT_TRUE(std::ranges::all_of(frames, [](const home::Frame& frame) {
    return frame.motion && frame.motion->use == scene::MotionUse::kTaken;
  }));
}

TEST_F(LiveHomeTest, OnlyWhoIsRecordedOrAHelperNamesTheWalksRooms) {
  open();
  const Client page = connect(1, service::Role::kHelper);
  const Client belt = connect(7, service::Role::kDevice);
  const Client other = connect(8, service::Role::kDevice);
  ASSERT_OK(home->begin_recording(7, "walk"));
  const std::string kitchen =
      write(service::DeviceMessage(service::Ask{1, 0, service::Question::kNameRoom, "kitchen"}));
  other.session->on_text(kitchen);
  EXPECT_THAT(other.wire->next<service::ErrorMessage>().text, HasSubstr("another device's walk"));
  for (const Client* client : {&page, &belt}) {
    client->session->on_text(kitchen);
    EXPECT_EQ(client->wire->next<service::PromptMessage>().message_id, "room.named");
  }
  for (const Client* client : {&page, &belt, &other}) client->session->on_closed();
}

TEST_F(LiveHomeTest, TheWearerIsToldOfTheRecording) {
  open();
  Client belt = connect(7, service::Role::kDevice);
  const Client other = connect(8, service::Role::kDevice);
  ASSERT_OK(home->begin_recording(7, "walk"));
  belt.session->on_message(message_of(**walk.next()));
  EXPECT_EQ(belt.wire->next<service::RecordingState>().state, "none") << "when it came";
  const auto begun = belt.wire->next<service::RecordingState>();
  EXPECT_EQ(begun.state, "recording");
  EXPECT_EQ(begun.device, 7);
  EXPECT_EQ(belt.wire->next<service::RecordingState>().frames, 1) << "the picture is stored";
  ASSERT_OK(home->end_recording());
  EXPECT_EQ(belt.wire->next<service::RecordingState>().state, "saved");
  EXPECT_EQ(other.wire->count<service::Welcome>(), 1);
  EXPECT_EQ(other.wire->count<service::RecordingState>(
                [](const service::RecordingState& one) { return one.device != 8; }),
            0)
      << "it is nobody else's business";
  other.session->on_closed();
  belt.session->on_closed();
}

TEST_F(LiveHomeTest, NothingIsToldOfARecordingAfterItsEnd) {
  open();
  const Client belt = connect(7, service::Role::kDevice);
  EXPECT_EQ(belt.wire->next<service::RecordingState>().state, "none");
  ASSERT_OK(home->begin_recording(7, "walk"));
  // It ends while a frame that cannot be stored is in hand.
  std::atomic<bool> has_ended = false;
  on_log = [&](std::string_view) {
    if (has_ended.exchange(true)) return;
    EXPECT_OK(home->end_recording());
  };
  EXPECT_EQ(belt.wire->next<service::RecordingState>().state, "recording");
  image::RgbdFrame frame = walk.next().value().value();
  const Bytes color = image::encode_jpeg(frame.color, 95), damaged{1, 2, 3};
  belt.session->on_message(write(service::FrameMessage{1, color, damaged}));
  EXPECT_TRUE(has_ended);
  EXPECT_EQ(belt.wire->next<service::RecordingState>().state, "empty");
  EXPECT_EQ(belt.wire->count<service::RecordingState>(), 0);
  belt.session->on_closed();
  home.reset();
}

// Over a slow link a device sends pictures without depth until it hears that it is recorded.
TEST_F(LiveHomeTest, ARecordingIsToldAsItBeginsAndOneWithoutFramesIsNone) {
  open();
  const Client belt = connect(7, service::Role::kDevice);
  EXPECT_EQ(belt.wire->next<service::RecordingState>().state, "none");
  ASSERT_OK(home->begin_recording(7, "walk"));
  const auto begun = belt.wire->next<service::RecordingState>();
  EXPECT_EQ(begun.state, "recording");
  EXPECT_EQ(begun.name, "walk");
  const Bytes color = image::encode_jpeg(walk.next().value().value().color, 95);
  belt.session->on_message(write(service::FrameMessage{1, color, {}}));
  EXPECT_EQ(belt.wire->next<service::RecordingState>().state, "recording");
  ASSERT_OK(home->end_recording());
  const auto ended = belt.wire->next<service::RecordingState>();
  EXPECT_EQ(ended.state, "empty");
  EXPECT_EQ(ended.frames, 0U);
  EXPECT_EQ(ended.text, "1 frames had no depth and were left out");
  home->jobs().wait();
  EXPECT_EQ(home->jobs().state()->state, "done") << home->jobs().state()->text;
  EXPECT_FALSE(home->walk_waits()) << "there is nothing to be mapped at the next start";
  EXPECT_THAT(home->view()->walks, IsEmpty());
  belt.session->on_closed();
}

// It may have ended, or begun, while a device was away.
TEST_F(LiveHomeTest, WhoComesIsToldWhatIsRecorded) {
  open();
  const auto told = [this](std::int64_t device, service::Role role) {
    const Client client = connect(device, role);
    std::vector<std::string> states;
    while (client.wire->count<service::RecordingState>() > 0) {
      const auto state = client.wire->next<service::RecordingState>();
      states.push_back(fmt::format("{} {} {}", state.device, state.state, state.name));
    }
    client.session->on_closed();
    return states;
  };
  const Client belt = connect(7, service::Role::kDevice);
  EXPECT_THAT(told(1, service::Role::kHelper), ElementsAre("1 none "));
  ASSERT_OK(home->begin_recording(7, "walk"));
  EXPECT_THAT(told(7, service::Role::kDevice), ElementsAre("7 recording walk"));
  EXPECT_THAT(told(8, service::Role::kDevice), ElementsAre("8 none "));
  EXPECT_THAT(told(1, service::Role::kHelper), ElementsAre("1 none ", "7 recording walk"));
  ASSERT_OK(home->end_recording());
  EXPECT_THAT(told(7, service::Role::kDevice), ElementsAre("7 none "));
  belt.session->on_closed();
}

TEST_F(LiveHomeTest, HelpersAreToldOfJobsAndDevices) {
  open();
  const Client page = connect(1, service::Role::kHelper);
  Client belt = connect(7, service::Role::kDevice);
  const auto came = page.wire->next<service::DeviceSeen>(
      [](const service::DeviceSeen& one) { return one.device == 7; });
  EXPECT_TRUE(came.online);
  ASSERT_OK(home->begin_recording(7, "walk"));
  while (auto frame = walk.next().value()) belt.session->on_message(message_of(*frame));
  const auto recording = [](const char* state) {
    return [state](const service::RecordingState& one) { return one.state == state; };
  };
  EXPECT_EQ(page.wire->next<service::RecordingState>(recording("recording")).device, 7);
  ASSERT_OK(home->end_recording());
  EXPECT_EQ(page.wire->next<service::RecordingState>(recording("saved")).device, 7);
  home->jobs().wait();
  const auto done = page.wire->next<service::JobState>(
      [](const service::JobState& job) { return job.state != "running"; });
  EXPECT_EQ(done.state, "done") << done.text;
  EXPECT_EQ(belt.wire->count<service::JobState>(), 0) << "helpers alone";
  EXPECT_EQ(belt.wire->count<service::DeviceSeen>(), 0) << "where others are is not for devices";
  belt.session->on_closed();
  EXPECT_FALSE(page.wire
                   ->next<service::DeviceSeen>([](const service::DeviceSeen& one) {
                     return one.device == 7 && !one.online;
                   })
                   .online);
}

TEST_F(LiveHomeTest, HelpersWhoWatchAndNobodyElseSeeAWalkWhosePersonLetsThem) {
  open();
  record_the_walk();
  const Client belt = connect(7, service::Role::kDevice);
  const Client page = connect(1, service::Role::kHelper);
  const Client reader = connect(2, service::Role::kHelper);  // who looks at other things
  const auto tell = [](const Client& client, const service::DeviceMessage& message) {
    client.session->on_text(write(message));
  };
  double t_ms = 0;
  const auto look = [&] {  // until all that comes of the picture was sent
    const auto frame = pipeline::testing::SyntheticWalk(kFrames).next().value();
    const Bytes color = image::encode_jpeg(frame->color, 95);
    const Bytes depth = image::encode_png(frame->depth);
    belt.session->on_message(write(service::FrameMessage{t_ms += 400, color, depth}));
    (void)belt.wire->next<service::Seen>(
        [&](const service::Seen& seen) { return seen.t_ms == t_ms; });
  };
  tell(page, service::Watch{true});
  const auto is_of_belt = [](const service::WatchedDevice& one) { return one.device == 7; };
  EXPECT_FALSE(page.wire->next<service::WatchedDevice>(is_of_belt).may_watch);
  look();
  tell(belt, service::Ask{1, t_ms, service::Question::kMarkSpot, "my chair"});
  tell(belt, service::Ask{2, t_ms, service::Question::kTakeMeTo, "my chair"});
  for (int i = 0; i < 5; ++i) look();
  EXPECT_FALSE(page.wire
                   ->next<service::DeviceSeen>([](const service::DeviceSeen& one) {
                     return one.device == 7 && one.seen && one.seen->t_ms == 400;
                   })
                   .seen->position);
  EXPECT_EQ(page.wire->count<service::WatchedDevice>(is_of_belt), 0);

  tell(belt, service::SettingsChange{{}, {}, {}, {}, true});
  EXPECT_TRUE(page.wire->next<service::WatchedDevice>(is_of_belt).may_watch);
  t_ms += 60'000;  // nobody knows where they are now: they are led, and not there
  tell(belt, service::Ask{3, t_ms, service::Question::kTakeMeTo, "my chair"});
  const auto led = page.wire->next<service::WatchedDevice>(
      [](const service::WatchedDevice& one) { return one.walk.has_value(); });
  EXPECT_EQ(led.walk->goal, "my chair");
  EXPECT_EQ(led.name, "client");
  home->device_renamed(7, "Anna's belt");
  const auto renamed = page.wire->next<service::WatchedDevice>(
      [](const service::WatchedDevice& one) { return one.name != "client"; });
  EXPECT_EQ(renamed.name, "Anna's belt");
  EXPECT_TRUE(renamed.walk);
  EXPECT_EQ(page.wire
                ->next<service::DeviceSeen>(
                    [](const service::DeviceSeen& one) { return one.name != "client"; })
                .name,
            "Anna's belt");
  const auto told = belt.wire->next<service::PromptMessage>(
      [](const service::PromptMessage& one) { return one.message_id == "watch.by"; });
  EXPECT_THAT(told.text, HasSubstr("client"));
  tell(reader, service::Watch{true});  // now they do, too
  EXPECT_TRUE(reader.wire->next<service::WatchedDevice>(is_of_belt).may_watch);
  tell(reader, service::Watch{false});

  // The phone comes again, where its person said no meanwhile: its old connection is not closed
  // yet.
  const Client again = connect(7, service::Role::kDevice);
  const auto is_no = [](const service::WatchedDevice& one) {
    return one.device == 7 && !one.may_watch;
  };
  EXPECT_FALSE(page.wire->next<service::WatchedDevice>(is_no).walk);
  tell(reader, service::Watch{true});
  EXPECT_FALSE(reader.wire->next<service::WatchedDevice>(is_of_belt).may_watch);
  EXPECT_EQ(reader.wire->count<service::WatchedDevice>(
                [](const service::WatchedDevice& one) { return one.walk.has_value(); }),
            0);
  tell(reader, service::Watch{false});
  again.session->on_closed();
  tell(belt, service::SettingsChange{{}, {}, {}, {}, true});

  tell(belt, service::Ask{4, t_ms, service::Question::kHideWalks, ""});
  EXPECT_FALSE(page.wire->next<service::WatchedDevice>(is_no).walk);
  for (int i = 0; i < 3; ++i) look();
  EXPECT_EQ(page.wire->count<service::WatchedDevice>(is_of_belt), 0);
  EXPECT_EQ(belt.wire->count<service::WatchedDevice>(), 0) << "helpers alone";
  EXPECT_EQ(reader.wire->count<service::WatchedDevice>(is_of_belt), 0);
  for (const Client& one : {std::cref(belt), std::cref(page), std::cref(reader)}) {
    one.session->on_closed();
  }
}

// Every request that sees or changes the home needs somebody who may, as docs/protocol.md says.
TEST_F(LiveHomeTest, NoRouteOfTheHomeIsForEveryone) {
  open();
  const service::Router router(home_routes(*home));
  for (const service::Route& route : router.routes()) {
    ASSERT_TRUE(route.role) << route.pattern;
    const bool for_devices = route.method == "GET" && route.pattern == "/api/home";
    EXPECT_EQ(*route.role, for_devices ? service::Role::kDevice : service::Role::kHelper)
        << route.method << ' ' << route.pattern;
  }
}

// ---- a home that is begun with photos ----

TEST_F(LiveHomeTest, RoomsAreLearnedFromPhotosAndALaterWalkMakesTheMap) {
  open();
  EXPECT_ERROR(home->photos().add("", {}), "name");
  const auto photograph = [&](const std::string& room, int first) {
    for (int i = 0; i < static_cast<int>(RoomPhotos::kPerRoom); ++i) {
      pipeline::testing::SyntheticWalk turn(kFrames);
      turn.skip_before(static_cast<std::uint64_t>(first + 2 * i));
      const auto picture = image::encode_jpeg(turn.next().value()->color, 95);
      EXPECT_EQ(home->photos().add(room, picture).value(), static_cast<std::size_t>(i + 1));
    }
  };
  photograph("kitchen", 0);
  photograph("bedroom", 30);
  ASSERT_OK(home->learn());
  home->jobs().wait();
  ASSERT_EQ(home->jobs().state()->state, "done") << home->jobs().state()->text;
  ASSERT_TRUE(home->view()->recognizer) << home->view()->why_no_recognizer;
  EXPECT_FALSE(home->view()->map);

  // It is asked at once, by a phone whose camera nobody calibrated.
  Client phone{std::make_shared<WaitingWire>(), nullptr};
  phone.session = home->connect({8, "phone", service::Role::kDevice}, phone.wire);
  service::Hello hello;
  hello.version = 1;
  hello.camera = service::DeviceCamera{walk.info().camera.width, walk.info().camera.height};
  phone.session->on_text(write(service::DeviceMessage(hello)));
  const Bytes color =
      image::encode_jpeg(pipeline::testing::SyntheticWalk(kFrames).next().value()->color, 95);
  phone.session->on_message(write(service::FrameMessage{1, color, {}}));
  EXPECT_EQ(phone.wire->next<service::Seen>().room, "kitchen");
  phone.session->on_closed();

  record_the_walk();
  EXPECT_TRUE(home->view()->map);
  EXPECT_TRUE(home->view()->recognizer) << "what was learned stays";
  // Learned anew, of the walk and the photos: a room that nobody named on the walk stays known.
  ASSERT_OK(home->name_rooms(1, {{0, 29, "kitchen", 1}}));
  ASSERT_OK(home->learn());
  home->jobs().wait();
  ASSERT_EQ(home->jobs().state()->state, "done") << home->jobs().state()->text;
  EXPECT_THAT(home->view()->recognizer->rooms(), ::testing::ElementsAre("bedroom", "kitchen"));

  ASSERT_OK(home->change_room("bedroom", "guest room", {}));
  EXPECT_EQ(home->photos().counts()->at(0),
            (RoomPhotos::Count{"guest room", RoomPhotos::kPerRoom}));
  ASSERT_OK(home->forget_room("guest room"));
  EXPECT_THAT(home->photos().counts().value(), SizeIs(1));
  ASSERT_OK(home->forget_home());
  EXPECT_FALSE(std::filesystem::exists(folder / "flat.home.photos"));
}

// Of a room that stays, whatever kept the home from taking it away or renaming it.
TEST_F(LiveHomeTest, PhotosFollowTheRoomsThatTheHomeHas) {
  {
    home::Home made = pipeline::create_home(file, {}).value();
    ASSERT_OK(made.replace_rooms(std::array{rooms::Room{"kitchen", "kitchen"}}));
  }
  open();
  const Bytes picture = image::encode_png(image::ColorImage(200, 200));
  EXPECT_TRUE(home->photos().add("kitchen", picture));
  const auto counts = [&] { return home->photos().counts().value(); };
  const std::vector<RoomPhotos::Count> all{{"kitchen", 1}};
  constexpr int kSmall = 1000;  // bytes: names of photos' rooms can be written, and no page
  {
    const testing::FullDisk full(kSmall);
    EXPECT_FALSE(home->forget_room("kitchen"));
    EXPECT_FALSE(home->change_room("kitchen", "galley", {}));
  }
  EXPECT_EQ(counts(), all);
  home.reset();
  open();
  EXPECT_EQ(counts(), all);

  ASSERT_OK(home->forget_room("kitchen"));
  EXPECT_THAT(counts(), IsEmpty());
  const home::EditId removal = home->view()->edits.front().edit.id;
  {
    const testing::FullDisk full(kSmall);
    EXPECT_FALSE(home->undo(removal));
  }
  EXPECT_THAT(counts(), IsEmpty()) << "the room is still removed";
  ASSERT_OK(home->undo(removal));
  EXPECT_EQ(counts(), all);

  ASSERT_OK(home->photos().set_aside("kitchen"));  // as where it is killed before it is stored
  home.reset();
  open();
  EXPECT_EQ(counts(), all);
}

// ---- a recording that is handed in ----

class HandedIn : public LiveHomeTest {
 protected:
  HandedIn() { open(); }
  int damaged_pictures = 0;  // of the archive's
  // A zip of a TUM folder of the walk within another folder, as apps pack it.
  [[nodiscard]] Bytes archive_of_the_walk() {
    const auto recorded = folder / "recorded";
    auto writer = recording::TumWriter::create(recorded, walk.info().camera).value();
    while (auto frame = walk.next().value()) EXPECT_OK(writer->write(*frame));
    EXPECT_OK(writer->close());
    int damaged = 0;
    for (const auto& picture : std::filesystem::directory_iterator(recorded / "rgb")) {
      if (damaged++ < damaged_pictures) std::filesystem::resize_file(picture.path(), 100);
    }
    EXPECT_OK(write_file(recorded / "info.json",
                         std::string_view(R"({"latitude":50.1,"deviceName":"Jane's","rooms":3})")));
    const auto path = folder / "walk.zip";
    int code = 0;
    zip_t* archive = zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &code);
    for (const auto& entry : std::filesystem::recursive_directory_iterator(recorded)) {
      if (!entry.is_regular_file()) continue;
      const auto name = "export" / std::filesystem::relative(entry.path(), recorded);
      zip_file_add(archive, name.c_str(), zip_source_file(archive, entry.path().c_str(), 0, -1), 0);
    }
    EXPECT_EQ(zip_close(archive), 0);
    return read_file(path).value();
  }
  // By the requests of the helper's page: asks where to go on, then piece by piece.
  nlohmann::json ask(const char* method, const std::string& path, const Bytes& body = {}) {
    const service::Router router(home_routes(*home));
    service::HttpRequest request;
    request.method = method;
    request.path = path;
    request.body = body;
    request.headers["content-type"] = "application/json";
    request.who = service::Identity{1, "page", service::Role::kHelper};
    const service::HttpAnswer answer = router.answer(request);
    return nlohmann::json::parse(answer.body);
  }
  nlohmann::json begin(std::size_t bytes) {
    const std::string body =
        fmt::format(R"({{"name":"My flat.zip","bytes":{},"modified":"7"}})", bytes);
    return ask("POST", "/api/uploads", {body.begin(), body.end()});
  }
  std::string hand_in(const Bytes& whole, std::size_t up_to = SIZE_MAX) {
    nlohmann::json state = begin(whole.size());
    constexpr std::size_t kPiece = 100'000;
    while (state.at("offset") < std::min(whole.size(), up_to)) {
      const std::size_t from = state.at("offset");
      const std::size_t size = std::min(kPiece, whole.size() - from);
      state = ask("PUT", fmt::format("/api/uploads/{}/{}", std::string(state.at("upload")), from),
                  {whole.begin() + static_cast<std::ptrdiff_t>(from),
                   whole.begin() + static_cast<std::ptrdiff_t>(from + size)});
    }
    return state.at("upload");
  }
};

TEST_F(LiveHomeTest, WhyRoomsAreNotLearnedIsToldByASentenceOfItsOwn) {
  open();
  const auto end_of_learning = [&] {
    EXPECT_OK(home->learn());
    home->jobs().wait();
    return *home->jobs().state();
  };
  const auto photograph = [&](const std::string& room, int count) {
    for (int i = 0; i < count; ++i) {
      const auto level = static_cast<std::uint8_t>(20 * i + 10);
      EXPECT_OK(home->photos().add(
          room, image::encode_png(image::ColorImage(200, 160, {level, level, level}))));
    }
  };
  photograph("kitchen", 6);
  EXPECT_EQ(end_of_learning().message, "one_room");
  photograph("hall", 2);
  const service::JobState few = end_of_learning();
  EXPECT_EQ(few.state, "failed");
  EXPECT_EQ(few.message, "few_pictures");
  EXPECT_EQ(few.values, (std::map<std::string, std::int64_t>{{"pictures", 2}, {"wanted", 5}}));
  EXPECT_THAT(few.text, HasSubstr("2 pictures of hall"));
}

TEST_F(HandedIn, AnExportIsMappedThoughTheComputerStoppedMeanwhile) {
  const Bytes archive = archive_of_the_walk();
  const std::string id = hand_in(archive, archive.size() / 2);
  EXPECT_THAT(ask("POST", "/api/uploads/" + id + "/map").dump(), HasSubstr("is not whole"));
  home.reset();
  open();
  EXPECT_THAT(ask("GET", "/api/uploads").at("uploads"), SizeIs(1));
  EXPECT_GE(begin(archive.size()).at("offset"), archive.size() / 2) << "nothing is sent again";
  EXPECT_EQ(hand_in(archive), id);
  EXPECT_EQ(ask("POST", "/api/uploads/" + id + "/map").dump(), "{}");
  home->jobs().wait();
  ASSERT_EQ(home->jobs().state()->state, "done") << home->jobs().state()->text;
  ASSERT_THAT(home->view()->walks, SizeIs(1));
  EXPECT_EQ(home->view()->walks[0].stored.recording.name, "My flat");
  EXPECT_TRUE(std::filesystem::exists(folder / "flat.home.walks/My flat/rgb.txt"));
  EXPECT_EQ(std::filesystem::status(folder / "flat.home.walks").permissions(),
            std::filesystem::perms::owner_all);
  EXPECT_EQ(read_text_file(folder / "flat.home.walks/My flat/info.json").value(), R"({"rooms":3})");
  EXPECT_FALSE(std::filesystem::exists(folder / "flat.home.walks/.unpacking"));
  EXPECT_THAT(ask("GET", "/api/uploads").at("uploads"), IsEmpty());
  ASSERT_OK(home->forget_walk(1));
  EXPECT_FALSE(std::filesystem::exists(folder / "flat.home.walks/My flat"));
}

TEST_F(HandedIn, WhatIsBeingMappedIsToldAndIsNotRemoved) {
  const std::string id = hand_in(archive_of_the_walk());
  const auto is_being_mapped = [&] {
    return ask("GET", "/api/uploads").at("uploads").at(0).at("is_being_mapped") == true;
  };
  EXPECT_FALSE(is_being_mapped());
  for (const bool is_stopped : {true, false}) {
    auto place = std::optional(take_the_place());
    ask("POST", "/api/uploads/" + id + "/map");
    EXPECT_TRUE(is_being_mapped());
    EXPECT_THAT(ask("DELETE", "/api/uploads/" + id).dump(), HasSubstr("is being mapped"));
    if (is_stopped) home->jobs().stop();
    if (!is_stopped) place.reset();
    home->jobs().wait();
    if (is_stopped) {
      EXPECT_FALSE(is_being_mapped());
      std::promise<void> go_on;
      ASSERT_OK(home->jobs().start("learn", [&](Progress&) -> Expected<JobEnd> {
        go_on.get_future().wait();
        return JobEnd{};
      }));
      const bool is_told = is_being_mapped();
      go_on.set_value();
      home->jobs().wait();
      EXPECT_FALSE(is_told) << "while something else is done";
    }
  }
  EXPECT_EQ(home->jobs().state()->message, "mapped");
  EXPECT_THAT(ask("GET", "/api/uploads").at("uploads"), IsEmpty());
}

TEST_F(HandedIn, AWalkThatIsInTheHomeIsRefusedByName) {
  const Bytes archive = archive_of_the_walk();
  for (const char* message : {"mapped", "walk_known"}) {
    const std::string id = hand_in(archive);
    ask("POST", "/api/uploads/" + id + "/map");
    home->jobs().wait();
    EXPECT_EQ(home->jobs().state()->message, message);
  }
  EXPECT_EQ(home->jobs().state()->state, "failed");
  const std::string waiting = ask("GET", "/api/uploads").at("uploads").at(0).at("upload");
  EXPECT_EQ(ask("DELETE", "/api/uploads/" + waiting).dump(), "{}");
}

TEST_F(HandedIn, WhatIsInTheHomeDoesNotWaitAfterAKill) {
  const Bytes archive = archive_of_the_walk();
  const std::string id = hand_in(archive);
  ask("POST", "/api/uploads/" + id + "/map");
  home->jobs().wait();
  ASSERT_THAT(home->view()->walks, SizeIs(1));
  // As before the kill.
  EXPECT_EQ(hand_in(archive), id);
  ASSERT_OK(home->uploads().note_walk(id, "My flat"));
  std::filesystem::create_directory(folder / "flat.home.walks/.unpacking");
  const std::string other = home->uploads().begin("other.zip", 5, "")->id;
  ASSERT_OK(home->uploads().note_walk(other, "other"));
  home.reset();
  open();
  const auto left = home->uploads().list().value();
  ASSERT_THAT(left, SizeIs(1));
  EXPECT_EQ(left[0].id, other);
  EXPECT_EQ(left[0].walk, "") << "nothing became of it";
  EXPECT_FALSE(std::filesystem::exists(folder / "flat.home.walks/.unpacking"));
}

TEST_F(HandedIn, AnArchiveOfWhichMostCannotBeReadStays) {
  damaged_pictures = kFrames / 2 + 1;
  const std::string id = hand_in(archive_of_the_walk());
  ask("POST", "/api/uploads/" + id + "/map");
  home->jobs().wait();
  ASSERT_EQ(home->jobs().state()->state, "done") << home->jobs().state()->text;
  EXPECT_EQ(home->jobs().state()->message, "mapped_damaged");
  EXPECT_THAT(home->view()->walks, SizeIs(1)) << "what can be read is in the home";
  EXPECT_THAT(ask("GET", "/api/uploads").at("uploads"), SizeIs(1));
}

TEST_F(HandedIn, WhatIsNoRecordingIsToldAndWaits) {
  const std::string text = "neither a picture nor an archive";
  const std::string id = hand_in({text.begin(), text.end()});
  ask("POST", "/api/uploads/" + id + "/map");
  home->jobs().wait();
  EXPECT_EQ(home->jobs().state()->state, "failed");
  EXPECT_THAT(home->jobs().state()->text, HasSubstr("neither a zip archive nor a recording"));
  EXPECT_EQ(home->jobs().state()->message, "file_unknown");
  service::MetricsText metrics;
  home->write_metrics(metrics);
  EXPECT_THAT(metrics.text(), HasSubstr("jobs_total{job=\"map\",state=\"failed\"} 1\n"));
  EXPECT_THAT(metrics.text(), HasSubstr("failures_total{what=\"a job\",why=\"other\"} 1\n"));
  EXPECT_THAT(metrics.text(), HasSubstr("roomwise_networks_changed 0\n"));
  EXPECT_THAT(home->uploads().list().value(), SizeIs(1));
  ask("DELETE", "/api/uploads/" + id);
  EXPECT_THAT(home->uploads().list().value(), IsEmpty());
}

TEST_F(HandedIn, OfEachFileThatIsNoRecordingItIsToldWhy) {
  const auto end_of = [&](const Bytes& handed_in) {
    const std::string id = hand_in(handed_in);
    ask("POST", "/api/uploads/" + id + "/map");
    home->jobs().wait();
    ask("DELETE", "/api/uploads/" + id);
    return home->jobs().state()->message;
  };
  const auto archive = [&](const std::vector<std::string>& names) {
    const std::filesystem::path path = folder / "made.zip";
    int code = 0;
    zip_t* made = zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &code);
    for (const std::string& name : names) {
      zip_file_add(made, name.c_str(), zip_source_buffer(made, "text", 4, 0), 0);
    }
    EXPECT_EQ(zip_close(made), 0);
    return read_file(path).value();
  };
  EXPECT_EQ(end_of(archive({"notes.txt"})), "no_recording");
  EXPECT_EQ(end_of(archive({"a/rgb.txt", "a/depth.txt", "b/rgb.txt", "b/depth.txt"})),
            "several_recordings");
  EXPECT_EQ(end_of(archive({"../evil.txt"})), "file_unsafe");
  Bytes cut = archive({"a/rgb.txt", "a/depth.txt"});
  cut.resize(cut.size() / 2);
  EXPECT_EQ(end_of(cut), "file_damaged");
}

TEST_F(HandedIn, APieceThatDoesNotFitIsAnsweredByWhereToGoOn) {
  const std::string id = begin(10).at("upload");
  const auto answer = ask("PUT", "/api/uploads/" + id + "/4", {1, 2});
  EXPECT_THAT(std::string(answer.at("error")), HasSubstr("go on from 0"));
  EXPECT_EQ(answer.at("offset"), 0);
  EXPECT_THAT(ask("PUT", "/api/uploads/nothing/0", {1}).dump(), HasSubstr("no upload"));
  EXPECT_THAT(ask("POST", "/api/uploads", {'{', '}'}).dump(), HasSubstr("'name' is missing"));
  ASSERT_OK(home->forget_home());
  EXPECT_FALSE(std::filesystem::exists(folder / "flat.home.uploads"));
}

TEST_F(LiveHomeTest, RequestsWithWrongValuesAreRefusedByName) {
  open();
  const service::Router router(home_routes(*home));
  const auto ask = [&](const char* method, const char* path, const std::string& body) {
    service::HttpRequest request;
    request.method = method;
    request.path = path;
    request.body.assign(body.begin(), body.end());
    request.headers["content-type"] = "application/json";
    request.who = service::Identity{1, "page", service::Role::kHelper};
    const service::HttpAnswer answer = router.answer(request);
    return fmt::format("{} {}", answer.status, std::string(answer.body.begin(), answer.body.end()));
  };
  EXPECT_THAT(ask("GET", "/api/home", ""), HasSubstr("200 {"));
  EXPECT_THAT(ask("GET", "/api/map/cloud", ""), HasSubstr("503"));
  EXPECT_THAT(ask("GET", "/api/map/cloud/fine", ""), HasSubstr("503"));
  EXPECT_THAT(ask("GET", "/api/keyframes/7/picture", ""), HasSubstr("404"));
  EXPECT_THAT(ask("GET", "/api/keyframes/-1/picture", ""), HasSubstr("404"));
  EXPECT_THAT(ask("GET", "/api/keyframes/x/picture", ""), HasSubstr("'x' is no number"));
  EXPECT_THAT(ask("PUT", "/api/recordings/1/rooms", "{}"), HasSubstr("'ranges'"));
  EXPECT_THAT(ask("PUT", "/api/recordings/1/rooms", R"({"ranges":[{"first":-1}]})"),
              HasSubstr("'first'"));
  EXPECT_THAT(
      ask("PUT", "/api/recordings/1/rooms", R"({"ranges":[{"first":5,"last":2,"room":"a"}]})"),
      HasSubstr("409"));
  EXPECT_THAT(ask("PUT", "/api/rooms/attic", R"({"type":"bedroom"})"), HasSubstr("409"));
  EXPECT_THAT(ask("POST", "/api/learn", ""), HasSubstr("record one first"));
  EXPECT_THAT(ask("GET", "/api/job", ""), HasSubstr("none")) << "nothing was begun";
  EXPECT_THAT(ask("POST", "/api/job/stop", ""), HasSubstr("409"));
  EXPECT_THAT(ask("POST", "/api/test", "no picture"), HasSubstr("400"));
  EXPECT_THAT(ask("POST", "/api/recording", R"({"device":"x","name":"a"})"), HasSubstr("'device'"));
  EXPECT_THAT(ask("DELETE", "/api/home", R"({"really":"yes"})"), HasSubstr("flat"));
  EXPECT_THAT(ask("DELETE", "/api/home", R"({"really":"flat"})"), HasSubstr("200"));
}

// A checkered thing in the middle of a picture as the walk's camera takes it.
Bytes message_of_thing(const geometry::PinholeCamera& camera, double t_ms) {
  image::ColorImage picture(camera.width, camera.height, {180, 180, 180});
  for (int y = camera.height / 3; y < camera.height * 2 / 3; ++y) {
    for (int x = camera.width / 3; x < camera.width * 2 / 3; ++x) {
      if ((x / 16 + y / 16) % 2 == 0) picture.at(x, y) = {180, 20, 40};
    }
  }
  const Bytes color = image::encode_jpeg(picture, 95);
  return write(service::FrameMessage{t_ms, color, {}});
}

class Teaching : public LiveHomeTest {
 protected:
  service::PromptMessage ask(const Client& client, service::Question question,
                             std::string subject = "", bool is_private = false) {
    service::Ask asked{++id, 60'000, question, std::move(subject)};
    asked.is_private = is_private;
    client.session->on_text(write(service::DeviceMessage(asked)));
    return client.wire->next<service::PromptMessage>(
        [&](const auto& prompt) { return prompt.answer_to == id; });
  }
  // Up to its name.
  void teach(const Client& client, const std::string& name) {
    EXPECT_EQ(ask(client, service::Question::kTeachThing).message_id, "teach.begin");
    for (int i = 0; i < 10; ++i) {
      client.session->on_message(message_of_thing(walk.info().camera, t_ms += 1000));
      // Answered once the picture has been looked at.
      EXPECT_EQ(ask(client, service::Question::kWhichRooms).message_id, "rooms.count");
    }
    EXPECT_EQ(ask(client, service::Question::kNameThing, name, true).message_id, "teach.learning");
  }
  static std::function<bool(const service::PromptMessage&)> is_message(const std::string& message) {
    return [message](const service::PromptMessage& prompt) { return prompt.message_id == message; };
  }

  std::int64_t id = 0;
  double t_ms = 0;  // of the last picture
};

TEST_F(Teaching, AThingIsTaughtToldToItsOwnerAloneSharedAndForgotten) {
  open();
  const Client anna = connect(7, service::Role::kDevice), ben = connect(8, service::Role::kDevice);
  const auto where = [&](const Client& client) {
    return ask(client, service::Question::kInWords, "where is my mug").message_id;
  };

  teach(anna, "my mug");
  // Without a walk nobody knows what is usual here.
  anna.wire->next<service::PromptMessage>(is_message("teach.no_walk"));
  home->jobs().wait();
  EXPECT_THAT(home->jobs().state()->text, StartsWith("a thing is known"));  // to all helpers

  EXPECT_EQ(where(anna), "where.not_seen");
  EXPECT_THAT(home->view_for({7, "another name", service::Role::kDevice})->things, SizeIs(1));
  EXPECT_EQ(where(ben), "where.unknown");
  EXPECT_THAT(home->view()->things, IsEmpty());  // what helpers' pages show
  EXPECT_EQ(ask(ben, service::Question::kForgetThing, "my mug").message_id, "own.not_own");
  EXPECT_EQ(ask(anna, service::Question::kShareThing, "my mug").message_id, "own.shared");
  EXPECT_EQ(where(ben), "where.not_seen");

  EXPECT_THAT(bytes_of_home(), HasSubstr("my mug"));
  EXPECT_EQ(ask(anna, service::Question::kInWords, "forget my mug").message_id, "own.forgotten");
  EXPECT_EQ(where(anna), "where.unknown");
  home->jobs().wait();
  EXPECT_EQ(home->jobs().state()->message, "erased");
  EXPECT_THAT(bytes_of_home(), Not(HasSubstr("my mug")));
}

TEST_F(Teaching, NobodyWaitsWhileWhatTheyForgotIsErased) {
  open();
  const Client anna = connect(7, service::Role::kDevice);
  for (const char* name : {"my mug", "my bag"}) {
    teach(anna, name);
    anna.wire->next<service::PromptMessage>(is_message("teach.no_walk"));
    home->jobs().wait();
  }
  std::promise<void> go;
  on_log = [&](std::string_view line) {
    if (line.starts_with("job erase: begun")) go.get_future().wait();
  };
  EXPECT_EQ(ask(anna, service::Question::kForgetThing, "my mug").message_id, "own.forgotten");
  EXPECT_TRUE(home->view()->owes_erasing);
  EXPECT_EQ(ask(anna, service::Question::kInWords, "where is my mug").message_id, "where.unknown");
  EXPECT_EQ(ask(anna, service::Question::kShareThing, "my bag").message_id, "own.shared");
  EXPECT_TRUE(home->view()->owes_erasing) << "nor while they change something else";
  go.set_value();
  home->jobs().wait();
  EXPECT_FALSE(home->view()->owes_erasing);
  EXPECT_THAT(bytes_of_home(), Not(HasSubstr("my mug")));
  EXPECT_EQ(home->jobs().state()->message, "looked_for") << "what is left";
  home.reset();
}

TEST_F(Teaching, ThatWhatTheyForgotIsNotErasedIsToldToTheDeviceThatAsked) {
  open();
  const Client anna = connect(7, service::Role::kDevice), ben = connect(8, service::Role::kDevice);
  teach(anna, "my mug");
  anna.wire->next<service::PromptMessage>(is_message("teach.no_walk"));
  home->jobs().wait();
  {
    home::Home other = home::Home::open_read_only(file).value();
    home::Statement reading = other.database().prepare("SELECT name FROM own_things").value();
    ASSERT_TRUE(reading.step().value());
    EXPECT_EQ(ask(anna, service::Question::kForgetThing, "my mug").message_id, "own.forgotten");
    const auto told = anna.wire->next<service::PromptMessage>(is_message("own.not_erased"));
    EXPECT_THAT(told.because, HasSubstr("another program reads the home"));
    home->jobs().wait();
  }
  EXPECT_EQ(home->jobs().state()->kind, "erase");
  EXPECT_EQ(home->jobs().state()->state, "failed");
  EXPECT_TRUE(home->view()->owes_erasing);
  EXPECT_EQ(ben.wire->count<service::PromptMessage>(is_message("own.not_erased")), 0);
  home.reset();
  EXPECT_THAT(bytes_of_home(), Not(HasSubstr("my mug"))) << "tried again";
}

TEST_F(Teaching, AThingIsKnownAlsoWhereLookingForItIsStopped) {
  open();
  record_the_walk();
  const Client anna = connect(7, service::Role::kDevice);
  on_log = [&](std::string_view line) {
    if (line.starts_with("job teach: begun")) home->jobs().stop();
  };
  teach(anna, "my mug");
  anna.wire->next<service::PromptMessage>(is_message("teach.no_walk"));
  home->jobs().wait();
  EXPECT_EQ(home->jobs().state()->message, "taught_for_later");
  EXPECT_EQ(ask(anna, service::Question::kInWords, "where is my mug").message_id, "where.not_seen");
  home.reset();
}

TEST_F(Teaching, ThingsAreLookedForThoughAPictureOfTheMapCannotBeReadAgain) {
  open();
  record_the_walk();
  walk = pipeline::testing::SyntheticWalk(kFrames, 0.045, 0.2);  // enough to tell what is usual
  const Client belt = connect(7, service::Role::kDevice);
  ASSERT_OK(home->begin_recording(7, "second walk"));
  record_the_rest(belt);
  home.reset();
  ASSERT_OK(home::Home::open(file)->database().run(
      "UPDATE keyframe_images SET color = x'00' WHERE keyframe_id = 0"));
  open();
  home->jobs().wait();
  const Client anna = connect(7, service::Role::kDevice);
  for (const std::string name : {"my mug", "my bag"}) {
    teach(anna, name);
    anna.wire->next<service::PromptMessage>(is_message("teach.taught"));
    home->jobs().wait();
  }
  EXPECT_TRUE(home->view()->own_thing_watch);
  EXPECT_EQ(ask(anna, service::Question::kForgetThing, "my bag").message_id, "own.forgotten");
  home->jobs().wait();
  EXPECT_EQ(home->jobs().state()->message, "looked_for");
  EXPECT_TRUE(home->view()->own_thing_watch);
}

TEST_F(LiveHomeTest, APlaceIsMarkedLedToToldToItsOwnerAloneAndForgotten) {
  open();
  record_the_walk();
  pipeline::testing::SyntheticWalk again{kFrames};
  const image::RgbdFrame frame = again.next().value().value();
  const Client anna = connect(7, service::Role::kDevice), ben = connect(8, service::Role::kDevice);
  std::int64_t id = 0;
  const auto ask = [&](const Client& client, const std::string& words) {
    client.session->on_message(message_of(frame));
    const double t_ms = static_cast<double>(frame.timestamp_ns) / 1e6 + 10;
    client.session->on_text(write(
        service::DeviceMessage(service::Ask{++id, t_ms, service::Question::kInWords, words})));
    return client.wire->next<service::PromptMessage>(
        [&](const auto& prompt) { return prompt.answer_to == id; });
  };
  EXPECT_EQ(ask(anna, "take me back").message_id, "spot.no_way_back");
  EXPECT_EQ(ask(anna, "mark my throne here").text, "My throne is marked here.");
  EXPECT_EQ(ask(anna, "which places did I mark").text, "You marked: my throne.");
  EXPECT_EQ(ask(ben, "which places did I mark").message_id, "spot.none");
  EXPECT_EQ(ask(ben, "where is my throne").message_id, "where.unknown");
  EXPECT_THAT(home->view()->spots, IsEmpty()) << "what helpers' pages show";
  EXPECT_EQ(ask(ben, "take me back").message_id, "spot.no_way_back") << "he was led nowhere";
  EXPECT_NE(ask(anna, "where is my throne").message_id, "where.unknown");
  // This map shows no floor to walk on, and the guide says so.
  EXPECT_EQ(ask(anna, "take me to my throne").replace_key, "guide");
  EXPECT_EQ(ask(anna, "take me back").replace_key, "guide") << "to where she set out";
  const auto knows_start = [&] {
    const auto view = home->view_for({7, "client", service::Role::kDevice});
    return std::ranges::any_of(
        view->spots, [](const auto& one) { return one.thing.name == guide::kStartingPlace; });
  };
  EXPECT_TRUE(knows_start());
  ASSERT_OK(home->edit("Anna", [](home::Home& changed, const HomeView&, const auto& author) {
    return pipeline::take_walk_away(changed, author, 1);
  }));
  EXPECT_TRUE(knows_start()) << "the map is the same";
  ASSERT_OK(home->undo(home->view()->edits.front().edit.id));
  walk = pipeline::testing::SyntheticWalk(kFrames, 0.045, 0.2);
  const Client belt = connect(9, service::Role::kDevice);
  ASSERT_OK(home->begin_recording(9, "second walk"));
  record_the_rest(belt);
  EXPECT_FALSE(knows_start()) << "the map was made anew, and with it the key-frames' numbers";
  EXPECT_EQ(ask(anna, "remember where I am").message_id, "spot.marked_here");
  EXPECT_EQ(ask(ben, "forget my throne").message_id, "where.unknown");
  EXPECT_THAT(bytes_of_home(), HasSubstr("my throne"));
  home.reset();
  open();
  home->jobs().wait();
  const Client anew = connect(7, service::Role::kDevice);
  EXPECT_EQ(ask(anew, "forget my throne").message_id, "own.forgotten");
  EXPECT_EQ(ask(anew, "where is my throne").message_id, "where.unknown");
  home->jobs().wait();
  EXPECT_EQ(home->jobs().state()->kind, "erase");
  EXPECT_THAT(bytes_of_home(), Not(HasSubstr("my throne")));
}

TEST_F(LiveHomeTest, AThingWasSeenInTheRoomAsAHelperCallsItNow) {
  {
    home::Home made = pipeline::create_home(file, {}).value();
    ASSERT_OK(made.replace_rooms(std::array{rooms::Room{"kitchen", "kitchen"}}));
    const auto mug =
        made.add_own_thing({.name = "my mug", .owner = "7"},
                           std::vector<objects::TaughtView>{{Bytes(9, 1), Bytes(9, 1)}});
    ASSERT_OK(mug);
    ASSERT_OK(made.put_own_thing_sighting(*mug, {1'753'000'000, "kitchen", {}, {}}));
  }
  open();
  const auto seen_in = [&] {
    return home->view_for({7, "client", service::Role::kDevice})->things.at(0).room;
  };
  EXPECT_EQ(seen_in(), "kitchen");
  ASSERT_OK(home->change_room("kitchen", "galley", {}));
  EXPECT_EQ(seen_in(), "galley");
  ASSERT_OK(home->undo(home->view()->edits.front().edit.id));
  EXPECT_EQ(seen_in(), "kitchen");
}

TEST_F(LiveHomeTest, AThingIsForgottenAlsoWhereItsBytesCannotBeErasedNow) {
  {
    home::Home made = pipeline::create_home(file, {}).value();
    ASSERT_OK(made.add_own_thing({.name = "my mug", .owner = "7"},
                                 std::vector<objects::TaughtView>{{Bytes(9, 1), Bytes(9, 1)}}));
  }
  open();
  const Client anna = connect(7, service::Role::kDevice);
  const auto ask = [&](std::int64_t id, const std::string& words) {
    anna.session->on_text(
        write(service::DeviceMessage(service::Ask{id, 100, service::Question::kInWords, words})));
    return anna.wire
        ->next<service::PromptMessage>([&](const auto& prompt) { return prompt.answer_to == id; })
        .message_id;
  };
  EXPECT_EQ(ask(1, "where is my mug"), "where.not_seen");
  home::Home reader = home::Home::open_read_only(file).value();
  {
    home::Statement reading = reader.database().prepare("SELECT name FROM own_things").value();
    ASSERT_TRUE(reading.step().value());  // in the middle of reading: nothing can be written anew
    EXPECT_EQ(ask(2, "forget my mug"), "own.forgotten");
  }
  EXPECT_EQ(ask(3, "where is my mug"), "where.unknown");
}

}  // namespace
}  // namespace roomwise::live
