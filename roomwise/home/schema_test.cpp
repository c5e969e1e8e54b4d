#include "roomwise/home/schema.h"

#include <algorithm>
#include <set>

#include "roomwise/home/testing/sample_home.h"

namespace roomwise::home {
namespace {

using ::roomwise::testing::ScratchFolder;
using ::testing::HasSubstr;
using ::testing::UnorderedElementsAreArray;

std::vector<std::string> texts(const Database& database, const std::string& sql) {
  std::vector<std::string> texts;
  EXPECT_OK(database.for_each(
      sql, [&](const Statement& row) { texts.push_back(row.column<std::string>(0)); }));
  return texts;
}

constexpr Migration kFirst{1, "CREATE TABLE chairs (name TEXT NOT NULL)"};
constexpr Migration kSecond{2, "ALTER TABLE chairs ADD COLUMN legs INTEGER NOT NULL DEFAULT 4"};
constexpr Migration kThird{3, "UPDATE chairs SET legs = 3 WHERE name = 'stool'"};
constexpr Migration kBroken{3, "UPDATE chairs SET legs = 9; UPDATE tables SET legs = 3"};

TEST(Migrate, BringsAnOlderDatabaseUpStepByStep) {
  Database database = Database::in_memory().value();
  ASSERT_OK(migrate(database, std::array{kFirst}));
  EXPECT_EQ(database.get<int>("PRAGMA user_version").value(), 1);
  ASSERT_OK(database.run("INSERT INTO chairs (name) VALUES ('stool'), ('throne')"));

  ASSERT_OK(migrate(database, std::array{kFirst, kSecond, kThird}));
  EXPECT_EQ(database.get<int>("PRAGMA user_version").value(), 3);
  EXPECT_EQ(texts(database, "SELECT name || legs FROM chairs ORDER BY name"),
            (std::vector<std::string>{"stool3", "throne4"}));
  // Nothing is done twice.
  ASSERT_OK(migrate(database, std::array{kFirst, kSecond, kThird}));
}

TEST(Migrate, ThatFailsLeavesTheVersionBeforeIt) {
  Database database = Database::in_memory().value();
  ASSERT_OK(migrate(database, std::array{kFirst}));
  ASSERT_OK(database.run("INSERT INTO chairs (name) VALUES ('stool')"));
  EXPECT_ERROR(migrate(database, std::array{kFirst, kSecond, kBroken}),
               "bringing the home from version 2 to 3");
  EXPECT_EQ(database.get<int>("PRAGMA user_version").value(), 2);
  EXPECT_EQ(database.get<int>("SELECT legs FROM chairs").value(), 4);
}

TEST(Migrations, StandInOrderOfVersion) {
  EXPECT_TRUE(std::ranges::is_sorted(migrations(), std::less(), &Migration::version));
  EXPECT_EQ(migrations().front().version, 1);
}

TEST(CheckTables, NamesWhatIsMissing) {
  Database database = Database::in_memory().value();
  EXPECT_ERROR(check_tables(database, migrations()), "no table");
  ASSERT_OK(migrate(database, migrations()));
  EXPECT_OK(check_tables(database, migrations()));
  ASSERT_OK(database.run("ALTER TABLE has_a RENAME COLUMN object TO thing"));
  EXPECT_ERROR(check_tables(database, migrations()), "table 'has_a' has no column 'object'");
}

class FilledHome : public ::testing::Test {
 protected:
  void SetUp() override { testing::fill(home_); }
  [[nodiscard]] Database& database() { return home_.database(); }
  [[nodiscard]] std::vector<std::string> table_names() {
    return texts(
        database(),
        "SELECT name FROM sqlite_schema WHERE type = 'table' AND name NOT LIKE 'sqlite_%'");
  }

  ScratchFolder folder_;
  Home home_ = Home::create(folder_ / "a.home").value();
};

TEST_F(FilledHome, HasEveryTableThatIsListedAndNoOther) {
  std::vector<std::string> listed;
  for (const Table& table : tables()) listed.emplace_back(table.name);
  EXPECT_THAT(table_names(), UnorderedElementsAreArray(listed));
}

TEST_F(FilledHome, ExplainsItsTables) {
  for (const std::string& sql :
       texts(database(), "SELECT sql FROM sqlite_schema WHERE type = 'table'")) {
    EXPECT_THAT(sql, HasSubstr("\n  -- ")) << "a comment under the name of the table";
    EXPECT_THAT(sql, HasSubstr("STRICT"));
  }
}

// A table or column of the future cannot be forgotten: each is tried.
TEST_F(FilledHome, DigestSeesEveryColumnOfEveryTableThatIsNotExempt) {
  // Two runs of one seed may differ in how long they took and where they read from; and what can be
  // made anew from pictures is no content.
  const auto is_exempt = [](const std::string& table, const std::string& column) {
    return table == "stage_timings" || table == "picture_features" ||
           ((table == "recordings" || table == "visits") && column == "folder");
  };
  const std::string digest = home_.content_digest().value();
  ASSERT_OK(database().run("PRAGMA foreign_keys = OFF"));
  for (const std::string& table : table_names()) {
    EXPECT_GT(database().get<int>("SELECT count(*) FROM " + table).value(), 0)
        << "the sample home must have a row of " << table;
    for (const std::string& column :
         texts(database(), fmt::format("SELECT name FROM pragma_table_info('{}')", table))) {
      // Another value of the same type, in one row.
      const std::string change = fmt::format(
          "UPDATE OR IGNORE {0} SET {1} = CASE typeof({1}) WHEN 'text' THEN {1} || 'x' "
          "WHEN 'blob' THEN x'99' WHEN 'real' THEN {1} + 0.5 "
          "ELSE CASE WHEN {1} = 0 THEN 1 WHEN {1} = 1 THEN 0 ELSE {1} + 1000 END END "
          "WHERE rowid = (SELECT max(rowid) FROM {0} WHERE {1} IS NOT NULL)",
          table, column);
      ASSERT_OK(database().run("SAVEPOINT before"));
      ASSERT_OK(database().run("PRAGMA ignore_check_constraints = ON"));
      ASSERT_OK(database().run(change));
      EXPECT_EQ(sqlite3_changes(database().handle()), 1) << change;
      EXPECT_EQ(home_.content_digest().value() == digest, is_exempt(table, column))
          << table << "." << column;
      ASSERT_OK(database().run_script("ROLLBACK TO before; RELEASE before"));
    }
  }
}

}  // namespace
}  // namespace roomwise::home
