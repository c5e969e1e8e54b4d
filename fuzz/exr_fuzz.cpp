// Any bytes as OpenEXR.

#include "fuzz_target.h"
#include "roomwise/recording/bytes/exr.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::int64_t kMaxPixels = 1 << 16;
  const auto pixels = roomwise::recording::decode_exr({data, size}, kMaxPixels);
  if (!pixels && pixels.error().message.empty()) __builtin_trap();
  if (pixels && std::int64_t{pixels->width()} * pixels->height() > kMaxPixels) __builtin_trap();
  return 0;
}
