#include "roomwise/pipeline/edits/walk_edits.h"

#include <algorithm>
#include <filesystem>

#include "roomwise/pipeline/stored/stored_map.h"

namespace roomwise::pipeline {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view kWalks = ".walks";

fs::path stored_folder(const home::StoredRecording& walk) {
  return fs::path(walk.recording.folder).lexically_normal();
}

bool lies_in(const fs::path& folder, const fs::path& parent) {
  std::error_code ignored;
  return folder.has_filename() && fs::weakly_canonical(folder.parent_path(), ignored) ==
                                      fs::weakly_canonical(parent, ignored);
}

// Its folder in the home's own; absent where it was recorded elsewhere. The folder is stored by the
// path that the home had then: it may have been moved, copied or restored since. Then it is the one
// of its name, unless that is another walk's.
std::optional<fs::path> own_folder_of(const home::Home& home, const home::StoredRecording& walk) {
  const fs::path folder = stored_folder(walk);
  const fs::path own = own_walks_folder(home.file());
  const fs::path there = own / folder.filename();
  if (lies_in(folder, own)) return there;
  if (!folder.has_filename() || !folder.parent_path().filename().string().ends_with(kWalks)) {
    return std::nullopt;
  }
  std::error_code ignored;
  const auto recordings = home.recordings();
  if (!recordings || !fs::exists(there, ignored)) return std::nullopt;
  const bool is_of_another =
      std::ranges::any_of(*recordings, [&](const home::StoredRecording& other) {
        const fs::path its = stored_folder(other);
        return its.filename() == folder.filename() && lies_in(its, own);
      });
  return is_of_another ? std::nullopt : std::optional(there);
}

}  // namespace

fs::path own_walks_folder(const fs::path& home) {
  return fs::path(home.string() + std::string(kWalks));
}

fs::path folder_of_walk(const home::Home& home, const home::StoredRecording& walk) {
  return own_folder_of(home, walk).value_or(walk.recording.folder);
}

Expected<home::EditId> take_walk_away(home::Home& home, const EditAuthor& author,
                                      home::RecordingId walk) {
  ROOMWISE_TRY(const auto recordings, home.recordings());
  const auto found = std::ranges::find(recordings, walk, &home::StoredRecording::id);
  if (found == recordings.end()) return fail("this home has no walk {}", walk);
  ROOMWISE_TRY(const auto edits, stored_edits(home));
  const std::string& name = found->recording.name;
  if (walks_taken_away(edits).contains(walk)) return fail("'{}' is taken away already", name);
  const StoredEdit edit{.made_s = author.time_s,
                        .made_by = author.name,
                        .kind = EditKind::kTakeWalk,
                        .change = {.name = name, .walk = walk}};
  return home.add_edit(edit.row());
}

Expected<void> remove_walk_folder(const home::Home& home, const home::StoredRecording& walk) {
  const auto folder = own_folder_of(home, walk);
  if (!folder) return {};
  std::error_code error;
  fs::remove_all(*folder, error);
  if (error) return fail("{}: could not be removed: {}", folder->string(), error.message());
  return {};
}

Expected<std::vector<home::StoredRecording>> forget_taken_walks(
    home::Home& home, const std::optional<std::string>& by) {
  ROOMWISE_TRY(auto edits, stored_edits(home));
  if (by) std::erase_if(edits, [&](const StoredEdit& edit) { return edit.made_by != *by; });
  const std::set<home::RecordingId> walks = walks_taken_away(edits);
  std::vector<home::StoredRecording> forgotten;
  for (const home::RecordingId walk : walks) {
    ROOMWISE_TRY(const auto recordings, home.recordings());
    const auto found = std::ranges::find(recordings, walk, &home::StoredRecording::id);
    if (found == recordings.end()) continue;
    ROOMWISE_RETURN_IF_ERROR(remove_walk_folder(home, *found));
    ROOMWISE_RETURN_IF_ERROR(forget_walk(home, walk));
    forgotten.push_back(*found);
  }
  return forgotten;
}

}  // namespace roomwise::pipeline
