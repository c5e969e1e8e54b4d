#include "run_program.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>

#include "roomwise/base/file.h"
#include "roomwise/base/testing.h"

namespace roomwise::testing {
namespace {

// This program's environment, but without the machine's networks: a test names the ones it needs.
std::vector<char*> environment_without_networks(std::string& models, std::string& data) {
  std::vector<char*> variables;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    if (std::strncmp(*variable, "ROOMWISE_MODELS=", 16) != 0 &&
        std::strncmp(*variable, "XDG_DATA_HOME=", 14) != 0) {
      variables.push_back(*variable);
    }
  }
  variables.push_back(data.data());
  variables.push_back(models.data());
  variables.push_back(nullptr);
  return variables;
}

}  // namespace

ProgramResult run_roomwise(const std::vector<std::string>& arguments,
                           const std::string& data_folder) {
  const ScratchFolder folder;
  const std::string output = folder / "output";
  const std::string errors = folder / "errors";

  std::string program = ROOMWISE_PROGRAM;
  std::vector<std::string> words = arguments;
  std::vector<char*> argv{program.data()};
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  const ScratchFolder no_networks;
  std::string models = "ROOMWISE_MODELS=" + no_networks.path().string();
  std::string data =
      "XDG_DATA_HOME=" + (data_folder.empty() ? no_networks.path().string() : data_folder);
  const std::vector<char*> environment = environment_without_networks(models, data);

  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, output.c_str(), O_WRONLY | O_CREAT, 0600);
  posix_spawn_file_actions_addopen(&files, STDERR_FILENO, errors.c_str(), O_WRONLY | O_CREAT, 0600);
  pid_t child = -1;
  const int spawned =
      posix_spawn(&child, program.c_str(), &files, nullptr, argv.data(), environment.data());
  posix_spawn_file_actions_destroy(&files);
  if (spawned != 0) std::abort();

  int status = 0;
  if (waitpid(child, &status, 0) != child) std::abort();
  ProgramResult result;
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  result.output = read_text_file(output).value();
  result.errors = read_text_file(errors).value();
  return result;
}

nlohmann::json result_of(std::vector<std::string> arguments, const std::string& data_folder) {
  arguments.emplace_back("--json");
  const ProgramResult result = run_roomwise(arguments, data_folder);
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  return result.exit_code == 0 ? nlohmann::json::parse(result.output) : nlohmann::json();
}

}  // namespace roomwise::testing
