// Any bytes as a file of 8 bits; what is taken is written as it was read.

#include <string_view>

#include "fuzz_target.h"
#include "roomwise/network/formats/eight_bit_file.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace roomwise::network;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto file = parse_eight_bit_file(text, "file");
  if (!file) {
    if (file.error().message.empty()) __builtin_trap();
    return 0;
  }
  const auto written = text_of(*file);
  if (!written) __builtin_trap();  // JSON is UTF-8
  const auto again = parse_eight_bit_file(*written, "file");
  if (!again || again->fingerprint() != file->fingerprint()) __builtin_trap();
  return 0;
}
