#include "laboratory/studies/study_run.h"

#include <gmock/gmock.h>
#include <sys/resource.h>

#include <csignal>
#include <mutex>
#include <set>

#include "laboratory/studies/study_table.h"
#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/home/database.h"

namespace roomwise::studies {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

constexpr const char* kStudy = R"([study]
name = "sums"
[factors]
home = ["a", "b"]
seed = [1, 2, 3]
[[steps]]
name = "map"
run = ["roomwise", "map", "{home}", "--seed", "{seed}"]
[[steps]]
name = "eval"
run = ["roomwise", "eval", "{map}", "--seed", "{seed}"]
[values]
error = "eval/error"
[table]
rows = ["home"]
)";

class StudyRun : public ::testing::Test {
 protected:
  StudyRun() { EXPECT_OK(write_file(folder_ / "s.toml", std::string_view(kStudy))); }
  [[nodiscard]] StudyStore store(const std::string& version = "1") const {
    return StudyStore::create(folder_ / "out", folder_ / "s.toml", "", version).value();
  }
  // Prints a figure that its words alone decide; counts its runs.
  RunProgram program() {
    return [this](const ProgramRun& run) -> Expected<std::string> {
      const std::scoped_lock lock(mutex_);
      if (stop_after_ && runs_ >= *stop_after_) {
        return fail_with(ErrorCode::kInterrupted, "interrupted");
      }
      ++runs_;
      if (run.words[0] == "map" && run.words[1] == fails_) return fail("the walk is damaged");
      return fmt::format(R"({{"error": {}.125}})", run.words.back());
    };
  }
  [[nodiscard]] static std::string table(const StudyStore& of) {
    return table_of(of.study(), of.tasks(), of.results().value());
  }

  void write_study(std::string text, const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
    EXPECT_OK(write_file(folder_ / "s.toml", text));
  }

  ::roomwise::testing::ScratchFolder folder_;
  SilentProgress progress_;
  std::mutex mutex_;
  int runs_ = 0;
  std::optional<int> stop_after_;
  std::string fails_;
};

TEST_F(StudyRun, ATableMayHaveItsFiguresAsRowsWithFewerDigits) {
  write_study(kStudy, "rows = [\"home\"]", "columns = [\"home\"]\ndigits = 2");
  EXPECT_OK(run_here(store(), 1, program(), progress_));
  EXPECT_EQ(table(store()),
            "| home | a | b |\n| --- | --- | --- |\n| tasks | 3 of 3 | 3 of 3 |\n"
            "| error | 2.1 (1.1 – 3.1) | 2.1 (1.1 – 3.1) |\n");
}

TEST_F(StudyRun, WhatLiesBesideTheStudysFileIsFoundFromIt) {
  write_study(kStudy, "\"{home}\"", "\"{study}/{home}.txt\"");
  const StudyStore made = store();
  std::string words;
  EXPECT_OK(
      run_task(made, made.tasks().front(), [&](const ProgramRun& run) -> Expected<std::string> {
        if (run.words[0] == "map") words = run.words[1];
        return std::string(R"({"error": 1})");
      }));
  EXPECT_EQ(words, (folder_ / "a.txt").string());
}

TEST_F(StudyRun, ResultsOfOtherDataAreNotTakenForThese) {
  write_study(kStudy, "\"{home}\"", "\"{data}/{home}\"");
  const auto create = [&](const std::string& data) {
    std::filesystem::create_directories(folder_ / data);
    return StudyStore::create(folder_ / "out", folder_ / "s.toml", folder_ / data, "1");
  };
  ASSERT_OK(create("walks"));
  EXPECT_OK(create("other")) << "there is no result yet";
  ASSERT_OK(run_here(create("walks").value(), 1, program(), progress_));
  EXPECT_OK(create("walks/"));
  EXPECT_ERROR(create("other"), "holds results of {data} in");
  EXPECT_EQ(create("walks")->results()->size(), 6u) << "and nothing was written";
  // What no command names is not of the results.
  write_study(kStudy, "\"sums\"", "\"sums\"");
  EXPECT_OK(create("other"));
}

TEST_F(StudyRun, WhatIsSaidAboutAStudyStandsAboveItsTable) {
  write_study(kStudy, "name = \"sums\"", "name = \"sums\"\nabout = \"Of two homes.\"");
  EXPECT_THAT(table(store()), StartsWith("Of two homes.\n\n| home |"));
}

TEST_F(StudyRun, DoesEachTaskOnceAndGivesTheSameTableWithAnyNumberOfWorkers) {
  const auto count = run_here(store(), 3, program(), progress_);
  ASSERT_OK(count);
  EXPECT_EQ(count->done, 6u);
  EXPECT_EQ(runs_, 12);
  const std::string made = table(store());
  EXPECT_THAT(made, HasSubstr("| home | tasks | error |\n"));
  EXPECT_THAT(made, HasSubstr("| a | 3 of 3 | 2.125 (1.125 – 3.125) |\n"));
  ASSERT_OK(run_here(store(), 1, program(), progress_));
  EXPECT_EQ(runs_, 12) << "what is done is not done again";
  EXPECT_EQ(table(store()), made);
  // With other programs all is done anew, and nothing of the two is mixed.
  ASSERT_OK(run_here(store("2"), 1, program(), progress_));
  EXPECT_EQ(runs_, 24);
  EXPECT_EQ(table(store("2")), made);
}

TEST_F(StudyRun, GoesOnAfterTheStepThatWasDone) {
  stop_after_ = 7;  // of the fourth task one step is done
  const auto stopped = run_here(store(), 1, program(), progress_);
  ASSERT_FALSE(stopped.has_value());
  EXPECT_EQ(stopped.error().code, ErrorCode::kInterrupted);
  EXPECT_EQ(count_of(store())->done, 3u);
  EXPECT_THAT(table(store()), HasSubstr("\n3 tasks are not done yet.\n"));
  stop_after_.reset();
  ASSERT_OK(run_here(store(), 1, program(), progress_));
  EXPECT_EQ(runs_, 12) << "no step is done twice";
  const auto results = store().results().value();
  EXPECT_EQ(results[3].attempts, 2);
  EXPECT_EQ(results[4].attempts, 1);
  EXPECT_THAT(table(store()), Not(HasSubstr("not done yet")));
}

TEST_F(StudyRun, ATaskThatFailsIsToldAndTheOthersGoOn) {
  fails_ = "b";
  const auto count = run_here(store(), 2, program(), progress_);
  ASSERT_OK(count);
  EXPECT_EQ(count->done, 3u);
  EXPECT_EQ(count->failed, 3u);
  EXPECT_THAT(table(store()), HasSubstr("| b | 0 of 3 | – |\n"));
  EXPECT_THAT(table(store()), HasSubstr("- home=b seed=2: the walk is damaged\n"));
  // Once more, where that is wished for.
  fails_ = "";
  const auto results = store().results().value();
  for (const TaskResult& result : results) {
    if (result.is_good) continue;
    ASSERT_OK(store().forget(result.id));
  }
  EXPECT_EQ(run_here(store(), 2, program(), progress_)->done, 6u);
}

TEST_F(StudyRun, AFigureThatFewerTasksHaveSaysOfHowMany) {
  const RunProgram program = [](const ProgramRun& run) -> Expected<std::string> {
    const std::string& seed = run.words.back();
    return fmt::format(R"({{"error": {}}})", seed == "2" ? "null" : seed);
  };
  EXPECT_EQ(run_here(store(), 1, program, progress_)->done, 6u);
  EXPECT_THAT(table(store()), HasSubstr("| a | 3 of 3 | 2 (1 – 3) (of 2) |\n"));
}

TEST_F(StudyRun, AFigureThatWasNotPrintedFailsTheTask) {
  const RunProgram silent = [](const ProgramRun&) -> Expected<std::string> { return "{}"; };
  EXPECT_EQ(run_here(store(), 1, silent, progress_)->failed, 6u);
  EXPECT_THAT(table(store()),
              HasSubstr("eval printed no '/error', which is to be the figure error"));
}

TEST_F(StudyRun, AFullDiskEndsItAndCountsNothing) {
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = ::signal(SIGXFSZ, SIG_IGN);
  const StudyStore made = store();
  ASSERT_OK(run_task(made, made.tasks()[0], program()));
  const rlimit full{10, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &full), 0);
  const auto count = run_here(made, 2, program(), progress_);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  ::signal(SIGXFSZ, handler);
  ASSERT_FALSE(count.has_value());
  EXPECT_EQ(count.error().code, ErrorCode::kDiskFull) << count.error().message;
  EXPECT_EQ(count_of(made)->open, 5u);
  EXPECT_EQ(run_here(made, 2, program(), progress_)->done, 6u);
}

TEST_F(StudyRun, WritesCsvAndSqlite) {
  fails_ = "b";
  ASSERT_OK(run_here(store("1 (ab)"), 1, program(), progress_));
  const std::string csv = read_text_file(folder_ / "out" / "results.csv").value();
  EXPECT_THAT(csv, HasSubstr("task,factor_home,factor_seed,state,value_error,why,version,machine,"
                             "attempts,seconds\r\n"));
  EXPECT_EQ(std::ranges::count(csv, '\n'), 7);
  EXPECT_THAT(csv, HasSubstr(",a,2,done,2.125,,1 (ab),"));
  const home::Database database =
      home::Database::open(folder_ / "out" / "results.sqlite", home::Database::Access::kReadOnly)
          .value();
  EXPECT_EQ(database.get<std::int64_t>("SELECT count(*) FROM results WHERE state = 'failed'"), 3);
  EXPECT_EQ(database.get<double>("SELECT avg(value_error) FROM results"), 2.125);
}

TEST(Processor, IsNamedAsLinuxNamesIt) {
  EXPECT_EQ(
      processor_in("processor\t: 0\nmodel\t\t: 17\nmodel name\t: AMD EPYC 9354 \n\nprocessor\t: 1\n"
                   "model name\t: another\n"),
      "AMD EPYC 9354");
  EXPECT_EQ(processor_in("processor\t: 0\nBogoMIPS\t: 108.00\nCPU implementer\t: 0x41\n"
                         "CPU part\t: 0xd08\n\nModel\t\t: Raspberry Pi 4 Model B Rev 1.1\n"),
            "Raspberry Pi 4 Model B Rev 1.1");
  EXPECT_EQ(processor_in("CPU implementer\t: 0x41\nCPU part\t: 0xd0c\n"),
            "ARM implementer 0x41, part 0xd0c");
  EXPECT_EQ(processor_in(""), "");
}

TEST_F(StudyRun, AResultTellsTheMachineWithItsProcessorAndTheVersion) {
  const StudyStore made = store("1 (ab)");
  ASSERT_OK(run_task(made, made.tasks()[0], program()));
  const TaskResult result = made.results().value().at(0);
  EXPECT_EQ(result.machine, machine_name());
  EXPECT_THAT(result.machine, HasSubstr(processor_in(read_text_file("/proc/cpuinfo").value())));
  EXPECT_EQ(result.version, "1 (ab)");
}

TEST_F(StudyRun, AResultOfBeforeThatTellsTheHostAloneIsRead) {
  const StudyStore made = store();
  TaskResult before;
  before.id = made.tasks()[0].id;
  before.factors = made.tasks()[0].factors;
  before.machine = "node1";
  ASSERT_OK(made.put(before));
  EXPECT_EQ(made.results().value().at(0).machine, "node1");
}

TEST_F(StudyRun, ADamagedResultIsToldAndNotDoneAgainByItself) {
  const StudyStore made = store();
  ASSERT_OK(run_here(made, 1, program(), progress_));
  const auto file = folder_ / "out" / "results" / (made.tasks()[0].id + ".json");
  ASSERT_OK(write_file(file, std::string_view("{\"task\": ")));
  EXPECT_ERROR(made.results(), "is damaged; remove it");
}

}  // namespace
}  // namespace roomwise::studies
