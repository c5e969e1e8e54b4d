// The product's program where the laboratory is installed beside it, and where it is not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

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
#endif

}  // namespace
}  // namespace roomwise
