#include "roomwise/guide/questions/name_index.h"

#include <algorithm>
#include <set>

#include "roomwise/guide/grammar/folded_words.h"
#include "roomwise/objects/kinds/kinds.h"

namespace roomwise::guide {
namespace {

constexpr std::size_t kMinStem = 3;  // letters that stay when an ending is taken off

// "bedroom 2" -> "bedroom".
std::string without_last_number(const std::string& name) {
  const std::size_t end = name.find_last_not_of("0123456789");
  const bool has_number = end != std::string::npos && end + 1 < name.size() && name[end] == ' ';
  return has_number ? name.substr(0, end) : name;
}

bool is_same_but_for_ending(const std::string& a, const std::string& b,
                            std::span<const std::string> endings) {
  const std::string& shorter = a.size() < b.size() ? a : b;
  const std::string& longer = a.size() < b.size() ? b : a;
  if (shorter.size() < kMinStem || !longer.starts_with(shorter)) return false;
  return std::ranges::count(endings, longer.substr(shorter.size())) > 0;
}

}  // namespace

bool NameIndex::fits(const Entry& entry, Slot slot) {
  if (slot == Slot::kPlace || slot == Slot::kGoal) return true;
  if (slot == Slot::kSpot) return entry.is_spot;
  if (entry.is_goal) return false;
  if (slot == Slot::kSurface) {
    const objects::Kind* const kind = objects::find_kind(entry.noun.name);
    return entry.noun.kind == Noun::Kind::kThing && kind != nullptr && kind->is_surface;
  }
  return slot == (entry.noun.kind == Noun::Kind::kThing ? Slot::kThing : Slot::kRoom);
}

NameIndex::NameIndex(const Phrasebook& phrases, const HomeNames& home) : phrases_(phrases) {
  for (const std::string& name : home.things) add_noun({Noun::Kind::kThing, name}, true, false);
  for (const std::string& name : home.rooms) add_noun({Noun::Kind::kRoom, name}, true, false);
  for (const std::string& name : home.goals) add_noun({Noun::Kind::kThing, name}, true, true);
  for (const std::string& name : home.spots) add_spot(name);
  add_labels(home);
  for (const auto kind : {Noun::Kind::kThing, Noun::Kind::kRoom}) {
    for (const std::string& word : phrases.words(kind)) add_noun({kind, word}, false, false);
  }
}

void NameIndex::add(const std::string& name, const Noun& noun, Way way, bool is_of_home,
                    bool is_goal) {
  const std::vector<std::string> words = folded_words(name);
  if (words.empty()) return;
  entries_.push_back({joined(words), noun, way, is_goal, is_of_home});
  if (is_of_home) add_parts(words, noun, is_goal);
}

// Its first or last words alone: "chair" of "Anna's chair", "coffee" of "coffee machine".
void NameIndex::add_parts(const std::vector<std::string>& words, const Noun& noun, bool is_goal) {
  const bool is_own = phrases_.words_for(noun.kind, without_last_number(noun.name)).empty();
  const Way way = is_own ? Way::kPartOfOwn : Way::kPart;
  for (std::size_t i = 1; i < words.size(); ++i) {
    const auto middle = words.begin() + static_cast<std::ptrdiff_t>(i);
    for (const auto& part : {std::vector<std::string>(words.begin(), middle),
                             std::vector<std::string>(middle, words.end())}) {
      entries_.push_back({joined(part), noun, way, is_goal, true});
    }
  }
}

void NameIndex::add_spot(const std::string& name) {
  const std::size_t first = entries_.size();
  add(name, {Noun::Kind::kThing, name}, Way::kName, true, true);
  for (std::size_t i = first; i < entries_.size(); ++i) entries_[i].is_spot = true;
}

void NameIndex::add_noun(const Noun& noun, bool is_of_home, bool is_goal) {
  add(noun.name, noun, Way::kName, is_of_home, is_goal);
  Noun unnumbered = noun;
  unnumbered.name = without_last_number(noun.name);
  const std::string number = noun.name.substr(unnumbered.name.size());
  const Phrasebook::Called called = phrases_.spoken_names(unnumbered);
  for (const std::string& name : called.names) {
    add(name + number, noun, Way::kName, is_of_home, is_goal);
    if (!number.empty()) add(name, noun, Way::kOtherName, is_of_home, is_goal);
  }
  for (const std::string& name : called.also) {
    add(name + number, noun, Way::kOtherName, is_of_home, is_goal);
  }
}

void NameIndex::add_labels(const HomeNames& home) {
  if (home.vocabulary == nullptr) return;
  for (const auto& [object, labels] : home.vocabulary->objects()) {
    if (std::ranges::count(home.things, object) == 0) continue;
    for (const std::string& label : labels) {
      // ImageNet's list synonyms.
      for (std::size_t at = 0; at < label.size();) {
        const std::size_t comma = std::min(label.find(',', at), label.size());
        entries_.push_back({joined(folded_words(label.substr(at, comma - at))),
                            {Noun::Kind::kThing, object},
                            Way::kLabel,
                            false,
                            true});
        at = comma + 1;
      }
    }
  }
}

std::vector<std::string> NameIndex::new_name(std::span<const std::string> words) const {
  const Grammar& grammar = phrases_.grammar();
  std::vector<std::string> name = grammar.without_fillers({words.begin(), words.end()});
  while (name.size() > 1 && grammar.is_determiner(name.front()) &&
         !grammar.is_possessive(name.front())) {
    name.erase(name.begin());
  }
  return name;
}

std::span<const std::string> NameIndex::without_determiners(
    std::span<const std::string> words) const {
  while (words.size() > 1 && phrases_.grammar().is_determiner(words.front())) {
    words = words.subspan(1);
  }
  return words;
}

Nouns NameIndex::nouns_of(std::vector<const Entry*> entries) const {
  if (entries.empty()) return {};
  const auto best_way = std::ranges::min(entries, {}, &Entry::way)->way;
  std::erase_if(entries, [&](const Entry* entry) { return entry->way != best_way; });
  // A thing before the room that is called so, too: it stands there.
  const auto is_thing = [](const Entry* entry) { return entry->noun.kind == Noun::Kind::kThing; };
  if (std::ranges::any_of(entries, is_thing)) {
    std::erase_if(entries, [&](const Entry* entry) { return !is_thing(entry); });
  }
  Nouns nouns;
  std::set<std::string> called;  // who hears two of one name could not choose
  for (const Entry* entry : entries) {
    if (called.insert(phrases_.called(entry->noun)).second) nouns.push_back(entry->noun);
  }
  return nouns;
}

Nouns NameIndex::own_spots(const std::string& key, Slot slot) const {
  std::vector<const Entry*> found;
  for (const Entry& entry : entries_) {
    if (!entry.is_spot || !fits(entry, slot)) continue;
    const std::vector<std::string> words = folded_words(entry.noun.name);
    const bool is_own = phrases_.grammar().is_possessive(words.front());
    const auto bare = without_determiners(words);
    if (is_own && joined({bare.begin(), bare.end()}) == key) found.push_back(&entry);
  }
  return nouns_of(std::move(found));
}

Nouns NameIndex::exact(const std::string& key, Slot slot, bool is_of_home, Way least) const {
  std::vector<const Entry*> found;
  for (const Entry& entry : entries_) {
    const bool is_same = entry.key == key && entry.is_of_home == is_of_home && entry.way <= least;
    if (is_same && fits(entry, slot)) found.push_back(&entry);
  }
  return nouns_of(std::move(found));
}

Nouns NameIndex::with_endings(const std::string& key, Slot slot) const {
  std::vector<const Entry*> found;
  for (const Entry& entry : entries_) {
    if (entry.is_of_home && entry.way <= Way::kLabel && fits(entry, slot) &&
        is_same_but_for_ending(entry.key, key, phrases_.grammar().endings())) {
      found.push_back(&entry);
    }
  }
  return nouns_of(std::move(found));
}

Nouns NameIndex::nearest(const std::string& key, Slot slot) const {
  // "halt" is no hall, and "slower" no flower.
  if (phrases_.grammar().knows(key)) return {};
  int least = forgiven_slips(key);
  std::vector<const Entry*> found;
  for (const Entry& entry : entries_) {
    if (!entry.is_of_home || entry.way > Way::kLabel) continue;
    if (!fits(entry, slot)) continue;
    const int slips = slips_between(entry.key, key);
    if (slips > std::min(least, forgiven_slips(entry.key))) continue;
    if (slips < least) found.clear();
    least = slips;
    found.push_back(&entry);
  }
  return nouns_of(std::move(found));
}

FoundName NameIndex::find(std::span<const std::string> words, Slot slot) const {
  const auto bare = without_determiners(words);
  // "my mug" may be the name of a thing, and another than the mugs of the home.
  if (bare.size() < words.size()) {
    Nouns nouns = exact(joined({words.begin(), words.end()}), slot, true, Way::kName);
    if (!nouns.empty()) return {NameMatch::kKnown, std::move(nouns)};
  }
  const std::string key = joined({bare.begin(), bare.end()});
  if (bare.size() < words.size() && phrases_.grammar().is_possessive(words.front())) {
    if (Nouns nouns = own_spots(key, slot); !nouns.empty()) {
      return {NameMatch::kKnown, std::move(nouns)};
    }
  }
  if (Nouns nouns = exact(key, slot, true, Way::kLabel); !nouns.empty()) {
    return {NameMatch::kKnown, std::move(nouns)};
  }
  // "My room": which one is asked.
  const bool may_be_room = slot == Slot::kRoom || slot == Slot::kPlace || slot == Slot::kGoal;
  if (may_be_room && phrases_.grammar().is_any_room(key)) {
    if (Nouns rooms = rooms_of_home(); !rooms.empty()) return {NameMatch::kNear, std::move(rooms)};
  }
  if (Nouns nouns = with_endings(key, slot); !nouns.empty()) {
    return {NameMatch::kKnown, std::move(nouns)};
  }
  // What is forgotten by a part of its name might be another's.
  const Way least = slot == Slot::kSpot ? Way::kLabel : Way::kPartOfOwn;
  if (Nouns nouns = exact(key, slot, true, least); !nouns.empty()) {
    return {NameMatch::kKnown, std::move(nouns)};
  }
  if (Nouns nouns = exact(key, slot, false, Way::kLabel); !nouns.empty()) {
    // "The corridor" of a home that has a hall and neither a corridor nor an entrance.
    for (const Noun& noun : nouns) {
      if (noun.kind != Noun::Kind::kRoom) continue;
      Nouns alike = rooms_of_home(phrases_.grammar().rooms_alike(noun.name));
      if (alike.size() == 1) return {NameMatch::kKnown, std::move(alike)};
    }
    return {NameMatch::kAbsent, {nouns.front()}};
  }
  if (Nouns nouns = exact(key, slot, true, Way::kPart); slot != Slot::kSpot && !nouns.empty()) {
    return {NameMatch::kKnown, std::move(nouns)};
  }
  if (Nouns nouns = nearest(key, slot); !nouns.empty()) {
    return {NameMatch::kNear, std::move(nouns)};
  }
  return {};
}

FoundName NameIndex::find_in_room(std::span<const std::string> words) const {
  for (std::size_t at = 1; at + 1 < words.size(); ++at) {
    if (!phrases_.grammar().says_inside(words[at])) continue;
    const FoundName room = find(words.subspan(at + 1), Slot::kRoom);
    FoundName thing = find(words.first(at), Slot::kThing);
    const bool is_both = room.match == NameMatch::kKnown && thing.match == NameMatch::kKnown &&
                         room.nouns.size() == 1;
    if (!is_both) continue;
    thing.rooms = room.nouns;
    return thing;
  }
  return {};
}

FoundName NameIndex::find_door(std::span<const std::string> words) const {
  for (const DoorPattern& pattern : phrases_.grammar().doors()) {
    FoundName found = find_door(pattern, without_determiners(words));
    if (found.match != NameMatch::kUnknown) return found;
  }
  return {};
}

FoundName NameIndex::find_door(const DoorPattern& pattern,
                               std::span<const std::string> words) const {
  const std::size_t own = pattern.before.size() + pattern.after.size();
  if (words.size() <= own ||
      !std::ranges::equal(words.first(pattern.before.size()), pattern.before) ||
      !std::ranges::equal(words.last(pattern.after.size()), pattern.after)) {
    return {};
  }
  const auto inside = words.subspan(pattern.before.size(), words.size() - own);
  std::vector<std::string> said(inside.begin(), inside.end());
  if (!pattern.joined.empty()) {
    if (!said.back().ends_with(pattern.joined) || said.back() == pattern.joined) return {};
    said.back().resize(said.back().size() - pattern.joined.size());
  }
  const std::string door = "door";
  const bool has_doors = std::ranges::any_of(
      entries_, [&](const Entry& entry) { return entry.is_of_home && entry.noun.name == door; });
  const auto door_of = [&](Nouns rooms, bool is_one_room) {
    return FoundName{has_doors ? NameMatch::kKnown : NameMatch::kAbsent, thing(door),
                     has_doors ? std::move(rooms) : Nouns{}, has_doors && is_one_room};
  };
  if (!pattern.has_two_rooms) {
    FoundName room = find(said, Slot::kRoom);
    if (room.match == NameMatch::kAbsent) return room;
    if (room.match != NameMatch::kKnown) return {};
    const bool is_one_of_several = room.nouns.size() > 1;
    return door_of(std::move(room.nouns), is_one_of_several);
  }
  const std::span<const std::string> both(said);
  for (std::size_t at = 1; at + pattern.between.size() < both.size(); ++at) {
    if (!std::ranges::equal(both.subspan(at, pattern.between.size()), pattern.between)) continue;
    const FoundName one = find(both.first(at), Slot::kRoom);
    const FoundName other = find(both.subspan(at + pattern.between.size()), Slot::kRoom);
    for (const FoundName& room : {one, other}) {
      if (room.match == NameMatch::kAbsent) return room;
    }
    const auto is_clear = [](const FoundName& room) {
      return room.match == NameMatch::kKnown && room.nouns.size() == 1;
    };
    if (is_clear(one) && is_clear(other)) {
      return door_of({one.nouns.front(), other.nouns.front()}, false);
    }
  }
  return {};
}

Nouns NameIndex::rooms_of_home() const {
  Nouns rooms;
  for (const Entry& entry : entries_) {
    const bool is_room = entry.is_of_home && entry.noun.kind == Noun::Kind::kRoom;
    if (is_room && std::ranges::find(rooms, entry.noun.name, &Noun::name) == rooms.end()) {
      rooms.push_back(entry.noun);
    }
  }
  return rooms;
}

Nouns NameIndex::rooms_of_home(const std::set<std::string>& kinds) const {
  Nouns rooms = rooms_of_home();
  std::erase_if(rooms,
                [&](const Noun& room) { return !kinds.contains(without_last_number(room.name)); });
  return rooms;
}

bool NameIndex::is_name(const std::string& word) const {
  return std::ranges::find(entries_, word, &Entry::key) != entries_.end();
}

bool NameIndex::is_known(std::span<const std::string> words) const {
  const std::string key = joined({words.begin(), words.end()});
  return !exact(key, Slot::kPlace, true, Way::kLabel).empty() ||
         !with_endings(key, Slot::kPlace).empty();
}

bool NameIndex::has_name(std::span<const std::string> words) const {
  return is_known(words) || has_name_inside(words);
}

bool NameIndex::has_name_inside(std::span<const std::string> words) const {
  for (std::size_t begin = 0; begin < words.size(); ++begin) {
    for (std::size_t count = 1; count <= words.size() - begin; ++count) {
      if (count < words.size() && is_known(words.subspan(begin, count))) return true;
    }
  }
  return false;
}

}  // namespace roomwise::guide
