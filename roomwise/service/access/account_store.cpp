#include "roomwise/service/access/account_store.h"

#include <sodium.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "roomwise/base/encodings.h"
#include "roomwise/service/credentials/secrets.h"
#include "roomwise/service/protocol/http.h"

namespace roomwise::service {
namespace {

constexpr std::size_t kMinPassword = 10;
constexpr std::size_t kMaxPassword = 256;

bool is_account_name(std::string_view name) {
  return !name.empty() && name.size() <= 64 &&
         std::ranges::all_of(name, [](unsigned char c) { return c > 0x20 && c != 0x7F; });
}

Expected<void> check_password(std::string_view password) {
  if (password.size() < kMinPassword || password.size() > kMaxPassword) {
    return fail("a password has {} to {} bytes", kMinPassword, kMaxPassword);
  }
  return {};
}

// Argon2id with its salt and costs, as one text.
Expected<std::string> hashed(std::string_view password) {
  if (sodium_init() < 0) return fail("libsodium cannot be used on this computer");
  std::array<char, crypto_pwhash_STRBYTES> text{};
  if (crypto_pwhash_str_alg(text.data(), password.data(), password.size(),
                            crypto_pwhash_OPSLIMIT_INTERACTIVE, crypto_pwhash_MEMLIMIT_INTERACTIVE,
                            crypto_pwhash_ALG_ARGON2ID13) != 0) {
    return fail("there is not enough memory to keep a password (64 MiB)");
  }
  return std::string(text.data());
}

bool fits(const std::string& hash, std::string_view password) {
  return sodium_init() >= 0 &&
         crypto_pwhash_str_verify(hash.c_str(), password.data(), password.size()) == 0;
}

// What takes as long for a name that is not known: nobody's password.
const std::string& nobodys_hash() {
  static const std::string hash = hashed("nobody's password").value_or("");
  return hash;
}

std::string text_of(std::int64_t number) {
  return fmt::format("{}", number);
}

std::int64_t number_in(const std::string& text) {
  return number_of<std::int64_t>(text).value_or(0);
}

Expected<Role> role_in(const std::string& text) {
  const auto role = parse_role(text);
  if (!role) return fail("the accounts hold a role '{}', which is none", text);
  return *role;
}

}  // namespace

Expected<std::optional<Role>> parse_staff_role(std::string_view text) {
  if (text == "none") return std::nullopt;
  const auto role = parse_role(text);
  if (!role) return fail("'{}' is no role; give helper, device or none", text);
  return role;
}

Expected<std::unique_ptr<AccountStore>> AccountStore::open(std::unique_ptr<SqlLink> link) {
  const std::string tables[] = {
      fmt::format("CREATE TABLE IF NOT EXISTS roomwise_accounts (account {}, name TEXT NOT NULL "
                  "UNIQUE, password TEXT NOT NULL)",
                  link->counting_key()),
      "CREATE TABLE IF NOT EXISTS roomwise_roles (account BIGINT NOT NULL REFERENCES "
      "roomwise_accounts (account) ON DELETE CASCADE, home TEXT NOT NULL, role TEXT NOT NULL CHECK "
      "(role IN ('device', 'helper')), PRIMARY KEY (account, home))",
      "CREATE TABLE IF NOT EXISTS roomwise_sessions (token_sha256 TEXT PRIMARY KEY, account BIGINT "
      "NOT NULL REFERENCES roomwise_accounts (account) ON DELETE CASCADE, until_s BIGINT NOT NULL)",
      fmt::format("CREATE TABLE IF NOT EXISTS roomwise_audit (line {}, time_s BIGINT NOT NULL, who "
                  "TEXT NOT NULL, home TEXT NOT NULL, what TEXT NOT NULL, outcome TEXT NOT NULL, "
                  "peer TEXT NOT NULL)",
                  link->counting_key())};
  for (const std::string& table : tables) {
    // Processes that start together may make it at once, of which PostgreSQL lets one down.
    if (!link->run(table)) ROOMWISE_RETURN_IF_ERROR(link->run(table));
  }
  return std::unique_ptr<AccountStore>(new AccountStore(std::move(link)));
}

Expected<std::optional<std::int64_t>> AccountStore::id_of(const std::string& name) {
  ROOMWISE_TRY(const auto rows,
               link_->run("SELECT account FROM roomwise_accounts WHERE name = $1", {name}));
  if (rows.empty()) return std::nullopt;
  return number_in(rows.front().at(0));
}

Expected<std::int64_t> AccountStore::known(const std::string& name) {
  ROOMWISE_TRY(const auto id, id_of(name));
  if (!id) return fail("there is no account '{}'", name);
  return *id;
}

// ---- keeping them ----

Expected<void> AccountStore::add(const std::string& name, std::string_view password) {
  if (!is_account_name(name)) {
    return fail("'{}' is no name of an account: it has 1 to 64 bytes without spaces", name);
  }
  ROOMWISE_RETURN_IF_ERROR(check_password(password));
  ROOMWISE_TRY(const std::string hash, hashed(password));
  ROOMWISE_TRY(const auto rows,
               link_->run("INSERT INTO roomwise_accounts (name, password) VALUES ($1, $2) ON "
                          "CONFLICT (name) DO NOTHING RETURNING account",
                          {name, hash}));
  if (rows.empty()) return fail("there is an account '{}' already", name);
  return {};
}

Expected<void> AccountStore::set_password(const std::string& name, std::string_view password) {
  ROOMWISE_RETURN_IF_ERROR(check_password(password));
  ROOMWISE_TRY(const std::int64_t id, known(name));
  ROOMWISE_TRY(const std::string hash, hashed(password));
  ROOMWISE_RETURN_IF_ERROR(link_->run(
      "UPDATE roomwise_accounts SET password = $1 WHERE account = $2", {hash, text_of(id)}));
  ROOMWISE_RETURN_IF_ERROR(
      link_->run("DELETE FROM roomwise_sessions WHERE account = $1", {text_of(id)}));
  return {};
}

Expected<void> AccountStore::set_role(const std::string& name, const std::string& home,
                                      std::optional<Role> role) {
  ROOMWISE_TRY(const std::int64_t id, known(name));
  if (!role) {
    ROOMWISE_RETURN_IF_ERROR(link_->run(
        "DELETE FROM roomwise_roles WHERE account = $1 AND home = $2", {text_of(id), home}));
    return {};
  }
  ROOMWISE_RETURN_IF_ERROR(
      link_->run("INSERT INTO roomwise_roles (account, home, role) VALUES ($1, $2, $3) ON CONFLICT "
                 "(account, home) DO UPDATE SET role = excluded.role",
                 {text_of(id), home, std::string(to_string(*role))}));
  return {};
}

Expected<void> AccountStore::remove(const std::string& name) {
  ROOMWISE_TRY(const std::int64_t id, known(name));
  // SQLite follows references only where it is told to.
  for (const char* table : {"roomwise_sessions", "roomwise_roles", "roomwise_accounts"}) {
    ROOMWISE_RETURN_IF_ERROR(
        link_->run(fmt::format("DELETE FROM {} WHERE account = $1", table), {text_of(id)}));
  }
  return {};
}

Expected<std::map<std::string, Role>> AccountStore::homes_of(std::int64_t account) {
  ROOMWISE_TRY(const auto rows,
               link_->run("SELECT home, role FROM roomwise_roles WHERE account = $1 ORDER BY home",
                          {text_of(account)}));
  std::map<std::string, Role> homes;
  for (const SqlLink::Row& row : rows) {
    ROOMWISE_TRY(const Role role, role_in(row.at(1)));
    homes.emplace(row.at(0), role);
  }
  return homes;
}

Expected<std::vector<Account>> AccountStore::accounts() {
  ROOMWISE_TRY(const auto rows,
               link_->run("SELECT account, name FROM roomwise_accounts ORDER BY name"));
  std::vector<Account> accounts;
  for (const SqlLink::Row& row : rows) {
    Account account{number_in(row.at(0)), row.at(1), {}};
    ROOMWISE_TRY(account.homes, homes_of(account.id));
    accounts.push_back(std::move(account));
  }
  return accounts;
}

// ---- staff ----

std::int64_t AccountStore::begin_try(const std::string& peer, double now_s) {
  const std::scoped_lock lock(guard_mutex_);
  if (trying_.size() >= kPasswordPlaces || trying_.contains(peer)) return 1;
  if (!tries_.take(peer, now_s)) return static_cast<std::int64_t>(std::ceil(1 / kTriesEachSecond));
  trying_.insert(peer);
  return 0;
}

void AccountStore::end_try(const std::string& peer) {
  const std::scoped_lock lock(guard_mutex_);
  trying_.erase(peer);
}

tl::expected<StaffSession, Refusal> AccountStore::sign_in(const std::string& name,
                                                          const std::string& password,
                                                          const std::string& peer, const Now& now) {
  const std::string counted = peer_key(peer);
  if (const std::int64_t wait_s = begin_try(counted, now.steady_s); wait_s > 0) {
    return tl::unexpected(
        Refusal{429, fmt::format("too many passwords are tried; wait {} s", wait_s), wait_s});
  }
  const auto end = [this](const std::string* at) { end_try(*at); };
  const std::unique_ptr<const std::string, decltype(end)> place(&counted, end);
  return try_password(name, password, counted, now);
}

tl::expected<StaffSession, Refusal> AccountStore::try_password(const std::string& name,
                                                               const std::string& password,
                                                               const std::string& peer,
                                                               const Now& now) {
  const auto refuse = [](int status, std::string message, std::int64_t wait_s = 0) {
    return tl::unexpected(Refusal{status, std::move(message), wait_s});
  };
  const auto cannot = [&](const Error& error) { return refuse(503, error.message); };
  // What can be nobody's name is asked for as the name that nobody has: whoever invents such ones
  // neither meets an account nor fills the guard, and learns nothing by the time it takes.
  const std::string asked = is_account_name(name) ? name : "";
  const std::string guesser = asked + " " + peer;
  // One after the other, so that many tries at once are counted like tries in turn.
  const std::scoped_lock one_by_one(hashing_mutex_);
  {
    const std::scoped_lock lock(guard_mutex_);
    if (const double wait_s = guard_.wait_s(guesser, now.steady_s); wait_s > 0) {
      const auto whole_s = static_cast<std::int64_t>(std::ceil(wait_s));
      return refuse(429, fmt::format("too many wrong passwords; wait {} s", whole_s), whole_s);
    }
  }
  const auto rows =
      link_->run("SELECT account, password FROM roomwise_accounts WHERE name = $1", {asked});
  if (!rows) return cannot(rows.error());
  const std::string& hash = rows->empty() ? nobodys_hash() : rows->front().at(1);
  const bool is_right = fits(hash, password) && !rows->empty();
  {
    const std::scoped_lock lock(guard_mutex_);
    if (!is_right) {
      guard_.wrong(guesser, now.steady_s);
      return refuse(401, "the name or the password is wrong");
    }
    guard_.right(guesser, "");
    tries_.give_back(peer);
  }
  StaffSession session;
  session.account = {number_in(rows->front().at(0)), name, {}};
  auto homes = homes_of(session.account.id);
  if (!homes) return cannot(homes.error());
  session.account.homes = *std::move(homes);
  const auto secret = random_bytes(32);
  if (!secret) return cannot(secret.error());
  session.token = base64url(*secret);
  for (const auto& done :
       {link_->run("DELETE FROM roomwise_sessions WHERE until_s <= $1", {text_of(now.unix_s)}),
        link_->run("INSERT INTO roomwise_sessions (token_sha256, account, until_s) VALUES ($1, $2, "
                   "$3)",
                   {sha256_of(session.token), text_of(session.account.id),
                    text_of(now.unix_s + kStaffSession_s)})}) {
    if (!done) return cannot(done.error());
  }
  return session;
}

Expected<std::optional<Account>> AccountStore::who(std::string_view token, const Now& now) {
  ROOMWISE_TRY(const auto rows,
               link_->run("SELECT a.account, a.name FROM roomwise_sessions s JOIN "
                          "roomwise_accounts a ON a.account = s.account WHERE s.token_sha256 = $1 "
                          "AND s.until_s > $2",
                          {sha256_of(token), text_of(now.unix_s)}));
  if (rows.empty()) return std::nullopt;
  Account account{number_in(rows.front().at(0)), rows.front().at(1), {}};
  ROOMWISE_TRY(account.homes, homes_of(account.id));
  return account;
}

Expected<void> AccountStore::sign_out(std::string_view token) {
  ROOMWISE_RETURN_IF_ERROR(
      link_->run("DELETE FROM roomwise_sessions WHERE token_sha256 = $1", {sha256_of(token)}));
  return {};
}

Expected<std::optional<Role>> AccountStore::role_in_home(std::int64_t account,
                                                         const std::string& home) {
  ROOMWISE_TRY(auto homes, homes_of(account));
  const auto role = homes.find(home);
  if (role == homes.end()) return std::nullopt;
  return role->second;
}

Expected<std::optional<Role>> AccountStore::role_now(std::int64_t account, const std::string& home,
                                                     const Now& now) {
  ROOMWISE_TRY(
      const auto rows,
      link_->run("SELECT r.role FROM roomwise_roles r JOIN roomwise_sessions s ON s.account = "
                 "r.account WHERE r.account = $1 AND r.home = $2 AND s.until_s > $3 LIMIT "
                 "1",
                 {text_of(account), home, text_of(now.unix_s)}));
  if (rows.empty()) return std::nullopt;
  ROOMWISE_TRY(const Role role, role_in(rows.front().at(0)));
  return role;
}

// ---- who did what ----

Expected<void> AccountStore::note(const AuditLine& line) {
  ROOMWISE_RETURN_IF_ERROR(
      link_->run("INSERT INTO roomwise_audit (time_s, who, home, what, outcome, peer) VALUES ($1, "
                 "$2, $3, $4, $5, $6)",
                 {text_of(line.time_s), line.who, line.home, line.what, line.outcome, line.peer}));
  return {};
}

Expected<std::vector<AuditLine>> AccountStore::audit(std::size_t most, const std::string& home) {
  const std::string of_home = home.empty() ? "$1 = ''" : "home = $1";
  ROOMWISE_TRY(const auto rows,
               link_->run(fmt::format("SELECT time_s, who, home, what, outcome, peer FROM "
                                      "roomwise_audit WHERE {} ORDER BY line DESC LIMIT {}",
                                      of_home, most),
                          {home}));
  std::vector<AuditLine> lines;
  for (const SqlLink::Row& row : rows) {
    lines.push_back({number_in(row.at(0)), row.at(1), row.at(2), row.at(3), row.at(4), row.at(5)});
  }
  return lines;
}

}  // namespace roomwise::service
