// Any bytes as messages between a device and the computer: the first byte says which kind.

#include <span>
#include <string_view>

#include "fuzz_target.h"
#include "roomwise/service/protocol/messages.h"

namespace {

template <typename Value>
void check_error(const roomwise::Expected<Value>& read) {
  if (!read && read.error().message.empty()) __builtin_trap();
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace roomwise::service;
  if (size == 0) return 0;
  const std::span<const std::uint8_t> bytes(data + 1, size - 1);
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  switch (data[0] % 3) {
    case 0: {
      const auto message = read_device_message(text);
      check_error(message);
      // What was understood is understood again, the same.
      if (message && !read_device_message(write(*message))) __builtin_trap();
      break;
    }
    case 1: {
      const auto message = read_home_message(text);
      check_error(message);
      if (message && !read_home_message(write(*message))) __builtin_trap();
      break;
    }
    default: {
      const auto frame = read_frame(bytes);
      check_error(frame);
      if (frame && frame->color.size() + frame->depth.size() > bytes.size()) __builtin_trap();
      break;
    }
  }
  return 0;
}
