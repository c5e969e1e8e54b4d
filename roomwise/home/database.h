#pragma once

#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <concepts>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

#include "roomwise/base/expected.h"
#include "roomwise/base/file.h"

// A thin layer over SQLite: handles that close themselves, typed values, and errors that name the
// file and say what to do. Not thread-safe: a database and its statements belong to one thread at a
// time.
namespace roomwise::home {

// What went wrong last on a connection, for people: the file and how to mend it.
[[nodiscard]] Error describe_error(sqlite3* connection, const std::string& file);

// A prepared SQL statement with its values. Made by Database::prepare; must not outlive the
// database.
class Statement {
 public:
  // Goes to the next row of the result; false after the last.
  [[nodiscard]] Expected<bool> step();

  // Gives the next parameter ("?") of the statement a value: a whole number, a double, a text,
  // bytes, an optional of these (NULL where it is empty), or an array of doubles or a tuple of any
  // of these (as many parameters as it has elements). A value that SQLite refuses is reported by
  // step(). A double is kept to the bit, but for the sign of zero, and NaN becomes NULL.
  template <typename T>
  void bind(const T& value);

  // A column (from 0) of the current row as a whole number, double, std::string, Bytes, or an
  // optional of these, which is empty for NULL.
  template <typename T>
  [[nodiscard]] T column(int index) const;
  // The columns from `first` on.
  template <std::size_t N>
  [[nodiscard]] std::array<double, N> columns(int first) const;

  [[nodiscard]] sqlite3_stmt* handle() const { return statement_.get(); }

 private:
  friend class Database;
  struct Finalizer {
    void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
  };
  Statement(sqlite3_stmt* statement, std::string file)
      : statement_(statement), file_(std::move(file)) {}

  void bind_integer(std::int64_t value);
  void bind_real(double value);
  void bind_text(std::string_view value);
  void bind_blob(std::span<const std::uint8_t> value);
  void bind_null();
  void note(int result);
  [[nodiscard]] std::string text(int index) const;
  [[nodiscard]] Bytes blob(int index) const;

  std::unique_ptr<sqlite3_stmt, Finalizer> statement_;
  std::string file_;
  int parameters_ = 0;           // bound so far
  int bind_result_ = SQLITE_OK;  // of the first value that could not be bound
};

// The first bytes of a file, as they stand on the disk.
struct DatabaseHeader {
  bool is_sqlite = false;  // the rest is meaningful only then
  std::uint32_t application_id = 0;
  std::int32_t user_version = 0;
  int reserved_bytes = 0;            // at the end of each page
  std::uint64_t expected_bytes = 0;  // pages times page size; 0 where the header does not know
  std::uint64_t file_bytes = 0;      // of the file itself, also where it is no database
};

// A connection to one database.
class Database {
 public:
  enum class Access {
    kReadWrite,
    kReadOnly,
    kImmutable,  // read-only, and nobody else changes the file: needs no lock and no other file
  };

  // Opens a file that exists; SQLite reads nothing of it yet.
  [[nodiscard]] static Expected<Database> open(const std::filesystem::path& path, Access access);
  [[nodiscard]] static Expected<Database> in_memory();

  // Reads the header of the file without a lock and without changing anything, so that a file of
  // somebody else can be refused untouched.
  [[nodiscard]] Expected<DatabaseHeader> header() const;

  // One statement with the values of its parameters, in order.
  template <typename... Values>
  [[nodiscard]] Expected<Statement> prepare(std::string_view sql, const Values&... values) const {
    ROOMWISE_TRY(Statement statement, prepare_sql(sql));
    (statement.bind(values), ...);
    return statement;
  }
  // Carries out one statement.
  template <typename... Values>
  [[nodiscard]] Expected<void> run(std::string_view sql, const Values&... values) {
    return for_each(
        sql, [](const Statement&) {}, values...);
  }
  // Inserts one row into "table (column, ...)" and gives its number (its INTEGER PRIMARY KEY).
  template <typename... Values>
  [[nodiscard]] Expected<std::int64_t> insert(std::string_view into, const Values&... values) {
    ROOMWISE_RETURN_IF_ERROR(run(insert_sql("INSERT", into), values...));
    return sqlite3_last_insert_rowid(handle());
  }
  // The same where the number means nothing.
  template <typename... Values>
  [[nodiscard]] Expected<void> add(std::string_view into, const Values&... values) {
    return run(insert_sql("INSERT", into), values...);
  }
  // The same in place of a row with the same key.
  template <typename... Values>
  [[nodiscard]] Expected<void> put(std::string_view into, const Values&... values) {
    return run(insert_sql("INSERT OR REPLACE", into), values...);
  }
  // Carries out several statements without parameters.
  [[nodiscard]] Expected<void> run_script(const std::string& sql);
  // All that is here takes the place of all that `copy` holds; others may write here meanwhile.
  [[nodiscard]] Expected<void> copy_to(Database& copy) const;
  // Calls visit(statement) for every row of the result. A visit that returns Expected<void> ends it
  // with an error.
  template <typename Visit, typename... Values>
  [[nodiscard]] Expected<void> for_each(std::string_view sql, Visit&& visit,
                                        const Values&... values) const;
  // The first column of the first row; nothing where there is no row.
  template <typename T, typename... Values>
  [[nodiscard]] Expected<std::optional<T>> find(std::string_view sql,
                                                const Values&... values) const;
  // The same of a question that always has an answer, such as SELECT count(*).
  template <typename T, typename... Values>
  [[nodiscard]] Expected<T> get(std::string_view sql, const Values&... values) const;

  [[nodiscard]] const std::string& file() const { return file_; }
  [[nodiscard]] sqlite3* handle() const { return connection_.get(); }

 private:
  struct Closer {
    // v2: a statement that is still alive keeps the connection until it goes.
    void operator()(sqlite3* connection) const { sqlite3_close_v2(connection); }
  };
  Database(sqlite3* connection, std::string file)
      : connection_(connection), file_(std::move(file)) {}
  [[nodiscard]] Expected<Statement> prepare_sql(std::string_view sql) const;
  // With a parameter for each column.
  [[nodiscard]] static std::string insert_sql(std::string_view verb, std::string_view into);

  std::unique_ptr<sqlite3, Closer> connection_;
  std::string file_;  // as the user named it
};

// All or nothing: what is written between begin() and commit() is kept together, or not at all
// where the transaction goes out of scope without commit(). One within another is a savepoint.
class Transaction {
 public:
  // Takes the right to write at once, so that it cannot fail later for another writer.
  [[nodiscard]] static Expected<Transaction> begin(Database& database);
  ~Transaction();
  Transaction(Transaction&& other) noexcept
      : database_(std::exchange(other.database_, nullptr)), nested_(other.nested_) {}
  Transaction& operator=(Transaction&&) = delete;

  [[nodiscard]] Expected<void> commit();

 private:
  Transaction(Database& database, bool nested) : database_(&database), nested_(nested) {}

  Database* database_;  // nullptr once it is over
  bool nested_;
};

// ---- templates ----

template <typename T>
inline constexpr bool kIsOptional = false;
template <typename T>
inline constexpr bool kIsOptional<std::optional<T>> = true;
template <typename T>
inline constexpr bool kIsTuple = false;
template <typename... Values>
inline constexpr bool kIsTuple<std::tuple<Values...>> = true;
template <typename T>
inline constexpr std::size_t kDoublesIn = 0;
template <std::size_t N>
inline constexpr std::size_t kDoublesIn<std::array<double, N>> = N;

template <typename T>
void Statement::bind(const T& value) {
  if constexpr (kIsOptional<T>) {
    constexpr std::size_t kParameters =
        std::max<std::size_t>(1, kDoublesIn<typename T::value_type>);
    if (value) return bind(*value);
    for (std::size_t i = 0; i < kParameters; ++i) bind_null();
  } else if constexpr (kIsTuple<T>) {
    std::apply([this](const auto&... values) { (bind(values), ...); }, value);
  } else if constexpr (kDoublesIn<T> > 0) {
    for (const double element : value) bind_real(element);
  } else if constexpr (std::same_as<T, bool>) {
    bind_integer(value ? 1 : 0);
  } else if constexpr (std::integral<T>) {
    if (std::in_range<std::int64_t>(value)) return bind_integer(static_cast<std::int64_t>(value));
    note(SQLITE_RANGE);
  } else if constexpr (std::floating_point<T>) {
    bind_real(value);
  } else if constexpr (std::convertible_to<T, std::string_view>) {
    bind_text(value);
  } else {
    bind_blob(value);
  }
}

template <typename T>
T Statement::column(int index) const {
  if constexpr (kIsOptional<T>) {
    if (sqlite3_column_type(statement_.get(), index) == SQLITE_NULL) return std::nullopt;
    return column<typename T::value_type>(index);
  } else if constexpr (std::same_as<T, bool>) {
    return sqlite3_column_int64(statement_.get(), index) != 0;
  } else if constexpr (std::integral<T>) {
    return static_cast<T>(sqlite3_column_int64(statement_.get(), index));
  } else if constexpr (std::same_as<T, double>) {
    return sqlite3_column_double(statement_.get(), index);
  } else if constexpr (std::same_as<T, std::string>) {
    return text(index);
  } else {
    static_assert(std::same_as<T, Bytes>);
    return blob(index);
  }
}

template <std::size_t N>
std::array<double, N> Statement::columns(int first) const {
  std::array<double, N> values{};
  for (std::size_t i = 0; i < N; ++i) values[i] = column<double>(first + static_cast<int>(i));
  return values;
}

template <typename Visit, typename... Values>
Expected<void> Database::for_each(std::string_view sql, Visit&& visit,
                                  const Values&... values) const {
  ROOMWISE_TRY(Statement statement, prepare(sql, values...));
  for (;;) {
    ROOMWISE_TRY(const bool row, statement.step());
    if (!row) return {};
    if constexpr (std::is_void_v<std::invoke_result_t<Visit, const Statement&>>) {
      visit(std::as_const(statement));
    } else {
      ROOMWISE_RETURN_IF_ERROR(visit(std::as_const(statement)));
    }
  }
}

template <typename T, typename... Values>
Expected<std::optional<T>> Database::find(std::string_view sql, const Values&... values) const {
  ROOMWISE_TRY(Statement statement, prepare(sql, values...));
  ROOMWISE_TRY(const bool row, statement.step());
  if (!row) return std::optional<T>();
  return std::optional<T>(statement.column<T>(0));
}

template <typename T, typename... Values>
Expected<T> Database::get(std::string_view sql, const Values&... values) const {
  ROOMWISE_TRY(std::optional<T> value, find<T>(sql, values...));
  if (!value) return fail("{}: no answer to {}", file_, sql);
  return *std::move(value);
}

}  // namespace roomwise::home
