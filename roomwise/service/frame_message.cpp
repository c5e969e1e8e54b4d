#include <cstring>

#include "roomwise/service/json_members.h"
#include "roomwise/service/messages.h"

namespace roomwise::service {
namespace {

constexpr std::string_view kFrameMagic = "RWF1";
constexpr std::size_t kPrefixBytes = 8;
constexpr std::size_t kMaxHeaderBytes = 1024;

}  // namespace

Expected<FrameMessage> read_frame(std::span<const std::uint8_t> message) {
  if (message.size() > kMaxFrameBytes) {
    return fail("the frame has {} bytes; at most {} are taken", message.size(), kMaxFrameBytes);
  }
  if (message.size() < kPrefixBytes ||
      std::memcmp(message.data(), kFrameMagic.data(), kFrameMagic.size()) != 0) {
    return fail("the binary message is no frame: it does not begin with {}", kFrameMagic);
  }
  std::size_t header_bytes = 0;
  for (std::size_t i = 0; i < 4; ++i) header_bytes |= std::size_t{message[4 + i]} << (8 * i);
  if (header_bytes > kMaxHeaderBytes || header_bytes > message.size() - kPrefixBytes) {
    return fail("the frame's header of {} bytes is too long", header_bytes);
  }
  const auto header = message.subspan(kPrefixBytes, header_bytes);
  auto json =
      parse_object({reinterpret_cast<const char*>(header.data()), header.size()}, kMaxHeaderBytes);
  if (!json) return Unexpected(std::move(json).error().in("the frame's header"));
  Members members(*json);
  const auto images = message.subspan(kPrefixBytes + header_bytes);
  const auto most = static_cast<std::int64_t>(images.size());
  FrameMessage frame;
  frame.t_ms = members.number("t", -kMaxTime_ms, kMaxTime_ms);
  const auto color_bytes = static_cast<std::size_t>(members.whole("color_bytes", 1, most));
  const auto depth_bytes = static_cast<std::size_t>(members.whole("depth_bytes", 0, most));
  if (!members.error() && color_bytes + depth_bytes != images.size()) {
    members.wrong("depth_bytes",
                  fmt::format("with color_bytes the {} bytes that follow", images.size()));
  }
  if (members.error()) return Unexpected(Error(*members.error()).in("the frame's header"));
  frame.color = images.first(color_bytes);
  frame.depth = images.subspan(color_bytes);
  return frame;
}

Bytes write(const FrameMessage& frame) {
  const std::string header = dump({{"t", frame.t_ms},
                                   {"color_bytes", frame.color.size()},
                                   {"depth_bytes", frame.depth.size()}});
  Bytes message(kFrameMagic.begin(), kFrameMagic.end());
  message.reserve(kPrefixBytes + header.size() + frame.color.size() + frame.depth.size());
  for (std::size_t i = 0; i < 4; ++i) {
    message.push_back(static_cast<std::uint8_t>(header.size() >> (8 * i)));
  }
  message.insert(message.end(), header.begin(), header.end());
  message.insert(message.end(), frame.color.begin(), frame.color.end());
  message.insert(message.end(), frame.depth.begin(), frame.depth.end());
  return message;
}

}  // namespace roomwise::service
