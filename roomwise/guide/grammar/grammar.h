#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/guide/grammar/question_type.h"

namespace roomwise::guide {

// What a name in a question may be of.
enum class Slot {
  kThing,
  kSurface,  // a thing of a kind on which others are put: nothing is in it
  kRoom,
  kPlace,  // a thing, a room, or what else has a place: a door
  kGoal,   // what one may be led to: the same
  kSpot,   // a place that somebody marked
  kNew,    // a name that is given now: any words
};

// One way to ask: folded words, and where among them a name stands, if one does.
struct QuestionPattern {
  QuestionType type = QuestionType::kWhereAmI;
  std::vector<std::string> before;
  std::optional<Slot> slot;
  std::vector<std::string> after;
};

// One way to name a door by its rooms: "door between {room} and {room}". The words around the
// rooms' names; `joined`: what the name ends with in one word ("Küchentür").
struct DoorPattern {
  std::vector<std::string> before, between, after;
  std::string joined;
  bool has_two_rooms = false;
};

// How one takes back what was understood: texts of folded words, the longest first.
struct Corrections {
  using Texts = std::vector<std::vector<std::string>>;
  Texts openers, closers, denials, denials_after, but;
};

// How one asks in a language: "questions" of its file.
//
//   patterns     type -> ways to ask. "where is {place}": words and a slot for a name. "(a|b)": one
//                of them; "[a|b]": one of them or none; both may hold each other.
//   determiners  what may stand before a name and says nothing: articles, "my", "nearest".
//   possessives  of these, what says that it is one's own: "my".
//   doors        ways to name a door by its rooms: "{room} door", "{room}tür".
//
// The rest as patterns:
//
//   inside       what may stand between a thing's name and its room's: "the chair in the kitchen".
//   fillers      what may stand anywhere and says nothing: "please".
//   endings      what a name may end with besides: "s".
//   stops        what says, anywhere in a few words, that who is led wants to stop.
//   waits        likewise, for a while.
//   generic      words for any room: "room".
//   alike        rooms, by the home's words, whose names people use for each other.
//   joins        what may stand between two questions: "and".
//   negations    what may turn that into its opposite: "not".
//   corrections  how one takes back what was understood, as patterns without a slot:
//     openers        what comes before what is meant: "no", "I meant"
//     closers        what comes after it: "instead"
//     denials        what comes before what is not meant: "not", "instead of"
//     denials_after  what comes after it
//     but            what may stand between that and what is meant
//   digraphs     how letters are typed by who has no key for them: "ae" -> "a".
class Grammar {
 public:
  // Fails, naming the pattern, where one cannot be read, is two types' or has two slots, and where
  // a type has none.
  [[nodiscard]] static Expected<Grammar> parse(const nlohmann::json& questions);

  [[nodiscard]] std::span<const QuestionPattern> patterns() const { return patterns_; }
  [[nodiscard]] std::span<const DoorPattern> doors() const { return doors_; }
  [[nodiscard]] bool is_determiner(const std::string& word) const {
    return determiners_.contains(word);
  }
  [[nodiscard]] bool is_possessive(const std::string& word) const {
    return possessives_.contains(word);
  }
  [[nodiscard]] bool says_inside(const std::string& word) const { return inside_.contains(word); }
  [[nodiscard]] std::span<const std::string> endings() const { return endings_; }
  [[nodiscard]] std::vector<std::string> without_fillers(std::vector<std::string> words) const;
  [[nodiscard]] bool says_stop(std::span<const std::string> words) const;
  [[nodiscard]] bool says_wait(std::span<const std::string> words) const;
  [[nodiscard]] bool denies(std::span<const std::string> words) const;
  [[nodiscard]] bool is_any_room(const std::string& word) const { return generic_.contains(word); }
  // The home's words for rooms that may be meant by the name of this one: itself among them.
  [[nodiscard]] std::set<std::string> rooms_alike(const std::string& room) const;
  [[nodiscard]] std::span<const std::vector<std::string>> joins() const { return joins_; }
  [[nodiscard]] const Corrections& corrections() const { return corrections_; }
  [[nodiscard]] std::span<const std::vector<std::string>> fillers() const { return fillers_; }
  // With every digraph as the letter that it stands for, but where the word is known as it is:
  // "kueche" -> "kuche".
  [[nodiscard]] std::string without_digraphs(const std::string& word) const;
  // Whether a pattern or a filler has the word: it is then no name with a slip.
  [[nodiscard]] bool knows(const std::string& word) const { return own_words_.contains(word); }

 private:
  std::vector<QuestionPattern> patterns_;
  std::vector<DoorPattern> doors_;
  std::set<std::string> determiners_, possessives_, inside_;
  std::set<std::string> negations_, own_words_, generic_;
  std::vector<std::set<std::string>> alike_;
  std::vector<std::vector<std::string>> fillers_;  // the longest first
  std::vector<std::vector<std::string>> stops_, waits_, joins_;
  Corrections corrections_;
  std::map<std::string, std::string> digraphs_;
  std::vector<std::string> endings_;
};

}  // namespace roomwise::guide
