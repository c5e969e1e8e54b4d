#include "roomwise/guide/grammar/grammar.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "roomwise/base/in_context.h"
#include "roomwise/guide/grammar/folded_words.h"

namespace roomwise::guide {
namespace {

constexpr std::size_t kMaxWaysOfOne = 4096;  // that a pattern stands for

constexpr std::array<std::pair<std::string_view, Slot>, 7> kSlots{{{"{thing}", Slot::kThing},
                                                                   {"{surface}", Slot::kSurface},
                                                                   {"{room}", Slot::kRoom},
                                                                   {"{place}", Slot::kPlace},
                                                                   {"{goal}", Slot::kGoal},
                                                                   {"{spot}", Slot::kSpot},
                                                                   {"{new}", Slot::kNew}}};

// Reads "where (is|are) [all] {place}" into all the texts that it stands for.
class PatternReader {
 public:
  explicit PatternReader(std::string_view text) : rest_(text) {}

  Expected<std::vector<std::string>> read() {
    ROOMWISE_TRY(std::vector<std::string> all, alternatives());
    if (!rest_.empty()) return fail("\"{}\" closes nothing", rest_.substr(0, 1));
    return all;
  }

 private:
  Expected<std::vector<std::string>> alternatives() {
    std::vector<std::string> all;
    while (true) {
      ROOMWISE_TRY(std::vector<std::string> some, sequence());
      all.insert(all.end(), some.begin(), some.end());
      if (!rest_.starts_with('|')) return all;
      rest_.remove_prefix(1);
    }
  }

  Expected<std::vector<std::string>> sequence() {
    std::vector<std::string> all{""};
    while (!rest_.empty() && rest_.find_first_of(")]|") != 0) {
      ROOMWISE_TRY(const std::vector<std::string> next, part());
      if (all.size() * next.size() > kMaxWaysOfOne)
        return fail("it stands for too many ways to ask");
      std::vector<std::string> longer;
      for (const std::string& begin : all) {
        for (const std::string& end : next) longer.push_back(begin + end);
      }
      all = std::move(longer);
    }
    return all;
  }

  Expected<std::vector<std::string>> part() {
    const char open = rest_.front();
    if (open != '(' && open != '[') {
      const std::string_view words = rest_.substr(0, rest_.find_first_of("()[]|"));
      rest_.remove_prefix(words.size());
      return std::vector<std::string>{std::string(words)};
    }
    rest_.remove_prefix(1);
    ROOMWISE_TRY(std::vector<std::string> all, alternatives());
    const char close = open == '(' ? ')' : ']';
    if (!rest_.starts_with(close)) return fail("\"{}\" is not closed", open);
    rest_.remove_prefix(1);
    if (open == '[') all.emplace_back();
    return all;
  }

  std::string_view rest_;
};

Expected<QuestionPattern> pattern_of(QuestionType type, std::string_view text) {
  QuestionPattern pattern{.type = type, .before = {}, .slot = std::nullopt, .after = {}};
  const std::size_t open = std::min(text.find('{'), text.size());
  const std::size_t close = std::min(text.find('}', open), text.size());
  pattern.before = folded_words(text.substr(0, open));
  if (open < text.size()) {
    const std::string_view name = text.substr(open, close - open + 1);
    const auto* const slot =
        std::ranges::find(kSlots, name, [](const auto& one) { return one.first; });
    if (slot == kSlots.end()) return fail("there is no \"{}\"", name);
    pattern.slot = slot->second;
    const std::string_view after = text.substr(close + 1);
    if (after.find('{') != std::string_view::npos) return fail("it has two names");
    pattern.after = folded_words(after);
  }
  if (pattern.before.empty() && !pattern.slot) return fail("it may be empty");
  return pattern;
}

Expected<DoorPattern> door_pattern_of(std::string_view text) {
  constexpr std::string_view kRoom = "{room}";
  const auto take_until_room = [&] {
    const std::size_t at = text.find(kRoom);
    const std::string_view words = text.substr(0, at);
    text.remove_prefix(at == std::string_view::npos ? text.size() : at + kRoom.size());
    return std::pair(words, at != std::string_view::npos);
  };
  DoorPattern pattern;
  const auto [before, has_one] = take_until_room();
  if (!has_one) return fail("it names no room");
  pattern.before = folded_words(before);
  const bool is_joined = !text.empty() && text.front() != ' ' && text.front() != '\'';
  const auto [next, has_two] = take_until_room();
  pattern.has_two_rooms = has_two;
  (has_two ? pattern.between : pattern.after) = folded_words(next);
  if (has_two) pattern.after = folded_words(text);
  if (is_joined && !has_two && pattern.after.size() == 1) {
    pattern.joined = std::exchange(pattern.after, {}).front();
  }
  if (has_two ? pattern.between.empty() : before.empty() && next.empty()) {
    return fail("nothing says that it is a door, or parts its rooms");
  }
  return pattern;
}

// "where is {place}" for words that mean the same by themselves.
std::string text_of(const QuestionPattern& pattern) {
  std::string text;
  for (const std::string& word : pattern.before) text += word + " ";
  if (pattern.slot) text += std::string(kSlots.at(static_cast<std::size_t>(*pattern.slot)).first);
  for (const std::string& word : pattern.after) text += " " + word;
  return text;
}

Expected<void> add_patterns(QuestionType type, std::string_view text,
                            std::map<std::string, QuestionType>& types,
                            std::vector<QuestionPattern>& patterns) {
  ROOMWISE_TRY(const std::vector<std::string> ways, PatternReader(text).read());
  for (const std::string& way : ways) {
    ROOMWISE_TRY(QuestionPattern pattern, pattern_of(type, way));
    const auto [known, is_new] = types.emplace(text_of(pattern), type);
    if (known->second != type) return fail("\"{}\" asks something else, too", known->first);
    if (is_new) patterns.push_back(std::move(pattern));
  }
  return {};
}

using Texts = std::vector<std::vector<std::string>>;

Texts folded_texts(const nlohmann::json& texts) {
  Texts all;
  for (const auto& text : texts) all.push_back(folded_words(text.get<std::string>()));
  std::erase_if(all, [](const auto& words) { return words.empty(); });
  return all;
}

// Patterns without a slot, written out; the longest first.
Expected<Texts> written_out(const nlohmann::json& patterns) {
  Texts all;
  for (const auto& pattern : patterns) {
    const auto text = pattern.get<std::string>();
    ROOMWISE_TRY(const std::vector<std::string> ways, in_context(text, PatternReader(text).read()));
    for (const std::string& way : ways) all.push_back(folded_words(way));
  }
  std::erase_if(all, [](const auto& words) { return words.empty(); });
  std::ranges::stable_sort(all, std::ranges::greater{}, &std::vector<std::string>::size);
  return all;
}

Expected<Corrections> corrections_of(const nlohmann::json& json) {
  Corrections corrections;
  ROOMWISE_TRY(corrections.openers, written_out(json.at("openers")));
  ROOMWISE_TRY(corrections.closers, written_out(json.at("closers")));
  ROOMWISE_TRY(corrections.denials, written_out(json.at("denials")));
  ROOMWISE_TRY(corrections.denials_after, written_out(json.at("denials_after")));
  ROOMWISE_TRY(corrections.but, written_out(json.at("but")));
  return corrections;
}

bool holds_one(std::span<const std::string> words, const Texts& texts) {
  return std::ranges::any_of(texts, [&](const std::vector<std::string>& text) {
    return !std::ranges::search(words, text).empty();
  });
}

std::set<std::string> word_set(const nlohmann::json& words) {
  std::set<std::string> all;
  for (const auto& word : words) {
    for (std::string& folded : folded_words(word.get<std::string>())) all.insert(std::move(folded));
  }
  return all;
}

}  // namespace

Expected<Grammar> Grammar::parse(const nlohmann::json& questions) {
  Grammar grammar;
  std::map<std::string, std::vector<std::string>> patterns;
  std::vector<std::string> doors;
  try {
    questions.at("patterns").get_to(patterns);
    grammar.determiners_ = word_set(questions.at("determiners"));
    grammar.possessives_ = word_set(questions.at("possessives"));
    grammar.inside_ = word_set(questions.at("inside"));
    grammar.generic_ = word_set(questions.at("generic"));
    questions.at("alike").get_to(grammar.alike_);
    grammar.joins_ = folded_texts(questions.at("joins"));
    grammar.negations_ = word_set(questions.at("negations"));
    grammar.fillers_ = folded_texts(questions.at("fillers"));
    grammar.stops_ = folded_texts(questions.at("stops"));
    grammar.waits_ = folded_texts(questions.at("waits"));
    questions.at("endings").get_to(grammar.endings_);
    questions.at("doors").get_to(doors);
    questions.at("digraphs").get_to(grammar.digraphs_);
    ROOMWISE_TRY(grammar.corrections_,
                 in_context("questions: corrections", corrections_of(questions.at("corrections"))));
  } catch (const nlohmann::json::exception& error) {
    return fail("questions: {}", error.what());
  }
  if (!std::ranges::includes(grammar.determiners_, grammar.possessives_)) {
    return fail("questions: a possessive is no determiner; name it under both");
  }
  std::ranges::stable_sort(grammar.fillers_, std::ranges::greater{},
                           &std::vector<std::string>::size);
  for (const std::string& text : doors) {
    ROOMWISE_TRY(const std::vector<std::string> ways, in_context(text, PatternReader(text).read()));
    for (const std::string& way : ways) {
      ROOMWISE_TRY(grammar.doors_.emplace_back(), in_context(way, door_pattern_of(way)));
    }
  }
  std::map<std::string, QuestionType> types;
  for (const auto& [name, type] : kQuestionTypes) {
    const auto found = patterns.find(std::string(name));
    if (found == patterns.end() || found->second.empty()) {
      return fail("questions: there is no pattern of \"{}\"", name);
    }
    for (const std::string& text : found->second) {
      if (auto added = add_patterns(type, text, types, grammar.patterns_); !added) {
        return fail("questions: \"{}\", \"{}\": {}", name, text, added.error().message);
      }
    }
    patterns.erase(found);
  }
  for (const QuestionPattern& pattern : grammar.patterns_) {
    grammar.own_words_.insert(pattern.before.begin(), pattern.before.end());
    grammar.own_words_.insert(pattern.after.begin(), pattern.after.end());
  }
  for (const auto& words : grammar.fillers_) {
    grammar.own_words_.insert(words.begin(), words.end());
  }
  if (!patterns.empty()) return fail("questions: there is no type \"{}\"", patterns.begin()->first);
  return grammar;
}

std::string Grammar::without_digraphs(const std::string& word) const {
  if (knows(word) || is_determiner(word)) return word;
  std::string plain = word;
  for (const auto& [typed, letter] : digraphs_) {
    for (std::size_t at = plain.find(typed); at != std::string::npos; at = plain.find(typed, at)) {
      plain.replace(at, typed.size(), letter);
      at += letter.size();
    }
  }
  return plain;
}

std::set<std::string> Grammar::rooms_alike(const std::string& room) const {
  std::set<std::string> all{room};
  for (const auto& group : alike_) {
    if (group.contains(room)) all.insert(group.begin(), group.end());
  }
  return all;
}

bool Grammar::says_stop(std::span<const std::string> words) const {
  return holds_one(words, stops_);
}

bool Grammar::says_wait(std::span<const std::string> words) const {
  return holds_one(words, waits_);
}

bool Grammar::denies(std::span<const std::string> words) const {
  return std::ranges::any_of(words,
                             [&](const std::string& word) { return negations_.contains(word); });
}

std::vector<std::string> Grammar::without_fillers(std::vector<std::string> words) const {
  for (std::size_t at = 0; at < words.size();) {
    const auto begin = words.begin() + static_cast<std::ptrdiff_t>(at);
    const auto stands_here = [&](const std::vector<std::string>& filler) {
      return filler.size() <= words.size() - at && std::equal(filler.begin(), filler.end(), begin);
    };
    const auto filler = std::ranges::find_if(fillers_, stands_here);
    if (filler == fillers_.end()) {
      ++at;
    } else {
      words.erase(begin, begin + static_cast<std::ptrdiff_t>(filler->size()));
    }
  }
  return words;
}

}  // namespace roomwise::guide
