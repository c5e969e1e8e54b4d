#pragma once

#include <span>
#include <string>

#include "roomwise/home/home.h"
#include "roomwise/pipeline/objects/home_things.h"
#include "roomwise/pipeline/stored/stored_edits.h"

namespace roomwise::pipeline {

// Takes a change back: the home is as if it had never been made, to the bit where nothing else
// changed since. Returns what was undone. Fails, changing nothing, where a later change is about
// the same thing, or about rooms as well: undo that one first.
[[nodiscard]] Expected<StoredEdit> undo_edit(home::Home& home, home::EditId id);

// Why it cannot be undone; empty where it can. `edits` and `things`: of the home.
[[nodiscard]] std::string why_not_undone(std::span<const StoredEdit> edits, const StoredEdit& edit,
                                         const HomeThings& things);

// Whether anything waits for forget_removed_rooms().
[[nodiscard]] Expected<bool> has_removed_rooms(const home::Home& home);
// When the home is closed: what was kept of removed rooms, so that they could be undone, goes, and
// what was learned of them. Then Home::erase_removed() leaves no byte of them. Earlier changes of
// rooms cannot be undone any more; what they made of rooms stands.
[[nodiscard]] Expected<void> forget_removed_rooms(home::Home& home);

// What a change did, in few words: "renamed cup to mug".
[[nodiscard]] std::string describe(const StoredEdit& edit);

}  // namespace roomwise::pipeline
