// The program as its users meet it: what it prints, where, and its exit code.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"
#include "run_program.h"

namespace roomwise {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using testing::ProgramResult;
using testing::run_roomwise;
using testing::ScratchFolder;
using ::testing::StartsWith;
using Words = std::vector<std::string>;

// A failure is one line on standard error that begins with the program's name, and nothing else.
void expect_failure(const ProgramResult& result, int exit_code, const std::string& text) {
  EXPECT_EQ(result.exit_code, exit_code);
  EXPECT_THAT(result.output, IsEmpty());
  EXPECT_THAT(result.errors, StartsWith("roomwise: "));
  EXPECT_THAT(result.errors, HasSubstr(text));
  EXPECT_EQ(std::ranges::count(result.errors, '\n'), 1) << result.errors;
}

// The words under "Subcommands:" of a --help.
Words subcommands_in(const std::string& help) {
  Words names;
  bool listed = false;
  std::istringstream lines(help);
  for (std::string line; std::getline(lines, line);) {
    if (line == "Subcommands:") {
      listed = true;
    } else if (line.empty()) {
      listed = false;
    } else if (listed && line.starts_with("  ") && line[2] != ' ') {
      names.push_back(line.substr(2, line.find(' ', 2) - 2));
    }
  }
  return names;
}

// Asks `command` and all commands under it for help.
void expect_helpful(const Words& command, std::vector<Words>& found) {
  Words arguments = command;
  arguments.emplace_back("--help");
  const ProgramResult help = run_roomwise(arguments);
  const std::string name = ::testing::PrintToString(command);
  EXPECT_EQ(help.exit_code, 0) << name;
  EXPECT_THAT(help.errors, IsEmpty()) << name;
  EXPECT_THAT(help.output, HasSubstr("Example:\n  roomwise")) << name;
  const Words subcommands = subcommands_in(help.output);
  if (subcommands.empty()) {
    for (const char* shared : {"--json", "--seed", "--threads"}) {
      EXPECT_THAT(help.output, HasSubstr(shared)) << name;
    }
    found.push_back(command);
  }
  for (const std::string& subcommand : subcommands) {
    Words next = command;
    next.push_back(subcommand);
    expect_helpful(next, found);
  }
}

TEST(CommandLine, EveryCommandHasHelpWithAnExampleAndTheSharedOptions) {
  std::vector<Words> commands;
  expect_helpful({}, commands);
  EXPECT_THAT(commands,
              ::testing::IsSupersetOf(
                  {Words{"optimize"}, Words{"record"}, Words{"eval", "trajectory"}, Words{"info"},
                   Words{"export", "ply"}, Words{"concepts", "add"}, Words{"objects", "list"}}));
}

TEST(CommandLine, WrongUsageIsExitCodeTwo) {
  expect_failure(run_roomwise({}), 2, "roomwise --help");
  expect_failure(run_roomwise({"dance"}), 2, "dance");
  expect_failure(run_roomwise({"optimize", "--fast"}), 2, "roomwise optimize --help");
  expect_failure(run_roomwise({"optimize", "in.g2o"}), 2, "--output");
  expect_failure(run_roomwise({"eval"}), 2, "roomwise eval --help");
  expect_failure(run_roomwise({"info", "x", "--threads", "0"}), 2, "--threads");
  expect_failure(run_roomwise({"info", "x", "--seed", "-1"}), 2, "--seed");
  for (const char* wrong : {"--method=nope", "--features=nope", "--loop-similar=-1",
                            "--keyframe-reuse=2", "--keyframe-translation=0", "--object-score=2"}) {
    expect_failure(run_roomwise({"map", "walk", "--home", "a.home", wrong}), 2, "map --help");
  }
}

TEST(CommandLine, NumbersThatCannotBeAreWrongUsage) {
  for (const char* wrong : {"1e300", "inf", "nan", "0", "-1", "1000000001"}) {
    expect_failure(
        run_roomwise({"rooms", "recognize", "x.png", "--home", "a.home", "--walk", wrong}), 2,
        "must be positive, and at most 1000000000");
  }
  for (const char* wrong : {"1e300", "nan", "-1", "1.5"}) {
    expect_failure(run_roomwise({"map", "walk", "--home", "a.home", "--keypoints", wrong}), 2,
                   "--keypoints");
  }
  expect_failure(run_roomwise({"eval", "trajectory", "--truth", "a", "--estimate", "b",
                               "--max-difference", "1e300"}),
                 2, "--max-difference: Value 1e300 not in range");
}

TEST(CommandLine, APipeIsNoFile) {
  const testing::ScratchFolder folder;
  const std::string pipe = folder / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  expect_failure(run_roomwise({"info", pipe}), 1, pipe + ": is a pipe or a device");
  expect_failure(run_roomwise({"objects", "list", "--home", pipe}), 1,
                 pipe + ": is a pipe or a device");
}

TEST(CommandLine, APathThatMayNotBeLookedAtIsToldAsSuch) {
  const std::string path(300, 'a');  // longer than any name
  const ProgramResult told = run_roomwise({"info", path});
  EXPECT_EQ(told.exit_code, 1);
  EXPECT_THAT(told.errors, HasSubstr(path + ": File name too long"));
  EXPECT_THAT(told.errors, Not(HasSubstr("internal error")));
}

TEST(CommandLine, WhatWouldHaveNoEffectIsWrongUsage) {
  const auto refused = [](Words words, const Words& more) {
    words.insert(words.end(), more.begin(), more.end());
    expect_failure(run_roomwise(words), 2, more.front());
  };
  const Words device{"device", "--server", "flat.local:8443"};
  refused(device, {"--rate", "5", "--camera"});
  refused(device, {"--calibration", "a", "--recording", "walk"});
  refused(device, {"--calibration", "a"});
  const Words map{"map", "walk", "--home", "a.home", "--no-networks"};
  refused(map, {"--labels", "a"});
  refused(map, {"--network-precision", "float"});
}

TEST(CommandLine, TellsItsVersion) {
  const ProgramResult version = run_roomwise({"--version"});
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_THAT(version.output, ::testing::MatchesRegex("[0-9]+\\.[0-9]+\\.[0-9]+\n"));
}

TEST(Record, SaysWhatALiveCameraNeeds) {
  const ScratchFolder folder;
  const auto refused = [&](const Words& more, const std::string& why) {
    Words words{"record", "-o", folder / "walk"};
    words.insert(words.end(), more.begin(), more.end());
    expect_failure(run_roomwise(words), 1, why);
  };
  refused({"--source", "v4l2"}, "v4l2 needs --calibration FILE");
  refused({"--source", "v4l2", "--camera", "fr1"}, "--camera is not for v4l2");
  refused({"--source", "openni2", "--calibration", "a"}, "--calibration is for v4l2");
  refused({"--source", folder / "none", "--calibration", "a"}, "--calibration is for v4l2");
  ASSERT_OK(write_file(folder / "rgbd.txt", std::string("colour 1\n")));
  refused({"--source", "v4l2:/dev/null", "--calibration", folder / "rgbd.txt"},
          "rgbd.txt:1: 'colour' is not known");
  ASSERT_OK(write_file(folder / "rgbd.txt",
                       std::string("color 50 50 32 24 64 48\ndepth_units_per_metre 1000\n")));
  refused({"--source", "v4l2:/dev/null", "--calibration", folder / "rgbd.txt"},
          "/dev/null: is no video device");
}

// Two poses that the odometry and a second measurement place at 1 m and at 1.2 m: F is least in the
// middle, where each is 0.1 m off.
constexpr const char* kTwoPoses =
    "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n"
    "VERTEX_SE3:QUAT 1 1 0 0 0 0 0 1\n"
    "EDGE_SE3:QUAT 0 1 1 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n"
    "EDGE_SE3:QUAT 0 1 1.2 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n";

// The paths of a command and of all below it, as "help --json" tells them.
void collect_commands(const nlohmann::json& command, std::vector<std::string>& paths) {
  paths.push_back(command.at("command"));
  for (const auto& below : command.at("commands")) collect_commands(below, paths);
}

TEST(Help, TellsProgramsOfEveryCommandThatPeopleAreToldOf) {
  std::vector<std::string> paths;
  collect_commands(testing::result_of({"help"}), paths);
  EXPECT_THAT(paths, ::testing::Contains("roomwise rooms learn"));
  const auto below = [&](const std::string& path) {
    Words names;
    for (const std::string& other : paths) {
      const std::string name = other.substr(std::min(other.size(), path.size() + 1));
      if (other.starts_with(path + " ") && name.find(' ') == std::string::npos)
        names.push_back(name);
    }
    return names;
  };
  EXPECT_EQ(below("roomwise"), subcommands_in(run_roomwise({"--help"}).output));
  EXPECT_EQ(below("roomwise rooms"), subcommands_in(run_roomwise({"rooms", "--help"}).output));
}

TEST(Help, SaysOfACommandWhatItSaysItself) {
  EXPECT_EQ(run_roomwise({"help", "rooms", "learn"}).output,
            run_roomwise({"rooms", "learn", "--help"}).output);
  expect_failure(run_roomwise({"help", "rooms", "paint"}), 1,
                 "'paint' is no command of roomwise rooms");
}

TEST(Help, WritesWhatShellsAndManRead) {
  EXPECT_THAT(run_roomwise({"help", "--as", "bash"}).output, HasSubstr("complete -o default"));
  EXPECT_THAT(run_roomwise({"help", "--as", "zsh"}).output, StartsWith("#compdef roomwise\n"));
  const ScratchFolder folder;
  EXPECT_EQ(run_roomwise({"help", "rooms", "--manual", folder.path()}).exit_code, 0);
  const auto page = read_text_file(folder / "roomwise-rooms-learn.1");
  ASSERT_OK(page);
  EXPECT_EQ(*page, run_roomwise({"help", "rooms", "learn", "--as", "man"}).output);
}

// What the build has a program write of itself for shells and man.
void expect_help_written(const std::string& program, const Words& pages, const std::string& page,
                         const std::string& option) {
  const ScratchFolder folder;
  const std::string path = std::filesystem::path(ROOMWISE_PROGRAM).parent_path() / program;
  EXPECT_EQ(testing::run_program(path, {"--write-help", folder.path()}).exit_code, 0) << program;
  for (const std::string& one : pages)
    EXPECT_TRUE(std::filesystem::exists(folder / ("man1/" + one))) << one;
  const auto manual = read_text_file(folder / ("man1/" + page));
  ASSERT_OK(manual);
  EXPECT_THAT(*manual, HasSubstr(option));
  const std::string script = folder / (program + ".bash");
  EXPECT_THAT(read_text_file(script).value(), HasSubstr(fmt::format("_{0} {0}\n", program)));
  EXPECT_EQ(testing::run_program("/bin/bash", {"-n", script}).exit_code, 0) << program;
  EXPECT_THAT(read_text_file(folder / ("_" + program)).value(),
              StartsWith(fmt::format("#compdef {}\n", program)));
}

TEST(Help, IsWrittenByEveryProgramForItself) {
  expect_help_written("roomwise", {"roomwise.1", "roomwise-serve.1"}, "roomwise-check.1",
                      "roomwise check");
  expect_help_written("roomwise-device", {}, "roomwise-device.1", "\\-\\-camera");
#ifdef ROOMWISE_HAS_LABORATORY
  expect_help_written("roomwise-lab", {"roomwise-lab.1", "roomwise-lab-study-table.1"},
                      "roomwise-lab-simulate.1", "\\-\\-walk\\-seed");
#endif
#ifdef ROOMWISE_HAS_TRAINING
  expect_help_written("roomwise-train", {}, "roomwise-train.1", "\\-\\-steps");
#endif
}

TEST(Optimize, PrintsTheErrorBeforeAndAfterAndWritesTheGraph) {
  const ScratchFolder folder;
  ASSERT_OK(write_file(folder / "in.g2o", kTwoPoses));
  const ProgramResult result =
      run_roomwise({"optimize", folder / "in.g2o", "-o", folder / "out.g2o", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.errors;
  const auto json = nlohmann::json::parse(result.output);
  EXPECT_NEAR(json.at("f_before").get<double>(), 0.04, 1e-9);
  EXPECT_NEAR(json.at("f_after").get<double>(), 0.02, 1e-6);

  const ProgramResult again =
      run_roomwise({"optimize", folder / "out.g2o", "-o", folder / "out.g2o"});
  EXPECT_EQ(again.exit_code, 0);
  EXPECT_THAT(again.output, HasSubstr("F before 0.02\n"));
}

TEST(Optimize, NamesTheFileThatIsWrong) {
  const ScratchFolder folder;
  expect_failure(run_roomwise({"optimize", folder / "absent.g2o", "-o", folder / "out.g2o"}), 1,
                 "absent.g2o");
  ASSERT_OK(write_file(folder / "in.g2o", "VERTEX_SE3:QUAT 0 0 0\n"));
  expect_failure(run_roomwise({"optimize", folder / "in.g2o", "-o", folder / "out.g2o"}), 1,
                 "in.g2o:1");
  ASSERT_OK(write_file(folder / "in.g2o", kTwoPoses));
  expect_failure(run_roomwise({"optimize", folder / "in.g2o", "-o", folder / "no" / "out.g2o"}), 1,
                 "out.g2o");
}

}  // namespace
}  // namespace roomwise
