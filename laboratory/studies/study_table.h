#pragma once

#include <string>
#include <vector>

#include "laboratory/studies/study_store.h"

namespace roomwise::studies {

// A table of a study's results in Markdown: a row (or column) for each combination of the factors
// that [table] names, with how many tasks are done, and of each figure the mean and, of several,
// the least and the largest, and of how many tasks where not all have it. Then the tasks that
// failed, and why, and how many are open. The same results give the same table, wherever and in
// whatever order they were made.
[[nodiscard]] std::string table_of(const Study& study, const std::vector<StudyTask>& tasks,
                                   const std::vector<TaskResult>& results);

}  // namespace roomwise::studies
