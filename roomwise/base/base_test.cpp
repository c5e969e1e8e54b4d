#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstdlib>
#include <fstream>
#include <numeric>

#include "roomwise/base/calendar_time.h"
#include "roomwise/base/disjoint_sets.h"
#include "roomwise/base/encodings.h"
#include "roomwise/base/file.h"
#include "roomwise/base/in_context.h"
#include "roomwise/base/name.h"
#include "roomwise/base/progress.h"
#include "roomwise/base/protobuf_reader.h"
#include "roomwise/base/random.h"
#include "roomwise/base/scratch_file.h"
#include "roomwise/base/shell_word.h"
#include "roomwise/base/simd.h"
#include "roomwise/base/spread.h"
#include "roomwise/base/stage_clock.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/base/thread_pool.h"
#include "roomwise/base/timestamp.h"

namespace roomwise {
namespace {

TEST(Name, IsSeenAndHasALetterOrADigit) {
  for (const char* name : {"Anna's phone", "7", "Küche", "e\u0301tage", "台所", "кухня", "٣", "🏠 1",
                           "می\u200cخواهم", "☀\uFE0F 2"}) {
    EXPECT_TRUE(is_name(name)) << name;
  }
  for (const char* none : {"",
                           "   ",
                           "…",
                           "🏠",
                           "\u0301",
                           "a\nb",
                           "a\x7F",
                           "a\u0085b",
                           "a\u009b31mb",
                           "\u200b",
                           "a\u200b",
                           "\u202eevil",
                           "a\u2066b",
                           "\ufeff"
                           "a",
                           "a\u2028b",
                           "a\u2029b",
                           "\u3164",
                           "a\u115F",
                           "a\u200c",
                           "\u200d"
                           "a",
                           "a\xFF",
                           "a\xC3"}) {
    EXPECT_FALSE(is_name(none)) << none;
  }
  EXPECT_TRUE(is_legible("…")) << "a note need hold no name";
  EXPECT_FALSE(is_legible("a\u202eb"));
  EXPECT_FALSE(is_name(std::string_view("a\0b", 3)));
}

TEST(Error, KeepsItsCodeOnItsWay) {
  const Expected<void> refused = fail_with(ErrorCode::kRefused, "no {}", "entry");
  const auto pass_on = [&]() -> Expected<int> {
    ROOMWISE_RETURN_IF_ERROR(refused);
    return 1;
  };
  EXPECT_EQ(pass_on().error().code, ErrorCode::kRefused);
  const Error outer = Error(refused.error()).with_context("door");
  EXPECT_EQ(outer.message, "door: no entry");
  EXPECT_EQ(outer.code, ErrorCode::kRefused);
  EXPECT_EQ(fail("no").value().code, ErrorCode::kFailed);
}

TEST(Interruption, IsAnErrorThatNamesTheWork) {
  EXPECT_OK(SilentProgress().check("waiting"));
  struct Stopped final : Interruption {
    [[nodiscard]] bool interrupted() const override { return true; }
  };
  const auto stopped = Stopped().check("waiting");
  EXPECT_ERROR(stopped, "interrupted while waiting");
  EXPECT_EQ(stopped.error().code, ErrorCode::kInterrupted);
}

TEST(DisjointSets, AreKnownByTheirLowestElement) {
  DisjointSets sets(6);
  EXPECT_TRUE(sets.join(5, 3));
  EXPECT_TRUE(sets.join(3, 1));
  EXPECT_FALSE(sets.join(1, 5)) << "they were together";
  EXPECT_TRUE(sets.join(4, 2));
  for (const std::size_t element : {1, 3, 5}) EXPECT_EQ(sets.find(element), 1U);
  for (const std::size_t element : {2, 4}) EXPECT_EQ(sets.find(element), 2U);
  EXPECT_EQ(sets.find(0), 0U);
}

TEST(ProtobufReader, RefusesNumbersWithoutEnd) {
  for (const Bytes& damaged : {Bytes(12, 0xFF), Bytes{0x0A, 0xFF, 0xFF, 0xFF, 0xFF, 0x0F}}) {
    ProtobufReader reader(damaged);
    EXPECT_FALSE(reader.next().has_value());
    EXPECT_FALSE(reader.ok());
  }
}

TEST(ProtobufReader, GivesNumbersFloatsAndPackedNumbers) {
  // 1: 300; 2: 1.5 as a float; 3: 1 and 300, packed.
  const Bytes message{0x08, 0xAC, 0x02, 0x15, 0, 0, 0xC0, 0x3F, 0x1A, 0x03, 0x01, 0xAC, 0x02};
  ProtobufReader reader(message);
  EXPECT_EQ(reader.next()->as_integer(), 300);
  EXPECT_EQ(std::bit_cast<float>(reader.next()->as_count()), 1.5F);
  const auto field = reader.next();
  EXPECT_TRUE(field->holds_bytes);
  ProtobufReader packed(field->bytes);
  EXPECT_EQ(packed.varint(), 1U);
  EXPECT_EQ(packed.varint(), 300U);
  EXPECT_TRUE(packed.ok() && packed.at_end() && !reader.next().has_value() && reader.ok());
}

TEST(Encodings, AreThoseOfRfc4648) {
  const Bytes bytes{0xFB, 0xEF, 0xFF, 0x00};
  EXPECT_EQ(base64(bytes), "++//AA==");
  EXPECT_EQ(base64url(bytes), "--__AA");
  EXPECT_EQ(hexadecimal(bytes), "fbefff00");
}

TEST(SpreadEvenly, TakesAllOfFewAndSomeOfManyFromTheFirstOn) {
  EXPECT_THAT(spread_evenly(3, 5), ::testing::ElementsAre(0, 1, 2));
  EXPECT_THAT(spread_evenly(10, 4), ::testing::ElementsAre(0, 2, 5, 7));
  EXPECT_THAT(spread_evenly(10, 0), ::testing::IsEmpty());
  EXPECT_THAT(spread_evenly(std::vector{'a', 'b', 'c', 'd'}, 2), ::testing::ElementsAre('a', 'c'));
}

TEST(InContext, NamesWhereAnErrorWasSeenAndPassesValuesOn) {
  EXPECT_EQ(in_context("a.png", Expected<int>(3)), 3);
  const Expected<int> failed = in_context("a.png", Expected<int>(fail("is empty")));
  EXPECT_EQ(failed.error().message, "a.png: is empty");
}

TEST(ScratchFile, GivesBackWhatWasAppendedAndLeavesNothing) {
  const roomwise::testing::ScratchFolder folder;
  {
    auto scratch = ScratchFile::create(folder.path());
    ASSERT_OK(scratch);
    const Bytes first{1, 2, 3};
    const Bytes second(100'000, 7);
    const auto first_at = scratch->append(first);
    const auto second_at = scratch->append(second);
    ASSERT_OK(first_at);
    ASSERT_OK(second_at);
    ScratchFile moved = *std::move(scratch);
    EXPECT_EQ(moved.read(*second_at, second.size()).value(), second);
    EXPECT_EQ(moved.read(*first_at, first.size()).value(), first);
    EXPECT_ERROR(moved.read(*second_at, second.size() + 1), "it ends before");
    EXPECT_TRUE(std::filesystem::is_empty(folder.path())) << "it has no name";
  }
  EXPECT_ERROR(ScratchFile::create(folder / "nowhere"), "no scratch file can be made there");
}

TEST(Timestamp, KeepsEveryNanosecond) {
  EXPECT_EQ(parse_timestamp("1305031229.528748").value(), 1305031229528748000);
  EXPECT_EQ(parse_timestamp("1305031229.123456789").value(), 1305031229123456789);
  EXPECT_EQ(parse_timestamp("0").value(), 0);
  EXPECT_EQ(parse_timestamp("-0.25").value(), -250'000'000);
  EXPECT_EQ(format_timestamp(1305031229528748000), "1305031229.528748");
  EXPECT_EQ(format_timestamp(1305031229123456789), "1305031229.123456789");
  EXPECT_EQ(format_timestamp(-250'000'000), "-0.250000");
}

TEST(CalendarTime, TellsTheDayOfStampsThatCountFrom1970Only) {
  const auto time = calendar_time(1305031229'528748000);  // 10 May 2011, 12:40 in Greenwich
  ASSERT_TRUE(time.has_value());
  EXPECT_EQ(time->year, 2011);
  EXPECT_EQ(time->month, 5);
  EXPECT_NEAR(time->day, 10, 1) << "wherever this computer stands";
  EXPECT_EQ(calendar_time(0), std::nullopt);
  EXPECT_EQ(calendar_time(1'000'000 * std::int64_t{1'000'000'000}), std::nullopt)
      << "a device that has run for eleven days";
  EXPECT_TRUE(calendar_time(unix_now_ns()).has_value());
}

TEST(CalendarTime, CountsDaysOverMonthsAndYears) {
  const CalendarTime eve{2023, 12, 31, 23};
  EXPECT_EQ(eve.days_until({2024, 1, 1, 0}), 1);
  EXPECT_EQ(eve.days_until({2023, 12, 31, 1}), 0);
  EXPECT_EQ(eve.days_until({2023, 12, 30, 1}), -1);
  EXPECT_EQ((CalendarTime{2024, 2, 28, 1}).days_until({2024, 3, 1, 1}), 2);
  EXPECT_EQ((CalendarTime{2024, 2, 28, 22}).hours_until({2024, 2, 29, 1}), 3);
  EXPECT_EQ((CalendarTime{2026, 11, 26, 0}).weekday(), 4) << "a Thursday";
}

TEST(Timestamp, RefusesWhatIsNoTime) {
  for (const char* text :
       {"", "nan", "inf", "abc", "1.2.3", "1e9", "12x", "-", ".", "99999999999999"}) {
    EXPECT_FALSE(parse_timestamp(text).has_value()) << text;
  }
}

TEST(RandomStream, IsTheSameEverywhereAndSplitsByKey) {
  RandomStream first(7, {1, 2});
  RandomStream again(7, {1, 2});
  RandomStream other(7, {2, 1});
  const std::uint64_t value = first.next();
  EXPECT_EQ(value, again.next());
  EXPECT_NE(value, other.next());
  EXPECT_EQ(RandomStream(0).next(), 5987356902031041503ULL)
      << "the sequence is part of what a seed means";
}

TEST(RandomStream, IsUniformAndNormal) {
  RandomStream random(1);
  constexpr int kDraws = 60'000;
  std::array<int, 6> faces{};
  double sum = 0;
  double squares = 0;
  for (int i = 0; i < kDraws; ++i) {
    ++faces[random.index(6)];
    const double x = random.normal();
    sum += x;
    squares += x * x;
  }
  for (const int count : faces) EXPECT_NEAR(count, kDraws / 6, 400);
  EXPECT_NEAR(sum / kDraws, 0, 0.02);
  EXPECT_NEAR(squares / kDraws, 1, 0.03);
}

TEST(ThreadPool, DoesEverythingOnce) {
  for (const std::size_t threads : {1U, 2U, 5U}) {
    ThreadPool pool(threads);
    std::vector<int> done(1000, 0);
    pool.parallel_for(done.size(), [&](std::size_t i) { done[i] += 1; });
    EXPECT_TRUE(std::ranges::all_of(done, [](int n) { return n == 1; }));
    EXPECT_EQ(pool.submit([] { return 42; }).get(), 42);
  }
}

TEST(ThreadPool, DoesAllByTheThreadsThatTheSystemGives) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers take more memory than is left here";
#endif
  const auto run_in_little = [] {
    const rlimit little{rlim_t{1} << 30U, rlim_t{1} << 30U};  // of 1,000 stacks of 8 MB
    if (setrlimit(RLIMIT_AS, &little) != 0) std::_Exit(2);
    ThreadPool pool(1000);
    std::atomic<int> done = 0;
    pool.parallel_for(50, [&](std::size_t) { ++done; });
    std::_Exit(done == 50 && pool.size() < 1000 ? 0 : 1);
  };
  EXPECT_EXIT(run_in_little(), ::testing::ExitedWithCode(0), "");
}

TEST(ThreadPool, CarriesExceptionsToTheCallerAfterAllWorkIsDone) {
  ThreadPool pool(2);
  std::atomic<int> done = 0;
  const auto body = [&](std::size_t i) {
    if (i == 0) throw std::runtime_error("no");
    ++done;
  };
  EXPECT_THROW(pool.parallel_for(50, body), std::runtime_error);
  EXPECT_EQ(done, 49);
}

TEST(StageClock, SumsCalls) {
  StageClock clock;
  clock.add("features", 0.5, 0.25);
  clock.add("features", 0.5, 0.25);
  const auto stages = clock.stages();
  EXPECT_EQ(stages.at("features").calls, 2U);
  EXPECT_DOUBLE_EQ(stages.at("features").wall_s, 1.0);
  EXPECT_DOUBLE_EQ(stages.at("features").cpu_s, 0.5);
}

// What the environment's ROOMWISE_SIMD gives where it is `name`.
Expected<Simd> simd_named(const char* name) {
  const std::string before =
      std::getenv("ROOMWISE_SIMD") == nullptr ? "" : std::getenv("ROOMWISE_SIMD");
  ::setenv("ROOMWISE_SIMD", name, 1);
  const Expected<Simd> simd = simd_of_environment();
  ::setenv("ROOMWISE_SIMD", before.c_str(), 1);  // empty: as if it were not there
  return simd;
}

TEST(Simd, IsTheBestOfTheProcessorUnlessTheEnvironmentNamesAnother) {
  EXPECT_TRUE(is_supported(best_simd()));
  EXPECT_EQ(simd_named("").value(), best_simd());
  EXPECT_EQ(simd_named("portable").value(), Simd::kPortable);
  EXPECT_THAT(simd_named("mmx").error().message, ::testing::HasSubstr("'mmx'; it can be"));
}

TEST(Simd, ThatThisProcessorLacksIsRefusedByItsName) {
  // No processor has both.
  ASSERT_FALSE(is_supported(Simd::kAvx2) && is_supported(Simd::kNeon));
  const char* const lacking = is_supported(Simd::kNeon) ? "avx2" : "neon";
  EXPECT_THAT(simd_named(lacking).error().message, ::testing::HasSubstr("lacks"));
}

TEST(File, WritesWholeOrNotAtAll) {
  const testing::ScratchFolder folder;
  ASSERT_OK(write_file(folder / "a", "first"));
  ASSERT_OK(write_file(folder / "a", "second"));
  EXPECT_EQ(read_text_file(folder / "a").value(), "second");
  EXPECT_ERROR(write_file(folder / "none" / "a", "x"), "none/a");
  EXPECT_ERROR(write_file(folder.path(), "x"), folder.path().string());
  EXPECT_ERROR(read_file(folder / "missing"), "missing: cannot be opened");
  EXPECT_ERROR(read_file(folder.path()), "is a folder");
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_ERROR(read_file(folder / "pipe"), "pipe: is a pipe or a device");
  EXPECT_ERROR(read_text_file("/dev/zero"), "/dev/zero: is a pipe or a device");
  std::filesystem::remove(folder / "pipe");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

TEST(File, WhetherItCanBeWrittenIsToldWithoutWriting) {
  const testing::ScratchFolder folder;
  EXPECT_OK(check_can_write(folder / "new"));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  ASSERT_OK(write_file(folder / "old", "content"));
  EXPECT_OK(check_can_write(folder / "old"));
  EXPECT_EQ(read_text_file(folder / "old").value(), "content");
  EXPECT_OK(check_can_write("/dev/null"));
  EXPECT_ERROR(check_can_write(folder.path()), "is a folder");
  EXPECT_ERROR(check_can_write(folder / "none/new"), "none/new");
  EXPECT_ERROR(check_can_write(folder / "old/new"), "old/new");
  ASSERT_OK(write_file(folder / "my.home", std::string_view("SQLite format 3\0", 16)));
  EXPECT_ERROR(check_can_write(folder / "my.home"), "not overwritten");
}

TEST(File, WritesIntoADeviceInsteadOfReplacingIt) {
  const roomwise::testing::ScratchFolder folder;
  std::filesystem::create_symlink("/dev/null", folder / "device");
  EXPECT_OK(write_file(folder / "device", "x"));
  EXPECT_TRUE(std::filesystem::is_character_file(folder / "device"));
}

TEST(ShellWord, IsReadBackByAShellAsItWas) {
  EXPECT_EQ(shell_word("walks/office-1.home"), "walks/office-1.home");
  EXPECT_EQ(shell_word("my walk"), "'my walk'");
  EXPECT_EQ(shell_word("Anna's $HOME"), "'Anna'\\''s $HOME'");
  EXPECT_EQ(shell_word(""), "''");
}

TEST(File, HashesAsPublished) {
  EXPECT_EQ(sha256_hex({}), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

}  // namespace
}  // namespace roomwise
