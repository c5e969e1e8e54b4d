#include "laboratory_program.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <vector>

#include "roomwise/base/file.h"

namespace roomwise::app {

Expected<Answer> become_program(const std::string& program) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path file = fs::read_symlink("/proc/self/exe", error).parent_path() / program;
  if (error || !fs::exists(file, error)) {
    return fail(
        "{}: is not there: this command is part of Roomwise's laboratory ({}); install the "
        "packages that cmake/packages.txt lists for it, then configure with -DROOMWISE_LAB=ON and "
        "build again",
        file.string(), program == kTraining ? "training, by libtorch" : "simulation and trials");
  }
  ROOMWISE_TRY(std::string line, read_text_file("/proc/self/cmdline"));
  std::vector<char*> arguments;
  for (std::size_t begin = 0; begin < line.size(); begin = line.find('\0', begin) + 1)
    arguments.push_back(line.data() + begin);
  arguments.push_back(nullptr);
  execv(file.c_str(), arguments.data());
  return fail("{}: cannot be run: {}", file.string(), std::strerror(errno));
}

void add_command_elsewhere(CLI::App& parent, Context& context, const std::string& name,
                           const std::string& description, const std::string& program) {
  CLI::App* command = parent.add_subcommand(name, description);
  command->set_help_flag();
  command->prefix_command();
  command->callback(
      [&context, program] { context.chosen = [program] { return become_program(program); }; });
}

}  // namespace roomwise::app
