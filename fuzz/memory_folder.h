#pragma once

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

// Bytes as a folder of files, in memory. Between two files stands kBetween; a file is a line with
// its name, then its content. Names that lead out of the folder are left out.
class MemoryFolder {
 public:
  static constexpr std::string_view kBetween = "\xF5~\xF5\n";

  MemoryFolder(const std::uint8_t* data, std::size_t size) {
    std::string pattern = "/dev/shm/roomwise-fuzz-XXXXXX";
    if (mkdtemp(pattern.data()) == nullptr) __builtin_trap();
    path_ = pattern;
    std::string_view left(reinterpret_cast<const char*>(data), size);
    for (std::size_t files = 0; files < kMaxFiles && !left.empty(); ++files) {
      const std::size_t end = std::min(left.find(kBetween), left.size());
      write(left.substr(0, end));
      left.remove_prefix(std::min(end + kBetween.size(), left.size()));
    }
  }
  ~MemoryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  MemoryFolder(const MemoryFolder&) = delete;
  MemoryFolder& operator=(const MemoryFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  static constexpr std::size_t kMaxFiles = 32, kMaxName = 80;

  static bool is_safe(std::string_view name) {
    constexpr std::string_view kLetters =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-/";
    return !name.empty() && name.size() <= kMaxName &&
           name.find_first_not_of(kLetters) == std::string_view::npos && name.front() != '/' &&
           name.find("..") == std::string_view::npos;
  }
  void write(std::string_view file) const {
    const std::size_t end = file.find('\n');
    if (end == std::string_view::npos || !is_safe(file.substr(0, end))) return;
    const std::filesystem::path path = path_ / file.substr(0, end);
    std::error_code error;
    std::filesystem::create_directories(path.parent_path(), error);
    std::ofstream(path, std::ios::binary) << file.substr(end + 1);
  }

  std::filesystem::path path_;
};
