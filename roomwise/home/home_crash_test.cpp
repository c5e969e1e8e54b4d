// What is left of a home when the program is killed or the disk refuses.

#include <sys/resource.h>

#include <csignal>

#include "roomwise/home/testing/sample_home.h"

namespace roomwise::home {
namespace {

using ::roomwise::testing::ScratchFolder;
using ::testing::HasSubstr;
using ::testing::SizeIs;

// Kills this process when `count` SQL statements have begun.
void kill_at_statement(Home& home, int* count) {
  const auto on_statement = [](unsigned, void* left, void*, void*) {
    if (--*static_cast<int*>(left) == 0) ::kill(::getpid(), SIGKILL);
    return 0;
  };
  sqlite3_trace_v2(home.database().handle(), SQLITE_TRACE_STMT, on_statement, count);
}

class KilledHome : public ::testing::Test {
 protected:
  // A home of two committed steps whose process is killed at a statement of the third; false where
  // the third step has fewer statements.
  [[nodiscard]] bool make_and_kill_at(int statement) const {
    const int status = testing::run_in_child([&] {
      Home home = Home::create(path_).value();
      (void)home.add_recording(testing::sample_recording());
      (void)home.add_network(testing::sample_network());
      for (KeyframeId id = 0; id < 2; ++id) {
        if (!home.commit(testing::sample_commit(1, 1, id))) return 1;
      }
      int left = statement;
      kill_at_statement(home, &left);
      if (!home.commit(testing::sample_commit(1, 1, 2))) return 2;
      sqlite3_trace_v2(home.database().handle(), 0, nullptr, nullptr);
      return 3;
    });
    EXPECT_TRUE(WIFSIGNALED(status) || WEXITSTATUS(status) == 3);
    return WIFSIGNALED(status);
  }
  void remove_files() const {
    for (const char* suffix : {"", "-wal", "-shm", "-lock"}) {
      std::filesystem::remove(path_.string() + suffix);
    }
  }

  ScratchFolder folder_;
  std::filesystem::path path_ = folder_ / "a.home";
};

TEST_F(KilledHome, HasExactlyTheStepsThatWereCommitted) {
  int statement = 1;
  for (; make_and_kill_at(statement); ++statement) {
    {
      auto home = Home::open(path_);
      ASSERT_OK(home);
      EXPECT_OK(home->verify());
      EXPECT_THAT(home->keyframes().value(), SizeIs(2)) << "killed at statement " << statement;
      EXPECT_THAT(home->frames(1).value(), SizeIs(4));
      EXPECT_THAT(home->edges().value(), SizeIs(1));
      EXPECT_THAT(home->predictions(1).value(), SizeIs(2));
      EXPECT_EQ(home->recordings().value()[0].next_frame_index, 4U);
      // And goes on.
      EXPECT_OK(home->commit(testing::sample_commit(1, 1, 2)));
    }
    remove_files();
  }
  EXPECT_GT(statement, 10) << "the step was killed between all of its statements";
}

TEST_F(KilledHome, KeepsAStepThatWasCommittedJustBefore) {
  const int status = testing::run_in_child([&] {
    Home home = Home::create(path_).value();
    (void)home.add_recording(testing::sample_recording());
    (void)home.add_network(testing::sample_network());
    for (KeyframeId id = 0; id < 3; ++id) (void)home.commit(testing::sample_commit(1, 1, id));
    return ::kill(::getpid(), SIGKILL);
  });
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_THAT(Home::open(path_)->keyframes().value(), SizeIs(3));
}

TEST_F(KilledHome, WhileItIsClosedLosesNothing) {
  const int status = testing::run_in_child([&] {
    std::optional<Home> home = Home::create(path_).value();
    testing::fill(*home);
    int left = 1;
    kill_at_statement(*home, &left);
    home.reset();
    return 0;
  });
  ASSERT_TRUE(WIFSIGNALED(status));
  Home home = Home::open(path_).value();
  EXPECT_THAT(home.keyframes().value(), SizeIs(4));
  EXPECT_OK(home.verify());
}

TEST(FullDisk, IsSaidAndTheStepsBeforeAreKept) {
  ScratchFolder folder;
  Home home = Home::create(folder / "a.home").value();
  testing::fill(home);
  const std::string before = home.content_digest().value();
  const auto pages = home.database().get<int>("PRAGMA page_count").value();
  ASSERT_OK(home.database().run(fmt::format("PRAGMA max_page_count = {}", pages + 2)));
  EXPECT_ERROR(home.commit(testing::sample_commit(1, 1, 4)), "a.home: the disk is full; free");
  EXPECT_EQ(home.content_digest().value(), before);
  EXPECT_OK(home.verify());
  // Space is made.
  ASSERT_OK(home.database().run("PRAGMA max_page_count = 1000000"));
  EXPECT_OK(home.commit(testing::sample_commit(1, 1, 4)));
}

// The operating system itself refuses to let files grow, at every size there is on the way.
TEST(DiskThatRefuses, NeverLeavesAHomeInvalid) {
  for (rlim_t limit = 0; limit < 400'000; limit += 30'000) {
    ScratchFolder folder;
    const std::filesystem::path path = folder / "a.home";
    const int status = testing::run_in_child([&] {
      ::signal(SIGXFSZ, SIG_IGN);
      const rlimit most{limit, limit};
      if (::setrlimit(RLIMIT_FSIZE, &most) != 0) return 100;
      auto home = Home::create(path);
      if (!home) return home.error().message.find("a.home: ") != std::string::npos ? 50 : 101;
      (void)home->add_recording(testing::sample_recording());
      (void)home->add_network(testing::sample_network());
      for (KeyframeId id = 0; id < 40; ++id) {
        const auto done = home->commit(testing::sample_commit(1, 1, id));
        if (done) continue;
        const bool clear = done.error().message.find("check the disk") != std::string::npos ||
                           done.error().message.find("disk is full") != std::string::npos;
        return clear ? static_cast<int>(id) : 102;
      }
      return 60;
    });
    ASSERT_TRUE(WIFEXITED(status));
    const int steps = WEXITSTATUS(status);
    ASSERT_LT(steps, 60) << "limit " << limit;
    if (steps == 50) {
      EXPECT_FALSE(std::filesystem::exists(path)) << "a home that could not be made is gone";
      continue;
    }
    auto home = Home::open(path);
    ASSERT_OK(home);
    EXPECT_OK(home->verify());
    EXPECT_THAT(home->keyframes().value(), SizeIs(steps)) << "limit " << limit;
  }
}

}  // namespace
}  // namespace roomwise::home
