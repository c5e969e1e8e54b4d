#include "roomwise/guide/words/wording.h"

#include <algorithm>
#include <cmath>

namespace roomwise::guide {

Expected<void> SpeakingStyle::validate(const MessageCatalogue& catalogue) const {
  if (!catalogue.speaks(language)) {
    std::string known;
    for (const auto& name : catalogue.languages()) known += (known.empty() ? "" : ", ") + name;
    return fail("language \"{}\" is not spoken; expected one of {}", language, known);
  }
  if (!(step_m >= 0.2 && step_m <= 1.5)) {
    return fail("step_m is {}; expected 0.2 to 1.5", step_m);
  }
  return {};
}

std::string Wording::distance(double distance_m) const {
  if (style.distances == DistanceUnit::kSteps) {
    return phrases().count("step", std::max(1.0, std::round(distance_m / style.step_m)));
  }
  return phrases().count("metre", std::max(0.5, std::round(distance_m * 2) / 2));
}

// Going too far costs twice, so a third of the roundings may.
std::string Wording::distance_to_walk(double distance_m) const {
  constexpr double kLess = 0.5 - 1.0 / 3;
  constexpr double kHalfMetre_m = 0.5;
  const bool in_steps = style.distances == DistanceUnit::kSteps;
  return distance(distance_m - kLess * (in_steps ? style.step_m : kHalfMetre_m));
}

double speaking_s(const std::string& text) {
  constexpr double kSound_s = 0.3, kLetter_s = 0.065;
  return kSound_s + kLetter_s * static_cast<double>(text.size());
}

Prompt make_prompt(const Wording& wording, std::string key, std::string message,
                   const Values& values, Confidence confidence, TimestampNs valid_until_ns,
                   std::string because) {
  Prompt prompt;
  prompt.replace_key = std::move(key);
  prompt.text = wording.phrases().text(message, values);
  prompt.message_id = std::move(message);
  prompt.language = wording.style.language;
  prompt.confidence = confidence;
  prompt.sound = confidence == Confidence::kUnsure ? Sound::kUnsure : Sound::kAnswer;
  prompt.valid_until_ns = valid_until_ns;
  prompt.because = std::move(because);
  return prompt;
}

std::string part_key(const std::string& whole, std::size_t part) {
  return part == 0 ? whole : fmt::format("{}/{}", whole, part + 1);
}

Prompt make_part(const Wording& wording, const std::string& whole, std::size_t part,
                 std::string message, const Values& values, Confidence confidence,
                 TimestampNs now_ns, double valid_s, std::string because) {
  Prompt prompt = make_prompt(
      wording, part_key(whole, part), std::move(message), values, confidence,
      after(now_ns, valid_s + kSpokenIn_s * static_cast<double>(part)), std::move(because));
  if (part > 0) prompt.sound = Sound::kNone;
  return prompt;
}

std::string as_sentence(std::string note) {
  if (!note.empty() && std::string_view(".!?").find(note.back()) == std::string_view::npos) {
    note += '.';
  }
  return note;
}

}  // namespace roomwise::guide
