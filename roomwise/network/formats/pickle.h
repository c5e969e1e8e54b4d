#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/base/expected.h"

namespace roomwise::network {

// One object of a pickle. Objects name each other by their place in Pickle::values.
struct PickleValue {
  enum class Kind {
    kNone,
    kInteger,     // booleans too
    kNumber,      // a float; which one is not kept
    kText,        // texts and bytes
    kTuple,       // items: its members
    kList,        // the same
    kDictionary,  // items: key, value, key, value, ...
    kGlobal,      // text: "module.name"
    kCall,        // items: what is called, the tuple of its arguments
    kPersistent,  // items: the identity of something that lies outside of the pickle
  };
  Kind kind = Kind::kNone;
  std::int64_t integer = 0;
  std::string text;
  std::vector<std::size_t> items;
};

struct Pickle {
  std::vector<PickleValue> values;
  std::size_t root = 0;  // the place of the object that was pickled
};

// Reads Python's pickle format (protocols 2 to 5) as data: nothing is imported, called or built. A
// call stays a kCall, but an OrderedDict is a dictionary at once; what is put into an object by
// BUILD is left out. Fails, naming opcode and place, on an opcode that dictionaries of tensors do
// not need, on a global that is not among `globals`, and on damage. Takes memory of a few times the
// bytes' size at most, and never more than 2^20 objects.
[[nodiscard]] Expected<Pickle> read_pickle(std::span<const std::uint8_t> bytes,
                                           std::span<const std::string_view> globals);

}  // namespace roomwise::network
