#include "laboratory/studies/study_slurm.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <sstream>
#include <thread>

#include "laboratory/studies/child_process.h"
#include "laboratory/studies/study_run.h"
#include "roomwise/base/file.h"

namespace roomwise::studies {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxElements = 1000;
// A controller that is started anew answers nothing for a while, and the jobs go on.
constexpr int kMaxUnanswered = 60;

std::string quoted(const std::string& word) {
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    if (!line.empty()) lines.push_back(line);
  }
  return lines;
}

std::string script_of(const StudyStore& store, const std::string& list, std::size_t elements,
                      const SlurmOptions& options) {
  const Study& study = store.study();
  const fs::path folder = store.folder() / "slurm";
  std::string text = fmt::format(
      "#!/bin/sh\n"
      "#SBATCH --job-name={}\n"
      "#SBATCH --array=0-{}\n"
      "#SBATCH --cpus-per-task={}\n"
      "#SBATCH --requeue\n"
      "#SBATCH --open-mode=append\n"
      "#SBATCH --output={}\n",
      study.name, elements - 1, study.threads, (folder / "%A_%a.log").string());
  if (study.minutes > 0) text += fmt::format("#SBATCH --time={}\n", study.minutes);
  for (const std::string& option : options.options) text += "#SBATCH " + option + "\n";
  return text + fmt::format("exec {} study-task {} --list {} --index \"$SLURM_ARRAY_TASK_ID\"\n",
                            quoted(options.program), quoted(store.folder().string()), list);
}

Expected<std::string> output_of(const Words& words, const fs::path& log,
                                const Interruption& interruption) {
  ROOMWISE_TRY(ChildEnd end, run_child({words, log, {}}, interruption));
  if (end.is_good()) return std::move(end.printed);
  const std::string why = last_line_of(log);
  return fail("{} failed{}{}; is Slurm installed, and does its controller run?", words.front(),
              why.empty() ? "" : ": ", why);
}

fs::path jobs_file(const StudyStore& store) {
  return store.folder() / "slurm" / "jobs";
}

Expected<std::vector<std::string>> jobs_of(const StudyStore& store) {
  if (!fs::exists(jobs_file(store))) return std::vector<std::string>{};
  ROOMWISE_TRY(const std::string text, read_text_file(jobs_file(store)));
  return lines_of(text);
}

}  // namespace

// Slurm knows a job that ended for some minutes more, and then not at all, which it says by
// failing: a controller that is not there is told from that by a question that always has an
// answer.
Expected<std::vector<std::string>> jobs_in_queue(const StudyStore& store,
                                                 const Interruption& interruption) {
  ROOMWISE_TRY(const auto jobs, jobs_of(store));
  if (jobs.empty()) return jobs;
  ROOMWISE_TRY(const std::string queue,
               output_of({"squeue", "--noheader", "--array-unique", "--format=%A %F"},
                         store.folder() / "slurm" / "squeue.log", interruption));
  std::vector<std::string> there;
  for (const std::string& job : jobs) {
    for (const std::string& line : lines_of(queue)) {
      std::istringstream words(line);
      std::string element, array;
      words >> element >> array;
      if (element != job && array != job) continue;
      there.push_back(job);
      break;
    }
  }
  return there;
}

Expected<std::vector<std::string>> submit(const StudyStore& store, const SlurmOptions& options,
                                          const Interruption& interruption) {
  ROOMWISE_TRY(const auto waiting, jobs_in_queue(store, interruption));
  if (!waiting.empty()) {
    return fail(
        "{}: its job {} is in Slurm's queue still; wait for it by --wait, or end it: scancel {}",
        store.folder().string(), fmt::join(waiting, ", "), fmt::join(waiting, " "));
  }
  // Not before: a job in the queue would do them once more.
  if (options.retry) ROOMWISE_RETURN_IF_ERROR(store.forget_failed());
  ROOMWISE_TRY(const std::vector<StudyTask> open, store.open_tasks());
  const fs::path folder = store.folder() / "slurm";
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail("{}: cannot be made: {}", folder.string(), error.message());
  ROOMWISE_TRY(const auto before, jobs_of(store));
  std::vector<std::string> jobs;
  for (std::size_t first = 0; first < open.size(); first += kMaxElements) {
    const std::size_t count = std::min(kMaxElements, open.size() - first);
    const std::string name = fmt::format("array-{}", before.size() + jobs.size() + 1);
    std::string list;
    for (std::size_t i = 0; i < count; ++i) list += open[first + i].id + "\n";
    const fs::path script = folder / (name + ".sh");
    ROOMWISE_RETURN_IF_ERROR(write_file(folder / (name + ".tasks"), list));
    ROOMWISE_RETURN_IF_ERROR(write_file(script, script_of(store, name, count, options)));
    ROOMWISE_TRY(const std::string printed, output_of({"sbatch", "--parsable", script.string()},
                                                      folder / "sbatch.log", interruption));
    // "123", or "123;cluster"
    const std::string job = printed.substr(0, printed.find_first_of(";\n "));
    if (job.empty()) return fail("sbatch gave no number of a job");
    jobs.push_back(job);
    std::string all;
    for (const auto& numbers : {before, jobs}) {
      for (const std::string& one : numbers) all += one + "\n";
    }
    ROOMWISE_RETURN_IF_ERROR(write_file(jobs_file(store), all));
  }
  return jobs;
}

Expected<void> wait_for_jobs(const StudyStore& store, const SlurmOptions& options,
                             Progress& progress) {
  const std::size_t all = store.tasks().size();
  progress.begin("study " + store.study().name + " under Slurm", all);
  for (int unanswered = 0;;) {
    const auto jobs = jobs_in_queue(store, progress);
    if (jobs) {
      unanswered = 0;
    } else if (jobs.error().code == ErrorCode::kInterrupted || ++unanswered > kMaxUnanswered) {
      return Unexpected(jobs.error());
    }
    ROOMWISE_TRY(const StudyCount count, count_of(store));
    progress.advance(count.done + count.failed,
                     jobs ? fmt::format("{} failed", count.failed) : jobs.error().message);
    if (jobs && jobs->empty()) break;
    const auto until =
        std::chrono::steady_clock::now() + std::chrono::duration<double>(options.look_every_s);
    while (std::chrono::steady_clock::now() < until) {
      ROOMWISE_RETURN_IF_ERROR(progress.check("waiting for Slurm; the jobs go on"));
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  }
  progress.end();
  return {};
}

Expected<StudyTask> task_in_list(const StudyStore& store, const std::string& list,
                                 std::size_t index) {
  const fs::path file = store.folder() / "slurm" / (list + ".tasks");
  ROOMWISE_TRY(const std::string text, read_text_file(file));
  const auto ids = lines_of(text);
  if (index >= ids.size()) return fail("{}: has no task {}", file.string(), index);
  const std::vector<StudyTask> tasks = store.tasks();
  const auto found = std::ranges::find(tasks, ids[index], &StudyTask::id);
  if (found == tasks.end()) {
    return fail("{}: its task {} is none of the study any more", file.string(), ids[index]);
  }
  return *found;
}

}  // namespace roomwise::studies
