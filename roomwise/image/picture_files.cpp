#include "roomwise/image/picture_files.h"

#include <algorithm>
#include <string>

namespace roomwise::image {

namespace fs = std::filesystem;

bool has_ending_of_picture(const fs::path& file) {
  std::string ending = file.extension().string();
  std::ranges::transform(ending, ending.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c;
  });
  return ending == ".jpg" || ending == ".jpeg" || ending == ".png";
}

Expected<std::vector<fs::path>> picture_files(const fs::path& folder) {
  std::error_code error, ignored;
  std::vector<fs::path> files;
  for (fs::recursive_directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const bool is_picture = has_ending_of_picture(entry->path());
    if (is_picture && entry->is_regular_file(ignored)) files.push_back(entry->path());
  }
  if (error) return fail("{}: cannot be read: {}", folder.string(), error.message());
  std::ranges::sort(files);
  return files;
}

}  // namespace roomwise::image
