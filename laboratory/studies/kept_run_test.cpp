#include "laboratory/studies/kept_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::studies {
namespace {

using ::testing::HasSubstr;
using testing::ScratchFolder;

// Counts its runs and prints how many there were.
struct Counted {
  int runs = 0;
  RunProgram program() {
    return [this](const ProgramRun&) -> Expected<std::string> {
      return fmt::format(R"({{"runs": {}}})", ++runs);
    };
  }
};

TEST(KeptRun, IsNotRunAgain) {
  const ScratchFolder folder;
  const ProgramRun run{{"map", "walk"}, {}, {}, {}};
  Counted counted;
  for (int i = 0; i < 2; ++i) {
    const auto made = run_kept(run, folder / "map.json", counted.program());
    ASSERT_OK(made);
    EXPECT_EQ(made->at("runs"), 1);
  }
  EXPECT_EQ(counted.runs, 1);
}

TEST(KeptRun, IsOfItsWordsAlone) {
  const ScratchFolder folder;
  const std::string file = folder / "map.json";
  Counted counted;
  ASSERT_OK(run_kept({{"map", "walk"}, {"--threads", "1"}, {}, {}}, file, counted.program()));
  EXPECT_OK(kept_result({{"map", "walk"}, {}, {}, {}}, file))
      << "what changes no result does not count";
  EXPECT_ERROR(run_kept({{"map", "other"}, {}, {}, {}}, file, counted.program()),
               "made by another command, 'map walk'");
  EXPECT_EQ(counted.runs, 1);
}

TEST(KeptRun, IsOfWhatItWasMadeWith) {
  const ScratchFolder folder;
  Counted counted;
  ProgramRun run{{"map", "walk"}, {}, {}, {}};
  run.made_with = "1 (ab)";
  ASSERT_OK(run_kept(run, folder / "map.json", counted.program()));
  EXPECT_EQ(kept_result(run, folder / "map.json").value()->at("made_with"), "1 (ab)");
  run.made_with = "1 (cd)";
  EXPECT_ERROR(run_kept(run, folder / "map.json", counted.program()),
               "was made with '1 (ab)', not with '1 (cd)'");
}

TEST(KeptRun, KeepsNothingOfARunThatFailed) {
  const ScratchFolder folder;
  const std::string file = folder / "map.json";
  const RunProgram fails = [](const ProgramRun&) -> Expected<std::string> { return fail("no"); };
  const RunProgram babbles = [](const ProgramRun&) -> Expected<std::string> { return "done"; };
  EXPECT_ERROR(run_kept({{"map"}, {}, {}, {}}, file, fails), "no");
  EXPECT_ERROR(run_kept({{"map"}, {}, {}, {}}, file, babbles), "printed no JSON");
  EXPECT_FALSE(std::filesystem::exists(file));
  ASSERT_OK(write_file(file, std::string_view("half")));
  EXPECT_ERROR(kept_result({{"map"}, {}, {}, {}}, file), "made by another command");
}

}  // namespace
}  // namespace roomwise::studies
