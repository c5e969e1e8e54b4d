// Any bytes as a catalogue of networks.

#include <string_view>

#include "fuzz_target.h"
#include "roomwise/network/formats/catalogue.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto entries = roomwise::network::parse_catalogue(text, "list");
  if (!entries && entries.error().message.empty()) __builtin_trap();
  return 0;
}
