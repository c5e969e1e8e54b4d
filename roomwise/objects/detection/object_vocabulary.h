#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/base/expected.h"

namespace roomwise::objects {

// The objects that count, and the network's labels that mean each of them: "bed" is seen where the
// network says "studio couch" or "four-poster". The database of the paper holds it; this is its
// form in memory.
class ObjectVocabulary {
 public:
  // Words for what homes have, with the labels of ImageNet (classifiers), COCO (detectors) and our
  // compact network that mean them, as kinds.json has them. The paper's seven are among them: bed,
  // lamp, wardrobe, microwave, stove, fridge and toilet seat.
  [[nodiscard]] static ObjectVocabulary standard();

  // Fails where the kinds, with somebody's own, are no vocabulary: a label means two.
  [[nodiscard]] static Expected<void> check_kinds();

  // What stands in homes and is in no table, but is taken for what is: a radiator for a toilet.
  [[nodiscard]] static ObjectVocabulary look_alikes();

  // Adds labels to an object, making it if it is new. A label means one object only. On an error
  // nothing is changed.
  [[nodiscard]] Expected<void> add(const std::string& object,
                                   const std::vector<std::string>& labels);
  // Removes the object with its labels; fails if it is not there.
  [[nodiscard]] Expected<void> remove(const std::string& object);
  // The object that a label means.
  [[nodiscard]] std::optional<std::string> object_of(std::string_view label) const;
  // Object -> its labels, by name.
  [[nodiscard]] const std::map<std::string, std::set<std::string>>& objects() const {
    return objects_;
  }

 private:
  [[nodiscard]] static ObjectVocabulary of_kinds(bool spoken_of);

  std::map<std::string, std::set<std::string>> objects_;
};

// Whether two texts name one label of a network. ImageNet's labels list synonyms ("studio couch,
// day bed"): the names before the first comma must agree and, where both texts go on, the rest too
// ("crane" alone fits "crane, bird"); letter case and spaces around a comma's sides do not count.
[[nodiscard]] bool same_label(std::string_view a, std::string_view b);

// The network's own spelling of a label. Fails with the labels that contain the text where the
// network has none of this name.
[[nodiscard]] Expected<std::string> find_label(std::span<const std::string> labels,
                                               std::string_view wanted);

// The words of a table that are wanted and that these labels of a network can name, and the
// look-alikes that they can name and the table does not: what a finder is asked for.
[[nodiscard]] ObjectVocabulary classes_with_labels(
    const ObjectVocabulary& vocabulary, std::span<const std::string> labels,
    const std::function<bool(const std::string& word)>& is_wanted);

}  // namespace roomwise::objects
