#pragma once

#include <cstddef>
#include <memory>

#include "roomwise/base/progress.h"
#include "roomwise/base/stage_clock.h"
#include "roomwise/base/thread_pool.h"

namespace roomwise::pipeline {

class LostPictures;  // stored/lost_pictures.h

// What every long task is given besides its inputs: threads, a place to tell how far it
// is, a clock, memory. None of it changes a result.
struct RunContext {
  ThreadPool& pool;
  Progress& progress;
  StageClock& clock;
  // What a map may keep in memory of its key-frames, about 0.4 MB each, while it is made, and of its
  // voxels and surface while it is fused; the rest waits in a scratch file beside the home.
  std::size_t working_set_bytes = std::size_t{128} << 20U;
  // What to do where a stored picture cannot be read again; null: it ends the work.
  std::shared_ptr<LostPictures> lost = nullptr;
};

// What a run context refers to, made before it.
struct RunParts {
  ThreadPool own_pool;
  StageClock own_clock;
};

// A context with threads and a clock of its own.
class OwnRunContext : private RunParts, public RunContext {
 public:
  OwnRunContext(std::size_t threads, Progress& shown)
      : RunParts{ThreadPool(threads), {}},
        RunContext{.pool = own_pool, .progress = shown, .clock = own_clock} {}
  OwnRunContext(const OwnRunContext&) = delete;
  OwnRunContext& operator=(const OwnRunContext&) = delete;
};

}  // namespace roomwise::pipeline
