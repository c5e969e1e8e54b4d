#include "roomwise/guide/questions/word_prompts.h"

#include "roomwise/guide/answers/seen_prompt.h"

namespace roomwise::guide {
namespace {

constexpr const char* kKey = "word";

}  // namespace

std::optional<std::string> word_to_look_for(const Understood& heard, const Phrasebook& phrases) {
  const bool asks_for_place = heard.type == QuestionType::kWhereIs ||
                              heard.type == QuestionType::kWayTo ||
                              heard.type == QuestionType::kTakeMeTo;
  if (heard.outcome != Understood::Outcome::kUnknownName || !asks_for_place) return std::nullopt;
  const Noun& noun = heard.names.front();
  if (noun.kind != Noun::Kind::kThing) return std::nullopt;
  // The words that the language knows are the home's, which are English.
  const bool is_english =
      phrases.language() == "en" || phrases.words(Noun::Kind::kThing).contains(noun.name);
  return is_english ? std::optional(noun.name) : std::nullopt;
}

std::vector<Prompt> looking_prompts(const std::string& thing, const Wording& wording,
                                    TimestampNs now_ns) {
  const std::string why = "no label or name of the home means it";
  return {make_part(wording, kKey, 0, "where.unknown", {{"thing", guide::thing(thing)}},
                    Confidence::kUnsure, now_ns, kHomeValid_s, why),
          make_part(wording, kKey, 1, "word.looking", {}, Confidence::kUnsure, now_ns, kHomeValid_s,
                    why)};
}

std::vector<Prompt> word_prompts(const std::string& thing, const std::optional<SeenWord>& seen,
                                 const std::optional<CalendarTime>& today, const Wording& wording,
                                 TimestampNs now_ns) {
  const std::string why = "what networks say of the home's pictures, beside words of absent things";
  Values values{{"thing", guide::thing(thing)}};
  const auto say = [&](std::size_t part, const char* message, const Values& of) {
    return make_part(wording, kKey, part, message, of, Confidence::kUnsure, now_ns, kHomeValid_s,
                     why);
  };
  if (!seen) return {say(0, "word.none", values)};
  const char* const where = seen->room ? "word.maybe" : "word.maybe_somewhere";
  if (seen->room) values.emplace("room", room(*seen->room));
  std::vector<Prompt> prompts{say(0, where, values)};
  if (auto when = seen_prompt(part_key(kKey, 1), seen->seen, today, wording, now_ns, why)) {
    prompts.push_back(*std::move(when));
  }
  prompts.push_back(say(prompts.size(), "word.unsure", {}));
  return prompts;
}

}  // namespace roomwise::guide
