#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "laboratory/studies/study_file.h"
#include "roomwise/base/expected.h"

namespace roomwise::studies {

// What came of a task. There is one for each task or none: it is written whole, once.
struct TaskResult {
  std::string id;
  std::map<std::string, std::string> factors;
  bool is_good = false;
  std::string why;                            // it failed
  std::map<std::string, std::string> values;  // as JSON has them: numbers with all their digits
  std::string version;                        // of the programs
  std::string machine;  // machine_name(): of older studies without its processor
  int attempts = 0;
  double seconds = 0;  // of the last attempt
};

// The folder of a study: its file (study.toml), where that lay and where its recordings lie
// (study.json), a result a task (results/ID.json), and what tasks work with (tasks/ID/, gone when a
// task is done).
class StudyStore {
 public:
  // Makes the folder where there is none, and writes down the study. Fails where it holds a study
  // of another name, or results of what lies in another folder: {data} or {study} of its commands.
  [[nodiscard]] static Expected<StudyStore> create(const std::filesystem::path& folder,
                                                   const std::filesystem::path& study_file,
                                                   const std::filesystem::path& data,
                                                   const std::string& version);
  [[nodiscard]] static Expected<StudyStore> open(const std::filesystem::path& folder);

  [[nodiscard]] const Study& study() const { return study_; }
  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }
  // What {data} and {study} stand for: the recordings, and what lies beside the study's file.
  [[nodiscard]] const std::map<std::string, std::filesystem::path>& sources() const {
    return sources_;
  }
  [[nodiscard]] const std::string& version() const { return version_; }
  [[nodiscard]] std::vector<StudyTask> tasks() const { return tasks_of(study_, version_); }
  [[nodiscard]] std::filesystem::path task_folder(const std::string& id) const {
    return folder_ / "tasks" / id;
  }

  [[nodiscard]] Expected<void> put(const TaskResult& result) const;
  // Nothing where the task is not done. Fails where what lies there cannot be read.
  [[nodiscard]] Expected<std::optional<TaskResult>> find(const std::string& id) const;
  [[nodiscard]] Expected<void> forget(const std::string& id) const;
  [[nodiscard]] Expected<void> forget_failed() const;
  // Of the study's tasks, in their order; those that are not done are left out.
  [[nodiscard]] Expected<std::vector<TaskResult>> results() const;
  [[nodiscard]] Expected<std::vector<StudyTask>> open_tasks() const;

  // Writes results.csv and results.sqlite (table "results", a row a task) anew.
  [[nodiscard]] Expected<void> write_tables() const;

 private:
  std::filesystem::path folder_;
  Study study_;
  std::map<std::string, std::filesystem::path> sources_;
  std::string version_;
};

}  // namespace roomwise::studies
