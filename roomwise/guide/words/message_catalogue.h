#pragma once

#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/guide/words/phrasebook.h"

namespace roomwise::guide {

// All that Roomwise says, in every language that it speaks.
class MessageCatalogue {
 public:
  // The files of roomwise/guide/messages and the kinds' names (kinds.json), which are compiled in.
  // A test reads them, so they are right.
  [[nodiscard]] static MessageCatalogue built_in();
  // One file a language. Fails where one is wrong, a language comes twice or there is none, and
  // where two languages differ in their messages, the values of one, or in their words for rooms: a
  // message that is missing would be silence.
  [[nodiscard]] static Expected<MessageCatalogue> parse(std::span<const std::string_view> files,
                                                        std::span<const objects::Kind> kinds);

  [[nodiscard]] std::vector<std::string> languages() const;  // by name
  [[nodiscard]] bool speaks(const std::string& language) const;
  // Throws std::invalid_argument where the language is not spoken.
  [[nodiscard]] const Phrasebook& in(const std::string& language) const;

 private:
  MessageCatalogue() = default;

  std::map<std::string, Phrasebook> books_;
};

// The texts of the files that are compiled in.
[[nodiscard]] std::span<const std::string_view> built_in_messages();

}  // namespace roomwise::guide
