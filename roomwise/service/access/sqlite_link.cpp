#include <sys/stat.h>

#include <mutex>

#include "roomwise/home/database.h"
#include "roomwise/service/access/sql_link.h"
#include "roomwise/service/credentials/private_file.h"

namespace roomwise::service {
namespace {

class SqliteLink final : public SqlLink {
 public:
  explicit SqliteLink(home::Database database) : database_(std::move(database)) {}

  [[nodiscard]] Expected<std::vector<Row>> run(std::string_view sql,
                                               const std::vector<std::string>& values) override {
    const std::scoped_lock lock(mutex_);
    ROOMWISE_TRY(home::Statement statement, database_.prepare(sql));
    for (const std::string& value : values) statement.bind(value);
    std::vector<Row> rows;
    for (;;) {
      ROOMWISE_TRY(const bool row, statement.step());
      if (!row) return rows;
      Row& values_of_row = rows.emplace_back();
      for (int i = 0; i < sqlite3_column_count(statement.handle()); ++i) {
        values_of_row.push_back(statement.column<std::string>(i));
      }
    }
  }
  [[nodiscard]] std::string_view counting_key() const override {
    return "INTEGER PRIMARY KEY AUTOINCREMENT";
  }

 private:
  std::mutex mutex_;
  home::Database database_;
};

}  // namespace

Expected<std::unique_ptr<SqlLink>> open_sqlite_link(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) ROOMWISE_RETURN_IF_ERROR(write_private_file(file, ""));
  ROOMWISE_TRY(home::Database database,
               home::Database::open(file, home::Database::Access::kReadWrite));
  return std::make_unique<SqliteLink>(std::move(database));
}

}  // namespace roomwise::service
