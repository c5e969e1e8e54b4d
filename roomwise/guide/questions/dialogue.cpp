#include "roomwise/guide/questions/dialogue.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include "roomwise/guide/grammar/folded_words.h"
#include "roomwise/guide/grammar/grammar.h"

namespace roomwise::guide {
namespace {

using Outcome = Understood::Outcome;
using Type = QuestionType;
using Words = std::span<const SpelledWord>;
using Text = std::vector<std::string>;

constexpr std::size_t kMaxWordsOfACorrection = 12;

bool is_question(const Understood& heard) {
  return heard.outcome == Outcome::kQuestion;
}

bool begins_with(Words words, const Text& text) {
  return text.size() <= words.size() &&
         std::ranges::equal(words.first(text.size()), text, {}, &SpelledWord::folded);
}

bool ends_with(Words words, const Text& text) {
  return text.size() <= words.size() &&
         std::ranges::equal(words.last(text.size()), text, {}, &SpelledWord::folded);
}

std::string text_of(Words words) {
  std::string text;
  for (const SpelledWord& word : words) text += word.spelling + " ";
  return text;
}

// Which of the choices is meant by a place in the list, or by its place in the home.
bool chooses(Type type) {
  return type == Type::kFirst || type == Type::kSecond || type == Type::kThird ||
         type == Type::kNearest || type == Type::kLeftOne || type == Type::kRightOne ||
         type == Type::kOther;
}

// One way to read a correction; either part may be missing.
struct Correction {
  std::optional<Understood> meant;      // what is wanted
  std::optional<Understood> not_meant;  // what is not
  bool says_no = false;
};

// That a text names something to be chosen or to be led to, and asks nothing else.
bool is_name(const Understood& heard) {
  const bool is_one = heard.names.size() == 1;
  return is_question(heard) && (chooses(heard.type) || (is_one && (heard.type == Type::kNamed ||
                                                                   heard.type == Type::kTakeMeTo ||
                                                                   heard.type == Type::kWhatIsIn)));
}

class CorrectionReader {
 public:
  CorrectionReader(std::string_view text, const Phrasebook& phrases, const HomeNames& home)
      : phrases_(phrases), home_(home), words_(spelled_words(text)) {
    for (std::size_t at = text.find(','); at != std::string_view::npos;
         at = text.find(',', at + 1)) {
      commas_.insert(spelled_words(text.substr(0, at)).size());
    }
  }

  // All ways to read the text as a correction, those that name most first.
  [[nodiscard]] std::vector<Correction> read() {
    if (words_.size() <= kMaxWordsOfACorrection) read_from(words_, false, false);
    std::ranges::stable_sort(found_, std::ranges::greater{}, [](const Correction& one) {
      return std::tuple(one.meant && one.not_meant, one.meant && is_question(*one.meant),
                        one.meant.has_value(), one.not_meant.has_value());
    });
    return std::move(found_);
  }

 private:
  [[nodiscard]] const Corrections& grammar() const { return phrases_.grammar().corrections(); }
  [[nodiscard]] Understood heard(Words words) const {
    return understand(text_of(words), phrases_, home_);
  }

  // In what is spoken commas are rare; where there is one it tells.
  [[nodiscard]] bool ends_at_comma(Words words) const {
    return commas_.contains(static_cast<std::size_t>(&words.back() - words_.data()) + 1);
  }

  // Takes off, in every way, what comes before what is meant.
  void read_from(Words words, bool is_opened, bool says_no) {
    read_denied_first(words, says_no);
    read_denied_last(words, says_no);
    read_meant(words, is_opened, says_no);
    for (const Text& opener : grammar().openers) {
      if (!begins_with(words, opener)) continue;
      const Understood said = heard(words.first(opener.size()));
      const bool is_no = is_question(said) && said.type == Type::kNo;
      read_from(words.subspan(opener.size()), true, says_no || is_no);
    }
    for (const Text& filler : phrases_.grammar().fillers()) {
      if (begins_with(words, filler)) {
        read_from(words.subspan(filler.size()), is_opened, says_no);
        break;
      }
    }
  }

  // "The kitchen", "the kitchen instead", or nothing.
  void read_meant(Words words, bool is_opened, bool says_no) {
    for (const Text& closer : grammar().closers) {
      if (!ends_with(words, closer) || closer.size() == words.size()) continue;
      add(words.first(words.size() - closer.size()), {}, says_no);
    }
    if (is_opened) add(words, {}, says_no);
  }
  // "Not the kitchen", "not the kitchen but the bedroom", and in some languages "the kitchen not".
  void read_denied_first(Words words, bool says_no) {
    for (const Text& denial : grammar().denials) {
      if (!begins_with(words, denial)) continue;
      if (ends_at_comma(words.first(denial.size()))) continue;  // "no, la cocina"
      const Words rest = words.subspan(denial.size());
      for (std::size_t count = 1; count <= rest.size(); ++count) {
        read_meant_after(rest.subspan(count), rest.first(count), says_no);
      }
    }
    for (const Text& denial : grammar().denials_after) {
      for (std::size_t count = 1; count + denial.size() <= words.size(); ++count) {
        if (!begins_with(words.subspan(count), denial)) continue;
        read_meant_after(words.subspan(count + denial.size()), words.first(count), says_no);
      }
    }
  }
  void read_meant_after(Words words, Words denied, bool says_no) {
    add(words, denied, says_no);
    for (const Text& but : grammar().but) {
      if (begins_with(words, but)) add(words.subspan(but.size()), denied, says_no);
    }
  }
  // "The bedroom, not the kitchen".
  void read_denied_last(Words words, bool says_no) {
    for (const Text& denial : grammar().denials) {
      for (std::size_t count = 1; count + denial.size() < words.size(); ++count) {
        if (!begins_with(words.subspan(count), denial)) continue;
        add(words.first(count), words.subspan(count + denial.size()), says_no);
      }
    }
  }

  void add(Words meant, Words denied, bool says_no) {
    Correction correction{.meant = {}, .not_meant = {}, .says_no = says_no};
    if (!denied.empty()) {
      correction.not_meant = heard(denied);
      if (!is_name(*correction.not_meant)) return;
    }
    if (!meant.empty()) {
      correction.meant = heard(meant);
      const bool is_no = is_question(*correction.meant) && correction.meant->type == Type::kNo;
      const bool is_lost = is_no || correction.meant->outcome == Outcome::kNotUnderstood;
      if (is_lost && !denied.empty()) return;
      if (is_lost) correction.meant.reset();
    }
    found_.push_back(std::move(correction));
  }

  const Phrasebook& phrases_;
  const HomeNames& home_;
  std::vector<SpelledWord> words_;
  std::set<std::size_t> commas_;  // after so many words
  std::vector<Correction> found_;
};

bool are_same(const Noun& one, const Noun& other) {
  return one.kind == other.kind && one.name == other.name;
}

bool mean_same(const Understood& one, const Understood& other) {
  return std::ranges::equal(one.names, other.names, are_same) &&
         std::ranges::equal(one.rooms, other.rooms, are_same);
}

// Which of several lies to the left: the only one on that side, or, where all are ahead, the one
// farthest to it.
std::optional<std::size_t> at_side(const std::vector<std::optional<ChoicePlace>>& places,
                                   double side) {
  std::optional<std::size_t> found;
  int on_side = 0;
  bool are_ahead = true;
  const auto angle = [&](std::size_t i) {
    const Eigen::Vector2d& place = places[i]->ahead_left_m;
    return side * std::atan2(place.y(), place.x());
  };
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!places[i]) return std::nullopt;
    are_ahead = are_ahead && places[i]->ahead_left_m.x() > 0;
    on_side += side * places[i]->ahead_left_m.y() > 0 ? 1 : 0;
    if (!found || angle(i) > angle(*found)) found = i;
  }
  return on_side == 1 || are_ahead ? found : std::nullopt;
}

std::optional<std::size_t> nearest_of(const std::vector<std::optional<ChoicePlace>>& places) {
  if (!std::ranges::all_of(places, [](const auto& place) { return place.has_value(); })) {
    return std::nullopt;
  }
  const auto nearest =
      std::ranges::min_element(places, {}, [](const auto& place) { return place->way_m; });
  return static_cast<std::size_t>(nearest - places.begin());
}

std::optional<std::size_t> place_of(Type type,
                                    const std::vector<std::optional<ChoicePlace>>& places,
                                    std::size_t choices) {
  if (type == Type::kFirst) return 0;
  if (type == Type::kSecond) return 1;
  if (type == Type::kThird) return 2;
  if (places.size() != choices) return std::nullopt;
  if (type == Type::kNearest) return nearest_of(places);
  if (type == Type::kLeftOne) return at_side(places, 1);
  if (type == Type::kRightOne) return at_side(places, -1);
  return std::nullopt;
}

Understood without(Understood offer, const std::vector<Understood>& left) {
  const bool is_name = offer.outcome == Outcome::kWhichOne;
  const bool is_door = offer.outcome == Outcome::kWhichDoor;
  Nouns& offered = is_name ? offer.names : offer.rooms;
  offered.erase(offered.begin() + (is_door ? 1 : 0), offered.end());
  for (const Understood& choice : left) {
    offered.push_back(is_name ? choice.names.front() : choice.rooms.back());
  }
  return offer;
}

class Corrected {
 public:
  explicit Corrected(const Dialogue& dialogue)
      : dialogue_(dialogue), choices_(choices_of(dialogue.offer)), has_offer_(!choices_.empty()) {
    if (!has_offer_) choices_ = choices_of(dialogue.chosen_from);
  }

  // "The left one", "the other one" by itself; nothing where it chooses nothing.
  [[nodiscard]] std::optional<Understood> chosen(Type type) const {
    if (type == Type::kOther) return has_offer_ ? std::nullopt : other_than(dialogue_.last);
    const auto place = place_of(type, dialogue_.places, choices_.size());
    const bool is_one = place && *place < choices_.size();
    return is_one ? std::optional(choices_[*place]) : std::nullopt;
  }

  [[nodiscard]] Understood by(const std::vector<Correction>& ways) const {
    const Correction* const best = &ways.front();
    if (best->meant && best->not_meant) {
      // "A la cocina no, al baño": "no" denies what it stands behind, or what it stands before.
      const auto is_clear = [&](const Correction& one) {
        return one.meant && one.not_meant &&
               (is_offered(*one.not_meant) || is_present(*one.not_meant));
      };
      const auto clear = std::ranges::find_if(ways, is_clear);
      const Correction& way = clear != ways.end() ? *clear : *best;
      return instead(*way.meant, *way.not_meant);
    }
    const auto denies =
        std::ranges::find_if(ways, [](const Correction& one) { return one.not_meant.has_value(); });
    if (!best->meant) return denies != ways.end() ? denied(*denies->not_meant) : refused(ways);
    // Of "no la cocina" nobody knows whether it is wanted: what is led to or was asked for is not.
    if (denies != ways.end() && is_name(*best->meant)) {
      const Understood& name = *denies->not_meant;
      if (is_offered(name)) return dialogue_.offer;
      if (is_present(name)) return denied(name);
    }
    return meant(*best->meant);
  }

 private:
  [[nodiscard]] Understood refused(const std::vector<Correction>& ways) const {
    const bool says_no = std::ranges::any_of(ways, &Correction::says_no);
    if (says_no && dialogue_.is_led && !has_offer_) return paused();
    return says_no && has_offer_ ? Understood{.outcome = Outcome::kDeclined} : Understood{};
  }
  [[nodiscard]] static Understood paused() { return {Outcome::kQuestion, Type::kPause}; }

  // What the correction is about asks.
  [[nodiscard]] Type type_for(const Noun& name) const {
    if (has_offer_) return dialogue_.offer.type;
    const bool has_last = is_question(dialogue_.last) && !dialogue_.last.names.empty();
    if (!has_last) return dialogue_.is_led ? Type::kTakeMeTo : Type::kNamed;
    const Type last = dialogue_.last.type;
    const bool is_of_any =
        last == Type::kWhereIs || last == Type::kTakeMeTo || last == Type::kNamed;
    return is_of_any || dialogue_.last.names.front().kind == name.kind ? last : Type::kNamed;
  }

  [[nodiscard]] bool is_choice(const Understood& name, const Understood& choice) const {
    if (chooses(name.type)) {
      const auto one = chosen(name.type);
      return one && mean_same(*one, choice);
    }
    const auto is_of = [&](const Nouns& nouns) {
      return !nouns.empty() && are_same(nouns.back(), name.names.front());
    };
    return is_of(choice.names) || is_of(choice.rooms);
  }
  [[nodiscard]] bool is_offered(const Understood& name) const {
    return has_offer_ && std::ranges::any_of(choices_, [&](const Understood& choice) {
             return is_choice(name, choice);
           });
  }
  // Where somebody is led, or what they asked for.
  [[nodiscard]] bool is_present(const Understood& name) const {
    if (name.names.empty()) return false;
    const bool is_last = is_question(dialogue_.last) && !dialogue_.last.names.empty() &&
                         are_same(dialogue_.last.names.front(), name.names.front());
    return is_last || (dialogue_.goal && are_same(*dialogue_.goal, name.names.front()));
  }

  // Of two the one that was not chosen; of more the rest.
  [[nodiscard]] std::optional<Understood> other_than(const Understood& one) const {
    if (!is_question(one)) return std::nullopt;
    std::vector<Understood> left = choices_;
    std::erase_if(left, [&](const Understood& choice) { return mean_same(choice, one); });
    if (left.size() == choices_.size() || left.empty()) return std::nullopt;
    return left.size() == 1 ? left.front() : without(dialogue_.chosen_from, left);
  }

  // "Not the kitchen".
  [[nodiscard]] Understood denied(const Understood& name) const {
    if (!has_offer_) {
      if (dialogue_.is_led) return paused();
      return is_present(name) ? Understood{.outcome = Outcome::kDeclined} : Understood{};
    }
    std::vector<Understood> left = choices_;
    std::erase_if(left, [&](const Understood& choice) { return is_choice(name, choice); });
    if (left.empty()) return {.outcome = Outcome::kDeclined};
    if (left.size() == choices_.size()) return dialogue_.offer;
    return left.size() == 1 ? left.front() : without(dialogue_.offer, left);
  }

  // "Not the kitchen, the bedroom". Who is led elsewhere than they think is asked.
  [[nodiscard]] Understood instead(const Understood& meant_one, const Understood& not_meant) const {
    const bool is_other_goal = dialogue_.is_led && !has_offer_ && dialogue_.goal &&
                               !chooses(not_meant.type) && !is_present(not_meant);
    return is_other_goal && is_question(meant_one) ? asked_about(meant_one) : meant(meant_one);
  }

  [[nodiscard]] Understood asked_about(Understood name) const {
    name = meant(std::move(name));
    if (!is_question(name) || name.names.empty()) return name;
    name.outcome = Outcome::kDidYouMean;
    return name;
  }

  [[nodiscard]] Understood meant(Understood said) const {
    if (is_question(said) && chooses(said.type)) {
      if (auto one = chosen(said.type)) return *std::move(one);
      if (has_offer_) return dialogue_.offer;
      return dialogue_.is_led ? paused() : Understood{};
    }
    if (has_offer_ && is_question(said)) {
      const Understood answer = in_answer_to(dialogue_.offer, said);
      const bool is_same = answer.type == said.type && answer.outcome == said.outcome;
      if (!is_same || said.type == Type::kTakeMeTo) return answer;
    }
    const bool is_name_alone =
        said.type == Type::kNamed || (said.type == Type::kWhatIsIn && said.is_fragment);
    if (is_name_alone && !said.names.empty()) said.type = type_for(said.names.front());
    said.doubts_way = dialogue_.is_led && said.type == Type::kTakeMeTo;
    return said;
  }

  const Dialogue& dialogue_;
  std::vector<Understood> choices_;
  bool has_offer_ = false;
};

// What a correction may still change.
bool is_open(const Understood& heard) {
  return !is_question(heard) || heard.type == Type::kNo || chooses(heard.type);
}

}  // namespace

bool is_chosen_from(const Understood& heard, const Understood& offer) {
  return is_question(heard) &&
         std::ranges::any_of(choices_of(offer), [&](const Understood& choice) {
           return choice.type == heard.type && mean_same(choice, heard);
         });
}

Understood in_dialogue(std::string_view text, const Phrasebook& phrases, const HomeNames& home,
                       const Dialogue& dialogue) {
  const bool has_offer = !choices_of(dialogue.offer).empty();
  const Corrected corrected(dialogue);
  Understood heard = understand(text, phrases, home);
  if (is_question(heard) && chooses(heard.type)) {
    const bool may_be_a_turn = dialogue.is_led && !has_offer && heard.type != Type::kOther;
    if (auto chosen = corrected.chosen(heard.type)) {
      heard = *std::move(chosen);
      // "Left?": who is led may only say an instruction again.
      if (may_be_a_turn && is_question(heard)) heard.outcome = Outcome::kDidYouMean;
    }
  }
  heard = in_answer_to(dialogue.offer, std::move(heard));
  if (has_offer && !dialogue.is_led && is_question(heard) && heard.type == Type::kEnd) {
    return {.outcome = Outcome::kDeclined};
  }
  if (!dialogue.is_led) heard = following(dialogue.last, std::move(heard));
  if (dialogue.is_led) heard = unless_stopped(std::move(heard), text, phrases, home);
  const bool is_lost = heard.outcome == Outcome::kNotUnderstood ||
                       heard.outcome == Outcome::kUnknownName ||
                       (is_question(heard) && is_open(heard));
  if (is_lost) {
    const auto ways = CorrectionReader(text, phrases, home).read();
    if (!ways.empty()) {
      Understood meant = corrected.by(ways);
      if (meant.outcome != Outcome::kNotUnderstood) heard = std::move(meant);
    }
  }
  if (has_offer && heard.outcome == Outcome::kNotUnderstood) return dialogue.offer;
  return dialogue.follows_way ? while_led(std::move(heard)) : heard;
}

}  // namespace roomwise::guide
