#pragma once

#include <cstddef>
#include <string>

#include "laboratory/studies/kept_run.h"
#include "laboratory/studies/study_store.h"
#include "roomwise/base/progress.h"

namespace roomwise::studies {

// Carries out a task, going on after the steps that an earlier attempt ended, and keeps what came
// of it; a step or a figure that fails is a result, too. Does nothing where the task is done. Fails
// where the work is interrupted or nothing can be written: then the task is still open. False where
// another process is at it.
[[nodiscard]] Expected<bool> run_task(const StudyStore& store, const StudyTask& task,
                                      const RunProgram& program);

struct StudyCount {
  std::size_t tasks = 0;
  std::size_t done = 0;
  std::size_t failed = 0;
  std::size_t open = 0;  // also those that another process is at
};
[[nodiscard]] Expected<StudyCount> count_of(const StudyStore& store);

// All that is open, on this machine, `workers` tasks at once; then the tables. The first task that
// cannot be kept ends it.
[[nodiscard]] Expected<StudyCount> run_here(const StudyStore& store, std::size_t workers,
                                            const RunProgram& program, Progress& progress);

// The computer's name, or Slurm's name of it where a task of Slurm's asks, and its processor.
[[nodiscard]] std::string machine_name();
// What Linux's /proc/cpuinfo calls the processor: its model, else the board's, else the numbers of
// an ARM core; empty where it tells none.
[[nodiscard]] std::string processor_in(const std::string& cpuinfo);

}  // namespace roomwise::studies
