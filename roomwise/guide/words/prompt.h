#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "roomwise/base/timestamp.h"

namespace roomwise::guide {

// The most urgent first.
enum class Priority {
  kHazard,   // may hurt: is spoken at once, over everything
  kAnswer,   // to a question
  kNotice,   // of the device itself: the camera is dark, the connection is gone
  kCallout,  // what nobody asked for: a room that was entered
};

enum class Confidence { kSure, kProbable, kUnsure };

// What is heard before the words.
enum class Sound { kNone, kAnswer, kUnsure, kLost, kBack, kAlert };

// Something to be said to a person: one idea.
struct Prompt {
  // What it is about: "room", "thing microwave". A prompt replaces one of the same key that waits,
  // and a callout of one key with the same text is not repeated soon. An answer of several prompts
  // has the keys "around", "around/2", ...: whoever replaces the first replaces all.
  std::string replace_key;
  std::string message_id;  // its name in the catalogue: "room.is"
  std::string text;        // as it is spoken
  std::string language;    // of the text: "en"
  Priority priority = Priority::kAnswer;
  Confidence confidence = Confidence::kSure;
  Sound sound = Sound::kAnswer;
  std::string because;  // what it rests on, for people who look into it
  // By the clock that the caller gave; it must not be begun to be spoken later.
  TimestampNs valid_until_ns = 0;
};

[[nodiscard]] std::string_view to_string(Priority priority);      // "hazard", "answer", ...
[[nodiscard]] std::string_view to_string(Confidence confidence);  // "sure", "probable", "unsure"
[[nodiscard]] std::string_view to_string(Sound sound);            // "none", "answer", "unsure", ...

}  // namespace roomwise::guide
