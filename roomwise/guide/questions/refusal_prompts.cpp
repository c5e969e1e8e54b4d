#include "roomwise/guide/questions/refusal_prompts.h"

#include <algorithm>

#include "roomwise/objects/kinds/kinds.h"

namespace roomwise::guide {
namespace {

// Something large, where the home has it.
const std::string& example_of(const HomeNames& home) {
  const auto found = std::ranges::find_if(home.things, [](const std::string& name) {
    const objects::Kind* const kind = objects::find_kind(name);
    return kind != nullptr && kind->stands_on_floor;
  });
  return found == home.things.end() ? home.things.front() : *found;
}

class Refusal {
 public:
  Refusal(const Wording& wording, TimestampNs now_ns, Confidence confidence, const char* because)
      : wording_(wording), now_ns_(now_ns), confidence_(confidence), because_(because) {}

  void say(const std::string& message, const Values& values = {}) {
    prompts_.push_back(make_part(wording_, "ask", prompts_.size(), message, values, confidence_,
                                 now_ns_, kHomeValid_s, because_));
  }
  void say_examples(const HomeNames& home) {
    say("ask.examples");
    if (!home.things.empty()) say("ask.examples_thing", {{"thing", thing(example_of(home))}});
    if (!home.rooms.empty()) say("ask.examples_room", {{"room", room(home.rooms.front())}});
  }
  // Nobody is called: who hears that can do it themselves while there is time.
  void say_emergency(const std::optional<std::string>& in_room, bool is_help) {
    say("ask.emergency");
    if (in_room) say("room.is", {{"room", room(*in_room)}});
    say("ask.emergency_out");
    if (is_help) say("ask.emergency_help");
  }
  [[nodiscard]] std::vector<Prompt> take() { return std::move(prompts_); }

 private:
  const Wording& wording_;
  TimestampNs now_ns_;
  Confidence confidence_;
  const char* because_;
  std::vector<Prompt> prompts_;
};

}  // namespace

std::vector<Prompt> example_prompts(const HomeNames& home, const Wording& wording,
                                    TimestampNs now_ns) {
  Refusal refusal(wording, now_ns, Confidence::kSure, "these can be asked");
  refusal.say_examples(home);
  if (!home.rooms.empty()) refusal.say("ask.examples_spot");
  return refusal.take();
}

std::vector<Prompt> refusal_prompts(const Understood& heard, const HomeNames& home,
                                    const Wording& wording, TimestampNs now_ns,
                                    const Circumstances& now) {
  using Outcome = Understood::Outcome;
  Refusal refusal(wording, now_ns, Confidence::kUnsure,
                  "what was asked is no question that can be answered");
  const bool is_help = heard.type == QuestionType::kHelp;
  if (heard.outcome == Outcome::kQuestion && (is_help || heard.type == QuestionType::kEmergency)) {
    refusal.say_emergency(now.room, is_help);
    return refusal.take();
  }
  if (heard.outcome == Outcome::kQuestion && heard.type == QuestionType::kSettings) {
    refusal.say("ask.settings");
    refusal.say("ask.settings_sound");
    return refusal.take();
  }
  switch (heard.outcome) {
    case Outcome::kWhichOne:
      refusal.say("ask.which_one", {{"names", heard.names}});
      return refusal.take();
    case Outcome::kWhichRoom:
      refusal.say("ask.which_room", {{"thing", heard.names}, {"rooms", heard.rooms}});
      return refusal.take();
    case Outcome::kWhichDoor:
      refusal.say("ask.which_door", {{"rooms", Nouns(heard.rooms.begin() + 1, heard.rooms.end())}});
      return refusal.take();
    case Outcome::kDidYouMean:
      refusal.say("ask.did_you_mean", {{"name", heard.names}});
      return refusal.take();
    case Outcome::kDeclined:
      refusal.say("ask.all_right");
      return refusal.take();
    case Outcome::kUnknownName:
      refusal.say("where.unknown", {{"thing", heard.names}});
      break;
    case Outcome::kCannotTell:
      refusal.say("ask.cannot");
      break;
    case Outcome::kQuestion:  // a "yes" to nothing
    case Outcome::kNotUnderstood:
      refusal.say("ask.not_understood");
      break;
  }
  if (!now.is_led) refusal.say_examples(home);
  return refusal.take();
}

}  // namespace roomwise::guide
