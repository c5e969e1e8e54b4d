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
constexpr std::size_t kMaxWordsOfAName = 4;     // that nobody gave; more are no name
constexpr std::size_t kMaxWordsOfANewName = 5;  // that somebody gives

// One way to read a text.
struct Reading {
  const QuestionPattern* pattern = nullptr;
  FoundName name;  // kKnown where the pattern has no slot
  std::vector<std::string> said;
  int slips = 0;  // in the pattern's words

  [[nodiscard]] auto rank() const {
    const auto own_words = static_cast<int>(pattern->before.size() + pattern->after.size());
    return std::tuple(name.match, slips, -own_words, said.size());
  }
  // "Genu", a slip away from "genau" and from "genug": nobody knows which was meant.
  [[nodiscard]] bool rivals(const Reading& other) const {
    return slips > 0 && slips == other.slips && name.match == other.name.match &&
           pattern->type != other.pattern->type;
  }
};

constexpr std::size_t kMaxWordsOfAStop = 6;

// How many slips make `wanted` of what was said; nothing where they are too many.
std::optional<int> slips_in(const std::string& wanted, const std::string& said, bool forgives) {
  if (wanted == said) return 0;
  if (!forgives) return std::nullopt;
  const int slips = slips_between(wanted, said);
  return slips <= forgiven_slips(wanted) ? std::optional(slips) : std::nullopt;
}

// Whether slips in the pattern's words are forgiven for what was said. Nothing but one word tells
// an order: what means something else is none with a slip ("hall", "halt").
bool may_have_slips(const QuestionPattern& pattern, std::span<const std::string> words,
                    const NameIndex& names, const Grammar& grammar) {
  if (pattern.type == QuestionType::kEmergency || pattern.type == QuestionType::kHelp) return false;
  const bool is_word_alone = !pattern.slot && words.size() == 1;
  return !is_word_alone || !(names.is_name(words.front()) || grammar.knows(words.front()));
}

struct SlotWords {
  std::span<const std::string> inside;  // what stands in the slot; empty without a slot
  int slips = 0;                        // in the words around it
};

// Nothing where the words are no such question.
std::optional<SlotWords> words_in_slot(const QuestionPattern& pattern,
                                       std::span<const std::string> words, bool forgives) {
  const std::size_t own = pattern.before.size() + pattern.after.size();
  if (pattern.slot ? words.size() <= own : words.size() != own) return std::nullopt;
  SlotWords found{words.subspan(pattern.before.size(), words.size() - own)};
  std::size_t slipped = 0;  // words
  const auto agree = [&](const std::vector<std::string>& wanted,
                         std::span<const std::string> said) {
    return std::ranges::equal(wanted, said, [&](const std::string& one, const std::string& other) {
      const auto slips = slips_in(one, other, forgives);
      found.slips += slips.value_or(0);
      slipped += slips.value_or(0) > 0 ? 1 : 0;
      return slips.has_value();
    });
  };
  const bool is_asked = agree(pattern.before, words.first(pattern.before.size())) &&
                        agree(pattern.after, words.last(pattern.after.size()));
  // Of several words one at least is as it was said: "that oone" is not "what gone".
  const bool is_all_slips = own > 1 && slipped == own;
  return is_asked && !is_all_slips ? std::optional(found) : std::nullopt;
}

// That somebody may call something so. Of "is there a cup on the table" no name is left to deny:
// the home has a table, and "I know no cup on the table" would say more than anybody knows.
bool is_believed(const QuestionPattern& pattern, std::span<const std::string> said,
                 bool has_determiner, const NameIndex& names, const Grammar& grammar) {
  const bool is_name_alone = pattern.before.empty() && pattern.after.empty();
  if (is_name_alone || said.size() > kMaxWordsOfAName) return false;
  // "I know no to sit down here": what is left of a sentence is no name. A word after an article is
  // one: "my watch", though helpers may watch.
  const bool holds_own_words = std::ranges::any_of(said, [&](const std::string& word) {
    return grammar.knows(word) && !grammar.is_determiner(word);
  });
  const bool is_noun = said.size() == 1 && has_determiner;
  if (holds_own_words && !is_noun && pattern.type != QuestionType::kCannotTell) return false;
  return pattern.type == QuestionType::kCannotTell || !names.has_name_inside(said);
}

// Of questions whose answer can be the one in a room.
bool asks_for_place(QuestionType type) {
  return type == QuestionType::kWhereIs || type == QuestionType::kWayTo ||
         type == QuestionType::kTakeMeTo;
}

std::optional<Reading> read_as(const QuestionPattern& pattern, std::span<const std::string> words,
                               const NameIndex& names, const Grammar& grammar, bool forgives) {
  const auto found = words_in_slot(pattern, words, forgives);
  if (!found) return std::nullopt;
  const std::span<const std::string> inside = found->inside;
  Reading reading{&pattern, {NameMatch::kKnown, {}}, {}, found->slips};
  if (!pattern.slot) return reading;
  if (pattern.slot == Slot::kNew) {
    reading.said = names.new_name(inside);
    if (reading.said.empty() || reading.said.size() > kMaxWordsOfANewName) return std::nullopt;
    return reading;
  }
  reading.name = names.find(inside, *pattern.slot);
  if (reading.name.match != NameMatch::kKnown && asks_for_place(pattern.type)) {
    FoundName in_room = names.find_in_room(inside);
    if (in_room.match == NameMatch::kKnown) reading.name = std::move(in_room);
  }
  const bool may_be_door = pattern.slot == Slot::kPlace || pattern.slot == Slot::kGoal;
  if (reading.name.match != NameMatch::kKnown && may_be_door) {
    FoundName door = names.find_door(inside);
    if (door.match != NameMatch::kUnknown) reading.name = std::move(door);
  }
  const auto said = names.without_determiners(inside);
  reading.said.assign(said.begin(), said.end());
  const bool is_unknown = reading.name.match == NameMatch::kUnknown;
  if (is_unknown && pattern.slot == Slot::kSurface) return std::nullopt;
  const bool has_determiner = said.size() < inside.size();
  if (is_unknown && !is_believed(pattern, said, has_determiner, names, grammar)) {
    return std::nullopt;
  }
  return reading;
}

std::optional<Reading> best_reading(std::span<const std::string> words, const Grammar& grammar,
                                    const NameIndex& names, bool forgives) {
  std::optional<Reading> best;
  bool has_rival = false;
  std::optional<int> unforgiven;  // fewest slips of what must be said to the letter: "halp"
  for (const QuestionPattern& pattern : grammar.patterns()) {
    auto reading = read_as(pattern, words, names, grammar, forgives);
    if (!reading) continue;
    if (reading->slips > 0 && !may_have_slips(pattern, words, names, grammar)) {
      unforgiven = std::min(unforgiven.value_or(reading->slips), reading->slips);
      continue;
    }
    const bool is_rival = best && reading->rivals(*best);
    if (best && reading->rank() >= best->rank()) {
      has_rival |= is_rival;
      continue;
    }
    const bool is_as_near =
        best && reading->name.match == best->name.match && reading->slips == best->slips;
    has_rival = is_as_near && (has_rival || is_rival);
    best = std::move(reading);
  }
  const bool is_another = best && best->slips > 0 && unforgiven && *unforgiven <= best->slips;
  return has_rival || is_another ? std::nullopt : best;
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
  const std::size_t own_words = reading.pattern->before.size() + reading.pattern->after.size();
  meaning.is_fragment = reading.pattern->slot && own_words <= 1;
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

// Of "where is the table and what is on it", two questions, the first.
std::optional<Reading> first_of_two(std::span<const std::string> words, const Grammar& grammar,
                                    const NameIndex& names) {
  for (const auto& join : grammar.joins()) {
    for (std::size_t at = 1; at + join.size() < words.size(); ++at) {
      if (!std::ranges::equal(words.subspan(at, join.size()), join)) continue;
      auto first = best_reading(words.first(at), grammar, names, false);
      if (!is_whole(first)) continue;
      const bool is_urgent = first->pattern->type == QuestionType::kEmergency;
      if (is_urgent ||
          is_whole(best_reading(words.subspan(at + join.size()), grammar, names, false))) {
        return first;
      }
    }
  }
  return std::nullopt;
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
  std::vector<std::vector<std::string>> texts{whole};
  std::vector<std::string> plain;
  for (const std::string& word : whole) {
    plain.push_back(grammar.without_digraphs(word));
    spellings.emplace(plain.back(), spellings.at(word));
  }
  if (plain != whole) texts.push_back(std::move(plain));
  std::optional<Reading> first;
  for (const bool forgives : {false, true}) {
    for (const auto& text_words : texts) {
      // A name may hold what says nothing elsewhere, so the text counts first as it is.
      const auto without_fillers = grammar.without_fillers(text_words);
      for (const auto& words : {text_words, without_fillers, without_repeats(without_fillers)}) {
        auto reading = best_reading(words, grammar, names, forgives);
        if (is_whole(reading)) return meaning_of(*std::move(reading), spellings);
        const bool is_better = reading && (!first || reading->rank() < first->rank());
        if (is_better && !forgives) first = std::move(reading);
      }
    }
  }
  if (auto one = first_of_two(grammar.without_fillers(whole), grammar, names)) {
    return meaning_of(*std::move(one), spellings);
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
std::optional<Understood> door_chosen(const Understood& offer, const Understood& said) {
  const bool names_door = said.type == QuestionType::kNamed ||
                          said.type == QuestionType::kWhatIsIn ||
                          said.type == QuestionType::kTakeMeTo;
  if (!names_door) return std::nullopt;
  Nouns named = said.names;
  named.insert(named.end(), said.rooms.begin(), said.rooms.end());
  for (Understood& choice : choices_of(offer)) {
    const bool is_meant = std::ranges::any_of(named, [&](const Noun& noun) {
      return noun.kind == Noun::Kind::kRoom && noun.name == choice.rooms.back().name;
    });
    if (is_meant) return std::move(choice);
  }
  return std::nullopt;
}

// "The kitchen", "the one in the kitchen", or "in the kitchen", which asks what is in it else.
bool names_room(const Understood& said) {
  const bool is_half = said.type == QuestionType::kWhatIsIn && said.is_fragment;
  return (said.type == QuestionType::kNamed || is_half) && said.names.size() == 1 &&
         said.names.front().kind == Noun::Kind::kRoom;
}

std::optional<Understood> room_chosen(const Understood& offer, const Understood& said) {
  if (!names_room(said)) return std::nullopt;
  for (Understood& choice : choices_of(offer)) {
    if (choice.rooms.front().name == said.names.front().name) return std::move(choice);
  }
  return std::nullopt;
}

// Who said so knows where the choices lie: Dialogue.
bool is_choice_by_place(QuestionType type) {
  return type == QuestionType::kNearest || type == QuestionType::kLeftOne ||
         type == QuestionType::kRightOne || type == QuestionType::kOther;
}

std::optional<std::size_t> place_in_offer(QuestionType type) {
  switch (type) {
    case QuestionType::kFirst:
      return 0;
    case QuestionType::kSecond:
      return 1;
    case QuestionType::kThird:
      return 2;
    default:
      return std::nullopt;
  }
}

}  // namespace

Understood following(const Understood& last, Understood said) {
  const bool is_named = last.outcome == Outcome::kQuestion && !last.names.empty();
  if (!is_named) return said;
  const bool leads = said.type == QuestionType::kThere;
  if (said.outcome == Outcome::kQuestion && (leads || said.type == QuestionType::kHowFar)) {
    return {Outcome::kQuestion, leads ? QuestionType::kTakeMeTo : QuestionType::kWhereIs,
            last.names, false, last.rooms};
  }
  // Who was led is not led elsewhere by half a sentence.
  if (said.type == QuestionType::kAlso) said.type = QuestionType::kWhereIs;
  return said;
}

std::vector<Understood> choices_of(const Understood& heard) {
  std::vector<Understood> choices;
  const auto add = [&](Nouns names, Nouns rooms) {
    choices.push_back({Outcome::kQuestion, heard.type, std::move(names), false, std::move(rooms)});
  };
  switch (heard.outcome) {
    case Outcome::kDidYouMean:
    case Outcome::kWhichOne:
      for (const Noun& name : heard.names) add({name}, heard.rooms);
      break;
    case Outcome::kWhichRoom:
      for (const Noun& room : heard.rooms) add(heard.names, {room});
      break;
    case Outcome::kWhichDoor:
      for (std::size_t i = 1; i < heard.rooms.size(); ++i) {
        add(heard.names, {heard.rooms.front(), heard.rooms[i]});
      }
      break;
    default:
      break;
  }
  return choices;
}

Understood in_answer_to(const Understood& offer, Understood said) {
  const std::vector<Understood> choices = choices_of(offer);
  if (choices.empty() || said.outcome != Outcome::kQuestion) return said;
  if (said.type == QuestionType::kNo) return {.outcome = Outcome::kDeclined};
  const bool is_yes = said.type == QuestionType::kYes;
  if (is_yes) return offer.outcome == Outcome::kDidYouMean ? choices.front() : offer;
  if (const auto place = place_in_offer(said.type)) {
    const bool is_one = *place < choices.size() && offer.outcome != Outcome::kDidYouMean;
    return is_one ? choices[*place] : offer;
  }
  if (said.type == QuestionType::kNearest && offer.outcome == Outcome::kWhichRoom) {
    return {Outcome::kQuestion, offer.type, offer.names, true};
  }
  if (is_choice_by_place(said.type)) return offer;
  const bool is_of_names =
      offer.outcome == Outcome::kDidYouMean || offer.outcome == Outcome::kWhichOne;
  if (is_of_names) {
    if (said.type == QuestionType::kNamed) said.type = offer.type;
    return said;
  }
  const auto chosen =
      offer.outcome == Outcome::kWhichDoor ? door_chosen(offer, said) : room_chosen(offer, said);
  if (chosen) return *chosen;
  return names_room(said) ? offer : said;
}

namespace {

// "The bus stop" is a place.
bool names_a_stop(std::span<const std::string> words, const NameIndex& names,
                  const Grammar& grammar) {
  for (std::size_t begin = 0; begin < words.size(); ++begin) {
    for (std::size_t count = 1; count <= words.size() - begin; ++count) {
      const auto part = words.subspan(begin, count);
      if (grammar.says_stop(part) && names.is_known(part)) return true;
    }
  }
  return false;
}

}  // namespace

Understood unless_stopped(Understood said, std::string_view text, const Phrasebook& phrases,
                          const HomeNames& home) {
  if (said.outcome == Outcome::kQuestion) return said;
  const std::vector<std::string> words = folded_words(text);
  const Grammar& grammar = phrases.grammar();
  const bool stops = grammar.says_stop(words);
  const bool waits = grammar.says_wait(words);
  if (words.size() > kMaxWordsOfAStop || !(stops || waits)) return said;
  const NameIndex names(phrases, home);
  const bool has_name = names.has_name(words);
  if (has_name && (!stops || names_a_stop(words, names, grammar))) return said;
  const bool ends = stops && !waits && !has_name && !grammar.denies(words);
  return {Outcome::kQuestion, ends ? QuestionType::kEnd : QuestionType::kPause};
}

Understood while_led(Understood said) {
  if (said.type == QuestionType::kSomethingAhead) said.type = QuestionType::kBlocked;
  return said;
}

}  // namespace roomwise::guide
