#pragma once

#include <set>
#include <span>
#include <string>
#include <vector>

#include "roomwise/guide/grammar/grammar.h"
#include "roomwise/guide/questions/understand.h"

namespace roomwise::guide {

// What a name that somebody said may be; the surest first.
enum class NameMatch {
  kKnown,   // of the home
  kAbsent,  // a word of the language for what the home does not have
  kNear,    // a slip away from one of the home
  kUnknown,
};

struct FoundName {
  NameMatch match = NameMatch::kUnknown;
  Nouns nouns;               // of kKnown and kNear those that it may mean, of kAbsent the first
  Nouns rooms = {};          // the room that was named with it, or both of a door
  bool is_one_room = false;  // of `rooms` one is meant
};

// All that may be named in a question, for one home in one language.
class NameIndex {
 public:
  // What `phrases` points to must outlive it.
  NameIndex(const Phrasebook& phrases, const HomeNames& home);

  // `words`: folded, as they stand in the question, with articles.
  [[nodiscard]] FoundName find(std::span<const std::string> words, Slot slot) const;
  // A thing with its room: "chair in the kitchen"; kUnknown where it is none of the home's.
  [[nodiscard]] FoundName find_in_room(std::span<const std::string> words) const;
  // A door by its rooms: "kitchen door"; kAbsent of a room that the home does not have, or of any
  // door; kUnknown where the words are no such name.
  [[nodiscard]] FoundName find_door(std::span<const std::string> words) const;
  // Whether a part of the words, not all of them, is a name of the home: "cup on the table".
  [[nodiscard]] bool has_name_inside(std::span<const std::string> words) const;
  [[nodiscard]] bool is_known(std::span<const std::string> words) const;
  // The same of all words and any part of them.
  [[nodiscard]] bool has_name(std::span<const std::string> words) const;
  // Whether a word is a name of the home or for what homes have.
  [[nodiscard]] bool is_name(const std::string& word) const;
  // A name that is given now: without articles and what says nothing, but "my chair" keeps its
  // "my".
  [[nodiscard]] std::vector<std::string> new_name(std::span<const std::string> words) const;
  // The words of a name without what stands before it and says nothing.
  [[nodiscard]] std::span<const std::string> without_determiners(
      std::span<const std::string> words) const;

 private:
  // How a name may be said, the most exact first. kPartOfOwn: a part of a name that a helper gave
  // and that the language does not know as one: "chair" of "Anna's chair", but not "table" of
  // "table lamp".
  enum class Way { kName, kOtherName, kLabel, kPartOfOwn, kPart };
  struct Entry {
    std::string key;  // joined folded words
    Noun noun;
    Way way = Way::kName;
    bool is_goal = false;     // and no thing
    bool is_of_home = false;  // else the language only knows the word
    bool is_spot = false;     // a goal that somebody marked
  };

  [[nodiscard]] FoundName find_door(const DoorPattern& pattern,
                                    std::span<const std::string> words) const;
  void add(const std::string& name, const Noun& noun, Way way, bool is_of_home, bool is_goal);
  void add_parts(const std::vector<std::string>& words, const Noun& noun, bool is_goal);
  void add_noun(const Noun& noun, bool is_of_home, bool is_goal);
  void add_labels(const HomeNames& home);
  // `least`: the least exact way that counts.
  void add_spot(const std::string& name);
  [[nodiscard]] static bool fits(const Entry& entry, Slot slot);
  // Of the spots that are called "my chair" those that "chair" means, in whatever case: "meinem
  // Stuhl".
  [[nodiscard]] Nouns own_spots(const std::string& key, Slot slot) const;
  // Of the home's rooms all, or those whose kind is one of these.
  [[nodiscard]] Nouns rooms_of_home() const;
  [[nodiscard]] Nouns rooms_of_home(const std::set<std::string>& kinds) const;
  [[nodiscard]] Nouns exact(const std::string& key, Slot slot, bool is_of_home, Way least) const;
  [[nodiscard]] Nouns with_endings(const std::string& key, Slot slot) const;
  [[nodiscard]] Nouns nearest(const std::string& key, Slot slot) const;
  // Of entries that fit, those that are meant.
  [[nodiscard]] Nouns nouns_of(std::vector<const Entry*> entries) const;

  const Phrasebook& phrases_;
  std::vector<Entry> entries_;
};

}  // namespace roomwise::guide
