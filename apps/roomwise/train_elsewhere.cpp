// "roomwise train" is a program of its own, roomwise-train: loading libtorch takes half a second of
// processor time, which no other command should pay.
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "commands.h"
#include "roomwise/base/file.h"
#include "train_command.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

// This process becomes the other program, with the same arguments.
Expected<Answer> become_training_program() {
  std::error_code error;
  const fs::path program =
      fs::read_symlink("/proc/self/exe", error).parent_path() / "roomwise-train";
  if (error || !fs::exists(program, error)) {
    return fail(
        "{}: is not there: this Roomwise was built without libtorch, by which networks are "
        "trained; "
        "install libtorch-dev, libgloo-dev and libopenblas0-pthread, then configure and build "
        "again",
        program.string());
  }
  ROOMWISE_TRY(std::string line, read_text_file("/proc/self/cmdline"));
  std::vector<char*> arguments;
  for (std::size_t begin = 0; begin < line.size(); begin = line.find('\0', begin) + 1)
    arguments.push_back(line.data() + begin);
  arguments.push_back(nullptr);
  execv(program.c_str(), arguments.data());
  return fail("{}: cannot be run: {}", program.string(), std::strerror(errno));
}

}  // namespace

void add_train_command(CLI::App& app, Context& context) {
  declare_train_command(app, context,
                        [](const TrainRequest&) { return become_training_program(); });
}

}  // namespace roomwise::app
