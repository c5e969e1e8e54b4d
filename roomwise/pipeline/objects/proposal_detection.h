#pragma once

#include "roomwise/home/home.h"
#include "roomwise/objects/proposals/proposal_classifier.h"
#include "roomwise/pipeline/run_context.h"

namespace roomwise::pipeline {

// Shows networks, from its best views, what stands by itself in the map's depth, and stores what
// they call it as detections of those key-frames (objects::find_proposals,
// objects::classify_proposals). For when finders have looked at the key-frames and their poses are
// optimised, before update_objects(). It takes the place of what was stored so before. Where it
// fails, and where the user interrupts, nothing is changed.
[[nodiscard]] Expected<void> redetect_on_proposals(
    home::Home& home, const objects::ProposalClassifier& proposal_classifier, RunContext& run);

}  // namespace roomwise::pipeline
