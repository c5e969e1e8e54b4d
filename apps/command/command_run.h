#pragma once

#include "command.h"
#include "roomwise/pipeline/run_context.h"

namespace roomwise::app {

// What a run context refers to, made before it.
struct RunParts {
  ThreadPool own_pool;
  StageClock own_clock;
};

// The context of a command's long work: threads as asked for on the command line, the command's
// progress, and a clock of its own.
class CommandRun : private RunParts, public pipeline::RunContext {
 public:
  explicit CommandRun(Context& context)
      : RunParts{ThreadPool(context.threads), {}},
        pipeline::RunContext{own_pool, context.progress, own_clock} {}
  CommandRun(const CommandRun&) = delete;
  CommandRun& operator=(const CommandRun&) = delete;
};

}  // namespace roomwise::app
