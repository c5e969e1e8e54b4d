#pragma once

#include <map>
#include <optional>
#include <set>
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
  // Bed, lamp, wardrobe, microwave, stove, fridge and toilet seat with their ImageNet labels.
  [[nodiscard]] static ObjectVocabulary standard();

  // Adds labels to an object, making it if it is new. A label means one object only.
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
  std::map<std::string, std::set<std::string>> objects_;
};

}  // namespace roomwise::objects
