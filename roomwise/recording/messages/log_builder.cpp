#include "roomwise/recording/messages/log_builder.h"

#include <algorithm>

#include "roomwise/recording/messages/messages.h"

namespace roomwise::recording {
namespace {

Expected<std::optional<TimestampNs>> find_header_time(const Channel& channel, RecordSpace& space,
                                                      std::uint64_t offset, std::uint64_t size) {
  if (channel.encoding != Encoding::kJson) {
    ROOMWISE_TRY(const auto head, space.at(offset, std::min(size, kHeaderBytes)));
    const auto time = header_time(channel, head);
    if (time || size <= kHeaderBytes) return time;
  }
  if (channel.encoding == Encoding::kRos1 || channel.encoding == Encoding::kCdr) {
    return std::optional<TimestampNs>();
  }
  ROOMWISE_TRY(const auto whole, space.at(offset, size));
  return header_time(channel, whole);
}

}  // namespace

Expected<void> LogBuilder::add_channel(std::uint32_t number, Channel channel) {
  const auto known = channels_.find(number);
  if (known == channels_.end()) {
    channels_.emplace(number, static_cast<std::uint32_t>(contents_.channels.size()));
    contents_.channels.push_back(std::move(channel));
    return {};
  }
  const Channel& before = contents_.channels[known->second];
  if (before.topic == channel.topic && before.type_name == channel.type_name) return {};
  return fail("{}: number {} stands for {} and for {}; the file is damaged", file_.path().string(),
              number, before.topic, channel.topic);
}

const Channel* LogBuilder::channel(std::uint32_t number) const {
  const auto known = channels_.find(number);
  return known == channels_.end() ? nullptr : &contents_.channels[known->second];
}

std::uint32_t LogBuilder::add_chunk(const Chunk& chunk) {
  contents_.chunks.push_back(chunk);
  return static_cast<std::uint32_t>(contents_.chunks.size() - 1);
}

Expected<void> LogBuilder::add_message(std::uint32_t channel_number, std::uint32_t chunk,
                                       TimestampNs logged_ns, RecordSpace& space,
                                       std::uint64_t offset, std::uint64_t size) {
  const std::uint32_t place = channels_.at(channel_number);
  const Channel& channel = contents_.channels[place];
  if (!channel.is_read()) return {};
  if (contents_.messages.size() == kMaxMessages) {
    return fail("{}: holds more than {} messages of cameras; divide it", file_.path().string(),
                kMaxMessages);
  }
  ROOMWISE_TRY(const auto time, find_header_time(channel, space, offset, size));
  contents_.messages.push_back({place, logged_ns, time.value_or(logged_ns), chunk, offset, size});
  return {};
}

}  // namespace roomwise::recording
