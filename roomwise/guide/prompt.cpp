#include "roomwise/guide/prompt.h"

namespace roomwise::guide {

std::string_view to_string(Priority priority) {
  switch (priority) {
    case Priority::kHazard:
      return "hazard";
    case Priority::kAnswer:
      return "answer";
    case Priority::kNotice:
      return "notice";
    case Priority::kCallout:
      return "callout";
  }
  return "unknown";
}

std::string_view to_string(Confidence confidence) {
  switch (confidence) {
    case Confidence::kSure:
      return "sure";
    case Confidence::kProbable:
      return "probable";
    case Confidence::kUnsure:
      return "unsure";
  }
  return "unknown";
}

std::string_view to_string(Sound sound) {
  switch (sound) {
    case Sound::kNone:
      return "none";
    case Sound::kAnswer:
      return "answer";
    case Sound::kUnsure:
      return "unsure";
    case Sound::kLost:
      return "lost";
    case Sound::kBack:
      return "back";
    case Sound::kAlert:
      return "alert";
  }
  return "unknown";
}

}  // namespace roomwise::guide
