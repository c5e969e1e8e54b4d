// The product's program where the laboratory is installed beside it, and where it is not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "made_up_recording.h"
#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"
#include "run_program.h"

namespace roomwise {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::run_program;
using testing::run_roomwise;

TEST(LaboratoryProgram, SaysWhatToInstallWhereItIsNot) {
  const testing::ScratchFolder folder;
  const std::string alone = folder / "roomwise";
  std::filesystem::copy_file(ROOMWISE_PROGRAM, alone);
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"simulate", "-o", "flat"},
        {"eval", "objects", "--home", "a.home", "--truth", "flat"},
        {"train", "photos"}}) {
    const auto result = run_program(alone, command);
    EXPECT_EQ(result.exit_code, 1) << command.front();
    EXPECT_THAT(result.errors, AllOf(HasSubstr("is not there"), HasSubstr("ROOMWISE_LAB=ON")));
    EXPECT_EQ(result.output, "");
  }
  EXPECT_EQ(run_program(alone, {"eval", "trajectory", "--help"}).exit_code, 0);
}

#ifdef ROOMWISE_HAS_LABORATORY
TEST(LaboratoryProgram, IsStartedByTheNameOfItsCommands) {
  const auto help = run_roomwise({"simulate", "--help"});
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_THAT(help.output, HasSubstr("--walk-seed")) << "the laboratory's own help";
  const auto wrong = run_roomwise({"eval", "objects", "--truth", "flat"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_THAT(wrong.errors, HasSubstr("run 'roomwise eval objects --help'"));
}

class PaperCommandTest : public ::testing::Test {
 protected:
  const std::string laboratory_ =
      std::filesystem::path(ROOMWISE_PROGRAM).parent_path() / "roomwise-lab";
  const testing::ScratchFolder folder_;

  [[nodiscard]] testing::ProgramResult paper(const std::string& data) const {
    return run_program(laboratory_, {"paper", "--data", folder_ / data, "--only", "mapping", "-o",
                                     folder_ / "tables.html"});
  }
};

TEST_F(PaperCommandTest, MapsWhatIsThereAndNamesWhatIsNot) {
  ASSERT_OK(testing::write_made_up_recording(folder_ / "data/office_walk", 8));
  const auto first = paper("data");
  ASSERT_EQ(first.exit_code, 0) << first.errors;
  EXPECT_THAT(first.output, AllOf(HasSubstr("fr1/desk (rgbd_dataset_freiburg1_desk) is not in"),
                                  HasSubstr("cvg.cit.tum.de")));
  const std::string page = read_text_file(folder_ / "tables.html").value();
  EXPECT_THAT(page, HasSubstr("<th scope=\"row\">office_walk</th><td>measured here, real</td>"));
  EXPECT_THAT(page, HasSubstr("8 of 8"));
  ASSERT_EQ(paper("data").exit_code, 0);
  EXPECT_EQ(read_text_file(folder_ / "tables.html").value(), page)
      << "what was done is kept, with its times";
}

TEST_F(PaperCommandTest, SaysWhichRecordingIsBrokenAndMakesTheRest) {
  std::filesystem::create_directories(folder_ / "data/office_walk");
  const auto result = paper("data");
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, HasSubstr("office_walk, paper, surf: roomwise map: "));
}

// A study of how well made-up trajectories are measured, here and by stand-ins for sbatch and
// squeue that behave like them: sbatch carries out the elements of the array one after the other,
// but those of which the file "dead" holds the number, as where their node fails and nobody queues
// them again.
class StudyCommandTest : public ::testing::Test {
 protected:
  StudyCommandTest() {
    for (int i = 0; i < 4; ++i) {
      std::string path;
      for (int t = 0; t < 20; ++t) {
        path += fmt::format("{}.0 {} {} {} 0 0 0 1\n", t, 0.1 * t, 0.02 * (t * t % 7),
                            i * 0.01 * (t % 3));
      }
      EXPECT_OK(write_file(folder_ / fmt::format("walk-{}.txt", i), path));
    }
    write_study("[\"walk-1\", \"walk-2\", \"walk-3\"]");
    put_program("squeue", "exit 0\n");
    put_program("sbatch",
                "n=$(sed -n 's/^#SBATCH --array=0-//p' \"$2\")\n"
                "for i in $(seq 0 $n); do\n"
                "  grep -qx $i dead 2>/dev/null && continue\n"
                "  SLURM_ARRAY_TASK_ID=$i SLURMD_NODENAME=n$i sh \"$2\" >>log 2>&1\n"
                "done\necho 1\n");
    path_ = std::getenv("PATH");
    ::setenv("PATH", (folder_.path().string() + ":" + path_).c_str(), 1);
  }
  ~StudyCommandTest() override { ::setenv("PATH", path_.c_str(), 1); }

  void put_program(const std::string& name, const std::string& body) {
    const auto file = folder_ / name;
    EXPECT_OK(write_file(file, "#!/bin/sh\ncd '" + folder_.path().string() + "'\n" + body));
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
  }
  void write_study(const std::string& walks, const std::string& more = "") {
    EXPECT_OK(write_file(
        folder_ / "s.toml",
        "[study]\nname = \"paths\"\n" + more + "[factors]\nwalk = " + walks +
            "\nmax_difference = [0.02, 0.05]\n[[steps]]\nname = \"ate\"\n"
            "run = [\"roomwise\", \"eval\", \"trajectory\", \"--truth\", \"{data}/walk-0.txt\", "
            "\"--estimate\", \"{data}/{walk}.txt\", \"--max-difference\", \"{max_difference}\"]\n"
            "[values]\nate_m = \"ate/ate_rmse_m\"\npairs = \"ate/pairs\"\n"
            "[table]\nrows = [\"walk\"]\n"));
  }
  [[nodiscard]] testing::ProgramResult study(const std::string& output,
                                             const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{"study",          folder_ / "s.toml", "-o",
                                   folder_ / output, "--data",           folder_.path().string()};
    words.insert(words.end(), more.begin(), more.end());
    return run_program(laboratory_, words);
  }
  [[nodiscard]] std::string table(const std::string& output) const {
    return run_program(laboratory_, {"study-table", folder_ / output}).output;
  }

  const std::string laboratory_ =
      std::filesystem::path(ROOMWISE_PROGRAM).parent_path() / "roomwise-lab";
  const testing::ScratchFolder folder_;
  std::string path_;
};

TEST_F(StudyCommandTest, GivesTheSameTableHereAndUnderSlurmWhereATaskWasLost) {
  const auto here = study("here");
  ASSERT_EQ(here.exit_code, 0) << here.errors;
  EXPECT_THAT(here.output, HasSubstr("6 tasks: 6 done, 0 failed, 0 open"));
  ASSERT_OK(write_file(folder_ / "dead", std::string_view("4\n")));
  const auto lost = study("slurm", {"--slurm", "--wait"});
  EXPECT_THAT(lost.output, HasSubstr("6 tasks: 5 done, 0 failed, 1 open")) << lost.errors;
  EXPECT_EQ(lost.exit_code, 1) << "not all is done";
  std::filesystem::remove(folder_ / "dead");
  const auto again = study("slurm", {"--slurm", "--wait"});
  ASSERT_EQ(again.exit_code, 0) << again.errors;
  EXPECT_THAT(again.output, HasSubstr("6 tasks: 6 done, 0 failed, 0 open"));
  EXPECT_THAT(read_text_file(folder_ / "slurm/slurm/array-2.sh").value(),
              HasSubstr("--array=0-0\n"))
      << "the one that was lost, and no other";
  EXPECT_EQ(table("slurm"), table("here"));
  EXPECT_THAT(read_text_file(folder_ / "slurm/results.csv").value(), HasSubstr(",n3 ("));
}

TEST_F(StudyCommandTest, WhatSlurmDoesNotTakeIsAnErrorAlsoWhereItIsWaitedFor) {
  put_program("sbatch", "echo 'sbatch: error: invalid partition' >&2\nexit 1\n");
  const auto refused = study("out", {"--slurm", "--wait"});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.errors, HasSubstr("invalid partition"));
  // What is in the queue already is waited for.
  put_program("sbatch", "echo 1\n");
  ASSERT_EQ(study("out", {"--slurm"}).exit_code, 0) << "it is open, and is not waited for";
  put_program("squeue", "[ -e seen ] && exit\ntouch seen\necho '1 1'\n");
  put_program("sbatch", "touch handed\nexit 1\n");
  const auto waited = study("out", {"--slurm", "--wait"});
  EXPECT_THAT(waited.output, HasSubstr("6 tasks: 0 done, 0 failed, 6 open")) << waited.errors;
  EXPECT_EQ(waited.exit_code, 1);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "handed"));
}

TEST_F(StudyCommandTest, AFolderOfStudiesIsCarriedOutByOneCommandWithATableOfEach) {
  write_study("[\"walk-1\"]");
  const std::string text = read_text_file(folder_ / "s.toml").value();
  std::filesystem::create_directory(folder_ / "all");
  ASSERT_OK(write_file(folder_ / "all/b.toml", text));
  ASSERT_OK(write_file(folder_ / "all/a.toml",
                       "[study]\nname = \"first\"\n" + text.substr(text.find("[factors]"))));
  const auto study_all = [&] {
    return run_program(laboratory_, {"study", folder_ / "all", "-o", folder_ / "out", "--data",
                                     folder_.path().string(), "--table", folder_ / "out.md"});
  };
  const auto result = study_all();
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, HasSubstr("4 tasks: 4 done, 0 failed, 0 open"));
  const std::string page = read_text_file(folder_ / "out.md").value();
  EXPECT_LT(page.find("## first"), page.find("## paths"));
  EXPECT_EQ(page,
            run_program(laboratory_, {"study-table", folder_ / "out/a", folder_ / "out/b"}).output);
  ASSERT_OK(write_file(folder_ / "all/c.toml", std::string_view("[study]\n")));
  std::filesystem::remove_all(folder_ / "out");
  EXPECT_THAT(study_all().errors, HasSubstr("c.toml"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out")) << "none begins where one is wrong";
  std::filesystem::remove_all(folder_ / "all");
  std::filesystem::create_directory(folder_ / "all");
  EXPECT_THAT(study_all().errors, HasSubstr("all: holds no study (.toml)"));
}

TEST_F(StudyCommandTest, ATaskThatFailsIsToldAndTheOthersGoOn) {
  write_study("[\"walk-1\", \"nowhere\"]");
  const auto result = study("out");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output,
              AllOf(HasSubstr("4 tasks: 2 done, 2 failed"),
                    HasSubstr("- max_difference=0.02 walk=nowhere: roomwise eval: ")));
}

TEST_F(StudyCommandTest, SaysWhichKeyIsWrongBeforeAnythingIsDone) {
  write_study("[\"walk-1\"]", "thread = 1\n");
  const auto result = study("out");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.errors,
              HasSubstr("s.toml:3: 'thread' is no key here; the nearest is 'threads'"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out"));
}

TEST_F(PaperCommandTest, SaysThatTheFolderIsWrong) {
  const auto result = paper("nowhere");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.errors, HasSubstr("nowhere: is no folder; --data is the folder"));
}
#endif

}  // namespace
}  // namespace roomwise
