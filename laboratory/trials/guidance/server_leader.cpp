#include "laboratory/trials/guidance/server_leader.h"

#include <algorithm>

#include "roomwise/image/codec.h"
#include "roomwise/live/device/led_walk.h"
#include "roomwise/live/device/trial_question.h"

namespace roomwise::trials {
namespace {

constexpr int kJpegQuality = 90;  // of the wearable; the phone's page packs nearly as finely

double device_ms(double now_s) {
  return static_cast<double>(trial_ns(now_s)) / 1e6;
}

service::SpeakingSettings settings_of(const guide::SpeakingStyle& style) {
  service::SpeakingSettings settings;
  settings.language = style.language;
  settings.distances = style.distances == guide::DistanceUnit::kSteps ? service::Distances::kSteps
                                                                      : service::Distances::kMetres;
  settings.step_m = style.step_m;
  return settings;
}

service::Hello hello_of(const ChestCameraOptions& options,
                        const service::SpeakingSettings& settings) {
  service::Hello hello;
  hello.version = service::kProtocolVersion;
  hello.name = "simulated walker";
  hello.kind = options.is_phone ? service::DeviceKind::kPhone : service::DeviceKind::kWearable;
  hello.settings = settings;
  service::DeviceCamera& camera = hello.camera.emplace();
  camera.width = options.camera.width;
  camera.height = options.camera.height;
  if (options.is_phone) return hello;
  camera.calibrated = options.camera;
  camera.has_depth = true;
  return hello;
}

// Of several of its name in the home, the one in its room.
service::Ask ask_for(const GuidedGoal& goal) {
  service::Ask ask;
  ask.question = service::Question::kTakeMeTo;
  ask.subject = goal.word;
  ask.is_room = goal.goal.kind == guide::Goal::Kind::kRoom;
  if (!ask.is_room && goal.goal.room) ask.in_room = *goal.goal.room;
  return ask;
}

service::GuideWish wish_of(guide::GuidanceRequest request) {
  using guide::GuidanceRequest;
  switch (request) {
    case GuidanceRequest::kPause:
      return service::GuideWish::kPause;
    case GuidanceRequest::kResume:
      return service::GuideWish::kResume;
    case GuidanceRequest::kHowFar:
      return service::GuideWish::kHowFar;
    case GuidanceRequest::kNext:
      return service::GuideWish::kNext;
    case GuidanceRequest::kBlocked:
      return service::GuideWish::kBlocked;
    case GuidanceRequest::kRepeat:
    case GuidanceRequest::kEnd:
      break;
  }
  return service::GuideWish::kEnd;
}

}  // namespace

Expected<void> PictureTimes::validate() const {
  constexpr double kMost_s = 20;  // each step of the walker
  if (!(pictures_per_s > 0 && pictures_per_s <= kMost_s)) {
    return fail("pictures_per_s is {}; expected more than 0, at most {}", pictures_per_s, kMost_s);
  }
  if (!(latency_s >= 0 && latency_s < 10)) {
    return fail("latency_s is {}; expected 0 to 10", latency_s);
  }
  return {};
}

Expected<std::unique_ptr<ServerLeader>> ServerLeader::begin(
    std::unique_ptr<service::ServerConnection> connection,
    std::shared_ptr<const live::HomeView> view, const TrueFrame& frame, const GuidedGoal& goal,
    const guide::SpeakingStyle& style, const ChestCameraOptions& options, ChestCamera camera,
    const PictureTimes& times) {
  ROOMWISE_RETURN_IF_ERROR(times.validate());
  const service::SpeakingSettings settings = settings_of(style);
  ROOMWISE_TRY(LockStep device,
               LockStep::begin(std::move(connection), hello_of(options, settings)));
  std::unique_ptr<ServerLeader> leader(
      new ServerLeader(std::move(device), std::move(view), frame, std::move(camera), times));
  leader->sends_depth_ = !options.is_phone;
  leader->settings_ = settings;
  leader->goal_ = ask_for(goal);
  const live::Situation nowhere{*leader->view_, nullptr, settings, 0};
  leader->knows_goal_ = live::LedWalk::to(leader->goal_, leader->view_, nowhere) != nullptr;
  return leader;
}

Expected<void> ServerLeader::show_picture(double now_s) {
  const ChestCamera::Picture picture = camera_.take();
  const Bytes color = image::encode_jpeg(picture.frame.color, kJpegQuality);
  const Bytes depth = sends_depth_ ? image::encode_png(picture.frame.depth) : Bytes();
  ROOMWISE_TRY(PictureAnswer answer, device_.show(device_ms(now_s), color, depth));
  if (!answer.failure.empty()) return fail("a picture was not looked at: {}", answer.failure);
  ++sightings_.pictures;
  if (answer.place) add_error(*answer.place, picture.world_from_camera, frame_, sightings_);
  answers_.push_back({now_s + times_.latency_s, std::move(answer.prompts)});
  return {};
}

Expected<std::vector<guide::Prompt>> ServerLeader::after_step(double now_s,
                                                              const SimulatedWalker& walker) {
  constexpr double kSameTime_s = kWalkerStep_s / 10;  // of sums of steps
  camera_.carry(now_s, walker.place(), walker.heading_rad());
  if (now_s >= next_picture_s_ - kSameTime_s) {
    next_picture_s_ = now_s + 1 / times_.pictures_per_s;
    ROOMWISE_RETURN_IF_ERROR(show_picture(now_s));
  }
  std::vector<guide::Prompt> prompts;
  while (!answers_.empty() && now_s >= answers_.front().due_s - kSameTime_s) {
    std::ranges::move(answers_.front().prompts, std::back_inserter(prompts));
    answers_.pop_front();
    // Who stands there with a camera that sees asks to be led.
    if (std::exchange(has_asked_, true)) continue;
    service::Ask ask = goal_;
    ask.t_ms = device_ms(now_s);
    ROOMWISE_TRY(auto begun, device_.ask(std::move(ask)));
    std::ranges::move(begun, std::back_inserter(prompts));
    is_over_ = !knows_goal_;
  }
  note_end(prompts);
  return prompts;
}

Expected<std::vector<guide::Prompt>> ServerLeader::request(guide::GuidanceRequest request,
                                                           double now_s) {
  service::Ask ask;
  ask.t_ms = device_ms(now_s);
  const bool is_repeat = request == guide::GuidanceRequest::kRepeat;
  ask.question = is_repeat ? service::Question::kRepeat : service::Question::kGuide;
  ask.wish = wish_of(request);
  ROOMWISE_TRY(auto prompts, device_.ask(std::move(ask)));
  note_end(prompts);
  return prompts;
}

// A device knows the end by what is said.
void ServerLeader::note_end(const std::vector<guide::Prompt>& prompts) {
  for (const guide::Prompt& prompt : prompts) {
    says_there_ = says_there_ || prompt.message_id.starts_with("guide.there_");
    is_over_ = is_over_ || says_there_ || prompt.message_id == "guide.near_end" ||
               prompt.message_id.starts_with("guide.ended");
  }
}

std::optional<Eigen::Vector2d> ServerLeader::next_place(const SimulatedWalker& walker) const {
  if (!view_->map) return std::nullopt;
  live::TrialQuestion question;
  question.place = frame_.to_map(walker.place());
  question.heading_degrees = frame_.heading_on_map(walker.heading_rad()) / guide::kDegree_rad;
  question.settings = settings_;
  const live::TrialAnswer answer = live::try_ask(goal_, question, view_);
  const auto doors = guide::doors_of(live::doorways_of(*view_));
  const auto legs = guide::legs_of(answer.way, doors, view_->map->frame.storeys.stairs());
  if (legs.empty()) return std::nullopt;
  return frame_.to_truth(legs.front().to);
}

GuidedWalk lead_by_server(const DrawnWalks& walks, const WalkedHome& home, const GuidedGoal& goal,
                          const TrialOptions& options, std::uint64_t walk) {
  const auto begin = [&]() -> Expected<std::unique_ptr<ServerLeader>> {
    ROOMWISE_TRY(auto connection, walks.server.connect());
    ROOMWISE_TRY(ChestCamera camera, ChestCamera::create(walks.camera, walks.renderer, walks.pool,
                                                         seed_of_walk(options, walk)));
    return ServerLeader::begin(std::move(connection), walks.server.view(), walks.frame, goal,
                               options.style, walks.camera, std::move(camera), walks.times);
  };
  auto leader = begin();
  if (leader) return lead_by(**leader, home, goal, options, walk);
  GuidedWalk broken_off;
  broken_off.goal = goal;
  broken_off.broken_off = std::move(leader).error().message;
  return broken_off;
}

}  // namespace roomwise::trials
