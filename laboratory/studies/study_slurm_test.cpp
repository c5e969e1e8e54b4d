#include "laboratory/studies/study_slurm.h"

#include <gmock/gmock.h>

#include <cstdlib>

#include "laboratory/studies/study_run.h"
#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::studies {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Stand-ins for sbatch and squeue, found by PATH: the first counts jobs and keeps the script, the
// second shows the file "queue".
class StudySlurm : public ::testing::Test {
 protected:
  StudySlurm() {
    put_program("sbatch",
                "n=$(($(cat count 2>/dev/null || echo 6) + 1))\necho $n > count\n"
                "cp \"$2\" job-$n.sh\necho \"$n;cluster\"\n");
    put_program("squeue", "cat queue 2>/dev/null || true\n");
    const std::string path = std::getenv("PATH");
    ::setenv("PATH", (folder_.path().string() + ":" + path).c_str(), 1);
    path_ = path;
    write_study(3);
  }
  ~StudySlurm() override { ::setenv("PATH", path_.c_str(), 1); }
  void put_program(const std::string& name, const std::string& body) {
    const fs::path file = folder_ / name;
    EXPECT_OK(write_file(file, "#!/bin/sh\nset -e\ncd '" + folder_.path().string() + "'\n" + body));
    fs::permissions(file, fs::perms::owner_all);
  }
  void write_study(int seeds) {
    std::string list = "0";
    for (int i = 1; i < seeds; ++i) list += fmt::format(", {}", i);
    EXPECT_OK(write_file(folder_ / "s.toml",
                         "[study]\nname = \"sums\"\nthreads = 2\nminutes = 9\n[factors]\nseed = [" +
                             list +
                             "]\n[[steps]]\nname = \"map\"\nrun = [\"roomwise\", \"map\"]\n"
                             "[values]\nplaced = \"map/placed\"\n"));
  }
  [[nodiscard]] StudyStore store() const {
    return StudyStore::create(folder_ / "it's out", folder_ / "s.toml", "", "1").value();
  }
  static Expected<std::string> done(const ProgramRun&) { return R"({"placed": 7})"; }

  ::roomwise::testing::ScratchFolder folder_;
  std::string path_;
  SilentProgress progress_;
  SlurmOptions options_{"/opt/roomwise-lab", {"--partition=long"}, 0.01};
};

TEST_F(StudySlurm, HandsOpenTasksOverAsAnArrayThatIsQueuedAgain) {
  const StudyStore made = store();
  ASSERT_OK(run_task(made, made.tasks()[1], done));
  const auto jobs = submit(made, options_, progress_);
  ASSERT_OK(jobs);
  EXPECT_THAT(*jobs, ElementsAre("7"));
  const std::string script = read_text_file(folder_ / "job-7.sh").value();
  for (const char* line :
       {"#SBATCH --job-name=sums\n", "#SBATCH --array=0-1\n", "#SBATCH --requeue\n",
        "#SBATCH --cpus-per-task=2\n", "#SBATCH --time=9\n", "#SBATCH --partition=long\n",
        "it'\\''s out' --list array-1 --index \"$SLURM_ARRAY_TASK_ID\"\n"}) {
    EXPECT_THAT(script, HasSubstr(line));
  }
  EXPECT_EQ(task_in_list(made, "array-1", 0)->id, made.tasks()[0].id);
  EXPECT_EQ(task_in_list(made, "array-1", 1)->id, made.tasks()[2].id);
  EXPECT_ERROR(task_in_list(made, "array-1", 2), "has no task 2");
}

TEST_F(StudySlurm, DoesNotHandOverWhatIsInTheQueueStill) {
  const StudyStore made = store();
  ASSERT_OK(submit(made, options_, progress_));
  ASSERT_OK(write_file(folder_ / "queue", std::string_view("8 7\n9 12\n")));
  EXPECT_ERROR(submit(made, options_, progress_), "its job 7 is in Slurm's queue still");
  ASSERT_OK(write_file(folder_ / "queue", std::string_view("9 12\n")));
  EXPECT_THAT(submit(made, options_, progress_).value(), ElementsAre("8"));
}

TEST_F(StudySlurm, WhatFailedIsForgottenOnlyWhereItIsHandedOverAgain) {
  const StudyStore made = store();
  ASSERT_OK(submit(made, options_, progress_));
  const auto fails = [](const ProgramRun&) -> Expected<std::string> { return fail("no"); };
  ASSERT_OK(run_task(made, made.tasks()[0], fails));
  ASSERT_OK(write_file(folder_ / "queue", std::string_view("8 7\n")));
  EXPECT_THAT(jobs_in_queue(made, progress_).value(), ElementsAre("7"));
  options_.retry = true;
  EXPECT_ERROR(submit(made, options_, progress_), "in Slurm's queue still");
  EXPECT_EQ(count_of(made)->failed, 1U);
  fs::remove(folder_ / "queue");
  EXPECT_THAT(submit(made, options_, progress_).value(), ElementsAre("8"));
  EXPECT_EQ(count_of(made)->failed, 0U);
}

TEST_F(StudySlurm, IsHandedOverInArraysOfAThousand) {
  write_study(2001);
  const auto jobs = submit(store(), options_, progress_);
  ASSERT_OK(jobs);
  EXPECT_THAT(*jobs, ElementsAre("7", "8", "9"));
  EXPECT_THAT(read_text_file(folder_ / "job-9.sh").value(), HasSubstr("--array=0-0\n"));
}

TEST_F(StudySlurm, NothingIsHandedOverWhereAllIsDone) {
  const StudyStore made = store();
  ASSERT_OK(run_here(made, 1, done, progress_));
  EXPECT_THAT(submit(made, options_, progress_).value(), IsEmpty());
  EXPECT_OK(wait_for_jobs(made, options_, progress_));
}

TEST_F(StudySlurm, AControllerThatAnswersNothingForAWhileIsWaitedFor) {
  const StudyStore made = store();
  ASSERT_OK(submit(made, options_, progress_));
  put_program("squeue", "[ -e back ] && exit\ntouch back\nexit 1\n");
  EXPECT_OK(wait_for_jobs(made, options_, progress_));
  put_program("squeue", "echo 'cannot contact it' >&2\nexit 1\n");
  options_.look_every_s = 0;
  EXPECT_ERROR(wait_for_jobs(made, options_, progress_), "cannot contact it");
}

TEST_F(StudySlurm, WithoutSlurmItSaysSo) {
  put_program("sbatch", "echo 'sbatch: error: no controller' >&2\nexit 1\n");
  EXPECT_ERROR(submit(store(), options_, progress_), "no controller; is Slurm installed");
}

}  // namespace
}  // namespace roomwise::studies
