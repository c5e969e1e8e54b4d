#include "laboratory/studies/study_file.h"

#include <gmock/gmock.h>

#include <set>

#include "roomwise/base/testing/testing.h"

namespace roomwise::studies {
namespace {

using ::testing::ElementsAre;

const std::string kHead = "[study]\nname = \"maps\"\nthreads = 2\nminutes = 30\n";
const std::string kFactors = "[factors]\nrecording = [\"walk\", \"other\"]\nseed = [1, 2, 3]\n";
const std::string kSteps = R"([[steps]]
name = "map"
run = ["roomwise", "map", "{data}/{recording}", "--home", "{map}/a.home", "--seed", "{seed}"]
[[steps]]
name = "ate"
run = ["roomwise", "eval", "trajectory", "--estimate", "{map}/path.txt"]
)";
const std::string kValues = "[values]\nate_m = \"ate/ate/rmse_m\"\nplaced = \"map/placed\"\n";
const std::string kTable = "[table]\nrows = [\"recording\"]\n";

Expected<Study> parsed(const std::string& text) {
  return parse_study(text, "s.toml");
}

TEST(StudyFile, SaysWhatIsDoneForEveryCombinationAndWhatIsTakenOfIt) {
  const auto study = parsed(kHead + kFactors + kSteps + kValues + kTable);
  ASSERT_OK(study);
  EXPECT_EQ(study->name, "maps");
  EXPECT_EQ(study->threads, 2);
  EXPECT_EQ(study->minutes, 30);
  EXPECT_EQ(study->values[0].step, "ate");
  EXPECT_EQ(study->values[0].pointer, "/ate/rmse_m");
  EXPECT_THAT(study->groups, ElementsAre("recording"));
  const auto tasks = tasks_of(*study, "1");
  ASSERT_EQ(tasks.size(), 6u);
  EXPECT_EQ(tasks[0].title(), "recording=walk seed=1");
  EXPECT_EQ(tasks[4].title(), "recording=other seed=2");
  EXPECT_THAT(words_of(study->steps[0], tasks[4], {{"data", "/data"}, {"map", "/t/map"}}),
              ElementsAre("map", "/data/other", "--home", "/t/map/a.home", "--seed", "2"));
}

TEST(StudyFile, ATableHasRowsOrColumnsByFactorsOrAllTasksTogether) {
  const std::string head = kHead + kFactors + kSteps + kValues;
  const auto columns = parsed(head + "[table]\ncolumns = [\"recording\"]\ndigits = 3\n");
  ASSERT_OK(columns);
  EXPECT_TRUE(columns->are_columns);
  EXPECT_THAT(columns->groups, ElementsAre("recording"));
  EXPECT_EQ(columns->digits, 3);
  const auto together = parsed(head + "[table]\nrows = []\n");
  ASSERT_OK(together);
  EXPECT_FALSE(together->are_columns);
  EXPECT_THAT(together->groups, ElementsAre());
  EXPECT_ERROR(parsed(head + kTable + "columns = [\"seed\"]\n"),
               "either 'rows' or 'columns': factors by which there are some");
  EXPECT_ERROR(parsed(head + kTable + "digits = 10\n"),
               "'digits' must be a whole number from 1 to 9");
}

TEST(StudyFile, TheStudiesOfTheBenchmarksCanBeRead) {
  std::set<std::string> names;
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(ROOMWISE_BENCHMARKS)) {
    ++files;
    const auto study = read_study(entry.path());
    ASSERT_OK(study);
    EXPECT_EQ(study->name, entry.path().stem()) << "its table is found by the file's name";
    EXPECT_FALSE(study->about.empty()) << entry.path();
    names.insert(study->name);
  }
  EXPECT_GT(files, 0u);
  EXPECT_EQ(names.size(), files);
}

TEST(StudyFile, ATaskIsKnownByWhatItIsMadeOf) {
  const auto study = parsed(kHead + kFactors + kSteps + kValues).value();
  std::set<std::string> ids;
  for (const char* version : {"1", "2"}) {
    for (const StudyTask& task : tasks_of(study, version)) ids.insert(task.id);
  }
  EXPECT_EQ(ids.size(), 12u);
  // One more seed leaves the others what they are.
  Study more = study;
  more.factors[1].values.emplace_back("4");
  for (const StudyTask& task : tasks_of(more, "1")) ids.insert(task.id);
  EXPECT_EQ(ids.size(), 14u);
}

TEST(StudyFile, AnUnknownKeyIsNamedWithTheNearestRightOne) {
  EXPECT_ERROR(parsed(kHead + "thread = 2\n" + kFactors + kSteps + kValues),
               "s.toml:5: 'thread' is no key here; the nearest is 'threads'");
  EXPECT_ERROR(parsed(kHead + kFactors + kSteps + kValues + "[tabel]\nrows = [\"seed\"]\n"),
               "the nearest is 'table'");
  EXPECT_ERROR(parsed(kHead + kFactors + "[[steps]]\nname = \"map\"\nrnu = [\"roomwise\"]\n"),
               "the nearest is 'run'");
  EXPECT_ERROR(parsed(kHead + kFactors + kSteps + kValues + "[table]\nrows = [\"recordin\"]\n"),
               "there is no factor 'recordin'; the nearest is 'recording'");
  EXPECT_ERROR(parsed(kHead + kFactors + kSteps + "[values]\na = \"mpa/placed\"\n"),
               "there is no step 'mpa'; the nearest is 'map'");
  EXPECT_ERROR(parsed(kHead + "[factors]\nsede = [1]\n" + kSteps + kValues), "{recording} stands");
}

TEST(StudyFile, TasksThatWouldBeCountedTwiceAreRefused) {
  EXPECT_ERROR(parsed(kHead + "[factors]\nrecording = [\"walk\"]\nseed = [1, 2, 1]\n" + kSteps),
               "s.toml:7: 'seed' has '1' twice");
  EXPECT_ERROR(parsed(kHead + "[factors]\nseed = [1]\nseed = [2]\n"), "s.toml:7");
}

TEST(StudyFile, WhatIsMissingOrWrongIsSaid) {
  EXPECT_ERROR(parsed(kFactors), "the table [study] is missing");
  EXPECT_ERROR(parsed("[study]\nname = \"a b\"\n"), "'a b' is no name");
  EXPECT_ERROR(parsed(kHead + "[factors]\n"), "there is no factor; a seed is one");
  EXPECT_ERROR(parsed(kHead + "[factors]\nseed = []\n"), "a list that is not empty");
  EXPECT_ERROR(parsed(kHead + kFactors), "there is no step");
  EXPECT_ERROR(parsed(kHead + kFactors + "[[steps]]\nname = \"a\"\nrun = [\"rm\", \"-r\"]\n"),
               "a step runs");
  EXPECT_ERROR(parsed(kHead + kFactors + kSteps + "[values]\na = \"placed\"\n"),
               "must be a step and a place");
  EXPECT_ERROR(parsed("[study\n"), "s.toml:1: ");
}

}  // namespace
}  // namespace roomwise::studies
