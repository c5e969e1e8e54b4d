#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/home/database.h"
#include "roomwise/home/writer_lock.h"
#include "roomwise/service/access/pairing_door.h"
#include "roomwise/service/credentials/identity.h"

namespace roomwise::service {

// A device that may connect.
struct PairedDevice {
  Identity who;
  std::int64_t paired_s = 0;     // since 1970
  std::int64_t last_seen_s = 0;  // since 1970, right to a minute
};

// The folder for keys and devices of a home: "flat.home.access" beside "flat.home".
[[nodiscard]] std::filesystem::path access_folder(const std::filesystem::path& home);

// Who may connect: devices with tokens, and the codes by which they are paired. Thread-safe. Times
// are passed in.
class AccessRegister {
 public:
  // Opens the register in `folder`, which is made where it is missing (readable by its owner only).
  // `fingerprint`: of the computer's certificate, which proofs are bound to. ErrorCode::kRefused
  // where another process has it open.
  [[nodiscard]] static Expected<std::unique_ptr<AccessRegister>> open(
      const std::filesystem::path& folder, std::string fingerprint);
  // The same with codes and guesses that outlive it.
  [[nodiscard]] static Expected<std::unique_ptr<AccessRegister>> open(
      const std::filesystem::path& folder, std::shared_ptr<PairingDoor> door);
  // Whether there is one.
  [[nodiscard]] static bool exists(const std::filesystem::path& folder);
  // Whether some process has it open, by a look that touches nothing: perhaps one that was killed.
  [[nodiscard]] static bool looks_open(const std::filesystem::path& folder);

  // See PairingDoor.
  [[nodiscard]] Expected<OpenCode> make_code(Role role, const Now& now, std::int64_t maker = 0) {
    return door_->make_code(role, now, maker);
  }
  [[nodiscard]] double digits_wait_s(const Now& now) { return door_->digits_wait_s(now); }

  // Pairs whoever knows an open code.
  [[nodiscard]] tl::expected<Pairing, Refusal> redeem(const PairingAttempt& attempt,
                                                      const Now& now);

  // Pairs without a code: for who sits at the computer itself.
  [[nodiscard]] Expected<Pairing> pair_here(Role role, const std::string& name, const Now& now);
  // Pairs by a code of that maker; nothing where that device is a helper no more.
  [[nodiscard]] Expected<std::optional<Pairing>> pair_by_code(Role role, const std::string& name,
                                                              std::int64_t maker, const Now& now);

  // Whose token this is. Notes that the device was seen.
  [[nodiscard]] std::optional<Identity> identify(std::string_view token, const Now& now);

  // Takes the device's token away; false where there is no such device.
  [[nodiscard]] Expected<bool> revoke(std::int64_t device);

  // Calls the device otherwise; false where there is no such device. Fails where nobody could speak
  // the name.
  [[nodiscard]] Expected<bool> rename(std::int64_t device, const std::string& name);

  [[nodiscard]] std::vector<PairedDevice> devices() const;  // by number

 private:
  struct Entry {
    PairedDevice device;
    std::string token_hash;      // SHA-256, hexadecimal
    std::int64_t stored_seen_s;  // last_seen_s as the file has it
  };

  AccessRegister(home::WriterLock lock, home::Database database, std::shared_ptr<PairingDoor> door)
      : door_(std::move(door)), lock_(std::move(lock)), database_(std::move(database)) {}
  [[nodiscard]] Expected<void> load();
  // With mutex_ held.
  [[nodiscard]] Expected<Pairing> add(Role role, const std::string& name, const Now& now);

  // A proof takes a while to check, during which devices that are paired must not wait: so codes
  // have locks of their own.
  const std::shared_ptr<PairingDoor> door_;
  const home::WriterLock lock_;  // what is read once must not be changed by another process
  mutable std::mutex mutex_;
  home::Database database_;
  std::vector<Entry> entries_;  // by number
};

}  // namespace roomwise::service
