// A home whose pictures are protected by a passphrase, command by command.

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

using nlohmann::json;
using ::testing::HasSubstr;
using testing::result_of;
using testing::run_roomwise;
using testing::ScratchFolder;

class ProtectCommandTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<ScratchFolder>();
    EXPECT_OK(testing::write_made_up_recording(*folder_ / "walk", 12));
    EXPECT_OK(write_file(path("phrase"), std::string_view("open sesame\n")));
    EXPECT_OK(write_file(path("other"), std::string_view("another\n")));
    result_of({"map", path("walk"), "--no-networks", "--home", path("plain.home")});
    result_of({"map", path("walk"), "--no-networks", "--home", path("sealed.home"),
               "--passphrase-file", path("phrase")});
  }
  static void TearDownTestSuite() { folder_.reset(); }
  static std::string path(const std::string& name) { return *folder_ / name; }
  static std::string digest(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"info", "--digest", "--verify"});
    return result_of(arguments).at("content_sha256");
  }
  static void expect_refused(const std::vector<std::string>& arguments, const std::string& why) {
    const auto result = run_roomwise(arguments);
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_THAT(result.errors, HasSubstr(why));
  }

  inline static std::unique_ptr<ScratchFolder> folder_;
};

TEST_F(ProtectCommandTest, AProtectedHomeIsMappedLikeAnyOther) {
  EXPECT_EQ(digest({path("sealed.home"), "--passphrase-file", path("phrase")}),
            digest({path("plain.home")}));
  EXPECT_EQ(result_of({"info", path("sealed.home")}).at("protected"), true);
  EXPECT_EQ(result_of({"info", path("plain.home")}).at("protected"), false);
}

TEST_F(ProtectCommandTest, PicturesNeedThePassphraseAndTheRestDoesNot) {
  const std::string home = path("sealed.home");
  const std::vector<std::string> cloud{"export", "ply", "--home", home, "-o", path("my.ply")};
  expect_refused(cloud,
                 "sealed.home: its pictures are protected by a passphrase; give the file "
                 "that holds it by --passphrase-file, or name that file in the "
                 "environment's ROOMWISE_PASSPHRASE_FILE");
  const auto with_phrase = [&](const std::string& file) {
    auto arguments = cloud;
    arguments.insert(arguments.end(), {"--passphrase-file", path(file)});
    return arguments;
  };
  expect_refused(with_phrase("other"), "sealed.home: the passphrase is wrong");
  expect_refused(with_phrase("nowhere"), "nowhere: cannot be read");
  EXPECT_GT(result_of(with_phrase("phrase")).at("points").get<int>(), 1000);
  ::setenv("ROOMWISE_PASSPHRASE_FILE", path("phrase").c_str(), 1);
  EXPECT_GT(result_of(cloud).at("points").get<int>(), 1000);
  ::unsetenv("ROOMWISE_PASSPHRASE_FILE");

  EXPECT_GT(result_of({"export", "tum", "--home", home, "-o", path("my.txt")}).at("poses"), 0);
  EXPECT_EQ(result_of({"objects", "list", "--home", home}).at("objects").size(), 0U);
  expect_refused({"map", path("walk"), "--no-networks", "--home", path("new.home"),
                  "--passphrase-file", path("nowhere")},
                 "nowhere: cannot be read");
  EXPECT_FALSE(std::filesystem::exists(path("new.home")));
  expect_refused({"serve", home, "--port", "0"}, "are protected by a passphrase");
}

TEST_F(ProtectCommandTest, EveryCommandOpensAHomeWithThePassphraseThatIsGiven) {
  const std::string home = path("sealed.home");
  const std::string any = path("any");
  for (std::vector<std::string> arguments :
       {std::vector<std::string>{"concepts", "list", "--home", home},
        {"concepts", "add", "--home", home, "--room-type", "attic"},
        {"eval", "changes", "--home", home, "--truth", any, "--visit", any},
        {"export", "g2o", "--home", home, "-o", any},
        {"export", "tum", "--home", home, "-o", any},
        {"objects", "list", "--home", home},
        {"rooms", "name", "--home", home, "--types", "hall=hall"},
        {"rooms", "objects", "--home", home},
        {"rooms", "recognize", "--home", home, path("walk/rgb.txt")}}) {
    arguments.insert(arguments.end(), {"--passphrase-file", path("other")});
    expect_refused(arguments, "sealed.home: the passphrase is wrong");
  }
}

TEST_F(ProtectCommandTest, ProtectsChangesAndTakesAway) {
  const std::string home = path("mine.home");
  std::filesystem::copy_file(path("plain.home"), home);
  const std::string before = digest({home});
  expect_refused({"protect", home}, "give the file that holds the passphrase by --passphrase-file");
  expect_refused({"protect", home, "--remove", "--passphrase-file", path("phrase")},
                 "mine.home: its pictures are not protected");
  expect_refused(
      {"export", "ply", "--home", home, "-o", path("my.ply"), "--passphrase-file", path("phrase")},
      "a passphrase was given, but its pictures are not protected");

  const json made = result_of({"protect", home, "--passphrase-file", path("phrase")});
  EXPECT_EQ(made.at("protected"), true);
  EXPECT_EQ(made.at("pictures"), 2 * result_of({"info", home}).at("keyframes").get<int>());
  expect_refused({"info", home, "--digest"}, "are protected by a passphrase");
  EXPECT_EQ(digest({home, "--passphrase-file", path("phrase")}), before);

  expect_refused({"protect", home, "--passphrase-file", path("other")}, "the passphrase is wrong");
  EXPECT_EQ(result_of({"protect", home, "--passphrase-file", path("phrase")}).at("pictures"), 0);
  result_of({"protect", home, "--passphrase-file", path("phrase"), "--new-passphrase-file",
             path("other")});
  EXPECT_EQ(digest({home, "--passphrase-file", path("other")}), before);
  expect_refused({"protect", home, "--remove", "--passphrase-file", path("phrase")},
                 "the passphrase is wrong");
  const json removed = result_of({"protect", home, "--remove", "--passphrase-file", path("other")});
  EXPECT_EQ(removed.at("protected"), false);
  EXPECT_EQ(digest({home}), before);
}

}  // namespace
}  // namespace roomwise
