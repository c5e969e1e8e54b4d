// Any bytes as LZFSE.

#include "fuzz_target.h"
#include "roomwise/recording/bytes/lzfse.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kMaxSize = 1 << 18;
  const auto bytes = roomwise::recording::decode_lzfse({data, size}, kMaxSize);
  if (bytes && bytes->size() > kMaxSize) __builtin_trap();
  return 0;
}
