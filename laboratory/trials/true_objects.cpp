#include "laboratory/trials/true_objects.h"

#include <map>
#include <string>
#include <vector>

namespace roomwise::trials {
namespace {

// What a kind of thing may be called besides its own label. The first word is the one
// that it ought to be found by, if `has_word`.
struct OtherNames {
  bool has_word = false;
  std::vector<std::string> names;
};
const std::map<std::string, OtherNames, std::less<>>& other_names() {
  static const std::map<std::string, OtherNames, std::less<>> kNames = {
      {"coffee table", {true, {"table"}}},
      {"armchair", {true, {"chair", "sofa"}}},
      {"small plant", {true, {"plant", "vase"}}},
      {"plant", {true, {"plant", "vase"}}},
      {"vase", {true, {"vase", "plant"}}},
      {"stove", {true, {"stove", "microwave"}}},
      {"stool", {false, {"chair", "table"}}},
      {"nightstand", {false, {"table", "wardrobe"}}},
      {"tv stand", {false, {"table", "wardrobe"}}},
      {"chest of drawers", {false, {"wardrobe", "table"}}},
      {"kitchen cabinet", {false, {"sink", "stove", "table"}}},
      {"clothes", {false, {"chair"}}},
      {"teapot", {false, {"cup", "vase"}}},
      {"fruit", {false, {"bowl"}}},
      {"bookcase", {true, {"bookcase", "wardrobe"}}},
      {"cabinet", {false, {"wardrobe", "table"}}},
      {"shelf", {false, {"bookcase"}}},
      {"game table", {false, {"table"}}},
      {"telephone", {true, {"phone"}}},
      {"remote", {true, {"remote control"}}},
  };
  return kNames;
}

// Expected where the vocabulary has a word for it.
std::optional<evaluation::TrueObject> in_words(const std::string& label,
                                               const geometry::OrientedBox& box,
                                               const objects::ObjectVocabulary& vocabulary) {
  const auto& words = vocabulary.objects();
  evaluation::TrueObject entry{.kind = label, .box = box};
  bool has_word = words.contains(label);
  if (const auto word = vocabulary.object_of(label); word && !has_word) {
    entry.kind = *word;
    has_word = true;
  }
  if (const auto other = other_names().find(label); other != other_names().end()) {
    for (const std::string& name : other->second.names) {
      if (words.contains(name)) entry.also_called.insert(name);
    }
    has_word = has_word || (other->second.has_word && !entry.also_called.empty());
    if (has_word && !words.contains(entry.kind)) entry.kind = other->second.names.front();
  }
  if (!has_word && entry.also_called.empty()) return std::nullopt;
  entry.is_expected = has_word;
  if (label == "bookcase" || label == "shelf") entry.holds = {"book"};
  return entry;
}

}  // namespace

geometry::OrientedBox box_of(const simulation::ObjectTruth& object) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(object.yaw_rad, Eigen::Vector3d::UnitZ()));
  return {{turn, object.center_m}, object.size_m};
}

std::optional<evaluation::TrueObject> in_words(const simulation::ObjectTruth& object,
                                               const objects::ObjectVocabulary& vocabulary) {
  return in_words(object.label, box_of(object), vocabulary);
}

std::optional<std::string> word_of(const std::string& label,
                                   const objects::ObjectVocabulary& vocabulary) {
  const auto entry = in_words(label, {}, vocabulary);
  return entry && entry->is_expected ? std::optional(entry->kind) : std::nullopt;
}

std::optional<evaluation::TrueObject> in_words(const labelling::TrueThing& thing,
                                               const objects::ObjectVocabulary& vocabulary) {
  auto entry = in_words(thing.name, thing.box_world, vocabulary);
  for (const std::string& name : thing.also_called) {
    const auto other = in_words(name, thing.box_world, vocabulary);
    if (!other) continue;
    if (!entry) {
      entry = other;
    } else {
      entry->also_called.insert(other->kind);
    }
  }
  if (entry) entry->is_expected = entry->is_expected && thing.is_expected;
  return entry;
}

}  // namespace roomwise::trials
