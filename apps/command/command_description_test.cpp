// What is told of commands: to programs, to shells and to man.
#include "command_description.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::app {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

// A program "walk" with a command that has every kind of option, and a group.
class DescribedCommands : public ::testing::Test {
 protected:
  DescribedCommands() {
    program_.set_help_flag();
    CLI::App* go = program_.add_subcommand("go", "Go there, at once");
    go->set_help_flag();
    go->footer("Example:\n  walk go home --by foot");
    go->add_option("PLACE", place_, "Where to")->required()->envname("WALK_PLACE");
    go->add_option("--by", by_, "How; it's [quick]")->check(CLI::IsMember({"foot", "bus"}));
    go->add_option("-o,--output", output_, "Where to write")->capture_default_str();
    go->add_option_group("Speed")->add_flag("--fast", fast_, "Run");
    go->add_flag("--dry", dry_, ".begins with a dot");
    CLI::App* maps = program_.add_subcommand("maps", "Look at maps");
    maps->set_help_flag();
    maps->add_subcommand("list", "List them")->set_help_flag();
  }
  [[nodiscard]] CommandDescription described() const { return describe_command(program_, "walk"); }

  CLI::App program_{"Walks.", "walk"};
  std::string place_, by_, output_ = "out";
  bool dry_ = false, fast_ = false;
};

// What bash offers at the end of these words, the last of which is begun.
std::string offered(const std::string& script, const std::vector<std::string>& words) {
  const testing::ScratchFolder folder;
  EXPECT_OK(write_file(folder / "script", script));
  std::vector<std::string> quoted;
  for (const std::string& word : words) quoted.push_back('"' + word + '"');
  const std::string command = fmt::format(
      "bash -c '. {}; COMP_WORDS=({}); COMP_CWORD={}; _walk; echo \"${{COMPREPLY[*]}}\"'",
      (folder / "script").string(), fmt::join(quoted, " "), words.size() - 1);
  std::FILE* const output = popen(command.c_str(), "r");
  std::string said;
  for (int c = std::fgetc(output); c != EOF; c = std::fgetc(output)) said += static_cast<char>(c);
  EXPECT_EQ(pclose(output), 0);
  return said;
}

TEST_F(DescribedCommands, TellOptionsOperandsAndCommandsBelow) {
  const CommandDescription program = described();
  ASSERT_EQ(program.commands.size(), 2U);
  const CommandDescription& go = program.commands[0];
  EXPECT_EQ(go.path, "walk go");
  EXPECT_EQ(go.example, "walk go home --by foot");
  ASSERT_EQ(go.operands.size(), 1U);
  EXPECT_THAT(go.operands[0].names, ElementsAre("PLACE"));
  EXPECT_TRUE(go.operands[0].is_required);
  ASSERT_EQ(go.options.size(), 4U);
  EXPECT_THAT(go.options[0].choices, ::testing::UnorderedElementsAre("foot", "bus"));
  EXPECT_THAT(go.options[1].names, ElementsAre("-o", "--output"));
  EXPECT_EQ(go.options[1].default_value, "out");
  EXPECT_FALSE(go.options[2].takes_value);
  EXPECT_THAT(go.options[3].names, ElementsAre("--fast")) << "of a group of options";
  EXPECT_TRUE(go.commands.empty());
  EXPECT_EQ(program.commands[1].commands[0].path, "walk maps list");
  EXPECT_EQ(to_json(program).at("commands")[1].at("commands")[0].at("does"), "List them");
}

TEST_F(DescribedCommands, AreCompletedByBash) {
  const std::string script = bash_completion(described());
  EXPECT_EQ(offered(script, {"walk", ""}), "go maps\n");
  EXPECT_EQ(offered(script, {"walk", "m"}), "maps\n");
  EXPECT_EQ(offered(script, {"walk", "maps", ""}), "list\n");
  EXPECT_EQ(offered(script, {"walk", "go", "home", "--d"}), "--dry\n");
  EXPECT_EQ(offered(script, {"walk", "go", "--by", "f"}), "foot\n");
  EXPECT_EQ(offered(script, {"walk", "go", "-o", ""}), "\n") << "a file, by bash itself";
}

TEST_F(DescribedCommands, AreCompletedByZsh) {
  const std::string script = zsh_completion(described());
  EXPECT_THAT(script, ::testing::StartsWith("#compdef walk\n"));
  EXPECT_THAT(script, HasSubstr("'go:Go there, at once' 'maps:Look at maps'"));
  EXPECT_THAT(script, HasSubstr("How; it'\\''s \\[quick\\]]:value:("));
  EXPECT_THAT(script, HasSubstr("'--output[Where to write]:value:_files'"));
}

TEST_F(DescribedCommands, HaveManualPages) {
  const std::string page = manual_page(described().commands[0], "1.2");
  EXPECT_THAT(page, ::testing::StartsWith(".TH \"WALK\\-GO\" 1 \"\" \"Roomwise 1.2\"\n"));
  EXPECT_THAT(page, HasSubstr("walk\\-go \\- Go there, at once\n"));
  EXPECT_THAT(page, HasSubstr("\n\\&.begins with a dot.\n")) << "no macro of that name";
  EXPECT_THAT(page, HasSubstr("Where to.\nEnvironment: WALK_PLACE.\nMust be given.\n"));
  EXPECT_THAT(page, HasSubstr("Default: out."));
  EXPECT_THAT(page, HasSubstr("walk go home \\-\\-by foot\n"));
  EXPECT_THAT(page, HasSubstr("\\fBwalk\\fR(1)"));
  EXPECT_THAT(manual_page(described(), "1.2"), Not(HasSubstr("OPTIONS")));
}

}  // namespace
}  // namespace roomwise::app
