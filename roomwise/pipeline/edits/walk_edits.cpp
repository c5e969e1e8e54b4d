#include "roomwise/pipeline/edits/walk_edits.h"

#include <algorithm>

#include "roomwise/pipeline/stored/stored_map.h"

namespace roomwise::pipeline {

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

std::set<home::RecordingId> walks_taken_away(std::span<const StoredEdit> edits) {
  std::set<home::RecordingId> walks;
  for (const StoredEdit& edit : edits) {
    if (edit.kind == EditKind::kTakeWalk && edit.change.walk) walks.insert(*edit.change.walk);
  }
  return walks;
}

Expected<std::vector<home::StoredRecording>> forget_taken_walks(home::Home& home) {
  ROOMWISE_TRY(const auto edits, stored_edits(home));
  const std::set<home::RecordingId> walks = walks_taken_away(edits);
  std::vector<home::StoredRecording> forgotten;
  for (const home::RecordingId walk : walks) {
    ROOMWISE_TRY(const auto recordings, home.recordings());
    const auto found = std::ranges::find(recordings, walk, &home::StoredRecording::id);
    if (found == recordings.end()) continue;
    ROOMWISE_CHECK_OK(forget_walk(home, walk));
    forgotten.push_back(*found);
  }
  return forgotten;
}

}  // namespace roomwise::pipeline
