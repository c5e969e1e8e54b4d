#include "roomwise/guide/answers/people_prompts.h"

#include <algorithm>
#include <limits>
#include <string>

namespace roomwise::guide {
namespace {

const char* message_of(SeenPerson::Side side) {
  switch (side) {
    case SeenPerson::Side::kLeft:
      return "people.left";
    case SeenPerson::Side::kRight:
      return "people.right";
    case SeenPerson::Side::kAhead:
      break;
  }
  return "people.ahead";
}

}  // namespace

std::vector<Prompt> people_prompts(std::span<const SeenPerson> people, const Wording& wording,
                                   TimestampNs now_ns) {
  const auto say = [&](std::size_t part, const std::string& message, const Values& values,
                       Confidence confidence) {
    return make_part(wording, "people", part, message, values, confidence, now_ns,
                     kDirectionValid_s, "what the detector sees in the newest picture");
  };
  std::vector<SeenPerson> sure;
  std::ranges::copy_if(people, std::back_inserter(sure), &SeenPerson::is_sure);
  if (sure.empty() && !people.empty()) return {say(0, "people.perhaps", {}, Confidence::kUnsure)};
  if (sure.empty()) return {say(0, "people.none", {}, Confidence::kSure)};
  std::vector<Prompt> prompts;
  if (sure.size() > 1) {
    prompts.push_back(
        say(0, "people.count", {{"count", fmt::format("{}", sure.size())}}, Confidence::kSure));
  }
  // Whose distance is not known is told of last: boxes say little of it.
  const auto nearest = std::ranges::min_element(sure, {}, [](const SeenPerson& one) {
    return one.distance_m.value_or(std::numeric_limits<double>::infinity());
  });
  std::string message = message_of(nearest->side);
  Values values;
  if (nearest->distance_m) {
    message += "_at";
    values["distance"] = wording.distance(*nearest->distance_m);
  }
  prompts.push_back(say(prompts.size(), message, values, Confidence::kSure));
  return prompts;
}

Prompt no_eyes_prompt(const Wording& wording, TimestampNs now_ns) {
  return make_part(wording, "people", 0, "people.cannot", {}, Confidence::kUnsure, now_ns,
                   kNoticeValid_s, "no detector that is used here knows people");
}

std::vector<Prompt> light_prompts(bool is_dark, const Wording& wording, TimestampNs now_ns) {
  const auto say = [&](std::size_t part, const char* message, Confidence confidence) {
    return make_part(wording, "light", part, message, {}, confidence, now_ns, kRoomValid_s,
                     "by the newest picture");
  };
  return {say(0, is_dark ? "light.dark" : "light.bright", Confidence::kSure),
          say(1, "light.which", Confidence::kUnsure)};
}

}  // namespace roomwise::guide
