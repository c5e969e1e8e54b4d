#include "roomwise/home/database.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "roomwise/base/testing/testing.h"

namespace roomwise::home {
namespace {

using ::roomwise::testing::ScratchFolder;

// A database file with the table t (a), whose column takes anything.
class DatabaseFile : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_OK(write_file(path_, std::string_view()));
    Database database = open();
    ASSERT_OK(
        database.run_script("CREATE TABLE t (a); CREATE TABLE reals (a REAL NOT NULL) STRICT"));
  }
  [[nodiscard]] Database open(Database::Access access = Database::Access::kReadWrite) const {
    auto database = Database::open(path_, access);
    EXPECT_OK(database);
    sqlite3_busy_timeout(database->handle(), 0);
    return *std::move(database);
  }
  [[nodiscard]] static int rows(const Database& database) {
    return database.get<int>("SELECT count(*) FROM t").value_or(-1);
  }

  ScratchFolder folder_;
  std::filesystem::path path_ = folder_ / "a file?with %20 odd#name.home";
};

TEST_F(DatabaseFile, DoublesComeBackToTheBit) {
  Database database = open();
  using Limits = std::numeric_limits<double>;
  for (const double value :
       {0.1, 1.0, -3.0, 1.0 / 3, std::numbers::pi, 1e22, 9007199254740993.0, Limits::max(),
        Limits::min(), Limits::denorm_min(), Limits::infinity()}) {
    ASSERT_OK(database.run("DELETE FROM reals"));
    ASSERT_OK(database.run("INSERT INTO reals VALUES (?)", value));
    const auto read = database.get<double>("SELECT a FROM reals");
    ASSERT_OK(read);
    EXPECT_EQ(std::bit_cast<std::uint64_t>(*read), std::bit_cast<std::uint64_t>(value)) << value;
  }
}

TEST_F(DatabaseFile, ANumberThatIsNoneIsRefused) {
  EXPECT_ERROR(open().run("INSERT INTO reals VALUES (?)", std::nan("")), "reals.a");
}

TEST_F(DatabaseFile, ValuesOfEveryTypeComeBack) {
  Database database = open();
  const auto echo = [&]<typename T>(const T& value) {
    const auto read = database.get<T>("SELECT ?", value);
    ASSERT_OK(read);
    EXPECT_EQ(*read, value);
  };
  echo(std::int64_t{-1} << 62);
  echo(std::numeric_limits<std::int64_t>::max());
  echo(true);
  echo(false);
  echo(std::string("née\0 zero", 10));
  echo(std::string());
  echo(Bytes{0, 255, 0});
  echo(Bytes{});
  echo(std::optional<int>(3));
  echo(std::optional<int>());
  echo(std::optional<std::string>(""));  // an empty text is not NULL
  echo(std::optional<Bytes>(Bytes{}));
}

TEST_F(DatabaseFile, ArraysFillSeveralParameters) {
  Database database = open();
  const std::array<double, 2> pair{1.5, 2.5};
  EXPECT_EQ(database.get<std::string>("SELECT ? || ' ' || ? || ' ' || ?", pair, "x").value(),
            "1.5 2.5 x");
  EXPECT_EQ(database
                .get<int>("SELECT (? IS NULL) + (? IS NULL) + (? IS NULL)",
                          std::optional<std::array<double, 2>>(), 1)
                .value(),
            2);
}

TEST_F(DatabaseFile, AWholeNumberThatDoesNotFitIsRefused) {
  EXPECT_ERROR(open().run("INSERT INTO t VALUES (?)", std::numeric_limits<std::uint64_t>::max()),
               "a value cannot be stored");
}

TEST_F(DatabaseFile, ATransactionThatIsNotCommittedLeavesNothing) {
  Database database = open();
  {
    auto transaction = Transaction::begin(database);
    ASSERT_OK(transaction);
    ASSERT_OK(database.run("INSERT INTO t VALUES (1)"));
  }
  EXPECT_EQ(rows(database), 0);
  {
    auto transaction = Transaction::begin(database);
    ASSERT_OK(database.run("INSERT INTO t VALUES (1)"));
    ASSERT_OK(transaction->commit());
  }
  EXPECT_EQ(rows(database), 1);
}

TEST_F(DatabaseFile, AnInnerTransactionFailsAloneButLivesOnlyWithTheOuter) {
  Database database = open();
  {
    auto outer = Transaction::begin(database);
    ASSERT_OK(database.run("INSERT INTO t VALUES (1)"));
    {
      auto inner = Transaction::begin(database);
      ASSERT_OK(database.run("INSERT INTO t VALUES (2)"));
    }
    EXPECT_EQ(rows(database), 1);
    {
      auto inner = Transaction::begin(database);
      ASSERT_OK(database.run("INSERT INTO t VALUES (3)"));
      ASSERT_OK(inner->commit());
    }
    EXPECT_EQ(rows(database), 2);
  }
  EXPECT_EQ(rows(database), 0);
}

TEST_F(DatabaseFile, AFullDiskIsSaidAndTheTransactionUndone) {
  Database database = open();
  ASSERT_OK(database.run("INSERT INTO t VALUES (1)"));
  ASSERT_OK(database.run("PRAGMA max_page_count = 8"));
  const auto fill = [&]() -> Expected<void> {
    ROOMWISE_TRY(Transaction transaction, Transaction::begin(database));
    for (int i = 0; i < 100; ++i) {
      ROOMWISE_RETURN_IF_ERROR(database.run("INSERT INTO t VALUES (?)", Bytes(4096)));
    }
    return transaction.commit();
  };
  EXPECT_ERROR(fill(), "odd#name.home: the disk is full; free some space");
  EXPECT_EQ(rows(database), 1);
  EXPECT_OK(database.run("INSERT INTO t VALUES (2)"));
}

TEST_F(DatabaseFile, AnotherWriterIsSaid) {
  Database first = open();
  Database second = open();
  auto transaction = Transaction::begin(first);
  ASSERT_OK(transaction);
  EXPECT_ERROR(Transaction::begin(second), "in use by another process");
}

TEST_F(DatabaseFile, AReaderCannotWrite) {
  Database reader = open(Database::Access::kReadOnly);
  EXPECT_ERROR(reader.run("INSERT INTO t VALUES (1)"), "cannot be written");
  EXPECT_EQ(rows(reader), 0);
}

TEST_F(DatabaseFile, WhatIsNotThereIsSaid) {
  EXPECT_ERROR(Database::open(folder_ / "none.home", Database::Access::kReadWrite),
               "none.home: no such file");
  EXPECT_ERROR(Database::open(folder_.path(), Database::Access::kReadWrite), "is a folder");
  EXPECT_ERROR(Database::open("/dev/null", Database::Access::kReadWrite),
               "/dev/null: is a pipe or a device");
  EXPECT_ERROR(open().run("INSERT INTO nowhere VALUES (1)"), "no such table: nowhere");
}

TEST_F(DatabaseFile, AVisitCanEndTheReading) {
  Database database = open();
  ASSERT_OK(database.run("INSERT INTO t VALUES (1), (2), (3)"));
  int visits = 0;
  const auto read = database.for_each("SELECT a FROM t", [&](const Statement&) -> Expected<void> {
    if (++visits == 2) return fail("enough");
    return {};
  });
  EXPECT_ERROR(read, "enough");
  EXPECT_EQ(visits, 2);
}

TEST_F(DatabaseFile, TheHeaderIsReadWithoutTouchingTheFile) {
  ASSERT_OK(open().run_script("PRAGMA application_id = 0x12345678; PRAGMA user_version = 42"));
  const Bytes before = read_file(path_).value();
  {
    const Database database = open();
    const auto header = database.header();
    ASSERT_OK(header);
    EXPECT_TRUE(header->is_sqlite);
    EXPECT_EQ(header->application_id, 0x12345678U);
    EXPECT_EQ(header->user_version, 42);
    EXPECT_EQ(header->file_bytes, before.size());
    EXPECT_EQ(header->expected_bytes, before.size());
  }
  EXPECT_EQ(read_file(path_).value(), before);
}

}  // namespace
}  // namespace roomwise::home
