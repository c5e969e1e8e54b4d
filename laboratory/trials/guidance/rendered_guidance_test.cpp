#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>
#include <functional>
#include <numbers>

#include "laboratory/simulation/home/scenario.h"
#include "laboratory/simulation/testing/test_homes.h"
#include "laboratory/trials/guidance/server_leader.h"
#include "laboratory/trials/truth_evaluation.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/pipeline/mapping/map_recording.h"
#include "roomwise/pipeline/rooms/walk_into_home.h"
#include "roomwise/recording/open_recording.h"
#include "roomwise/service/protocol/prompt_message.h"

namespace roomwise::trials {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr double kRight_rad = std::numbers::pi / 2;

// ---- where the map lies ----

TEST(TrueFrameTest, TurnsAndMovesPlacesAndDirections) {
  const TrueFrame frame{
      {Eigen::Quaterniond(Eigen::AngleAxisd(kRight_rad, Eigen::Vector3d::UnitZ())), {1, 2, 0}}};
  EXPECT_TRUE(frame.to_truth({3, 0}).isApprox(Eigen::Vector2d(1, 5)));
  EXPECT_TRUE(frame.to_map({1, 5}).isApprox(Eigen::Vector2d(3, 0)));
  EXPECT_NEAR(frame.heading_on_map(kRight_rad), 0, 1e-12);
}

TEST(TrueFrameTest, TellsHowFarAToldPlaceIsFromTheCamera) {
  const TrueFrame frame{
      {Eigen::Quaterniond(Eigen::AngleAxisd(kRight_rad, Eigen::Vector3d::UnitZ())), {1, 2, 0}}};
  Sightings sightings;
  // The camera is at (1, 5) and looks along y, which is x on the map.
  const auto truth_from_camera = simulation::level_view({1, 5, 1.3}, kRight_rad);
  add_error({3, 0, 1.3, 0, 0.05}, truth_from_camera, frame, sightings);
  add_error({3, 0.4, 1.3, 10, 0.05}, truth_from_camera, frame, sightings);
  ASSERT_THAT(sightings.position_errors_m, SizeIs(2));
  EXPECT_NEAR(sightings.position_errors_m[0], 0, 1e-12);
  EXPECT_NEAR(sightings.position_errors_m[1], 0.4, 1e-12);
  EXPECT_NEAR(sightings.heading_errors_rad[0], 0, 1e-12);
  EXPECT_NEAR(sightings.heading_errors_rad[1], 10 * guide::kDegree_rad, 1e-12);
}

// ---- a computer that is scripted ----

std::string text_of(const service::HomeMessage& message) {
  return service::write(message);
}

service::PromptMessage prompt(const std::string& message, std::optional<std::int64_t> answer_to) {
  service::PromptMessage said;
  said.answer_to = answer_to;
  said.replace_key = "guide";
  said.message_id = message;
  said.text = message;
  said.language = "en";
  said.priority = "answer";
  said.confidence = "sure";
  said.sound = "none";
  said.valid_until_t_ms = 1e9;
  return said;
}

// What it answers to each message; nothing more comes than that.
class ScriptedComputer final : public service::ServerConnection {
 public:
  struct Script {
    std::function<std::vector<service::HomeMessage>(const service::FrameMessage&)> on_picture;
    std::function<std::vector<service::HomeMessage>(const service::Ask&)> on_question;
    std::vector<double> pictures_t_ms = {};
    std::vector<service::Ask> asked = {};
    std::vector<std::size_t> depth_bytes = {};
    std::optional<service::Hello> hello = {};
    bool is_gone = false;
  };
  explicit ScriptedComputer(Script& script) : script_(script) {}

  [[nodiscard]] Expected<std::optional<Message>> receive(std::chrono::milliseconds) override {
    if (script_.is_gone) return fail("the connection is lost");
    if (waiting_.empty()) return std::optional<Message>();
    const std::string text = waiting_.front();
    waiting_.pop_front();
    return std::optional(Message{true, Bytes(text.begin(), text.end())});
  }
  void close() override {}

 private:
  [[nodiscard]] Expected<void> send(Message message) override {
    if (script_.is_gone) return fail("the connection is lost");
    if (!message.is_text) {
      ROOMWISE_TRY(const auto frame, service::read_frame(message.bytes));
      script_.pictures_t_ms.push_back(frame.t_ms);
      script_.depth_bytes.push_back(frame.depth.size());
      queue({service::FrameArrived{frame.t_ms, 0}});
      queue(script_.on_picture(frame));
      return {};
    }
    ROOMWISE_TRY(const auto told,
                 service::read_device_message(std::string_view(
                     reinterpret_cast<const char*>(message.bytes.data()), message.bytes.size())));
    if (const auto* hello = std::get_if<service::Hello>(&told)) {
      script_.hello = *hello;
      queue({service::Welcome{"flat", "device", {"hall"}, {"bed"}, true, true}});
    } else if (const auto* ask = std::get_if<service::Ask>(&told)) {
      script_.asked.push_back(*ask);
      queue(script_.on_question(*ask));
    }
    return {};
  }
  void queue(const std::vector<service::HomeMessage>& messages) {
    for (const auto& one : messages) waiting_.push_back(text_of(one));
  }

  Script& script_;
  std::deque<std::string> waiting_;
};

service::Seen seen_at(double t_ms) {
  service::Seen seen;
  seen.t_ms = t_ms;
  seen.position = service::SeenPosition{1, 2, 1.3, 45, 0.05};
  return seen;
}

ScriptedComputer::Script sees_and_says(const std::string& message) {
  ScriptedComputer::Script script;
  script.on_picture = [message](const service::FrameMessage& frame) {
    return std::vector<service::HomeMessage>{prompt(message, {}), seen_at(frame.t_ms)};
  };
  script.on_question = [](const service::Ask& ask) {
    return std::vector<service::HomeMessage>{prompt("guide.begin", ask.id)};
  };
  return script;
}

class LockStepTest : public ::testing::Test {
 protected:
  [[nodiscard]] LockStep device(ScriptedComputer::Script& script) {
    service::Hello hello;
    hello.version = service::kProtocolVersion;
    auto begun = LockStep::begin(std::make_unique<ScriptedComputer>(script), hello);
    EXPECT_OK(begun);
    return *std::move(begun);
  }
  const Bytes picture_ = {1};
};

TEST_F(LockStepTest, AnAnswerIsAllThatCameBeforeThePictureWasSeen) {
  auto script = sees_and_says("guide.stop");
  LockStep walker = device(script);
  const auto answer = walker.show(1500, picture_, {});
  ASSERT_OK(answer);
  ASSERT_TRUE(answer->place);
  EXPECT_EQ(answer->place->heading_degrees, 45);
  ASSERT_THAT(answer->prompts, SizeIs(1));
  EXPECT_EQ(answer->prompts[0].message_id, "guide.stop");
  EXPECT_THAT(answer->failure, IsEmpty());
}

TEST_F(LockStepTest, WhatWasSeenOnAnotherPictureDoesNotEndTheWait) {
  auto script = sees_and_says("guide.stop");
  script.on_picture = [](const service::FrameMessage& frame) {
    return std::vector<service::HomeMessage>{seen_at(frame.t_ms - 500), prompt("guide.off", {}),
                                             seen_at(frame.t_ms)};
  };
  LockStep walker = device(script);
  const auto answer = walker.show(1500, picture_, {});
  ASSERT_OK(answer);
  EXPECT_THAT(answer->prompts, SizeIs(1));
}

TEST_F(LockStepTest, APictureThatCannotBeLookedAtIsSaidSo) {
  auto script = sees_and_says("guide.stop");
  script.on_picture = [](const service::FrameMessage&) {
    return std::vector<service::HomeMessage>{service::ErrorMessage{"no JPEG", {}}};
  };
  LockStep walker = device(script);
  const auto answer = walker.show(1500, picture_, {});
  ASSERT_OK(answer);
  EXPECT_EQ(answer->failure, "no JPEG");
}

TEST_F(LockStepTest, AQuestionGetsItsOwnAnswer) {
  auto script = sees_and_says("guide.stop");
  script.on_question = [](const service::Ask& ask) {
    return std::vector<service::HomeMessage>{prompt("where.other", ask.id - 1),
                                             prompt("guide.far", ask.id)};
  };
  LockStep walker = device(script);
  const auto answer = walker.ask({});
  ASSERT_OK(answer);
  ASSERT_THAT(*answer, SizeIs(1));
  EXPECT_EQ((*answer)[0].message_id, "guide.far");
}

TEST_F(LockStepTest, AComputerThatIsGoneSilentOrRefusesIsAnError) {
  auto script = sees_and_says("guide.stop");
  LockStep walker = device(script);
  script.on_picture = [](const service::FrameMessage&) {
    return std::vector<service::HomeMessage>();
  };
  EXPECT_ERROR(walker.show(1500, picture_, {}), "said nothing for 120 s");
  script.on_question = [](const service::Ask& ask) {
    return std::vector<service::HomeMessage>{service::ErrorMessage{"busy", ask.id}};
  };
  EXPECT_ERROR(walker.ask({}), "busy");
  script.is_gone = true;
  EXPECT_ERROR(walker.show(2000, picture_, {}), "connection is lost");
}

// ---- the camera on the chest, and the walker's clock ----

class ChestCameraTest : public ::testing::Test {
 protected:
  ChestCameraTest() {
    options_.camera = simulation::small_camera();
    options_.camera.depth_units_per_metre = 1000;
    options_.jitter = 0;
  }
  static void SetUpTestSuite() {
    renderer_ =
        simulation::Renderer::create(
            simulation::square_rooms(2), simulation::load_box,
            {.samples_per_pixel = 1, .bake_effort = 0.02, .light_cache = {}}, pool_, silent_)
            .value();
  }
  static void TearDownTestSuite() { renderer_.reset(); }
  [[nodiscard]] ChestCamera camera() {
    return ChestCamera::create(options_, *renderer_, pool_, 1).value();
  }

  inline static ThreadPool pool_{1};
  inline static SilentProgress silent_;
  inline static std::unique_ptr<simulation::Renderer> renderer_;
  const WalkedHome home_{simulation::square_rooms(2)};
  ChestCameraOptions options_;
};

TEST_F(ChestCameraTest, IsAheadOfTheBodyAndLooksALittleDown) {
  ChestCamera worn = camera();
  worn.carry(0, {2, 1}, kRight_rad);
  const ChestCamera::Picture picture = worn.take();
  EXPECT_TRUE(picture.world_from_camera.translation.isApprox(Eigen::Vector3d(2, 1.1, 1.3)));
  const Eigen::Vector3d axis = picture.world_from_camera.rotation * Eigen::Vector3d::UnitZ();
  EXPECT_NEAR(axis.x(), 0, 1e-12);
  EXPECT_NEAR(axis.z(), -std::sin(options_.down_rad), 1e-12);
  // The floor's edge at the wall, 2.9 m ahead, lies below the picture; the wall's middle is there.
  const double wall_m = image::depth_m(picture.frame.depth, options_.camera, 39, 15);
  EXPECT_NEAR(wall_m, 2.9, 0.2);
}

TEST_F(ChestCameraTest, OptionsSayWhatIsWrong) {
  options_.ahead_m = 2;
  EXPECT_ERROR(ChestCamera::create(options_, *renderer_, pool_, 1), "ahead_m is 2");
  EXPECT_ERROR(PictureTimes{.pictures_per_s = 0}.validate(), "pictures_per_s is 0");
  EXPECT_ERROR(PictureTimes{.latency_s = -1}.validate(), "latency_s is -1");
}

class ServerLeaderTest : public ChestCameraTest {
 protected:
  [[nodiscard]] std::unique_ptr<ServerLeader> leader(ScriptedComputer::Script& script) {
    auto begun = ServerLeader::begin(std::make_unique<ScriptedComputer>(script), view_, {}, goal_,
                                     {}, options_, camera(), {});
    EXPECT_OK(begun);
    return *std::move(begun);
  }
  // Messages of what is said, each with the time, in hundredths.
  [[nodiscard]] std::vector<std::string> heard_until(Leader& leader, double end_s) {
    std::vector<std::string> heard;
    int steps = 0;
    for (double now_s = 0; now_s < end_s; now_s = ++steps * kWalkerStep_s) {
      const auto said = leader.after_step(now_s, walker_);
      EXPECT_OK(said);
      for (const auto& one : *said) {
        heard.push_back(fmt::format("{:.0f} {}", 100 * now_s, one.message_id));
      }
    }
    return heard;
  }

  std::shared_ptr<live::HomeView> view_ = std::make_shared<live::HomeView>();
  GuidedGoal goal_ = [] {
    GuidedGoal goal;
    goal.word = "bed";
    goal.goal.noun = {guide::Noun::Kind::kThing, "bed"};
    goal.goal.room = "hall";
    goal.room = 0;
    return goal;
  }();
  SimulatedWalker walker_{home_, {2, 2}, 0, {}, 1};
};

TEST_F(ServerLeaderTest, WhatAPictureTellsIsHeardAfterTheLatencyHoweverLongItTook) {
  auto script = sees_and_says("guide.stop");
  const auto led = leader(script);
  EXPECT_THAT(heard_until(*led, 1.2),
              ElementsAre("30 guide.stop", "30 guide.begin", "80 guide.stop"));
  EXPECT_THAT(script.pictures_t_ms, ElementsAre(1000, 1500, 2000));  // from 1 s on
  EXPECT_EQ(led->sightings().pictures, 3u);
}

TEST_F(ServerLeaderTest, AsksByNameForTheOneInItsRoomOnceAPictureWasSeen) {
  guide::KnownThing bed;
  bed.name = "bed";
  bed.room = "hall";
  view_->things = {bed};
  auto script = sees_and_says("guide.stop");
  const auto led = leader(script);
  EXPECT_TRUE(led->knows_goal());
  EXPECT_THAT(heard_until(*led, 0.4), SizeIs(2));
  ASSERT_THAT(script.asked, SizeIs(1));
  EXPECT_EQ(script.asked[0].question, service::Question::kTakeMeTo);
  EXPECT_EQ(script.asked[0].subject, "bed");
  EXPECT_EQ(script.asked[0].in_room, "hall");
  EXPECT_EQ(script.asked[0].t_ms, 1300);
  EXPECT_FALSE(led->is_over());
  ASSERT_OK(led->request(guide::GuidanceRequest::kBlocked, 0.4));
  EXPECT_EQ(script.asked[1].wish, service::GuideWish::kBlocked);
}

TEST_F(ServerLeaderTest, AGoalThatTheHomeDoesNotHaveEndsTheWalk) {
  auto script = sees_and_says("room.is");
  const auto led = leader(script);
  EXPECT_FALSE(led->knows_goal());
  EXPECT_THAT(heard_until(*led, 0.4), SizeIs(2));
  EXPECT_TRUE(led->is_over());
  EXPECT_FALSE(led->says_there());
}

TEST_F(ServerLeaderTest, TheEndIsKnownByWhatIsSaid) {
  guide::KnownThing bed;
  bed.name = "bed";
  bed.room = "hall";
  view_->things = {bed};
  auto script = sees_and_says("guide.there_left");
  const auto led = leader(script);
  EXPECT_THAT(heard_until(*led, 0.4), SizeIs(2));
  EXPECT_TRUE(led->is_over());
  EXPECT_TRUE(led->says_there());
}

TEST_F(ServerLeaderTest, APhoneSendsColourAndNothingOfItsLens) {
  options_.is_phone = true;
  auto script = sees_and_says("guide.stop");
  const auto led = leader(script);
  ASSERT_OK(led->after_step(0, walker_));
  EXPECT_FALSE(script.hello->camera->calibrated);
  EXPECT_FALSE(script.hello->camera->has_depth);
  EXPECT_EQ(script.depth_bytes.at(0), 0u);
}

TEST_F(ServerLeaderTest, AWalkWhoseComputerDiesIsBrokenOffAndSaysWhy) {
  auto script = sees_and_says("guide.stop");
  int left = 4;
  script.on_picture = [&](const service::FrameMessage& frame) {
    script.is_gone = --left == 0;
    return std::vector<service::HomeMessage>{seen_at(frame.t_ms)};
  };
  const auto led = leader(script);
  TrialOptions options;
  const GuidedWalk walk = lead_by(*led, home_, goal_, options, 0);
  ASSERT_TRUE(walk.broken_off);
  EXPECT_THAT(*walk.broken_off, HasSubstr("connection is lost"));
  EXPECT_FALSE(walk.arrived());
  EXPECT_EQ(walk.sightings.pictures, 3u);
  EXPECT_EQ(summarise(std::span(&walk, 1)).broken_off, 1u);
}

// ---- all of it: a home that is drawn, walked through, mapped and served ----

class ServedWalkTest : public ::testing::Test {
 protected:
  static simulation::SimulationOptions walk_options() {
    simulation::SimulationOptions options;
    options.home = simulation::HomeOptions{3, {simulation::RoomKind::kToilet}};
    options.walk.frames_per_second = 3;
    options.walk.max_frames = 40;
    options.walk.fast_turns = false;
    options.camera = simulation::SimulationOptions::default_camera();
    options.camera.fx = options.camera.fy = 262.5;
    options.camera.cx = 159.5;
    options.camera.cy = 119.5;
    options.camera.width = 320;
    options.camera.height = 240;
    options.render.samples_per_pixel = 1;
    options.render.bake_effort = 0.05;
    return options;
  }
  void SetUp() override {
    catalogue_ = simulation::FurnitureCatalogue::open().value();
    StageClock clock;
    ASSERT_OK(
        simulation::simulate_recording(walk_options(), *catalogue_, walk_, pool_, silent_, clock));
    ASSERT_OK(map());
    auto server = GuidingServer::start(file_, networks_, finders_);
    ASSERT_OK(server);
    server_ = *std::move(server);
    auto recorded = recorded_home(walk_, *catalogue_);
    ASSERT_OK(recorded);
    home_ = std::make_unique<WalkedHome>(recorded->model);
    map_ = map_truth(recorded->model, catalogue_->models(), 0).value();
    renderer_ = simulation::Renderer::create(recorded->model, *catalogue_, walk_options().render,
                                             pool_, silent_)
                    .value();
    const home::Home mapped = home::Home::open_read_only(file_).value();
    const auto truth_from_world = truth_from_map(mapped, walk_);
    ASSERT_OK(truth_from_world);
    frame_.truth_from_gravity =
        *truth_from_world * server_->view()->map->frame.gravity_from_world.inverse();
  }
  [[nodiscard]] Expected<void> map() {
    ROOMWISE_TRY(home::Home home, pipeline::make_or_open_home({file_, walk_, {}, false, ""}));
    ROOMWISE_TRY(const auto source, recording::open_recording(walk_, {}));
    pipeline::OwnRunContext run(1, silent_);
    ROOMWISE_RETURN_IF_ERROR(
        pipeline::map_recording(*source,
                                {source->info().name, walk_.string(), source->info().camera,
                                 source->info().frames_remaining},
                                home, networks_, {}, run));
    ROOMWISE_TRY(const recording::RoomLabels labels,
                 recording::RoomLabels::read(walk_ / "rooms.txt"));
    return pipeline::name_rooms_if_unnamed(home, labels);
  }
  [[nodiscard]] GuidedWalk walk(double seconds) {
    TrialOptions options;
    options.max_s = seconds;
    options.goals.by_name = true;
    options.goals.goals = 1;
    options.goals.min_way_m = 0.5;
    GuidedGoal goal;
    goal.goal = guide::Goal::of(map_->layout.rooms().at(0));
    goal.word = goal.goal.noun.name;
    goal.room = 0;
    // As the walk that was mapped looked there.
    const recording::Trajectory walked = recording::read_truth(walk_).value();
    const geometry::RigidTransform& pose = walked.at(walked.size() / 2).world_from_camera;
    const Eigen::Vector3d axis = pose.rotation * Eigen::Vector3d::UnitZ();
    goal.start = pose.translation.head<2>();
    goal.start_heading_rad = std::atan2(axis.y(), axis.x());
    ChestCameraOptions camera;
    camera.camera = walk_options().camera;
    return lead_by_server({*server_, *renderer_, pool_, frame_, camera}, *home_, goal, options, 0);
  }

  testing::ScratchFolder folder_;
  std::filesystem::path walk_ = folder_ / "walk", file_ = folder_ / "walk.home";
  ThreadPool pool_{1};
  SilentProgress silent_;
  std::optional<simulation::FurnitureCatalogue> catalogue_;
  pipeline::Networks networks_;
  objects::ObjectFinders finders_;
  std::unique_ptr<GuidingServer> server_;
  std::unique_ptr<WalkedHome> home_;
  std::optional<GuidedMap> map_;
  std::unique_ptr<simulation::Renderer> renderer_;
  TrueFrame frame_;
};

TEST_F(ServedWalkTest, IsLedByWhatTheComputerSeesAndAlikeWithTheSameSeed) {
  const GuidedWalk first = walk(4), second = walk(4);
  EXPECT_FALSE(first.broken_off) << *first.broken_off;
  EXPECT_TRUE(first.is_offered);
  EXPECT_GE(first.sightings.pictures, 8u);
  ASSERT_FALSE(first.heard.empty());
  ASSERT_EQ(first.heard.size(), second.heard.size());
  for (std::size_t i = 0; i < first.heard.size(); ++i) {
    EXPECT_EQ(first.heard[i].text, second.heard[i].text);
    EXPECT_EQ(first.heard[i].at_s, second.heard[i].at_s);
  }
  EXPECT_EQ(first.sightings.position_errors_m, second.sightings.position_errors_m);
  // The computer ends: the next walk says so.
  server_->stop();
  const GuidedWalk without = walk(4);
  EXPECT_TRUE(without.broken_off);
  EXPECT_FALSE(without.arrived());
}

}  // namespace
}  // namespace roomwise::trials
