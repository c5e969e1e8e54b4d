#pragma once

#include <string>
#include <vector>

#include "laboratory/studies/study_store.h"
#include "roomwise/base/progress.h"

namespace roomwise::studies {

struct SlurmOptions {
  std::string program;               // roomwise-lab, as the nodes find it
  std::vector<std::string> options;  // for sbatch: "--partition=long"
  double look_every_s = 5;           // for the end of the jobs
  bool retry = false;                // the tasks that failed, too
};

// Those of the study's jobs that wait or run.
[[nodiscard]] Expected<std::vector<std::string>> jobs_in_queue(const StudyStore& store,
                                                               const Interruption& interruption);

// Hands all open tasks to Slurm as job arrays of at most 1,000 (its usual MaxArraySize), each task
// an element that is put into the queue again where its node fails. Gives the jobs' numbers; none
// where no task is open. Fails where an earlier job of this study is in the queue still: its tasks
// are not to be done twice.
[[nodiscard]] Expected<std::vector<std::string>> submit(const StudyStore& store,
                                                        const SlurmOptions& options,
                                                        const Interruption& interruption);

// Until none of the study's jobs is in the queue any more. Interrupted, it leaves the jobs there.
[[nodiscard]] Expected<void> wait_for_jobs(const StudyStore& store, const SlurmOptions& options,
                                           Progress& progress);

// The id of a task of a list that submit() wrote, by the number of the array's element.
[[nodiscard]] Expected<StudyTask> task_in_list(const StudyStore& store, const std::string& list,
                                               std::size_t index);

}  // namespace roomwise::studies
