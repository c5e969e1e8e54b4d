#include "paths.h"

#include <gtest/gtest.h>

namespace roomwise::app {
namespace {

TEST(ShellWord, IsReadBackByAShellAsItWas) {
  EXPECT_EQ(shell_word("walks/office-1.home"), "walks/office-1.home");
  EXPECT_EQ(shell_word("my walk"), "'my walk'");
  EXPECT_EQ(shell_word("Anna's $HOME"), "'Anna'\\''s $HOME'");
  EXPECT_EQ(shell_word(""), "''");
}

}  // namespace
}  // namespace roomwise::app
