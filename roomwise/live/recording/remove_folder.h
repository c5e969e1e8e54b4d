#pragma once

#include <filesystem>

#include "roomwise/base/expected.h"

namespace roomwise::live {

// Removes a folder with all that is in it, where it is there. Fails, naming it, where something
// stays.
[[nodiscard]] inline Expected<void> remove_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::remove_all(folder, error);
  if (error) return fail("{}: could not be removed: {}", folder.string(), error.message());
  return {};
}

}  // namespace roomwise::live
