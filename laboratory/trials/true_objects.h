#pragma once

#include <optional>

#include "laboratory/labelling/recording_truth.h"
#include "laboratory/simulation/home/ground_truth.h"
#include "roomwise/evaluation/errors/object_error.h"
#include "roomwise/objects/detection/object_vocabulary.h"

namespace roomwise::trials {

// Upright, in the truth's frame.
[[nodiscard]] geometry::OrientedBox box_of(const simulation::ObjectTruth& object);

// A thing of a simulated home in the words of another home's vocabulary, expected where that has a
// word for it; absent where it has none, nor one for what is like it.
[[nodiscard]] std::optional<evaluation::TrueObject> in_words(
    const simulation::ObjectTruth& object, const objects::ObjectVocabulary& vocabulary);
// The same of what people marked in a real recording; what else they called it is not wrong.
[[nodiscard]] std::optional<evaluation::TrueObject> in_words(
    const labelling::TrueThing& thing, const objects::ObjectVocabulary& vocabulary);

// What a home calls a thing of a simulated home; absent where it has no word for it.
[[nodiscard]] std::optional<std::string> word_of(const std::string& label,
                                                 const objects::ObjectVocabulary& vocabulary);

}  // namespace roomwise::trials
