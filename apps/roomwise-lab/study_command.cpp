#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <span>
#include <thread>

#include "commands.h"
#include "laboratory/studies/study_run.h"
#include "laboratory/studies/study_slurm.h"
#include "laboratory/studies/study_table.h"
#include "roomwise/base/file.h"
#include "this_program.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

// In a study's folder, of the programs and networks that it was begun with.
constexpr const char* kDigests = "digests.json";

struct StudyOptions {
  fs::path study;  // a file, or a folder of several
  fs::path output;
  fs::path table;
  fs::path data;
  std::size_t workers = std::max(1U, std::thread::hardware_concurrency());
  bool retry = false;
  bool slurm = false;
  bool wait = false;
  std::vector<std::string> sbatch;
  double look_every_s = 5;
};

struct StudyTaskOptions {
  fs::path folder;
  std::string list;
  std::size_t index = 0;
};

struct StudyTableOptions {
  std::vector<fs::path> folders;
  fs::path output;
};

Json to_json(const studies::StudyCount& count) {
  return {
      {"tasks", count.tasks}, {"done", count.done}, {"failed", count.failed}, {"open", count.open}};
}

Expected<std::string> table_in(const studies::StudyStore& store) {
  ROOMWISE_TRY(const auto results, store.results());
  return studies::table_of(store.study(), store.tasks(), results);
}

// A page of them, each under its study's name and the program that it is of.
Expected<std::string> tables_in(std::span<const studies::StudyStore> stores) {
  std::string page = "# Tables of studies\n";
  for (const studies::StudyStore& store : stores) {
    ROOMWISE_TRY(const std::string table, table_in(store));
    page +=
        fmt::format("\n## {}\n\nBy roomwise {}.\n\n{}", store.study().name, store.version(), table);
  }
  return page;
}

// By the names of their files.
Expected<std::vector<fs::path>> studies_in(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> files;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    if (at->path().extension() == ".toml") files.push_back(at->path());
  }
  if (error) return fail("{}: cannot be read: {}", folder.string(), error.message());
  if (files.empty()) return fail("{}: holds no study (.toml)", folder.string());
  std::ranges::sort(files);
  return files;
}

// Of a file in the output folder itself; of a folder's each in one of its own.
Expected<std::vector<studies::StudyStore>> open_studies(const StudyOptions& options,
                                                        const std::string& version) {
  std::vector<studies::StudyStore> stores;
  if (!fs::is_directory(options.study)) {
    ROOMWISE_TRY(stores.emplace_back(),
                 studies::StudyStore::create(options.output, options.study, options.data, version));
    return stores;
  }
  ROOMWISE_TRY(const auto files, studies_in(options.study));
  for (const fs::path& file : files)
    ROOMWISE_RETURN_IF_ERROR(studies::read_study(file));  // before any begins
  for (const fs::path& file : files) {
    ROOMWISE_TRY(stores.emplace_back(), studies::StudyStore::create(options.output / file.stem(),
                                                                    file, options.data, version));
  }
  return stores;
}

Expected<studies::StudyCount> run_under_slurm(const studies::StudyStore& store,
                                              const StudyOptions& options, Context& context,
                                              Answer& answer) {
  studies::SlurmOptions slurm;
  ROOMWISE_TRY(const fs::path program, this_program());
  slurm.program = program.string();
  slurm.options = options.sbatch;
  slurm.retry = options.retry;
  slurm.look_every_s = options.look_every_s;
  std::vector<std::string> waiting;
  if (options.wait) {
    ROOMWISE_TRY(waiting, studies::jobs_in_queue(store, context.progress));
  }
  if (waiting.empty()) {
    ROOMWISE_TRY(const auto jobs, studies::submit(store, slurm, context.progress));
    if (!jobs.empty())
      answer.text += fmt::format("handed to Slurm as job {}\n", fmt::join(jobs, ", "));
    for (const auto& job : jobs) answer.json["jobs"].push_back(job);
  }
  if (options.wait)
    ROOMWISE_RETURN_IF_ERROR(studies::wait_for_jobs(store, slurm, context.progress));
  ROOMWISE_RETURN_IF_ERROR(store.write_tables());
  return studies::count_of(store);
}

Expected<studies::StudyCount> run_one(const studies::StudyStore& store, const StudyOptions& options,
                                      Context& context, Answer& answer) {
  if (options.retry && !options.slurm) ROOMWISE_RETURN_IF_ERROR(store.forget_failed());
  auto count = options.slurm ? run_under_slurm(store, options, context, answer)
                             : studies::run_here(store, options.workers,
                                                 studies::roomwise_beside(context.progress),
                                                 context.progress);
  if (count || count.error().code != ErrorCode::kInterrupted) return count;
  return fail_with(ErrorCode::kInterrupted, "{}; the same command goes on from there",
                   count.error().message);
}

Expected<Answer> run_study(const StudyOptions& options, Context& context) {
  studies::KnownDigests of_programs;
  ROOMWISE_TRY(const std::string version, version_of_programs(of_programs));
  ROOMWISE_TRY(const auto stores, open_studies(options, version));
  for (const studies::StudyStore& store : stores)
    ROOMWISE_RETURN_IF_ERROR(of_programs.write(store.folder() / kDigests));
  Answer answer;
  std::vector<std::string> names;
  studies::StudyCount all;
  for (const studies::StudyStore& store : stores) {
    ROOMWISE_TRY(const studies::StudyCount count, run_one(store, options, context, answer));
    names.push_back(store.study().name);
    all.tasks += count.tasks;
    all.done += count.done;
    all.failed += count.failed;
    all.open += count.open;
  }
  answer.json["study"] = fmt::format("{}", fmt::join(names, ", "));
  answer.json["version"] = version;
  answer.json.update(to_json(all));
  ROOMWISE_TRY(const std::string page, tables_in(stores));
  if (!options.table.empty()) ROOMWISE_RETURN_IF_ERROR(write_file(options.table, page));
  answer.text += page + fmt::format("\n{} tasks: {} done, {} failed, {} open; in {}\n", all.tasks,
                                    all.done, all.failed, all.open, options.output.string());
  // What was handed to Slurm, and is not waited for, is open.
  const bool may_be_open = options.slurm && !options.wait;
  answer.is_good = all.failed == 0 && (all.open == 0 || may_be_open);
  return answer;
}

Expected<Answer> run_study_task(const StudyTaskOptions& options, Context& context) {
  ROOMWISE_TRY(const auto store, studies::StudyStore::open(options.folder));
  auto of_programs = studies::KnownDigests::read(store.folder() / kDigests);
  ROOMWISE_TRY(const std::string version, version_of_programs(of_programs));
  if (version != store.version()) {
    return fail("{}: was begun with {}, and this is {}", options.folder.string(), store.version(),
                version);
  }
  ROOMWISE_TRY(const auto task, studies::task_in_list(store, options.list, options.index));
  ROOMWISE_TRY(const bool ended,
               studies::run_task(store, task, studies::roomwise_beside(context.progress)));
  return Answer{fmt::format("{}: {}\n", task.title(), ended ? "ended" : "another is at it"),
                {{"task", task.id}, {"ended", ended}}};
}

Expected<Answer> run_study_table(const StudyTableOptions& options, Context&) {
  Answer answer;
  answer.json["studies"] = Json::array();
  std::vector<studies::StudyStore> stores;
  for (const fs::path& folder : options.folders) {
    ROOMWISE_TRY(stores.emplace_back(), studies::StudyStore::open(folder));
    const studies::StudyStore& store = stores.back();
    ROOMWISE_RETURN_IF_ERROR(store.write_tables());
    ROOMWISE_TRY(const studies::StudyCount count, studies::count_of(store));
    Json json = to_json(count);
    json["study"] = store.study().name;
    json["version"] = store.version();
    answer.json["studies"].push_back(json);
  }
  ROOMWISE_TRY(answer.text, tables_in(stores));
  if (!options.output.empty()) {
    ROOMWISE_RETURN_IF_ERROR(write_file(options.output, answer.text));
    answer.text = fmt::format("wrote {}\n", options.output.string());
  }
  return answer;
}

}  // namespace

void add_study_commands(CLI::App& app, Context& context) {
  const auto [study, options] = add_command<StudyOptions>(
      app, context, "study",
      "Carry out commands for every combination of homes, seeds and options, on this machine or "
      "under Slurm, and make a table of it",
      "roomwise-lab study mapping.toml -o mapping --data recordings\n"
      "roomwise-lab study laboratory/benchmarks -o measured --data recordings --table measured.md\n"
      "After Ctrl-C, or a crash, the same command goes on. docs/experiments/studies.md says what "
      "the file holds.",
      run_study);
  study
      ->add_option("STUDY", options.study,
                   "The study's file (.toml), or a folder: all that are in it, one after the other")
      ->required();
  study
      ->add_option(
          "-o,--output", options.output,
          "Folder of the study: results.csv, results.sqlite, and what is kept. Under Slurm "
          "all nodes must see it under this name")
      ->required();
  study->add_option("--table", options.table, "Also write the tables there (.md)");
  study->add_option("--data", options.data, "What {data} in its commands stands for")
      ->envname("ROOMWISE_DATA");
  add_setting(*study, "--workers", options.workers, "Tasks at once on this machine", positive());
  study->add_flag("--retry", options.retry, "Do the tasks that failed once more");
  auto* slurm = study->add_flag("--slurm", options.slurm,
                                "Hand the tasks to Slurm (sbatch, squeue) as a job array");
  study->add_flag("--wait", options.wait, "Wait until Slurm has done them")->needs(slurm);
  study
      ->add_option("--sbatch", options.sbatch,
                   "An option for sbatch, such as --sbatch=--partition=long; any number")
      ->needs(slurm);
  add_setting(*study, "--look-every", options.look_every_s, "Seconds between looks at the queue");

  const auto [task, of_task] = add_command<StudyTaskOptions>(
      app, context, "study-task", "Carry out one task of a study: what Slurm runs",
      "roomwise-lab study-task mapping --list array-1 --index 0", run_study_task);
  task->add_option("FOLDER", of_task.folder, "Folder of the study")->required();
  task->add_option("--list", of_task.list, "List of tasks")->required();
  task->add_option("--index", of_task.index, "Which of the list, from 0 on")->required();

  const auto [table, of_table] = add_command<StudyTableOptions>(
      app, context, "study-table", "Make tables of studies, of what is done so far",
      "roomwise-lab study-table mapping rooms -o tables.md", run_study_table);
  table->add_option("FOLDER", of_table.folders, "Folders of studies")->required();
  table->add_option("-o,--output", of_table.output,
                    "File to write (.md); default: standard output");
}

}  // namespace roomwise::app
