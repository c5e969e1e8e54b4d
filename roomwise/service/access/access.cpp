#include "roomwise/service/access/access.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <system_error>

#include "roomwise/base/encodings.h"
#include "roomwise/base/file.h"
#include "roomwise/base/put_in_place.h"
#include "roomwise/service/credentials/private_folder.h"
#include "roomwise/service/credentials/secrets.h"

namespace roomwise::service {
namespace {

namespace fs = std::filesystem;

constexpr const char* kDevicesFile = "devices.sqlite";
constexpr std::size_t kMaxDevices = 100;
constexpr std::int64_t kSeenStep_s = 60;

constexpr auto kSchema = R"(
CREATE TABLE devices (
  device INTEGER PRIMARY KEY AUTOINCREMENT,
  name TEXT NOT NULL,
  role TEXT NOT NULL CHECK (role IN ('device', 'helper')),
  token_sha256 TEXT NOT NULL UNIQUE,
  paired_s INTEGER NOT NULL,
  last_seen_s INTEGER NOT NULL);
)";

// There whole or not at all: one without its table has lost it.
Expected<void> make_devices(const fs::path& path) {
  const fs::path part = path.string() + ".part";
  std::error_code ignored;
  fs::remove(part, ignored);                       // of a program that was stopped
  ROOMWISE_RETURN_IF_ERROR(write_file(part, ""));  // SQLite opens what is there
  {
    ROOMWISE_TRY(home::Database database,
                 home::Database::open(part, home::Database::Access::kReadWrite));
    ROOMWISE_RETURN_IF_ERROR(database.run_script(kSchema));
  }
  return put_in_place(part, path);
}

}  // namespace

fs::path access_folder(const fs::path& home) {
  return home.string() + ".access";
}

Expected<std::unique_ptr<AccessRegister>> AccessRegister::open(const fs::path& folder,
                                                               std::string fingerprint) {
  return open(folder, std::make_shared<PairingDoor>(PairingDoorOptions{std::move(fingerprint)}));
}

bool AccessRegister::exists(const fs::path& folder) {
  std::error_code ignored;
  return fs::exists(folder / kDevicesFile, ignored);
}

bool AccessRegister::looks_open(const fs::path& folder) {
  std::error_code ignored;
  return fs::exists(folder / (std::string(kDevicesFile) + "-lock"), ignored);
}

Expected<std::unique_ptr<AccessRegister>> AccessRegister::open(const fs::path& folder,
                                                               std::shared_ptr<PairingDoor> door) {
  ROOMWISE_RETURN_IF_ERROR(make_private_folder(folder));
  const fs::path path = folder / kDevicesFile;
  ROOMWISE_TRY(home::WriterLock lock, home::WriterLock::take(path));
  if (!fs::exists(path)) ROOMWISE_RETURN_IF_ERROR(make_devices(path));
  std::error_code error;
  fs::permissions(path, fs::perms::owner_read | fs::perms::owner_write, error);
  if (error) return fail("{}: cannot be made private: {}", path.string(), error.message());
  ROOMWISE_TRY(home::Database database,
               home::Database::open(path, home::Database::Access::kReadWrite));
  ROOMWISE_TRY(const auto tables,
               database.get<std::int64_t>(
                   "SELECT count(*) FROM sqlite_schema WHERE type = 'table' AND name = 'devices'"));
  if (tables == 0) {
    return fail_with(ErrorCode::kDamaged,
                     "{}: is damaged: the list of paired devices is gone from it; put back a copy "
                     "of it, or remove it and pair every device anew",
                     path.string());
  }
  std::unique_ptr<AccessRegister> access(
      new AccessRegister(std::move(lock), std::move(database), std::move(door)));
  ROOMWISE_RETURN_IF_ERROR(access->load());
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

tl::expected<Pairing, Refusal> AccessRegister::redeem(const PairingAttempt& attempt,
                                                      const Now& now) {
  return door_->redeem(attempt, now, [&](Role role, const std::string& name, std::int64_t maker) {
    return pair_by_code(role, name, maker, now);
  });
}

Expected<std::optional<Pairing>> AccessRegister::pair_by_code(Role role, const std::string& name,
                                                              std::int64_t maker, const Now& now) {
  const std::scoped_lock lock(mutex_);
  const bool is_device = maker > 0;
  if (is_device && std::ranges::none_of(entries_, [&](const Entry& one) {
        return one.device.who.device == maker && one.device.who.role == Role::kHelper;
      })) {
    return std::nullopt;
  }
  return add(role, name, now);
}

Expected<Pairing> AccessRegister::pair_here(Role role, const std::string& name, const Now& now) {
  if (!is_device_name(name)) {
    return fail("a device's name must have 1 to 64 bytes on one line, with a letter or digit");
  }
  const std::scoped_lock lock(mutex_);
  return add(role, name, now);
}

Expected<Pairing> AccessRegister::add(Role role, const std::string& name, const Now& now) {
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
  ROOMWISE_RETURN_IF_ERROR(database_.run("DELETE FROM devices WHERE device = ?", device));
  return std::erase_if(entries_,
                       [&](const Entry& entry) { return entry.device.who.device == device; }) > 0;
}

Expected<bool> AccessRegister::rename(std::int64_t device, const std::string& name) {
  if (!is_device_name(name)) {
    return fail("'name' must be a name of 1 to 64 bytes on one line, with a letter or digit");
  }
  const std::scoped_lock lock(mutex_);
  const auto entry = std::ranges::find_if(
      entries_, [&](const Entry& one) { return one.device.who.device == device; });
  if (entry == entries_.end()) return false;
  ROOMWISE_RETURN_IF_ERROR(
      database_.run("UPDATE devices SET name = ? WHERE device = ?", name, device));
  entry->device.who.name = name;
  return true;
}

std::vector<PairedDevice> AccessRegister::devices() const {
  const std::scoped_lock lock(mutex_);
  std::vector<PairedDevice> devices;
  for (const Entry& entry : entries_) devices.push_back(entry.device);
  return devices;
}

}  // namespace roomwise::service
