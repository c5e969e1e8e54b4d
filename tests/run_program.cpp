#include "run_program.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"

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

// Starts a program; `open_files` says where its output goes.
pid_t spawn(std::string program, const std::vector<std::string>& arguments,
            const std::string& data_folder,
            const std::function<void(posix_spawn_file_actions_t&)>& open_files) {
  std::vector<std::string> words = arguments;
  std::vector<char*> argv{program.data()};
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  static const ScratchFolder no_networks;  // also for programs that are still running
  std::string models = "ROOMWISE_MODELS=" + no_networks.path().string();
  std::string data =
      "XDG_DATA_HOME=" + (data_folder.empty() ? no_networks.path().string() : data_folder);
  const std::vector<char*> environment = environment_without_networks(models, data);

  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  open_files(files);
  pid_t child = -1;
  const int spawned =
      posix_spawn(&child, program.c_str(), &files, nullptr, argv.data(), environment.data());
  posix_spawn_file_actions_destroy(&files);
  if (spawned != 0) std::abort();
  return child;
}

int exit_code_of(pid_t child) {
  int status = 0;
  if (waitpid(child, &status, 0) != child) std::abort();
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

ProgramResult run_roomwise(const std::vector<std::string>& arguments,
                           const std::string& data_folder) {
  return run_program(ROOMWISE_PROGRAM, arguments, data_folder);
}

ProgramResult run_program(const std::string& program, const std::vector<std::string>& arguments,
                          const std::string& data_folder) {
  const ScratchFolder folder;
  const std::string output = folder / "output";
  const std::string errors = folder / "errors";
  const pid_t child =
      spawn(program, arguments, data_folder, [&](posix_spawn_file_actions_t& files) {
        posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, output.c_str(), O_WRONLY | O_CREAT,
                                         0600);
        posix_spawn_file_actions_addopen(&files, STDERR_FILENO, errors.c_str(), O_WRONLY | O_CREAT,
                                         0600);
      });
  ProgramResult result;
  result.exit_code = exit_code_of(child);
  result.output = read_text_file(output).value();
  result.errors = read_text_file(errors).value();
  return result;
}

RunningProgram start_roomwise(const std::vector<std::string>& arguments, const std::string& input) {
  std::string errors = (std::filesystem::temp_directory_path() / "roomwise-errors-XXXXXX").string();
  const int errors_file = mkstemp(errors.data());
  std::array<int, 2> output{};
  if (errors_file < 0 || pipe2(output.data(), O_CLOEXEC) != 0) std::abort();
  const pid_t child =
      spawn(ROOMWISE_PROGRAM, arguments, "", [&](posix_spawn_file_actions_t& files) {
        posix_spawn_file_actions_addopen(&files, STDIN_FILENO, input.c_str(), O_RDONLY, 0);
        posix_spawn_file_actions_adddup2(&files, output[1], STDOUT_FILENO);
        posix_spawn_file_actions_adddup2(&files, errors_file, STDERR_FILENO);
      });
  close(errors_file);
  close(output[1]);
  return {child, output[0], errors};
}

RunningProgram::~RunningProgram() {
  if (process_ > 0) end(SIGKILL);
  if (output_ >= 0) close(output_);
  if (!errors_file_.empty()) unlink(errors_file_.c_str());
}

bool RunningProgram::read_line(std::string& line) {
  line.clear();
  for (char c = 0; read(output_, &c, 1) == 1;) {
    if (c == '\n') return true;
    line += c;
  }
  return !line.empty();
}

int RunningProgram::end(int signal) {
  kill(process_, signal);
  return exit_code_of(std::exchange(process_, -1));
}

std::string RunningProgram::errors() const {
  return read_text_file(errors_file_).value();
}

nlohmann::json result_of(std::vector<std::string> arguments, const std::string& data_folder) {
  arguments.emplace_back("--json");
  const ProgramResult result = run_roomwise(arguments, data_folder);
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  return result.exit_code == 0 ? nlohmann::json::parse(result.output) : nlohmann::json();
}

}  // namespace roomwise::testing
