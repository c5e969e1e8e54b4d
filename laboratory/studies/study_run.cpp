#include "laboratory/studies/study_run.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <map>
#include <mutex>
#include <sstream>
#include <thread>

#include "roomwise/base/file.h"
#include "roomwise/base/file_descriptor.h"

namespace roomwise::studies {
namespace {

namespace fs = std::filesystem;

// Held while a process is at a task; it goes with the process, however that ends.
class TaskLock {
 public:
  static Expected<std::unique_ptr<TaskLock>> try_lock(const fs::path& file) {
    auto lock = std::make_unique<TaskLock>(file);
    if (lock->file_.value < 0) {
      return fail_with(code_of_write_error(errno), "{}: cannot be opened: {}", file.string(),
                       std::strerror(errno));
    }
    if (::flock(lock->file_.value, LOCK_EX | LOCK_NB) != 0) return nullptr;
    return lock;
  }
  explicit TaskLock(const fs::path& file)
      : file_(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)) {}

 private:
  FileDescriptor file_;
};

// How often the task was begun, with this time.
Expected<int> note_attempt(const fs::path& file) {
  std::string marks;
  if (fs::exists(file)) {
    ROOMWISE_TRY(marks, read_text_file(file));
  }
  marks += "begun on " + machine_name() + "\n";
  ROOMWISE_RETURN_IF_ERROR(write_file(file, marks));
  return static_cast<int>(std::ranges::count(marks, '\n'));
}

// What an earlier attempt left half done is in nobody's way.
Expected<void> empty_folder(const fs::path& folder) {
  std::error_code error;
  fs::remove_all(folder, error);
  if (!error) fs::create_directories(folder, error);
  if (error) {
    return fail_with(code_of_write_error(error.value()), "{}: cannot be emptied: {}",
                     folder.string(), error.message());
  }
  return {};
}

// A step's result, which is made where it is not kept. An Error of kFailed is the step's own.
Expected<nlohmann::json> result_of(const StudyStore& store, const StudyTask& task,
                                   const StudyStep& step,
                                   const std::map<std::string, fs::path>& folders,
                                   const RunProgram& program) {
  const fs::path folder = store.task_folder(task.id);
  ProgramRun run;
  run.program = step.program;
  run.words = words_of(step, task, folders);
  run.more = {"--threads", std::to_string(store.study().threads)};
  run.log = folder / (step.name + ".log");
  const fs::path kept = folder / (step.name + ".json");
  if (!fs::exists(kept)) ROOMWISE_RETURN_IF_ERROR(empty_folder(folders.at(step.name)));
  return run_kept(run, kept, program);
}

// The figures that the study takes of a step.
Expected<void> take_values(const Study& study, const StudyStep& step, const nlohmann::json& printed,
                           TaskResult& result) {
  for (const StudyValue& value : study.values) {
    if (value.step != step.name) continue;
    const nlohmann::json::json_pointer pointer(value.pointer);
    if (!printed.contains(pointer)) {
      std::string there;
      for (const auto& [key, ignored] : printed.items()) {
        if (key != "command") there += (there.empty() ? "" : ", ") + key;
      }
      return fail("{} printed no '{}', which is to be the figure {}; it printed: {}", step.name,
                  value.pointer, value.name, there);
    }
    const nlohmann::json& found = printed.at(pointer);
    if (found.is_structured()) {
      return fail("'{}' of {} is no figure", value.pointer, step.name);
    }
    result.values[value.name] = found.is_null()     ? ""
                                : found.is_string() ? found.get<std::string>()
                                                    : found.dump();
  }
  return {};
}

Expected<void> run_steps(const StudyStore& store, const StudyTask& task, const RunProgram& program,
                         TaskResult& result) {
  std::map<std::string, fs::path> folders = store.sources();
  for (const StudyStep& step : store.study().steps) {
    folders[step.name] = store.task_folder(task.id) / "work" / step.name;
  }
  for (const StudyStep& step : store.study().steps) {
    ROOMWISE_TRY(const auto printed, result_of(store, task, step, folders, program));
    ROOMWISE_RETURN_IF_ERROR(take_values(store.study(), step, printed, result));
  }
  return {};
}

}  // namespace

std::string processor_in(const std::string& cpuinfo) {
  std::map<std::string, std::string> values;  // of the first processor that has one
  std::istringstream lines(cpuinfo);
  const auto trimmed = [](const std::string& text) {
    const std::size_t begin = text.find_first_not_of(" \t");
    if (begin == std::string::npos) return std::string();
    return text.substr(begin, text.find_last_not_of(" \t") + 1 - begin);
  };
  for (std::string line; std::getline(lines, line);) {
    const std::size_t colon = line.find(':');
    if (colon == std::string::npos) continue;
    values.try_emplace(trimmed(line.substr(0, colon)), trimmed(line.substr(colon + 1)));
  }
  for (const char* name : {"model name", "Model", "Hardware"}) {
    if (!values[name].empty()) return values[name];
  }
  if (values["CPU part"].empty()) return {};
  return fmt::format("ARM implementer {}, part {}", values["CPU implementer"], values["CPU part"]);
}

std::string machine_name() {
  std::array<char, 256> name{};
  (void)::gethostname(name.data(), name.size() - 1);
  const char* const node = std::getenv("SLURMD_NODENAME");
  const std::string computer = node != nullptr ? node : name.data();
  const auto cpuinfo = read_text_file("/proc/cpuinfo");
  const std::string processor = cpuinfo ? processor_in(*cpuinfo) : "";
  return processor.empty() ? computer : fmt::format("{} ({})", computer, processor);
}

Expected<bool> run_task(const StudyStore& store, const StudyTask& task, const RunProgram& program) {
  const fs::path folder = store.task_folder(task.id);
  // Beside the folder, which goes; empty, and kept, so that no two processes lock different files.
  ROOMWISE_TRY(const auto lock, TaskLock::try_lock(folder.string() + ".lock"));
  if (lock == nullptr) return false;
  ROOMWISE_TRY(const auto done, store.find(task.id));
  if (done) return true;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail("{}: cannot be made: {}", folder.string(), error.message());
  const auto began = std::chrono::steady_clock::now();
  TaskResult result;
  result.id = task.id;
  result.factors = task.factors;
  result.version = store.version();
  result.machine = machine_name();
  ROOMWISE_TRY(result.attempts, note_attempt(folder / "attempts"));
  const Expected<void> ran = run_steps(store, task, program, result);
  const bool is_its_own = ran || ran.error().code == ErrorCode::kFailed;
  if (!is_its_own) return Unexpected(ran.error());
  result.is_good = ran.has_value();
  if (!ran) result.why = ran.error().message;
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  ROOMWISE_RETURN_IF_ERROR(store.put(result));
  // What a failed task left tells why.
  if (result.is_good) fs::remove_all(folder, error);
  return true;
}

Expected<StudyCount> count_of(const StudyStore& store) {
  StudyCount count;
  count.tasks = store.tasks().size();
  ROOMWISE_TRY(const auto results, store.results());
  for (const TaskResult& result : results) ++(result.is_good ? count.done : count.failed);
  count.open = count.tasks - results.size();
  return count;
}

Expected<StudyCount> run_here(const StudyStore& store, std::size_t workers,
                              const RunProgram& program, Progress& progress) {
  ROOMWISE_TRY(const std::vector<StudyTask> open, store.open_tasks());
  std::atomic<std::size_t> next = 0;
  std::atomic<bool> stop = false;
  std::mutex mutex;  // of what follows, and of the progress
  std::size_t ended = 0;
  std::optional<Error> trouble;
  progress.begin("study " + store.study().name, open.size());
  const auto work = [&] {
    for (std::size_t i = next++; i < open.size() && !stop; i = next++) {
      const auto ran = run_task(store, open[i], program);
      const std::scoped_lock lock(mutex);
      if (!ran) {
        stop = true;
        if (!trouble) trouble = ran.error();
        return;
      }
      progress.advance(++ended, open[i].title());
    }
  };
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < std::min(workers, open.size()); ++i) threads.emplace_back(work);
  for (std::thread& thread : threads) thread.join();
  progress.end();
  const Expected<void> written = store.write_tables();
  if (trouble) return Unexpected(*trouble);
  ROOMWISE_RETURN_IF_ERROR(written);
  return count_of(store);
}

}  // namespace roomwise::studies
