#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "laboratory/studies/child_process.h"
#include "roomwise/base/expected.h"

// A study: commands of Roomwise's programs, carried out for every combination of some factors
// (homes, seeds, options), and which of the figures that they print make its table. Written by
// people as a TOML file, which docs/experiments/studies.md explains.
namespace roomwise::studies {

struct StudyFactor {
  std::string name;
  std::vector<std::string> values;  // as they stand in commands
};

struct StudyStep {
  std::string name;
  std::string program;  // "roomwise" or "roomwise-lab"
  Words words;          // with placeholders: {FACTOR}, {data}, {study}, and {STEP}, a step's folder
};

// A figure of what a step prints.
struct StudyValue {
  std::string name;
  std::string step;
  std::string pointer;  // "/ate/rmse_m": JSON Pointer (RFC 6901)
};

struct Study {
  std::string name;
  std::string about;  // what its table shows; printed above it
  int threads = 1;    // of each command
  int minutes = 0;    // that a task may take under Slurm; 0: no limit
  std::vector<StudyFactor> factors;
  std::vector<StudyStep> steps;
  std::vector<StudyValue> values;
  std::vector<std::string> groups;  // factors by which its table has rows; the others are taken
                                    // together
  bool are_columns = false;         // it has columns by them, and a row for each figure
  int digits = 9;                   // significant ones, of the figures in its table
};

// Fails on keys that are not known, naming the nearest that is, on placeholders and figures that
// name nothing, and on values of a factor that stand there twice.
[[nodiscard]] Expected<Study> parse_study(const std::string& toml, const std::string& file_name);
[[nodiscard]] Expected<Study> read_study(const std::filesystem::path& file);

// One combination of factors.
struct StudyTask {
  std::string id;  // of what it is made of: 16 hexadecimal digits
  std::map<std::string, std::string> factors;

  [[nodiscard]] std::string title() const;  // "recording=walk seed=3"
};

// All of them, in the order of the file. `version`: of the programs; with another the same
// combination is another task.
[[nodiscard]] std::vector<StudyTask> tasks_of(const Study& study, const std::string& version);

// The words of a step of a task. `folders`: what {data}, {study} and the steps' names stand for.
[[nodiscard]] Words words_of(const StudyStep& step, const StudyTask& task,
                             const std::map<std::string, std::filesystem::path>& folders);

}  // namespace roomwise::studies
