#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/service/access/pairing_guard.h"
#include "roomwise/service/access/rate_limit.h"
#include "roomwise/service/access/sql_link.h"
#include "roomwise/service/credentials/identity.h"

namespace roomwise::service {

// Somebody of an organisation's staff, and what they may do in which homes.
struct Account {
  std::int64_t id = 0;  // never given twice
  std::string name;     // "anna.meier", by which they sign in
  std::map<std::string, Role> homes;

  bool operator==(const Account&) const = default;
};

// Who did what when; what was asked for is not kept.
struct AuditLine {
  std::int64_t time_s = 0;  // since 1970
  std::string who;          // "anna.meier", "device 3 (Anna's phone)", "the computer's keeper"
  std::string home;         // empty: none
  std::string what;         // "DELETE /api/things/{id}", "signed in"
  std::string outcome;      // "200", "done", "refused"
  std::string peer;         // address; empty: at the computer itself

  bool operator==(const AuditLine&) const = default;
};

// Somebody who has signed in.
struct StaffSession {
  Account account;
  std::string token;  // handed out here and kept nowhere: only its hash is stored
};

inline constexpr std::int64_t kStaffSession_s = 12 * 3600;

// Wrong passwords that an address may try: an office whose staff sign in at once has room, and
// guessing takes a small part of a processor.
inline constexpr double kTriesAtOnce = 20;
inline constexpr double kTriesEachSecond = 0.5;
// Passwords that are tried at once, of which all but one wait; an address has one of them, so that
// few addresses do not keep others out. Each holds a thread that answers requests.
inline constexpr std::size_t kPasswordPlaces = 16;

// The accounts of an organisation's staff, and the log of who did what. Passwords are kept as
// Argon2id of libsodium. Several processes may share one database. Thread-safe.
class AccountStore {
 public:
  // Makes the tables where they are missing.
  [[nodiscard]] static Expected<std::unique_ptr<AccountStore>> open(std::unique_ptr<SqlLink> link);

  // ---- keeping them ----
  // Fails where there is such a name, or name or password are unfit.
  [[nodiscard]] Expected<void> add(const std::string& name, std::string_view password);
  // Ends the account's sessions.
  [[nodiscard]] Expected<void> set_password(const std::string& name, std::string_view password);
  // What they may do in that home from now on; nothing: not even open it.
  [[nodiscard]] Expected<void> set_role(const std::string& name, const std::string& home,
                                        std::optional<Role> role);
  [[nodiscard]] Expected<void> remove(const std::string& name);
  [[nodiscard]] Expected<std::vector<Account>> accounts();  // by name

  // ---- staff ----
  [[nodiscard]] tl::expected<StaffSession, Refusal> sign_in(const std::string& name,
                                                            const std::string& password,
                                                            const std::string& peer,
                                                            const Now& now);
  // Whose token that is; nothing where it is nobody's, or over.
  [[nodiscard]] Expected<std::optional<Account>> who(std::string_view token, const Now& now);
  [[nodiscard]] Expected<void> sign_out(std::string_view token);
  // What that account may do in the home, signed in or not; nothing: not open it.
  [[nodiscard]] Expected<std::optional<Role>> role_in_home(std::int64_t account,
                                                           const std::string& home);
  // What that account, which must have a session, may do in the home now; nothing: not open it.
  [[nodiscard]] Expected<std::optional<Role>> role_now(std::int64_t account,
                                                       const std::string& home, const Now& now);

  // ---- who did what ----
  [[nodiscard]] Expected<void> note(const AuditLine& line);
  // The newest first; of one home where it is named.
  [[nodiscard]] Expected<std::vector<AuditLine>> audit(std::size_t most,
                                                       const std::string& home = {});

 private:
  explicit AccountStore(std::unique_ptr<SqlLink> link) : link_(std::move(link)) {}
  // Whether a password from there may be tried now, and if not, for how long.
  [[nodiscard]] std::int64_t begin_try(const std::string& peer, double now_s);
  void end_try(const std::string& peer);
  [[nodiscard]] tl::expected<StaffSession, Refusal> try_password(const std::string& name,
                                                                 const std::string& password,
                                                                 const std::string& peer,
                                                                 const Now& now);
  [[nodiscard]] Expected<std::optional<std::int64_t>> id_of(const std::string& name);
  [[nodiscard]] Expected<std::int64_t> known(const std::string& name);
  [[nodiscard]] Expected<std::map<std::string, Role>> homes_of(std::int64_t account);

  const std::unique_ptr<SqlLink> link_;
  std::mutex guard_mutex_;
  PairingGuard guard_;                               // of wrong passwords, by name and address
  RateLimit tries_{kTriesAtOnce, kTriesEachSecond};  // wrong ones by address, whatever the name
  std::set<std::string> trying_;                     // addresses; at work or waiting for their turn
  std::mutex hashing_mutex_;                         // each takes 64 MiB: one after the other
};

// A role, or "none".
[[nodiscard]] Expected<std::optional<Role>> parse_staff_role(std::string_view text);

}  // namespace roomwise::service
