#include "roomwise/live/answers.h"

#include <cmath>
#include <set>

#include "roomwise/guide/obstacle.h"
#include "roomwise/guide/room_prompts.h"
#include "roomwise/guide/route_prompts.h"
#include "roomwise/guide/thing_prompts.h"

namespace roomwise::live {
namespace {

const guide::MessageCatalogue& catalogue() {
  static const guide::MessageCatalogue built_in = guide::MessageCatalogue::built_in();
  return built_in;
}

// The language that is spoken to somebody who wants `tag` ("de-AT"): English where theirs is not
// known.
std::string spoken_language(const std::string& tag) {
  const std::string language = tag.substr(0, tag.find('-'));
  return catalogue().speaks(language) ? language : "en";
}

TimestampNs nanoseconds(double t_ms) {
  return std::llround(t_ms * 1e6);
}

guide::TurnHint hint_of(const FrameResult& result) {
  if (!result.more_to_see) return guide::TurnHint::kAnywhere;
  return *result.more_to_see == pipeline::Side::kLeft ? guide::TurnHint::kLeft
                                                      : guide::TurnHint::kRight;
}

// Of the computer's or the device's state: what there is to say instead of an answer.
guide::Prompt excuse(const std::string& message, const guide::Wording& wording, double now_t_ms) {
  return guide::make_prompt(wording, "answer", message, {}, guide::Confidence::kUnsure,
                            guide::after(nanoseconds(now_t_ms), guide::kNoticeValid_s));
}

std::vector<rooms::Doorway> doorways_of(const HomeView& home) {
  return home.layout ? home.layout->doorways() : std::vector<rooms::Doorway>{};
}

guide::Prompt where_am_i(const Situation& situation, const guide::Wording& wording) {
  if (!situation.home.recognizer)
    return excuse("device.nothing_learned", wording, situation.now_t_ms);
  if (situation.result == nullptr || !situation.result->decision) {
    return no_picture(situation.settings, situation.now_t_ms);
  }
  return guide::room_prompt(*situation.result->decision, hint_of(*situation.result), wording,
                            nanoseconds(situation.result->t_ms));
}

// The way from where somebody stands to the nearest thing that they mean.
std::vector<guide::Prompt> way_to(const std::string& asked, const Situation& situation,
                                  const guide::Wording& wording, TimestampNs now_ns) {
  const HomeView& home = situation.home;
  const guide::UserLocation location = standing_of(situation.result);
  const auto meant =
      guide::thing_meant(asked, home.things, home.concepts.vocabulary, wording.phrases());
  if (!meant) {  // says so
    return guide::where_prompts(asked, location, home.things, {}, home.concepts.vocabulary, wording,
                                now_ns);
  }
  const guide::Pose* const pose = location.sure_pose();
  if (pose == nullptr)
    return {guide::no_route_prompt(false, "no place on the map", wording, now_ns)};
  std::optional<guide::Route> shortest;
  std::string why = "its place is not known";
  for (const guide::KnownThing& thing : home.things) {
    if (thing.name != *meant || !thing.position_gravity || !home.map || !home.map->floor) continue;
    auto route = guide::find_route(*home.map->floor, pose->position_gravity,
                                   thing.position_gravity->head<2>(), {},
                                   home.layout ? &*home.layout : nullptr, thing.room);
    if (!route) {
      why = route.error().message;
    } else if (!shortest || guide::length_m(*route) < guide::length_m(*shortest)) {
      shortest = *std::move(route);
    }
  }
  if (!shortest) return {guide::no_route_prompt(true, why, wording, now_ns)};
  return guide::route_prompts(*shortest, *pose, guide::thing(*meant).front(), doorways_of(home),
                              wording, now_ns);
}

}  // namespace

guide::Wording wording_of(const service::SpeakingSettings& settings) {
  const auto unit = settings.distances == service::Distances::kSteps ? guide::DistanceUnit::kSteps
                                                                     : guide::DistanceUnit::kMetres;
  return {&catalogue(), {spoken_language(settings.language), unit, settings.step_m}};
}

guide::UserLocation standing_of(const FrameResult* result) {
  guide::UserLocation location;
  if (result == nullptr) return location;
  if (result->place) {
    location.pose = guide::Pose{result->place->position_gravity().head<2>(),
                                result->place->heading_rad(), result->place->sigma_m};
    location.room = result->place->room;
  }
  if (!location.room && result->decision) location.room = result->decision->room();
  return location;
}

std::vector<std::string> names_of_things(const HomeView& home,
                                         const service::SpeakingSettings& settings) {
  const guide::Wording wording = wording_of(settings);
  std::set<std::string> names;
  for (const guide::KnownThing& thing : home.things) {
    names.insert(wording.phrases().called({guide::Noun::Kind::kThing, thing.name}));
  }
  return {names.begin(), names.end()};
}

guide::Prompt no_picture(const service::SpeakingSettings& settings, double now_t_ms) {
  return excuse("device.no_picture", wording_of(settings), now_t_ms);
}

std::vector<guide::Prompt> answer(const service::Ask& ask, const Situation& situation) {
  const guide::Wording wording = wording_of(situation.settings);
  const guide::UserLocation location = standing_of(situation.result);
  // What rests on a picture is true of the moment when it was taken.
  const TimestampNs now_ns =
      nanoseconds(situation.result != nullptr ? situation.result->t_ms : situation.now_t_ms);
  switch (ask.question) {
    case service::Question::kWhereAmI:
      return {where_am_i(situation, wording)};
    case service::Question::kAroundMe:
      if (situation.home.walks.empty()) {
        return {excuse("device.no_map", wording, situation.now_t_ms)};
      }
      if (situation.result == nullptr) return {no_picture(situation.settings, situation.now_t_ms)};
      return guide::around_prompts(location, situation.home.things, wording, now_ns,
                                   situation.today);
    case service::Question::kWhereIs:
      return guide::where_prompts(ask.subject, location, situation.home.things,
                                  doorways_of(situation.home), situation.home.concepts.vocabulary,
                                  wording, now_ns, situation.today);
    case service::Question::kTakeMeTo:  // who cannot be led is told
    case service::Question::kWayTo:
      return way_to(ask.subject, situation, wording, now_ns);
    case service::Question::kNameRoom:
      return {guide::named_prompt(ask.subject, wording, nanoseconds(situation.now_t_ms))};
    case service::Question::kGuide:
      return {excuse("guide.not_running", wording, situation.now_t_ms)};
    case service::Question::kRepeat:
      return {excuse("repeat.nothing", wording, situation.now_t_ms)};
  }
  return {};
}

std::vector<guide::Prompt> Announcer::after(const Situation& situation) {
  std::vector<guide::Prompt> prompts;
  const FrameResult& result = *situation.result;
  if (result.obstacle_m) {
    prompts.push_back(guide::hazard_prompt(*result.obstacle_m, wording_of(situation.settings),
                                           nanoseconds(result.t_ms)));
  }
  if (!result.decision) return prompts;
  const std::string before = std::exchange(room_now_, result.decision->room().value_or(""));
  // Two looks must agree: one may fall on a mirror, or through a door.
  const bool is_certain = !room_now_.empty() && room_now_ == before;
  if (!is_certain || room_now_ == room_called_) return prompts;
  // Nothing where it is not sure enough to be said unasked; a later look may be.
  if (auto prompt = guide::entered_prompt(*result.decision, wording_of(situation.settings),
                                          nanoseconds(result.t_ms))) {
    room_called_ = room_now_;
    prompts.push_back(*std::move(prompt));
  }
  return prompts;
}

void Announcer::answered(const Situation& situation, const std::vector<guide::Prompt>& prompts) {
  const bool names_the_room =
      std::ranges::any_of(prompts, [](const auto& one) { return one.message == "room.is"; });
  if (!names_the_room || situation.result == nullptr || !situation.result->decision) return;
  room_called_ = situation.result->decision->room().value_or(room_called_);
}

}  // namespace roomwise::live
