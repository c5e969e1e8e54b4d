#pragma once

#include <string>

#include "roomwise/base/expected.h"
#include "roomwise/base/timestamp.h"
#include "roomwise/guide/words/message_catalogue.h"
#include "roomwise/guide/words/prompt.h"

namespace roomwise::guide {

enum class DistanceUnit { kMetres, kSteps };

// How somebody wants to be spoken to.
struct SpeakingStyle {
  std::string language = "en";
  DistanceUnit distances = DistanceUnit::kSteps;
  double step_m = 0.7;

  // A language that the catalogue speaks, a step that somebody can make.
  [[nodiscard]] Expected<void> validate(const MessageCatalogue& catalogue) const;
};

// Words for prompts. What it points to must outlive it.
struct Wording {
  const MessageCatalogue* catalogue = nullptr;
  SpeakingStyle style;

  [[nodiscard]] const Phrasebook& phrases() const { return catalogue->in(style.language); }
  // "3 steps" (rounded, one at least) or "1.5 metres" (to half a metre, a half at least).
  [[nodiscard]] std::string distance(double distance_m) const;
  // Of what is to be walked, rather less than more: who stops short is told the rest, who goes too
  // far has to come back.
  [[nodiscard]] std::string distance_to_walk(double distance_m) const;
};

// How long what is said may wait, from the moment that it rests on. A prompt that is not begun
// within it is not spoken at all: late words about places are wrong words.
constexpr double kDirectionValid_s = 2;  // somebody turns, and walks a metre or two
constexpr double kRoomValid_s = 3;       // somebody walks from one room into the next
constexpr double kHomeValid_s = 30;      // where things stand, seen from nowhere
constexpr double kHazardValid_s = 1;     // what lies ahead lies elsewhere after a step
constexpr double kNoticeValid_s = 10;    // the device's own state; a later one takes its place

// An answer of several prompts: each waits for those before it, and holds so much longer for each
// of them. Who asks what is around stands still and listens; where somebody walks on, the caller
// withdraws the rest of the answer. A direction takes 3.1 s at 175 words a minute, 4 s at 120.
constexpr double kSpokenIn_s = 4;

// About how long it takes to speak a text and the sound before it, s, at the rate of most voices
// (175 words a minute).
[[nodiscard]] double speaking_s(const std::string& text);

[[nodiscard]] constexpr TimestampNs after(TimestampNs now_ns, double seconds) {
  return now_ns + static_cast<TimestampNs>(seconds * 1e9);
}

// As people write notes: with a full stop at the end, unless there is a sign that ends it.
[[nodiscard]] std::string as_sentence(std::string note);

// An answer in the words of the catalogue; the caller sets what is different. The sound tells the
// confidence before the words do.
[[nodiscard]] Prompt make_prompt(const Wording& wording, std::string key, std::string message,
                                 const Values& values, Confidence confidence,
                                 TimestampNs valid_until_ns, std::string because = {});

// "around", "around/2", ...: the keys of an answer of several prompts, from part 0.
[[nodiscard]] std::string part_key(const std::string& whole, std::size_t part);
// One of an answer of several prompts: the first alone has a sound, and each holds as much longer
// as those before it take to speak.
[[nodiscard]] Prompt make_part(const Wording& wording, const std::string& whole, std::size_t part,
                               std::string message, const Values& values, Confidence confidence,
                               TimestampNs now_ns, double valid_s, std::string because);

}  // namespace roomwise::guide
