#pragma once

#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/guide/grammar/grammar.h"
#include "roomwise/objects/kinds/kinds.h"

namespace roomwise::guide {

// The name of a thing or a room as the home has it ("microwave", "Anna's room").
struct Noun {
  enum class Kind { kThing, kRoom };
  Kind kind = Kind::kThing;
  std::string name;
};
// Several are spoken as a list: "bed, chair and lamp".
using Nouns = std::vector<Noun>;
[[nodiscard]] Nouns thing(const std::string& name);
[[nodiscard]] Nouns thing_list(const std::vector<std::string>& names);
[[nodiscard]] Nouns room(const std::string& name);
[[nodiscard]] Nouns room_list(const std::vector<std::string>& names);

// What the placeholders of a message stand for: a text as it is, or names in the language's words.
using Values = std::map<std::string, std::variant<std::string, Nouns>>;
// A message, by its name in the catalogue, and what it is filled with.
struct Phrase {
  std::string message_id;
  Values values = {};
};

// What Roomwise says in one language, from a file roomwise/guide/messages/LANGUAGE.json, which the
// web pages read too:
//
//   messages  name -> text. "{hour}" is a value as it is. "{the thing}" is the value "thing" in the
//             form "the", "{hour hour}" the number "hour" as the unit "hour" is counted ("las 3").
//             The first letter of a text is made a capital.
//   forms     form -> class of word -> pattern ("in" -> "f" -> "in der {}"). The classes are the
//             language's own (genders), and two for names that it does not know: "proper" for one
//             with a capital or an apostrophe ("Anna's room") or that begins with a determiner ("my
//             mug"), else "other". CLASS-numbered is
//             for "bedroom 2", where the language has that.
//   rooms     the home's word -> its name here, its class, any forms of its own, and under "also"
//             what else people call it (objects::SpokenName). Things have theirs in kinds.json.
//   goals     the same for what one is led to or through that is no thing: the way out, a wide
//             door.
//   questions how one asks: grammar/grammar.h.
//   counts    unit -> "one", "other" ("{n} steps"), and "=1" for just that number where "one" is
//             for others, too; singular: the numbers of "one", "1" or "below 2" (CLDR's rules of
//             plurals); decimal: the sign in 1.5; and: of lists; and_before: how the next
//             word begins -> its "and" there, where that is another; months: their names.
class Phrasebook {
 public:
  // Fails on anything that is missing, of a wrong type or unknown, and names it.
  // `kinds`: what things are called; those that have no name in this language are left out.
  [[nodiscard]] static Expected<Phrasebook> parse(std::string_view json,
                                                  std::span<const objects::Kind> kinds);

  [[nodiscard]] const std::string& language() const { return language_; }  // "en"
  [[nodiscard]] const std::string& name() const { return name_; }          // "English"
  [[nodiscard]] std::set<std::string> messages() const;
  // The names of the values that a message takes. Throws std::invalid_argument on an unknown one.
  [[nodiscard]] std::set<std::string> values_of(const std::string& message) const;

  // Throws std::invalid_argument where there is no such message or a value is missing: names of
  // messages stand in code.
  [[nodiscard]] std::string text(const std::string& message, const Values& values = {}) const;
  // "November"; 1 to 12.
  [[nodiscard]] const std::string& month(int number) const;
  // "1 step", "2.5 metres". One decimal where the number has one.
  [[nodiscard]] std::string count(const std::string& unit, double number) const;
  // The home's words that somebody may mean who calls it so here ("Couch" -> "sofa"), whatever the
  // case: a word itself first, then those of that name or plural, then what stands under "also".
  [[nodiscard]] std::vector<std::string> words_for(Noun::Kind kind, std::string_view called) const;
  // What the thing or room is called here by itself ("Sofa"); as it is where it has no word here.
  [[nodiscard]] std::string called(const Noun& noun) const { return in_form("", noun); }
  // What people call the thing or room here, by name or in the plural, and what else they call it
  // ("also"); its own name where it has no word here.
  struct Called {
    std::vector<std::string> names, also;
  };
  [[nodiscard]] Called spoken_names(const Noun& noun) const;
  // How one asks here.
  [[nodiscard]] const Grammar& grammar() const { return grammar_; }
  // The home's words that are known here.
  [[nodiscard]] std::set<std::string> words(Noun::Kind kind) const;

 private:
  [[nodiscard]] bool begins_with_determiner(const std::string& name) const;
  using Word = objects::SpokenName;
  using Words = std::map<std::string, Word>;
  // A piece of a text between two placeholders, and the placeholder after it.
  struct Segment {
    std::string words;
    std::string form;
    std::string value;  // empty: none follows
  };
  [[nodiscard]] static std::vector<Segment> segments_of(std::string_view text);
  [[nodiscard]] const Words& words_of(Noun::Kind kind) const;
  [[nodiscard]] const Word* find(const Noun& noun) const;
  [[nodiscard]] std::string in_form(const std::string& form, const Noun& noun) const;
  [[nodiscard]] const std::string& and_for(const std::string& next) const;
  [[nodiscard]] std::string list(const std::string& form, const Nouns& nouns) const;
  [[nodiscard]] Expected<void> validate() const;
  [[nodiscard]] Expected<void> validate(const std::string& word, const Word& description) const;

  std::string language_;
  std::string name_;
  std::map<std::string, std::string> messages_;
  std::map<std::string, std::map<std::string, std::string>> forms_;
  std::map<std::string, std::map<std::string, std::string>> counts_;
  std::map<std::string, std::string> and_before_;  // by how the next word begins
  std::string singular_;
  std::string decimal_;
  std::vector<std::string> months_;
  std::string and_;
  Words things_;
  Words rooms_;
  Grammar grammar_;
};

}  // namespace roomwise::guide
