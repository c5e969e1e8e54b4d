#include "roomwise/objects/detection/object_vocabulary.h"

#include <algorithm>

#include "roomwise/objects/kinds/kinds.h"

namespace roomwise::objects {
namespace {

char lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

// Splits "studio couch, day bed" at the first comma into a name and the rest.
std::pair<std::string_view, std::string_view> first_name(std::string_view label) {
  const std::size_t comma = std::min(label.find(','), label.size());
  return {trimmed(label.substr(0, comma)),
          trimmed(label.substr(std::min(comma + 1, label.size())))};
}

bool same_text(std::string_view a, std::string_view b) {
  return std::ranges::equal(a, b, [](char x, char y) { return lower(x) == lower(y); });
}

}  // namespace

bool same_label(std::string_view a, std::string_view b) {
  const auto [name_a, rest_a] = first_name(a);
  const auto [name_b, rest_b] = first_name(b);
  return same_text(name_a, name_b) &&
         (rest_a.empty() || rest_b.empty() || same_text(rest_a, rest_b));
}

ObjectVocabulary ObjectVocabulary::standard() {
  return of_kinds(true);
}

ObjectVocabulary ObjectVocabulary::look_alikes() {
  return of_kinds(false);
}

Expected<void> ObjectVocabulary::check_kinds() {
  for (const bool spoken_of : {true, false}) {
    ObjectVocabulary vocabulary;
    for (const Kind& kind : standard_kinds()) {
      if (kind.is_spoken_of != spoken_of || kind.labels.empty()) continue;
      for (const std::string& label : kind.labels) {
        if (const auto other = vocabulary.object_of(label)) {
          return fail(
              "kind \"{}\": the label \"{}\" means \"{}\" already; leave it out in one of the two",
              kind.name, label, *other);
        }
      }
      if (auto added = vocabulary.add(kind.name, kind.labels); !added) return added;
    }
  }
  return {};
}

ObjectVocabulary ObjectVocabulary::of_kinds(bool spoken_of) {
  ObjectVocabulary vocabulary;
  for (const Kind& kind : standard_kinds()) {
    if (kind.is_spoken_of != spoken_of || kind.labels.empty()) continue;
    vocabulary.objects_[kind.name] = {kind.labels.begin(), kind.labels.end()};
  }
  return vocabulary;
}

Expected<void> ObjectVocabulary::add(const std::string& object,
                                     const std::vector<std::string>& labels) {
  if (trimmed(object).empty()) return fail("an object needs a name");
  if (labels.empty() && !objects_.contains(object)) {
    return fail("object \"{}\" needs at least one label of the network", object);
  }
  for (const std::string& label : labels) {
    if (trimmed(label).empty()) return fail("object \"{}\": a label is empty", object);
    if (const auto other = object_of(label); other && *other != object) {
      return fail("object \"{}\": the label \"{}\" means \"{}\" already; remove it there first",
                  object, label, *other);
    }
  }
  std::set<std::string>& known = objects_[object];
  for (const std::string& label : labels) {
    const bool present =
        std::ranges::any_of(known, [&](const auto& other) { return same_label(label, other); });
    if (!present) known.insert(label);
  }
  return {};
}

Expected<void> ObjectVocabulary::remove(const std::string& object) {
  if (objects_.erase(object) == 0) {
    std::string known;
    for (const auto& [name, labels] : objects_) known += (known.empty() ? "" : ", ") + name;
    return fail("there is no object \"{}\"; there are {}", object, known.empty() ? "none" : known);
  }
  return {};
}

std::optional<std::string> ObjectVocabulary::object_of(std::string_view label) const {
  for (const auto& [object, labels] : objects_) {
    if (std::ranges::any_of(labels, [&](const auto& own) { return same_label(label, own); })) {
      return object;
    }
  }
  return std::nullopt;
}

Expected<std::string> find_label(std::span<const std::string> labels, std::string_view wanted) {
  const auto found =
      std::ranges::find_if(labels, [&](const auto& label) { return same_label(label, wanted); });
  if (found != labels.end()) return *found;
  std::vector<std::string> similar;
  for (const std::string& label : labels) {
    const bool contains = !std::ranges::search(label, trimmed(wanted), [](char a, char b) {
                             return lower(a) == lower(b);
                           }).empty();
    if (contains && similar.size() < 5) similar.push_back(label);
  }
  return fail("unknown label \"{}\": the network has none of this name{}{}", wanted,
              similar.empty() ? "; see its labels file" : "; it has ", fmt::join(similar, " | "));
}

ObjectVocabulary classes_with_labels(
    const ObjectVocabulary& vocabulary, std::span<const std::string> labels,
    const std::function<bool(const std::string& word)>& is_wanted) {
  ObjectVocabulary chosen = vocabulary;
  for (const auto& [word, of_word] : vocabulary.objects()) {
    const bool can_be_named = std::ranges::any_of(
        labels, [&](const std::string& label) { return vocabulary.object_of(label) == word; });
    if (!can_be_named || !is_wanted(word)) std::ignore = chosen.remove(word);  // it is there
  }
  const ObjectVocabulary look_alikes = ObjectVocabulary::look_alikes();
  for (const auto& [word, of_word] : look_alikes.objects()) {
    for (const std::string& label : of_word) {
      const bool is_known = std::ranges::any_of(
          labels, [&](const std::string& other) { return same_label(label, other); });
      if (is_known && !vocabulary.object_of(label)) std::ignore = chosen.add(word, {label});
    }
  }
  return chosen;
}

}  // namespace roomwise::objects
