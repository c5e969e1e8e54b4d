// Any bytes as a question in one's own words, in every language.

#include <string_view>

#include "fuzz_target.h"
#include "roomwise/guide/questions/refusal_prompts.h"
#include "roomwise/guide/words/message_catalogue.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using roomwise::guide::Understood;
  static const auto catalogue = roomwise::guide::MessageCatalogue::built_in();
  static const roomwise::guide::HomeNames home{.things = {"Anna's chair", "bed", "oven", "stove"},
                                               .rooms = {"bedroom 1", "bedroom 2", "kitchen"},
                                               .goals = {"door"}};
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  for (const std::string& language : catalogue.languages()) {
    const Understood heard = understand(text, catalogue.in(language), home);
    if (heard.outcome == Understood::Outcome::kQuestion) continue;
    roomwise::guide::Wording wording{&catalogue, {}};
    wording.style.language = language;
    if (refusal_prompts(heard, home, wording, 0).empty()) __builtin_trap();
  }
  return 0;
}
