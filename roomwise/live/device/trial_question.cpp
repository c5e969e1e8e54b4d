#include "roomwise/live/device/trial_question.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "roomwise/guide/questions/refusal_prompts.h"
#include "roomwise/guide/way/legs.h"
#include "roomwise/live/device/led_walk.h"

namespace roomwise::live {
namespace {

constexpr double kCameraHeight_m = 1.4;  // a phone before the chest
constexpr double kSigma_m = 0.05;        // as of a picture that is found well

// A picture from that place, which says its room where the layout does.
FrameResult picture_at(const Eigen::Vector2d& place, double heading_degrees, const HomeView& home) {
  const double heading_rad = heading_degrees * std::numbers::pi / 180;
  // The camera looks along its z; its y is down.
  Eigen::Matrix3d axes;
  axes.col(2) = Eigen::Vector3d(std::cos(heading_rad), std::sin(heading_rad), 0);
  axes.col(1) = -Eigen::Vector3d::UnitZ();
  axes.col(0) = axes.col(1).cross(axes.col(2));
  FrameResult result;
  CameraPose& pose = result.place.emplace();
  pose.plan_from_camera = {Eigen::Quaterniond(axes),
                           Eigen::Vector3d(place.x(), place.y(), kCameraHeight_m)};
  pose.sigma_m = kSigma_m;
  pose.room = home.room_at(pose.position_plan());
  if (pose.room && home.recognizer) {
    rooms::RoomDecision& decision = result.decision.emplace();
    decision.verdict = rooms::Verdict::kRoom;
    decision.rooms = {{*pose.room, 1.0}};
    decision.why = "a helper said so";
  }
  return result;
}

// Of a question that changes something, goes on with what was begun, is of the device's own spots
// or looks at the picture itself there is nothing to try.
bool can_be_tried(service::Question question) {
  using service::Question;
  constexpr std::array kOthers{
      Question::kInWords,      Question::kNameRoom,    Question::kTeachThing, Question::kNameThing,
      Question::kStopTeaching, Question::kForgetThing, Question::kShareThing, Question::kKeepThing,
      Question::kMarkSpot,     Question::kWhichSpots,  Question::kForgetSpot, Question::kRenameSpot,
      Question::kWhoIsHere,    Question::kIsItLight,   Question::kShowWalks,  Question::kHideWalks};
  return std::ranges::find(kOthers, question) == kOthers.end();
}

// Somebody who does as they are told: they turn on the spot, listen, and walk along the way.
class ObedientWalker {
 public:
  ObedientWalker(LedWalk& led, const std::shared_ptr<const HomeView>& home,
                 const TrialQuestion& question)
      : led_(led),
        home_(home),
        place_(*question.place),
        heading_rad_(question.heading_degrees * std::numbers::pi / 180) {}

  // What they hear until they have arrived, or came to the end of the way.
  std::vector<guide::Prompt> walk(const guide::Route& way) {
    stand_for(kListen_s);
    for (std::size_t i = 1; i < way.size() && !led_.is_over(); ++i) {
      const Eigen::Vector2d leg = way[i] - place_;
      if (leg.norm() > kLongestLeg_m) break;  // the plan's next storey: nobody walks there
      turn_to(leg);
      walk_to(way[i]);
    }
    stand_for(kAtEnd_s);
    return std::move(heard_);
  }

 private:
  static constexpr double kPicture_s = 0.25, kListen_s = 2.5, kAtEnd_s = 8;
  static constexpr double kPace_mps = 0.6, kTurn_radps = std::numbers::pi / 4;
  static constexpr double kLongestLeg_m = 100;

  void look() {
    now_t_ms_ += 1000 * kPicture_s;
    FrameResult picture = picture_at(place_, heading_rad_ * 180 / std::numbers::pi, *home_);
    picture.t_ms = now_t_ms_;
    for (guide::Prompt& prompt : led_.after(picture, home_)) heard_.push_back(std::move(prompt));
  }
  void stand_for(double time_s) {
    for (double t_s = 0; t_s < time_s && !led_.is_over(); t_s += kPicture_s) look();
  }
  void turn_to(const Eigen::Vector2d& along) {
    if (along.norm() < 1e-6) return;
    const double step_rad = kTurn_radps * kPicture_s;
    const double wanted_rad = std::atan2(along.y(), along.x());
    double left_rad = std::remainder(wanted_rad - heading_rad_, 2 * std::numbers::pi);
    const bool is_a_turn = std::abs(left_rad) > guide::kNoTurn_rad;
    while (std::abs(left_rad) > step_rad && !led_.is_over()) {
      heading_rad_ += std::copysign(step_rad, left_rad);
      look();
      left_rad = std::remainder(wanted_rad - heading_rad_, 2 * std::numbers::pi);
    }
    heading_rad_ = wanted_rad;
    if (is_a_turn) stand_for(kListen_s);
  }
  void walk_to(const Eigen::Vector2d& end) {
    const Eigen::Vector2d from = place_;
    const double length_m = (end - from).norm();
    const int steps = static_cast<int>(std::ceil(length_m / (kPace_mps * kPicture_s)));
    for (int step = 1; step <= steps && !led_.is_over(); ++step) {
      place_ = from + (end - from) * step / steps;
      look();
    }
  }

  LedWalk& led_;
  std::shared_ptr<const HomeView> home_;
  Eigen::Vector2d place_;
  double heading_rad_ = 0, now_t_ms_ = 0;
  std::vector<guide::Prompt> heard_;
};

// What is led to: of "take me back" the place, where there is one.
service::Ask goal_of(const service::Ask& ask, const HomeView& home, std::int64_t now_s) {
  if (ask.question != service::Question::kTakeMeBack) return ask;
  const auto back = way_back(home, now_s);
  return back ? service::Ask{ask.id, ask.t_ms, service::Question::kTakeMeTo, *back} : ask;
}

}  // namespace

TrialAnswer try_question(const TrialQuestion& question,
                         const std::shared_ptr<const HomeView>& home) {
  const guide::Wording wording = wording_of(question.settings);
  const guide::HomeNames names = names_in(*home);
  const guide::Understood heard = guide::understand(question.text, wording.phrases(), names);
  service::Ask in_words;
  in_words.question = service::Question::kInWords;
  in_words.subject = question.text;
  const auto ask = ask_of(heard, in_words);
  if (ask) return try_ask(*ask, question, home);
  TrialAnswer answered;
  answered.prompts = guide::refusal_prompts(heard, names, wording, 0);
  return answered;
}

TrialAnswer try_ask(const service::Ask& asked, const TrialQuestion& question,
                    const std::shared_ptr<const HomeView>& home) {
  TrialAnswer answered;
  if (!can_be_tried(asked.question)) {
    answered.prompts = guide::example_prompts(names_in(*home), wording_of(question.settings), 0);
    return answered;
  }
  const service::Ask ask = goal_of(asked, *home, question.now_s);
  std::optional<FrameResult> picture;
  if (question.place) picture = picture_at(*question.place, question.heading_degrees, *home);
  const Situation situation{*home, picture ? &*picture : nullptr, question.settings, 0,
                            question.today};
  const bool wants_a_way =
      ask.question == service::Question::kTakeMeTo || ask.question == service::Question::kWayTo;
  const auto led = wants_a_way ? LedWalk::to(ask, home, situation) : nullptr;
  if (led && ask.question == service::Question::kTakeMeTo) {
    answered.prompts = {led->begin(situation)};
  } else {
    answered.prompts = answer(ask, situation);
  }
  if (led && question.place) {
    const guide::Plan plan = led->plan_from(situation);
    answered.way = plan.route;
    if (!plan.route.empty()) answered.goal = plan.touch_plan;
    if (ask.question == service::Question::kTakeMeTo) {
      answered.along_way = ObedientWalker(*led, home, question).walk(plan.route);
    }
  }
  return answered;
}

}  // namespace roomwise::live
