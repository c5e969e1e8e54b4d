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
#include "roomwise/service/identity.h"
#include "roomwise/service/pairing_guard.h"

namespace roomwise::service {

// A device that may connect.
struct PairedDevice {
  Identity who;
  std::int64_t paired_s = 0;     // since 1970
  std::int64_t last_seen_s = 0;  // since 1970, right to a minute
};

// The folder for keys and devices of a home: "flat.home.access" beside "flat.home".
[[nodiscard]] std::filesystem::path access_folder(const std::filesystem::path& home);

// What somebody sends who wants to be paired: the code itself, or a proof of knowing it.
struct PairingAttempt {
  std::string code = {};       // "123456"; empty where there is a proof or a secret
  std::string secret = {};     // of a link
  std::string nonce = {};      // chosen by the device, 32 hexadecimal digits or more
  std::string proof = {};      // hexadecimal; see pairing_proof.h
  bool proves_secret = false;  // and not the digits
  std::string name = {};       // that the device gives itself: "Anna's phone"
  std::string peer = {};       // address that it comes from
};

// A code as it is shown: digits to be typed, or a link to be opened.
struct OpenCode {
  std::string digits;  // six
  std::string secret;  // 128 bits, for links and QR codes: kSecretLength letters of base64url
};

struct Pairing {
  Identity who;
  std::string token;  // handed out here and kept nowhere: only its hash is stored
  std::string proof;  // that the computer knows the code too; empty where the code itself was sent
};

// Why a device was not paired.
struct PairingRefusal {
  int status = 401;         // of the answer: 400, 401, 429, 500
  std::string message;      // for people
  std::int64_t wait_s = 0;  // with 429
};

// Who may connect: devices with tokens, and the codes by which they are paired. Thread-safe. Times
// are passed in.
class AccessRegister {
 public:
  // Opens the register in `folder`, which is made where it is missing (readable by its owner only).
  // `fingerprint`: of the computer's certificate, which proofs are bound to. ErrorCode::kRefused
  // where another process has it open.
  [[nodiscard]] static Expected<std::unique_ptr<AccessRegister>> open(
      const std::filesystem::path& folder, std::string fingerprint);

  // A new code: redeemed once, within kCodeValid_s. While guessing is answered by waiting, only its
  // secret is heard.
  [[nodiscard]] Expected<OpenCode> make_code(Role role, const Now& now);
  // How long digits are not heard from anybody.
  [[nodiscard]] double digits_wait_s(const Now& now);

  // Pairs whoever knows an open code.
  [[nodiscard]] tl::expected<Pairing, PairingRefusal> redeem(const PairingAttempt& attempt,
                                                             const Now& now);

  // Pairs without a code: for who sits at the computer itself.
  [[nodiscard]] Expected<Pairing> pair_here(Role role, const std::string& name, const Now& now);

  // Whose token this is. Notes that the device was seen.
  [[nodiscard]] std::optional<Identity> identify(std::string_view token, const Now& now);

  // Takes the device's token away; false where there is no such device.
  [[nodiscard]] Expected<bool> revoke(std::int64_t device);

  // Calls the device otherwise; false where there is no such device. Fails where nobody could speak
  // the name.
  [[nodiscard]] Expected<bool> rename(std::int64_t device, const std::string& name);

  // Whether a code is open or somebody who guessed has to wait: both are forgotten with this.
  [[nodiscard]] bool awaits_pairing(const Now& now);

  [[nodiscard]] std::vector<PairedDevice> devices() const;  // by number
  [[nodiscard]] const std::string& fingerprint() const { return fingerprint_; }

 private:
  struct Entry {
    PairedDevice device;
    std::string token_hash;      // SHA-256, hexadecimal
    std::int64_t stored_seen_s;  // last_seen_s as the file has it
  };

  AccessRegister(home::WriterLock lock, home::Database database, std::string fingerprint)
      : fingerprint_(std::move(fingerprint)),
        lock_(std::move(lock)),
        database_(std::move(database)) {}
  [[nodiscard]] Expected<void> load();
  [[nodiscard]] tl::expected<Pairing, PairingRefusal> redeem_secret(const PairingAttempt& attempt,
                                                                    const Now& now);
  [[nodiscard]] Expected<Pairing> add(Role role, const std::string& name, const Now& now);

  const std::string fingerprint_;
  const home::WriterLock lock_;  // what is read once must not be changed by another process
  // A proof takes a while to check, during which devices that are paired must not wait: so codes
  // have a lock of their own. Where both are taken, this one is first.
  std::mutex guard_mutex_;
  PairingGuard guard_;
  mutable std::mutex mutex_;
  home::Database database_;
  std::vector<Entry> entries_;  // by number
};

}  // namespace roomwise::service
