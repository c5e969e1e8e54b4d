#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/base/expected.h"

namespace roomwise::service {

// A database that many processes share, by the SQL that SQLite and PostgreSQL have in common.
// Thread-safe.
class SqlLink {
 public:
  using Row = std::vector<std::string>;  // what is null is empty

  virtual ~SqlLink() = default;
  // Carries out one statement, whole or not at all. Parameters are $1, $2, … in their order, each
  // once.
  [[nodiscard]] virtual Expected<std::vector<Row>> run(std::string_view sql,
                                                       const std::vector<std::string>& values) = 0;
  [[nodiscard]] Expected<std::vector<Row>> run(std::string_view sql) { return run(sql, {}); }
  // A number that counts up by itself, as the type of a column that is a table's key.
  [[nodiscard]] virtual std::string_view counting_key() const = 0;
};

// A file of SQLite, readable by its owner alone; made where it is missing.
[[nodiscard]] Expected<std::unique_ptr<SqlLink>> open_sqlite_link(
    const std::filesystem::path& file);

// "postgresql://USER@HOST/DATABASE". A connection that is lost is made anew; what
// was being written then may have been carried out or not. A statement may take 5 s, unless the
// address says otherwise; so may the server's certificate be made sure of otherwise than by
// sslmode=verify-full, which holds where the server is not this computer. Fails where Roomwise
// was built without libpq. Errors never show the address, which may hold a password.
[[nodiscard]] Expected<std::unique_ptr<SqlLink>> open_postgresql_link(const std::string& address);
[[nodiscard]] bool has_postgresql();

}  // namespace roomwise::service
