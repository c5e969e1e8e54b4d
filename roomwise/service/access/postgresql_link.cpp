#include "roomwise/service/access/sql_link.h"

#ifdef ROOMWISE_POSTGRESQL
#include <libpq-fe.h>

#include <algorithm>
#include <array>
#include <mutex>

#include "roomwise/service/credentials/allowed_hosts.h"
#endif

namespace roomwise::service {

#ifdef ROOMWISE_POSTGRESQL

namespace {

struct EndResult {
  void operator()(PGresult* result) const { PQclear(result); }
};
struct EndConnection {
  void operator()(PGconn* connection) const { PQfinish(connection); }
};

// Of several lines, one.
std::string one_line(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  for (char& c : text) {
    if (c == '\n') c = ' ';
  }
  return text;
}

struct FreeOptions {
  void operator()(PQconninfoOption* options) const { PQconninfoFree(options); }
};

bool is_this_computer(std::string_view host) {
  return host.starts_with('/') || host.starts_with('@') || host == "localhost" || host == "::1" ||
         (host.starts_with("127.") && is_address(host));
}

// How the server is made sure of where the address does not say: by its certificate, unless it is
// this computer. Sockets of the system have no TLS whatever this says.
const char* default_sslmode(const std::string& address) {
  const std::unique_ptr<PQconninfoOption, FreeOptions> options(
      PQconninfoParse(address.c_str(), nullptr));
  bool is_here = false;
  for (const PQconninfoOption* one = options.get(); one != nullptr && one->keyword != nullptr;
       ++one) {
    const std::string_view keyword = one->keyword;
    if (one->val == nullptr || (keyword != "host" && keyword != "hostaddr")) continue;
    is_here = true;  // unless one of them, parted by commas, is elsewhere
    for (std::string_view left = one->val;; left.remove_prefix(left.find(',') + 1)) {
      if (!is_this_computer(left.substr(0, left.find(',')))) return "verify-full";
      if (left.find(',') == std::string_view::npos) break;
    }
  }
  return is_here ? "prefer" : "verify-full";
}

class PostgresqlLink final : public SqlLink {
 public:
  explicit PostgresqlLink(std::string address) : address_(std::move(address)) {}

  [[nodiscard]] Expected<std::vector<Row>> run(std::string_view sql,
                                               const std::vector<std::string>& values) override {
    // The server would take a text for what is before the zero: another one.
    if (std::ranges::any_of(
            values, [](const auto& value) { return value.find('\0') != std::string::npos; })) {
      return fail("PostgreSQL keeps no text with a zero byte in it");
    }
    const std::scoped_lock lock(mutex_);
    // Where the connection breaks nobody knows whether a statement was carried out: what only asks
    // is asked again, once; what writes is not, since it might be done twice.
    const bool only_asks = sql.starts_with("SELECT");
    for (int tries = 0;; ++tries) {
      ROOMWISE_RETURN_IF_ERROR(connect());
      const std::unique_ptr<PGresult, EndResult> result = ask(std::string(sql), values);
      const ExecStatusType status = PQresultStatus(result.get());
      if (status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK) return rows_of(*result);
      std::string why = one_line(PQerrorMessage(connection_.get()));
      const bool is_lost = PQstatus(connection_.get()) == CONNECTION_BAD;
      if (is_lost) connection_.reset();
      if (is_lost && !only_asks) {
        return fail("PostgreSQL: {}; it may have been carried out or not", why);
      }
      if (!is_lost || tries > 0) return fail("PostgreSQL: {}", why);
    }
  }
  [[nodiscard]] std::string_view counting_key() const override {
    return "BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY";
  }

 private:
  Expected<void> connect() {
    if (connection_ && is_alive()) return {};
    // Who signs in must not wait for a server that is away or hangs as long as the network may
    // take. The address comes last, so that it may say otherwise.
    const std::array<std::array<const char*, 2>, 9> settings{{
        {"application_name", "roomwise"},
        {"connect_timeout", "5"},      // s
        {"tcp_user_timeout", "5000"},  // ms until what was sent must have been received
        {"keepalives", "1"},
        {"keepalives_idle", "10"},  // s
        {"keepalives_interval", "5"},
        {"keepalives_count", "2"},
        {"options", "-c statement_timeout=5000"},  // ms
        {"sslmode", default_sslmode(address_)},
    }};
    std::vector<const char*> names;
    std::vector<const char*> values;
    for (const auto& [name, value] : settings) {
      names.push_back(name);
      values.push_back(value);
    }
    names.insert(names.end(), {"dbname", nullptr});
    values.insert(values.end(), {address_.c_str(), nullptr});
    connection_.reset(PQconnectdbParams(names.data(), values.data(), /*expand_dbname=*/1));
    if (connection_ && PQstatus(connection_.get()) == CONNECTION_OK) {
      // What it says beside, of tables that are there already, say, is no news: errors are told.
      PQsetNoticeProcessor(
          connection_.get(), [](void*, const char*) {}, nullptr);
      return {};
    }
    const std::string why =
        connection_ ? one_line(PQerrorMessage(connection_.get())) : "there is no memory";
    connection_.reset();
    return fail("PostgreSQL cannot be reached: {}; see to --accounts and that the server runs",
                why);
  }

  // Whether the server has not closed it, as one that was started anew has: known without asking.
  // The first look finds its last words, the second that nothing comes any more.
  bool is_alive() {
    return PQconsumeInput(connection_.get()) == 1 && PQconsumeInput(connection_.get()) == 1;
  }

  std::unique_ptr<PGresult, EndResult> ask(const std::string& sql,
                                           const std::vector<std::string>& values) {
    std::vector<const char*> texts;
    for (const std::string& value : values) texts.push_back(value.c_str());
    return std::unique_ptr<PGresult, EndResult>(
        PQexecParams(connection_.get(), sql.c_str(), static_cast<int>(texts.size()), nullptr,
                     texts.data(), nullptr, nullptr, /*resultFormat=*/0));
  }

  static std::vector<Row> rows_of(const PGresult& result) {
    std::vector<Row> rows;
    for (int row = 0; row < PQntuples(&result); ++row) {
      Row& values = rows.emplace_back();
      for (int column = 0; column < PQnfields(&result); ++column) {
        values.emplace_back(PQgetvalue(&result, row, column));
      }
    }
    return rows;
  }

  const std::string address_;  // may hold a password: is never shown
  std::mutex mutex_;
  std::unique_ptr<PGconn, EndConnection> connection_;
};

}  // namespace

bool has_postgresql() {
  return true;
}

Expected<std::unique_ptr<SqlLink>> open_postgresql_link(const std::string& address) {
  std::unique_ptr<SqlLink> link = std::make_unique<PostgresqlLink>(address);
  ROOMWISE_TRY(const auto rows, link->run("SELECT 1"));
  return link;
}

#else

bool has_postgresql() {
  return false;
}

Expected<std::unique_ptr<SqlLink>> open_postgresql_link(const std::string&) {
  return fail(
      "this Roomwise was built without PostgreSQL's client (libpq-dev); accounts can be kept in "
      "the folder of homes");
}

#endif

}  // namespace roomwise::service
