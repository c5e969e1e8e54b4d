#include "roomwise/guide/answers/spot_prompts.h"

#include <algorithm>

namespace roomwise::guide {
namespace {

constexpr double kSpotValid_s = 6;

std::string message_of(SpotStep step, bool has_name) {
  switch (step) {
    case SpotStep::kMarked:
      return has_name ? "spot.marked" : "spot.marked_here";
    case SpotStep::kNotSure:
      return "spot.not_sure";
    case SpotStep::kOtherName:
      return "teach.name";
    case SpotStep::kBadName:
      return "spot.bad_name";
    case SpotStep::kTooMany:
      return "spot.too_many";
    case SpotStep::kForgotten:
      return "own.forgotten";
    case SpotStep::kNotErased:
      return "own.not_erased";
    case SpotStep::kRenamed:
      return "spot.renamed";
    case SpotStep::kNotYours:
      return "spot.not_yours";
    case SpotStep::kNoWayBack:
      return "spot.no_way_back";
    case SpotStep::kBusy:
      break;
  }
  return "own.busy";
}

bool is_done(SpotStep step) {
  return step == SpotStep::kMarked || step == SpotStep::kForgotten || step == SpotStep::kRenamed;
}

}  // namespace

Prompt spot_prompt(SpotStep step, const std::string& name, const Wording& wording,
                   TimestampNs now_ns, const std::string& because) {
  const Nouns spot = thing(name.empty() ? kRememberedPlace : name);
  return make_prompt(wording, "spot", message_of(step, !name.empty()),
                     {{"spot", spot}, {"thing", spot}},
                     is_done(step) ? Confidence::kSure : Confidence::kUnsure,
                     after(now_ns, kSpotValid_s), because);
}

std::vector<Prompt> spots_prompts(const std::vector<std::string>& names, const Wording& wording,
                                  TimestampNs now_ns) {
  constexpr std::size_t kInOne = 3;  // who listens remembers no more
  std::vector<Prompt> prompts;
  for (std::size_t first = 0; first < names.size(); first += kInOne) {
    const auto begin = names.begin() + static_cast<std::ptrdiff_t>(first);
    const auto end =
        names.begin() + static_cast<std::ptrdiff_t>(std::min(first + kInOne, names.size()));
    prompts.push_back(
        make_part(wording, "spot", prompts.size(), first == 0 ? "spot.list" : "describe.then",
                  {{"spots", thing_list({begin, end})}, {"things", thing_list({begin, end})}},
                  Confidence::kSure, now_ns, kHomeValid_s, "these were marked"));
  }
  if (prompts.empty()) {
    prompts.push_back(make_part(wording, "spot", 0, "spot.none", {}, Confidence::kSure, now_ns,
                                kHomeValid_s, "nothing was marked"));
  }
  return prompts;
}

}  // namespace roomwise::guide
