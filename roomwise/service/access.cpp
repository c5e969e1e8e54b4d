#include "roomwise/service/access.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <system_error>

#include "roomwise/service/pairing_proof.h"
#include "roomwise/service/private_folder.h"
#include "roomwise/service/secrets.h"

namespace roomwise::service {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxDevices = 100;
constexpr std::int64_t kSeenStep_s = 60;

constexpr auto kSchema = R"(
CREATE TABLE IF NOT EXISTS devices (
  device INTEGER PRIMARY KEY AUTOINCREMENT,
  name TEXT NOT NULL,
  role TEXT NOT NULL CHECK (role IN ('device', 'helper')),
  token_sha256 TEXT NOT NULL UNIQUE,
  paired_s INTEGER NOT NULL,
  last_seen_s INTEGER NOT NULL);
)";

PairingRefusal refusal_to_wait(double seconds) {
  const auto wait_s = static_cast<std::int64_t>(std::ceil(seconds));
  return {429, fmt::format("too many wrong codes; wait {} s, then ask for a new code", wait_s),
          wait_s};
}

tl::unexpected<PairingRefusal> refuse(int status, std::string message) {
  return tl::unexpected(PairingRefusal{status, std::move(message), 0});
}

// A name that can be spoken, shown and logged on one line.
bool is_good_name(std::string_view name) {
  return !name.empty() && name.size() <= 64 &&
         std::ranges::all_of(name, [](unsigned char c) { return c >= 0x20 && c != 0x7F; });
}

bool is_code(std::string_view code) {
  return code.size() == 6 && std::ranges::all_of(code, [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

fs::path access_folder(const fs::path& home) {
  return home.string() + ".access";
}

Expected<std::unique_ptr<AccessRegister>> AccessRegister::open(const fs::path& folder,
                                                               std::string fingerprint) {
  ROOMWISE_CHECK_OK(make_private_folder(folder));
  const fs::path path = folder / "devices.sqlite";
  if (!fs::exists(path)) ROOMWISE_CHECK_OK(write_file(path, ""));  // SQLite opens what is there
  std::error_code error;
  fs::permissions(path, fs::perms::owner_read | fs::perms::owner_write, error);
  if (error) return fail("{}: cannot be made private: {}", path.string(), error.message());
  ROOMWISE_TRY(home::WriterLock lock, home::WriterLock::take(path));
  ROOMWISE_TRY(home::Database database,
               home::Database::open(path, home::Database::Access::kReadWrite));
  ROOMWISE_CHECK_OK(database.run_script(kSchema));
  std::unique_ptr<AccessRegister> access(
      new AccessRegister(std::move(lock), std::move(database), std::move(fingerprint)));
  ROOMWISE_CHECK_OK(access->load());
  return access;
}

Expected<void> AccessRegister::load() {
  return database_.for_each(
      "SELECT device, name, role, token_sha256, paired_s, last_seen_s FROM devices ORDER BY device",
      [&](const home::Statement& row) -> Expected<void> {
        const auto role = parse_role(row.column<std::string>(2));
        if (!role) return fail("{}: a device has no role", database_.file());
        const auto seen_s = row.column<std::int64_t>(5);
        entries_.push_back({{{row.column<std::int64_t>(0), row.column<std::string>(1), *role},
                             row.column<std::int64_t>(4),
                             seen_s},
                            row.column<std::string>(3),
                            seen_s});
        return {};
      });
}

Expected<OpenCode> AccessRegister::make_code(Role role, const Now& now) {
  const std::scoped_lock lock(guard_mutex_);
  ROOMWISE_TRY(std::string digits, random_code());
  ROOMWISE_TRY(const Bytes random, random_bytes(16));
  OpenCode code{std::move(digits), base64url(random)};
  guard_.open({code.digits, code.secret, role, now.steady_s + kCodeValid_s}, now.steady_s);
  return code;
}

double AccessRegister::digits_wait_s(const Now& now) {
  const std::scoped_lock lock(guard_mutex_);
  return guard_.wait_s(now.steady_s);
}

tl::expected<Pairing, PairingRefusal> AccessRegister::redeem_secret(const PairingAttempt& attempt,
                                                                    const Now& now) {
  std::optional<PairingGuard::Code> known;
  std::string proof;
  for (const PairingGuard::Code& code : guard_.codes(now.steady_s)) {
    if (!attempt.proves_secret) {
      if (equal_secrets(code.secret, attempt.secret)) known = code;
      continue;
    }
    const auto ours = make_secret_proof(code.secret, fingerprint_, attempt.nonce);
    if (!ours) return refuse(400, ours.error().message);
    if (!equal_secrets(ours->device, attempt.proof)) continue;
    known = code;
    proof = ours->computer;
  }
  if (!known) return refuse(401, "the link is no longer valid; ask for a new one");
  Expected<Pairing> pairing = add(known->role, attempt.name, now);
  if (!pairing) return refuse(500, pairing.error().message);
  guard_.redeemed(known->secret);
  pairing->proof = proof;
  return *std::move(pairing);
}

tl::expected<Pairing, PairingRefusal> AccessRegister::redeem(const PairingAttempt& attempt,
                                                             const Now& now) {
  if (!is_good_name(attempt.name)) {
    return refuse(400, "'name' must have 1 to 64 bytes, without control characters");
  }
  const std::scoped_lock lock(guard_mutex_);
  if (attempt.proves_secret || !attempt.secret.empty()) return redeem_secret(attempt, now);
  if (attempt.proof.empty() && !is_code(attempt.code)) {
    return refuse(400, "'code' must be the six digits that the computer shows");
  }
  if (const double wait_s = guard_.wait_s(attempt.peer, now.steady_s); wait_s > 0) {
    return tl::unexpected(refusal_to_wait(wait_s));
  }
  std::optional<PairingGuard::Code> known;
  std::string proof;
  // All codes are compared, so that the time tells nothing.
  for (const PairingGuard::Code& code : guard_.codes(now.steady_s)) {
    if (code.digits.empty()) continue;
    if (attempt.proof.empty()) {
      if (equal_secrets(code.digits, attempt.code)) known = code;
      continue;
    }
    const auto ours = make_pairing_proof(code.digits, fingerprint_, attempt.nonce);
    if (!ours) return refuse(400, ours.error().message);
    if (!equal_secrets(ours->device, attempt.proof)) continue;
    known = code;
    proof = ours->computer;
  }
  if (!known) {
    guard_.wrong(attempt.peer, now.steady_s);
    return refuse(401, "the code is wrong or no longer valid; ask for a new one");
  }
  Expected<Pairing> pairing = add(known->role, attempt.name, now);
  if (!pairing) return refuse(500, pairing.error().message);
  guard_.right(attempt.peer, known->digits);
  pairing->proof = proof;
  return *std::move(pairing);
}

Expected<Pairing> AccessRegister::pair_here(Role role, const std::string& name, const Now& now) {
  if (!is_good_name(name)) {
    return fail("a device's name must have 1 to 64 bytes, without control characters");
  }
  return add(role, name, now);
}

Expected<Pairing> AccessRegister::add(Role role, const std::string& name, const Now& now) {
  const std::scoped_lock lock(mutex_);
  if (entries_.size() >= kMaxDevices) {
    return fail("{} devices are paired already; remove one that is no longer used", kMaxDevices);
  }
  ROOMWISE_TRY(const Bytes secret, random_bytes(32));
  const std::string token = base64url(secret);
  const std::string hash = sha256_of(token);
  ROOMWISE_TRY(const std::int64_t device,
               database_.insert("devices (name, role, token_sha256, paired_s, last_seen_s)", name,
                                to_string(role), hash, now.unix_s, now.unix_s));
  entries_.push_back({{{device, name, role}, now.unix_s, now.unix_s}, hash, now.unix_s});
  return Pairing{{device, name, role}, token, ""};
}

std::optional<Identity> AccessRegister::identify(std::string_view token, const Now& now) {
  const std::string hash = sha256_of(token);
  const std::scoped_lock lock(mutex_);
  Entry* found = nullptr;
  for (Entry& entry : entries_) {
    if (equal_secrets(entry.token_hash, hash)) found = &entry;
  }
  if (found == nullptr) return std::nullopt;
  found->device.last_seen_s = now.unix_s;
  if (std::abs(now.unix_s - found->stored_seen_s) >= kSeenStep_s) {
    found->stored_seen_s = now.unix_s;
    // For showing only: that a full disk keeps it from being stored keeps nobody out.
    (void)database_.run("UPDATE devices SET last_seen_s = ? WHERE device = ?", now.unix_s,
                        found->device.who.device);
  }
  return found->device.who;
}

Expected<bool> AccessRegister::revoke(std::int64_t device) {
  const std::scoped_lock lock(mutex_);
  ROOMWISE_CHECK_OK(database_.run("DELETE FROM devices WHERE device = ?", device));
  return std::erase_if(entries_,
                       [&](const Entry& entry) { return entry.device.who.device == device; }) > 0;
}

Expected<bool> AccessRegister::rename(std::int64_t device, const std::string& name) {
  if (!is_good_name(name)) {
    return fail("'name' must be a name of 1 to 64 bytes on one line");
  }
  const std::scoped_lock lock(mutex_);
  const auto entry = std::ranges::find_if(
      entries_, [&](const Entry& one) { return one.device.who.device == device; });
  if (entry == entries_.end()) return false;
  ROOMWISE_CHECK_OK(database_.run("UPDATE devices SET name = ? WHERE device = ?", name, device));
  entry->device.who.name = name;
  return true;
}

bool AccessRegister::awaits_pairing(const Now& now) {
  const std::scoped_lock lock(guard_mutex_);
  return guard_.wait_s_of_any(now.steady_s) > 0 || !guard_.codes(now.steady_s).empty();
}

std::vector<PairedDevice> AccessRegister::devices() const {
  const std::scoped_lock lock(mutex_);
  std::vector<PairedDevice> devices;
  for (const Entry& entry : entries_) devices.push_back(entry.device);
  return devices;
}

}  // namespace roomwise::service
