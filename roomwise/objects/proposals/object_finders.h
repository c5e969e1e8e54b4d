#pragma once

#include <memory>

#include "roomwise/objects/detection/region_finder.h"
#include "roomwise/objects/proposals/proposal_classifier.h"

namespace roomwise::objects {

// All that finds things.
struct ObjectFinders {
  DetectionFinders in_pictures;  // each looks at every key-frame
  // Looks closer at what the depth of a finished map, or of a later walk, shows standing by itself;
  // may be absent.
  std::unique_ptr<const ProposalClassifier> of_proposals;
};

}  // namespace roomwise::objects
