#include "laboratory/training/trainer.h"
#include "own_kinds.h"
#include "train_command.h"

int main(int argc, char** argv) {
  using namespace roomwise::app;
  roomwise::training::keep_memory_of_large_tensors();
  CLI::App app("The training of roomwise; see roomwise train --help.", "roomwise");
  app.set_version_flag("--version", ROOMWISE_VERSION);
  app.require_subcommand(1);
  Context context;
  context.prepare = add_own_kinds;
  declare_train_command(app, context);
  return run(app, context, argc, argv);
}
