#pragma once

#include "command.h"
#include "roomwise/pipeline/run_context.h"

namespace roomwise::app {

// The context of a command's long work: threads as asked for on the command line, the command's
// progress, and a clock of its own.
class CommandRun : public pipeline::OwnRunContext {
 public:
  explicit CommandRun(Context& context) : OwnRunContext(context.threads, context.progress) {}
};

// Adds to the JSON what each stage of the work took.
inline void add_stages(Answer& answer, const StageClock& clock) {
  for (const auto& [name, stage] : clock.stages()) {
    answer.json["stages"][name] = {
        {"calls", stage.calls}, {"wall_s", stage.wall_s}, {"cpu_s", stage.cpu_s}};
  }
}

}  // namespace roomwise::app
