#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "roomwise/pipeline/edits/edit_things.h"
#include "roomwise/pipeline/stored/stored_edits.h"

// Taking walks away with a way back (walks_taken_away() says which are): until forget_taken_walks()
// undo_edit() brings one back.
namespace roomwise::pipeline {

// HOME.walks, where a served home keeps the walks that it recorded or was handed.
[[nodiscard]] std::filesystem::path own_walks_folder(const std::filesystem::path& home);

// Where its frames lie: in the home's own folder those of a walk that was recorded into one,
// whatever the home was called then; others where they lay when they were mapped.
[[nodiscard]] std::filesystem::path folder_of_walk(const home::Home& home,
                                                   const home::StoredRecording& walk);

// The walk stays in the home, and in its map; who shows walks leaves it out. Fails where there is
// no such walk, or it is taken away already.
[[nodiscard]] Expected<home::EditId> take_walk_away(home::Home& home, const EditAuthor& author,
                                                    home::RecordingId walk);

// Removes the walk's frames where they lie in the home's own folder (folder_of_walk());
// before the walk goes from the home, so that it is not taken for one that waits to be mapped. A
// recording that lies elsewhere stays: it is whoever recorded it's.
[[nodiscard]] Expected<void> remove_walk_folder(const home::Home& home,
                                                const home::StoredRecording& walk);

// remove_walk_folder() and forget_walk() of each of them; Home::erase_removed() is to follow.
// Returns what they were. `by`: of those alone whose author has this name.
[[nodiscard]] Expected<std::vector<home::StoredRecording>> forget_taken_walks(
    home::Home& home, const std::optional<std::string>& by = std::nullopt);

}  // namespace roomwise::pipeline
