#pragma once

#include "laboratory/labelling/recording_truth.h"
#include "roomwise/recording/recording.h"

namespace roomwise::labelling {

// What a reader marked in a recording, in the world of its true poses. A box counts where its
// picture has a pose within 0.02 s; depth is used where there is some. Fails where the labels are
// of another recording, or a box lies outside of its picture.
[[nodiscard]] Expected<LiftedLabels> lift_labels(const ReaderLabels& labels,
                                                 const recording::Recording& recording,
                                                 const recording::Trajectory& truth);

}  // namespace roomwise::labelling
