#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/base/file.h"
#include "roomwise/base/timestamp.h"

namespace roomwise::recording {

// Writes an MCAP file: chunks without compression, with CRC-32 and an index, so that a reader can
// begin anywhere. Source: MCAP's specification, version 0. Messages are best written in the order
// of time. The file gets its name when it is whole (finish()); until then it stands beside it, and
// is removed with the writer.
class McapFileWriter {
 public:
  // Fails where the file is there already or cannot be written.
  [[nodiscard]] static Expected<McapFileWriter> create(const std::filesystem::path& path);
  McapFileWriter(McapFileWriter&&) noexcept;
  McapFileWriter& operator=(McapFileWriter&&) = delete;
  ~McapFileWriter();

  // A channel of JSON messages, and its number. `schema`: a JSON Schema; channels of one name of
  // schema share it.
  std::uint16_t add_json_channel(const std::string& topic, const std::string& schema_name,
                                 const std::string& schema);
  // Fails where the time is before 0, which MCAP cannot say, and where writing does.
  [[nodiscard]] Expected<void> write(std::uint16_t channel, TimestampNs time_ns,
                                     std::string_view message);
  [[nodiscard]] Expected<void> finish();

  [[nodiscard]] std::uint64_t messages() const { return message_count_; }

 private:
  struct WrittenChannel {
    std::uint64_t messages = 0;
    std::vector<std::pair<std::uint64_t, std::uint64_t>> in_chunk;  // time, offset in its records
  };
  struct WrittenChunk {
    std::uint64_t first_ns = 0, last_ns = 0;
    std::uint64_t offset = 0, length = 0;  // of the record in the file
    std::uint64_t records_size = 0;
    std::map<std::uint16_t, std::uint64_t> index_offsets;  // by channel
    std::uint64_t index_length = 0;
  };

  struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  McapFileWriter(std::filesystem::path path, std::filesystem::path partial, std::FILE* file);
  [[nodiscard]] Expected<void> append(const Bytes& bytes);
  [[nodiscard]] Expected<void> close_chunk();
  [[nodiscard]] Bytes summary() const;

  std::filesystem::path path_;
  std::unique_ptr<const std::filesystem::path> partial_;  // null once the file is in place
  std::unique_ptr<std::FILE, CloseFile> file_;
  std::uint64_t size_ = 0;      // of what is in the file
  std::uint32_t data_crc_ = 0;  // of it
  Bytes chunk_;                 // the records of the chunk that is being filled
  std::uint64_t chunk_first_ns_ = 0, chunk_last_ns_ = 0;
  std::uint64_t first_ns_ = 0, last_ns_ = 0, message_count_ = 0;
  std::map<std::string, std::uint16_t> schema_ids_;
  Bytes schemas_, channels_records_;  // records, for the summary
  std::vector<WrittenChannel> channels_;
  std::vector<WrittenChunk> chunks_;
};

}  // namespace roomwise::recording
