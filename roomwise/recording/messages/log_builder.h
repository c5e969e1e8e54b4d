#pragma once

#include <map>
#include <optional>

#include "roomwise/recording/messages/message_log.h"
#include "roomwise/recording/messages/record_space.h"

namespace roomwise::recording {

// What the readers of MCAP and of bags do alike: gather the channels, chunks and messages of a file
// as its records are met.
class LogBuilder {
 public:
  explicit LogBuilder(const RandomAccessFile& file) : file_(file) {}

  // A channel by the file's own number. Fails where the number stands for another channel already.
  [[nodiscard]] Expected<void> add_channel(std::uint32_t number, Channel channel);
  // Null where there is none of that number.
  [[nodiscard]] const Channel* channel(std::uint32_t number) const;
  // The number under which add_message() knows it.
  std::uint32_t add_chunk(const Chunk& chunk);
  // A message of a channel that is read, whose data lies at `offset` of `space` (the chunk, or the
  // file itself). Its time is looked up in its header.
  [[nodiscard]] Expected<void> add_message(std::uint32_t channel_number, std::uint32_t chunk,
                                           TimestampNs logged_ns, RecordSpace& space,
                                           std::uint64_t offset, std::uint64_t size);
  void note(std::string text) { contents_.notes.push_back(std::move(text)); }
  [[nodiscard]] LogContents take() && { return std::move(contents_); }

 private:
  const RandomAccessFile& file_;
  LogContents contents_;
  std::map<std::uint32_t, std::uint32_t> channels_;  // file's number -> place in contents_
};

}  // namespace roomwise::recording
