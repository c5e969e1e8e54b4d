#pragma once

#include <cstddef>

#include "roomwise/base/progress.h"
#include "roomwise/base/stage_clock.h"
#include "roomwise/base/thread_pool.h"

namespace roomwise::pipeline {

// What every long piece of work is given besides its inputs: threads, a place to tell how far it
// is, a clock. None of it changes a result.
struct RunContext {
  ThreadPool& pool;
  Progress& progress;
  StageClock& clock;
};

}  // namespace roomwise::pipeline
