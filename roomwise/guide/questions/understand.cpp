#include "roomwise/guide/questions/understand.h"

#include <algorithm>
#include <map>
#include <tuple>

#include "roomwise/guide/grammar/folded_words.h"
#include "roomwise/guide/grammar/grammar.h"
#include "roomwise/guide/questions/name_index.h"

namespace roomwise::guide {
namespace {

using Outcome = Understood::Outcome;

constexpr std::size_t kMaxWords = 40;
constexpr std::size_t kMaxWordsOfAName = 5;  // that nobody gave; more are no name

// One way to read a text.
struct Reading {
  const QuestionPattern* pattern = nullptr;
  FoundName name;  // kKnown where the pattern has no slot
  std::vector<std::string> said;

  [[nodiscard]] auto rank() const {
    const auto own_words = static_cast<int>(pattern->before.size() + pattern->after.size());
    return std::tuple(name.match, -own_words, said.size());
  }
};

constexpr std::size_t kMaxWordsOfAStop = 6;

bool is_word(const std::string& wanted, const std::string& said, bool forgives) {
  return wanted == said || (forgives && slips_between(wanted, said) <= forgiven_slips(wanted));
}

// Whether slips in the pattern's words are forgiven for what was said. Nothing but one word tells
// an order: what means something else is none with a slip ("hall", "halt").
bool may_have_slips(const QuestionPattern& pattern, std::span<const std::string> words,
                    const NameIndex& names, const Grammar& grammar) {
  if (pattern.type == QuestionType::kEmergency || pattern.type == QuestionType::kHelp) return false;
  const bool is_word_alone = !pattern.slot && words.size() == 1;
  return !is_word_alone || !(names.is_name(words.front()) || grammar.knows(words.front()));
}

// What stands in the slot; nothing where the words are no such question. Empty without a slot.
std::optional<std::span<const std::string>> words_in_slot(const QuestionPattern& pattern,
                                                          std::span<const std::string> words,
                                                          bool forgives) {
  const std::size_t own = pattern.before.size() + pattern.after.size();
  if (pattern.slot ? words.size() <= own : words.size() != own) return std::nullopt;
  const auto agree = [&](const std::vector<std::string>& wanted,
                         std::span<const std::string> said) {
    return std::ranges::equal(wanted, said, [&](const std::string& one, const std::string& other) {
      return is_word(one, other, forgives);
    });
  };
  const bool is_asked = agree(pattern.before, words.first(pattern.before.size())) &&
                        agree(pattern.after, words.last(pattern.after.size()));
  if (!is_asked) return std::nullopt;
  return words.subspan(pattern.before.size(), words.size() - own);
}

// That somebody may call something so. Of "is there a cup on the table" no name is left to deny:
// the home has a table, and "I know no cup on the table" would say more than anybody knows.
bool is_believed(const QuestionPattern& pattern, std::span<const std::string> said,
                 const NameIndex& names) {
  const bool is_name_alone = pattern.before.empty() && pattern.after.empty();
  if (is_name_alone || said.size() > kMaxWordsOfAName) return false;
  return pattern.type == QuestionType::kCannotTell || !names.has_name_inside(said);
}

// Of questions whose answer can be the one in a room.
bool asks_for_place(QuestionType type) {
  return type == QuestionType::kWhereIs || type == QuestionType::kWayTo ||
         type == QuestionType::kTakeMeTo;
}

std::optional<Reading> read_as(const QuestionPattern& pattern, std::span<const std::string> words,
                               const NameIndex& names, bool forgives) {
  const auto inside = words_in_slot(pattern, words, forgives);
  if (!inside) return std::nullopt;
  Reading reading{&pattern, {NameMatch::kKnown, {}}, {}};
  if (!pattern.slot) return reading;
  if (pattern.slot == Slot::kNew) {
    reading.said = names.new_name(*inside);
    if (reading.said.empty() || reading.said.size() > kMaxWordsOfAName) return std::nullopt;
    return reading;
  }
  reading.name = names.find(*inside, *pattern.slot);
  if (reading.name.match != NameMatch::kKnown && asks_for_place(pattern.type)) {
    FoundName in_room = names.find_in_room(*inside);
    if (in_room.match == NameMatch::kKnown) reading.name = std::move(in_room);
  }
  const bool may_be_door = pattern.slot == Slot::kPlace || pattern.slot == Slot::kGoal;
  if (reading.name.match != NameMatch::kKnown && may_be_door) {
    FoundName door = names.find_door(*inside);
    if (door.match != NameMatch::kUnknown) reading.name = std::move(door);
  }
  const auto said = names.without_determiners(*inside);
  reading.said.assign(said.begin(), said.end());
  if (reading.name.match == NameMatch::kUnknown && !is_believed(pattern, said, names)) {
    return std::nullopt;
  }
  return reading;
}

std::optional<Reading> best_reading(std::span<const std::string> words, const Grammar& grammar,
                                    const NameIndex& names, bool forgives) {
  std::optional<Reading> best;
  for (const QuestionPattern& pattern : grammar.patterns()) {
    const bool forgives_here = forgives && may_have_slips(pattern, words, names, grammar);
    auto reading = read_as(pattern, words, names, forgives_here);
    if (reading && (!best || reading->rank() < best->rank())) best = std::move(reading);
  }
  return best;
}

bool is_whole(const std::optional<Reading>& reading) {
  return reading && reading->name.match == NameMatch::kKnown;
}

// How each word was written, by its folded form.
using Spellings = std::map<std::string, std::string>;

Noun noun_said(const std::vector<std::string>& words, const Spellings& spellings) {
  std::string name;
  for (const std::string& word : words) name += (name.empty() ? "" : " ") + spellings.at(word);
  return {Noun::Kind::kThing, name};
}

Understood meaning_of(Reading reading, const Spellings& spellings) {
  Understood meaning{.type = reading.pattern->type,
                     .names = std::move(reading.name.nouns),
                     .rooms = std::move(reading.name.rooms)};
  if (meaning.type == QuestionType::kCannotTell) {
    return {.outcome = Outcome::kCannotTell, .type = meaning.type, .names = {}};
  }
  if (reading.name.is_one_room) {
    meaning.outcome = Outcome::kWhichRoom;
    return meaning;
  }
  if (reading.pattern->slot == Slot::kNew) {
    meaning.outcome = Outcome::kQuestion;
    meaning.names = {noun_said(reading.said, spellings)};
    return meaning;
  }
  switch (reading.name.match) {
    case NameMatch::kKnown:
      meaning.outcome = meaning.names.size() > 1 ? Outcome::kWhichOne : Outcome::kQuestion;
      break;
    case NameMatch::kNear:
      meaning.outcome = meaning.names.size() > 1 ? Outcome::kWhichOne : Outcome::kDidYouMean;
      break;
    case NameMatch::kAbsent:
      meaning.outcome = Outcome::kUnknownName;
      break;
    case NameMatch::kUnknown:
      meaning.outcome = Outcome::kUnknownName;
      meaning.names = {noun_said(reading.said, spellings)};
      break;
  }
  return meaning;
}

std::vector<std::string> without_repeats(std::vector<std::string> words) {
  words.erase(std::ranges::unique(words).begin(), words.end());
  return words;
}

}  // namespace

Understood understand(std::string_view text, const Phrasebook& phrases, const HomeNames& home) {
  if (text.size() > kMaxQuestionBytes) return {};
  std::vector<std::string> whole;
  Spellings spellings;
  for (const SpelledWord& word : spelled_words(text)) {
    whole.push_back(word.folded);
    spellings.emplace(word.folded, word.spelling);
  }
  if (whole.size() > kMaxWords) return {};
  const Grammar& grammar = phrases.grammar();
  const NameIndex names(phrases, home);
  // A name may hold what says nothing elsewhere, so the text counts first as it is.
  std::optional<Reading> first;
  for (const bool forgives : {false, true}) {
    const auto without_fillers = grammar.without_fillers(whole);
    for (const auto& words : {whole, without_fillers, without_repeats(without_fillers)}) {
      auto reading = best_reading(words, grammar, names, forgives);
      if (is_whole(reading)) return meaning_of(*std::move(reading), spellings);
      const bool is_better = reading && (!first || reading->rank() < first->rank());
      if (is_better && !forgives) first = std::move(reading);
    }
  }
  return first ? meaning_of(*std::move(first), spellings) : Understood{};
}

Understood which_room(Understood question, std::vector<std::string> rooms) {
  question.outcome = Outcome::kWhichRoom;
  question.rooms = room_list(rooms);
  return question;
}

Understood which_door(Understood question, const std::vector<std::string>& rooms) {
  question.outcome = Outcome::kWhichDoor;
  std::ranges::move(room_list(rooms), std::back_inserter(question.rooms));
  return question;
}

namespace {

// "The hall", "the one to the hall", "to the hall", which asks to be led there else, or all of it.
Understood door_chosen(const Understood& offer, Understood said) {
  const bool names_door = said.type == QuestionType::kNamed ||
                          said.type == QuestionType::kWhatIsIn ||
                          said.type == QuestionType::kTakeMeTo;
  if (!names_door) return said;
  Nouns named = said.names;
  named.insert(named.end(), said.rooms.begin(), said.rooms.end());
  for (std::size_t i = 1; i < offer.rooms.size(); ++i) {
    const bool is_meant = std::ranges::any_of(named, [&](const Noun& noun) {
      return noun.kind == Noun::Kind::kRoom && noun.name == offer.rooms[i].name;
    });
    if (is_meant) {
      return {Outcome::kQuestion, offer.type, offer.names, {offer.rooms.front(), offer.rooms[i]}};
    }
  }
  return said;
}

}  // namespace

Understood in_answer_to(const Understood& offer, Understood said) {
  if (offer.outcome == Outcome::kWhichDoor && said.outcome == Outcome::kQuestion) {
    return door_chosen(offer, std::move(said));
  }
  if (offer.outcome == Outcome::kWhichRoom && said.outcome == Outcome::kQuestion) {
    // "The kitchen", "the one in the kitchen", or "in the kitchen", which asks what is in it else.
    const bool names_room =
        said.type == QuestionType::kNamed || said.type == QuestionType::kWhatIsIn;
    const bool is_offered = names_room && said.names.size() == 1 &&
                            std::ranges::any_of(offer.rooms, [&](const Noun& room) {
                              return said.names.front().kind == Noun::Kind::kRoom &&
                                     room.name == said.names.front().name;
                            });
    if (!is_offered) return said;
    return {Outcome::kQuestion, offer.type, offer.names, said.names};
  }
  const bool is_offer =
      offer.outcome == Outcome::kDidYouMean || offer.outcome == Outcome::kWhichOne;
  if (!is_offer || said.outcome != Outcome::kQuestion) return said;
  if (said.type == QuestionType::kYes && offer.outcome == Outcome::kDidYouMean) {
    return {Outcome::kQuestion, offer.type, offer.names, offer.rooms};
  }
  if (said.type == QuestionType::kNamed) said.type = offer.type;
  return said;
}

Understood unless_stopped(Understood said, std::string_view text, const Phrasebook& phrases,
                          const HomeNames& home) {
  if (said.outcome == Outcome::kQuestion) return said;
  const std::vector<std::string> words = folded_words(text);
  const Grammar& grammar = phrases.grammar();
  const bool stops = grammar.says_stop(words);
  const bool waits = grammar.says_wait(words);
  if (words.size() > kMaxWordsOfAStop || !(stops || waits)) return said;
  if (NameIndex(phrases, home).has_name(words)) return said;
  const bool ends = stops && !waits && !grammar.denies(words);
  return {Outcome::kQuestion, ends ? QuestionType::kEnd : QuestionType::kPause};
}

Understood while_led(Understood said) {
  if (said.type == QuestionType::kSomethingAhead) said.type = QuestionType::kBlocked;
  return said;
}

}  // namespace roomwise::guide
