// The product's program where the laboratory is installed beside it, and where it is not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

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

TEST_F(PaperCommandTest, SaysThatTheFolderIsWrong) {
  const auto result = paper("nowhere");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.errors, HasSubstr("nowhere: is no folder; --data is the folder"));
}
#endif

}  // namespace
}  // namespace roomwise
