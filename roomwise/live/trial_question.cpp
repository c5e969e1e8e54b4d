#include "roomwise/live/trial_question.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "roomwise/guide/questions/refusal_prompts.h"
#include "roomwise/live/led_walk.h"

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
  pose.gravity_from_camera = {Eigen::Quaterniond(axes),
                              Eigen::Vector3d(place.x(), place.y(), kCameraHeight_m)};
  pose.sigma_m = kSigma_m;
  pose.room = home.room_at(pose.position_gravity());
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
      Question::kWhoIsHere,    Question::kIsItLight};
  return std::ranges::find(kOthers, question) == kOthers.end();
}

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
    if (!plan.route.empty()) answered.goal = plan.touch_gravity;
  }
  return answered;
}

}  // namespace roomwise::live
