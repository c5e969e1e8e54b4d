#include "roomwise/live/recording/free_disk_bytes.h"

namespace roomwise::live {

namespace fs = std::filesystem;

Expected<std::uint64_t> free_bytes_at(const fs::path& path) {
  std::error_code error;
  fs::path there = fs::absolute(path);
  while (!fs::exists(there, error) && there.has_relative_path()) there = there.parent_path();
  const fs::space_info space = fs::space(there, error);
  if (error) return fail("{}: {}", there.string(), error.message());
  return std::uint64_t{space.available};
}

}  // namespace roomwise::live
