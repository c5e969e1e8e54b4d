#include "roomwise/guide/answers/teaching_prompts.h"

#include <array>

namespace roomwise::guide {
namespace {

constexpr double kTeachingValid_s = 6;
constexpr std::array<std::string_view, 18> kSteps{
    "teach.begin",  "teach.go_on",   "teach.enough",  "teach.more",     "teach.learning",
    "teach.taught", "teach.no_walk", "teach.name",    "teach.too_many", "teach.no_camera",
    "teach.failed", "teach.stopped", "own.forgotten", "own.not_erased", "own.shared",
    "own.kept",     "own.not_own",   "own.busy"};

bool has_name(TeachingStep step) {
  switch (step) {
    case TeachingStep::kTaught:
    case TeachingStep::kTaughtNotLookedFor:
    case TeachingStep::kForgotten:
    case TeachingStep::kNotErased:
    case TeachingStep::kShared:
    case TeachingStep::kKept:
    case TeachingStep::kNotOwn:
      return true;
    default:
      return false;
  }
}

}  // namespace

Prompt teaching_prompt(TeachingStep step, const std::string& name, const Wording& wording,
                       TimestampNs now_ns, const std::string& because) {
  Values values;
  if (has_name(step)) values["thing"] = thing(name);
  return make_prompt(wording, "teaching", std::string(kSteps.at(static_cast<std::size_t>(step))),
                     values, Confidence::kSure, after(now_ns, kTeachingValid_s), because);
}

Prompt fault_prompt(objects::ShowFault fault, const Wording& wording, TimestampNs now_ns) {
  return make_prompt(wording, "teaching", "teach." + std::string(objects::name_of(fault)), {},
                     Confidence::kUnsure, after(now_ns, kTeachingValid_s), "by the last picture");
}

}  // namespace roomwise::guide
