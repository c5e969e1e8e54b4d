#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "roomwise/home/home.h"
#include "roomwise/pipeline/run_context.h"
#include "roomwise/pipeline/stored/map_settings.h"

// Key-frame culling: what walk after walk shows again, in the same light, need not be kept for
// each. A walk is judged by those before it, so the first stays whole, and that a later one is
// forgotten takes nothing from the home that was there before it. That an earlier one is forgotten
// takes what later ones were culled for; one that is taken away already (stored_edits.h) covers
// nothing.
namespace roomwise::pipeline {

struct CullingOptions {
  // A key-frame goes only where the walks before say so often where its picture was taken: each
  // time without the key-frame that the answer before rested on. And so many others must have
  // measured what it did.
  int covers = 2;

  [[nodiscard]] Expected<void> validate() const;
};

// Why a key-frame stays, or that it adds nothing.
enum class CullingVerdict {
  kAddsNothing,
  kNotFound,      // the walks before do not say, or say wrongly, where it was taken
  kShowsMore,     // surfaces that no others, or too few, have seen, or others look through
  kRoomsPicture,  // the room is named there, and those that show the same are not of its pictures
  kReferenced,    // something hangs on it: a thing, a change by hand, where the walk or its part
                  // begins
};
[[nodiscard]] std::string_view to_string(CullingVerdict verdict);

using CullingVerdicts = std::map<home::KeyframeId, CullingVerdict>;
// Those that add nothing, ascending.
[[nodiscard]] std::vector<home::KeyframeId> redundant_of(const CullingVerdicts& verdicts);

// What each key-frame of a walk on the map adds to what the walks before it show. Each is judged
// for itself, by the home as it was before the walk, without walks that are taken away, so that any
// number of them can go together. Costs an answer of the localiser, or `covers`, a key-frame. Fails
// where the home has no such walk, and when the user interrupts.
[[nodiscard]] Expected<CullingVerdicts> judge_keyframes(const home::Home& home,
                                                        home::RecordingId walk,
                                                        const CullingOptions& options,
                                                        RunContext& run);

// Takes key-frames (ascending) of finished walks out of the home. The rest of the pose graph hangs
// together as before, frames stay where they are and hang on others, things are joined anew from
// what is left, and the localiser's index, where it was fresh, stays so. All of it or nothing.
// Fails where something else hangs on one of them (home::Home::held_keyframes()). `lost`: as for
// update_objects().
[[nodiscard]] Expected<void> cull_keyframes(home::Home& home,
                                            const std::vector<home::KeyframeId>& culled,
                                            const MapSettings& settings,
                                            const std::shared_ptr<LostPictures>& lost = nullptr);

}  // namespace roomwise::pipeline
