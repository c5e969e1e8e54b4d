#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/guide/grammar/question_type.h"
#include "roomwise/guide/words/phrasebook.h"
#include "roomwise/objects/detection/object_vocabulary.h"

namespace roomwise::guide {

// What a home calls its own.
struct HomeNames {
  std::vector<std::string> things;  // each once, by name
  std::vector<std::string> rooms;
  std::vector<std::string> goals;       // what has a place besides, by the home's word
  std::vector<std::string> spots = {};  // that somebody marked, as they called them: "my chair"
  // What networks call things; null: nothing.
  const objects::ObjectVocabulary* vocabulary = nullptr;
};

// What somebody meant by a text.
struct Understood {
  enum class Outcome {
    kQuestion,     // `names`: none, or what is asked for, as the home calls it
    kWhichOne,     // several of the home are called so: `names`
    kWhichRoom,    // several things of that name stand in `rooms`, or a door's room is one of them
    kWhichDoor,    // doors of the first of `rooms` lead to the others; by which_door() alone
    kDidYouMean,   // the name is a slip away from the one of `names`
    kUnknownName,  // the home has nothing that is called so: `names`, a thing, as it was said
    kCannotTell,   // nothing that Roomwise knows can answer that
    kDeclined,     // "no" to an offer
    kNotUnderstood,  // it is no question that is known
  };
  Outcome outcome = Outcome::kNotUnderstood;
  QuestionType type = QuestionType::kWhatCanIAsk;  // of all but the last two
  Nouns names = {};
  bool is_nearest = false;  // whichever of `rooms`
  // The room that was named with a thing: "the chair in the kitchen", or both of a door; of
  // kWhichRoom and kWhichDoor all of them.
  Nouns rooms = {};
  // A name with one word before it at most, "in the kitchen": a question, or half an answer.
  bool is_fragment = false;
  bool doubts_way = false;  // who is led does not want to go on as before: what is unclear pauses
};

// Texts that are longer are not understood, bytes.
constexpr std::size_t kMaxQuestionBytes = 500;

// Finds the question and the name in it by the language's grammar and the home's names. Of several
// ways to read a text: one whose name the home has, then one with more words of its own, then one
// with fewer words in a name. An unknown name is as it was written, and no name of the home is a
// part of it. Slips are forgiven in the question's own words, but for emergencies; a name with
// slips is asked about. Words that are said twice at once count once. The same for the same values;
// any bytes are a text. Time: patterns and names times the words of the text.
[[nodiscard]] Understood understand(std::string_view text, const Phrasebook& phrases,
                                    const HomeNames& home);

// What each of the things, rooms or doors means that `heard` offers to choose from, in the order in
// which they are told; empty where it offers nothing.
[[nodiscard]] std::vector<Understood> choices_of(const Understood& heard);

// The question which of a thing's rooms is meant, for a question about it.
[[nodiscard]] Understood which_room(Understood question, std::vector<std::string> rooms);
// The question to which of these rooms the door of the room leads that was named.
[[nodiscard]] Understood which_door(Understood question, const std::vector<std::string>& rooms);
// What is meant by "yes", or by a name alone, after an `offer` (kDidYouMean, kWhichOne; a room's
// after kWhichRoom and kWhichDoor), or by "the second one" and the like; else `said` as it is. The
// offer again where an answer chooses nothing of it: "the third one" of two, "yes" to two, the name
// of a room that was not offered.
[[nodiscard]] Understood in_answer_to(const Understood& offer, Understood said);
// What is meant by "take me there", "how far is it" or "and the sink" after `last`, a question with
// a name; else `said` as it is.
[[nodiscard]] Understood following(const Understood& last, Understood said);
// What is meant by who is led: a few words and no question that hold a word for stop end it, or
// where they deny something, name something else ("Stop, the table!") or hold one for wait and no
// name, pause it.
[[nodiscard]] Understood unless_stopped(Understood said, std::string_view text,
                                        const Phrasebook& phrases, const HomeNames& home);
// What is meant by who is led: "there is something ahead" then says that they cannot go on.
[[nodiscard]] Understood while_led(Understood said);

}  // namespace roomwise::guide
