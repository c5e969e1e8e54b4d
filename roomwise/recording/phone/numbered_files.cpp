#include "roomwise/recording/phone/numbered_files.h"

#include <charconv>

namespace roomwise::recording {

namespace fs = std::filesystem;

std::optional<std::uint64_t> number_in_name(const std::string& name, std::string_view before,
                                            std::string_view after) {
  if (!name.starts_with(before) || !name.ends_with(after)) return std::nullopt;
  if (name.size() <= before.size() + after.size()) return std::nullopt;
  const char* first = name.data() + before.size();
  const char* last = name.data() + name.size() - after.size();
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(first, last, number);
  if (error != std::errc() || end != last) return std::nullopt;
  return number;
}

Expected<NumberedFiles> numbered_files(const fs::path& folder, std::string_view before,
                                       std::string_view after) {
  NumberedFiles files;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const auto number = number_in_name(entry->path().filename().string(), before, after);
    if (number) files.emplace(*number, entry->path());
  }
  if (error) return fail("{}: cannot be read: {}", folder.string(), error.message());
  return files;
}

bool has_numbered_file(const fs::path& folder, std::string_view before, std::string_view after) {
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    if (number_in_name(entry->path().filename().string(), before, after)) return true;
  }
  return false;
}

fs::path file_or_none(const NumberedFiles& files, std::uint64_t number) {
  const auto file = files.find(number);
  return file == files.end() ? fs::path() : file->second;
}

}  // namespace roomwise::recording
