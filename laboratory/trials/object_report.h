#pragma once

#include <string>

#include "laboratory/trials/truth_evaluation.h"
#include "roomwise/evaluation/report/object_report.h"

namespace roomwise::trials {

// The page about a home's objects beside the truth: what is false, found once more, missed and
// found of those joined from regions, as the home's key-frames show it. Fails where a key-frame's
// picture cannot be read.
[[nodiscard]] Expected<evaluation::ObjectReportContent> object_report(
    const home::Home& home, const std::string& title, const ObjectEvaluation& evaluation);

}  // namespace roomwise::trials
