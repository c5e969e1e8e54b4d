// Any bytes as a model card.

#include <string_view>

#include "fuzz_target.h"
#include "roomwise/network/formats/model_card.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto card = roomwise::network::ModelCard::parse(text, "card");
  if (!card && card.error().message.empty()) __builtin_trap();
  return 0;
}
