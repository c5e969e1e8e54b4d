#include "roomwise/pipeline/exports/new_folder.h"

#include <unistd.h>

namespace roomwise::pipeline {
namespace {

namespace fs = std::filesystem;

// "a/b/" names the same folder as "a/b".
fs::path without_slash(const fs::path& folder) {
  return folder.has_filename() ? folder : folder.parent_path();
}

}  // namespace

Expected<void> check_new_folder(const fs::path& folder) {
  std::error_code ignored;
  const fs::path name = without_slash(folder);
  if (fs::exists(fs::symlink_status(name, ignored))) {
    return fail("{}: is there and is not overwritten; give a new folder", name.string());
  }
  const fs::path parent = name.parent_path();
  if (!parent.empty() && !fs::is_directory(parent, ignored)) {
    return fail("{}: no such folder to write in", parent.string());
  }
  return {};
}

Expected<void> make_new_folder(const fs::path& folder,
                               const std::function<Expected<void>(const fs::path&)>& fill) {
  ROOMWISE_RETURN_IF_ERROR(check_new_folder(folder));
  const fs::path name = without_slash(folder);
  fs::path partial = name;
  partial += fmt::format(".partial-{}", ::getpid());
  std::error_code error;
  fs::create_directory(partial, error);
  if (error) return fail("{}: cannot be made: {}", name.string(), error.message());
  Expected<void> filled = fill(partial);
  if (filled) {
    // A folder that was made meanwhile stays, unless it is empty.
    fs::rename(partial, name, error);
    if (!error) return {};
    filled = fail("{}: cannot be put in place: {}", name.string(), error.message());
  }
  std::error_code ignored;
  fs::remove_all(partial, ignored);
  return filled;
}

}  // namespace roomwise::pipeline
