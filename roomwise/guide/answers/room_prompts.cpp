#include "roomwise/guide/answers/room_prompts.h"

namespace roomwise::guide {
namespace {

// A room that is named with less is "probably" it: one in ten such answers may be wrong.
constexpr double kRoomSureFrom = 0.9;

bool is_sure(const rooms::RoomDecision& decision) {
  return decision.verdict == rooms::Verdict::kRoom && decision.rooms.front().score >= kRoomSureFrom;
}

std::string unsure_message(TurnHint hint) {
  return hint == TurnHint::kLeft    ? "room.unsure_left"
         : hint == TurnHint::kRight ? "room.unsure_right"
                                    : "room.unsure";
}

}  // namespace

Prompt room_prompt(const rooms::RoomDecision& decision, TurnHint hint, const Wording& wording,
                   TimestampNs now_ns) {
  const auto made = [&](std::string message, const Values& values, Confidence confidence) {
    return make_prompt(wording, "room", std::move(message), values, confidence,
                       after(now_ns, kRoomValid_s), decision.why);
  };
  if (decision.verdict == rooms::Verdict::kNoneOfThem) {
    Prompt prompt = made("room.unknown", {}, Confidence::kUnsure);
    prompt.sound = Sound::kLost;
    return prompt;
  }
  if (decision.verdict == rooms::Verdict::kEither) {
    const Values values{{"room", room(decision.rooms[0].room)},
                        {"other", room(decision.rooms[1].room)}};
    return made("room.either", values, Confidence::kProbable);
  }
  const auto name = decision.room();
  if (!name) return made(unsure_message(hint), {}, Confidence::kUnsure);
  const bool sure = is_sure(decision);
  return made(sure ? "room.is" : "room.probably", {{"room", room(*name)}},
              sure ? Confidence::kSure : Confidence::kProbable);
}

std::optional<Prompt> entered_prompt(const rooms::RoomDecision& decision, const Wording& wording,
                                     TimestampNs now_ns) {
  if (!is_sure(decision)) return std::nullopt;
  Prompt prompt = make_prompt(wording, "room", "room.entered", {{"room", room(*decision.room())}},
                              Confidence::kSure, after(now_ns, kRoomValid_s), decision.why);
  prompt.priority = Priority::kCallout;
  return prompt;
}

Prompt named_prompt(const std::string& name, const Wording& wording, TimestampNs now_ns) {
  return make_prompt(wording, "room", "room.named", {{"room", room(name)}}, Confidence::kSure,
                     after(now_ns, kNoticeValid_s), "it was named");
}

}  // namespace roomwise::guide
