#pragma once

#include <filesystem>
#include <fstream>
#include <span>

namespace roomwise::recording::testing {

// For files that are written by the thousand: write_file() waits for the disk, and so does a file
// system whose file is emptied.
inline void write_quickly(const std::filesystem::path& path, std::span<const std::uint8_t> bytes) {
  std::error_code ignored;
  std::filesystem::remove(path, ignored);
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

}  // namespace roomwise::recording::testing
