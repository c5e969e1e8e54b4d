#include "open_home.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include "roomwise/base/testing/testing.h"

namespace roomwise::app {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// A terminal in which somebody types.
class OpenHome : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_EQ(::openpty(&person_, &program_, nullptr, nullptr, nullptr), 0); }
  void TearDown() override {
    ::close(person_);
    ::close(program_);
  }
  // TCSAFLUSH forgets what was typed before a question: the answer has to come after it.
  Expected<home::Passphrase> ask(const std::string& typed) {
    const pid_t child = ::fork();
    if (child == 0) {
      std::string shown;
      read_until(": ", shown);
      ::_exit(::write(person_, typed.data(), typed.size()) > 0 ? 0 : 1);
    }
    auto passphrase = ask_passphrase(program_, "Passphrase");
    ::waitpid(child, nullptr, 0);
    return passphrase;
  }
  void read_until(std::string_view end, std::string& shown) const {
    char c = 0;
    while (!shown.ends_with(end) && ::read(person_, &c, 1) == 1) shown += c;
  }
  [[nodiscard]] tcflag_t modes() const {
    termios now{};
    ::tcgetattr(program_, &now);
    return now.c_lflag;
  }

  int person_ = -1;
  int program_ = -1;
};

home::Passphrase phrase(std::string_view text) {
  return home::Passphrase::from(text).value();
}

TEST_F(OpenHome, AsksWithoutShowingWhatIsTyped) {
  const tcflag_t before = modes();
  EXPECT_NE(before & ECHO, 0U);
  EXPECT_TRUE(ask("open sesame\n").value() == phrase("open sesame"));
  EXPECT_EQ(modes(), before);
  ASSERT_EQ(::write(program_, "#", 1), 1);
  std::string shown;
  read_until("#", shown);
  EXPECT_THAT(shown, Not(HasSubstr("sesame")));
}

TEST_F(OpenHome, TakesBackWhatWasTypedWrongly) {
  EXPECT_TRUE(ask("grüß\x7f\x7fn\r").value() == phrase("grn"));
  EXPECT_TRUE(ask("wrong\x15right\n").value() == phrase("right"));
  EXPECT_TRUE(ask("\x7f\x7fx\n").value() == phrase("x"));
}

TEST_F(OpenHome, GivesUpWhereThePersonDoes) {
  const tcflag_t before = modes();
  EXPECT_ERROR(ask("half a pass\x03"), "no passphrase was given");
  EXPECT_ERROR(ask("\x04"), "no passphrase was given");
  EXPECT_ERROR(ask("\n"), "the passphrase is empty");
  EXPECT_ERROR(ask(std::string(2000, 'x') + "\n"), "longer than 1024 bytes");
  EXPECT_EQ(modes(), before);
}

TEST(OpenHomeWithout, ATerminalOrAFileSaysSo) {
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  EXPECT_ERROR(ask_passphrase(ends[0], "Passphrase"), "the terminal cannot be asked");
  ::close(ends[0]);
  ::close(ends[1]);
  Context context;
  EXPECT_EQ(open_options(context)->passphrase, nullptr);
  context.passphrase_file = "nowhere/phrase";
  EXPECT_ERROR(open_options(context), "nowhere/phrase: cannot be read");
}

}  // namespace
}  // namespace roomwise::app
