#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <string>

#include "roomwise/base/expected.h"
#include "roomwise/service/identity.h"
#include "roomwise/service/pairing_guard.h"

namespace roomwise::service {

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

// A name that can be spoken, shown and logged on one line.
[[nodiscard]] bool is_device_name(std::string_view name);

struct PairingDoorOptions {
  // Of the computer's certificate, which proofs are bound to.
  std::string fingerprint;
  // Of a home among others, of which nobody learns here whether it is there, or has a code open: a
  // wrong attempt gets the same answer after the same work as at a door without codes. So those are
  // told nothing who have to wait for what others guessed: their digits are wrong.
  bool is_secret = false;
  // How long until a proof of digits by that peer may be checked, s, which takes half a
  // second where is_secret; 0: now. Empty: always.
  std::function<double(const std::string& peer, const Now&)> proof_wait_s = {};
};

// Where a home's codes are open and attempts at them are judged. Thread-safe. Times are passed in.
class PairingDoor {
 public:
  explicit PairingDoor(PairingDoorOptions options) : options_(std::move(options)) {}

  // A new code: redeemed once, within kCodeValid_s. While guessing is answered by waiting, only its
  // secret is heard.
  [[nodiscard]] Expected<OpenCode> make_code(Role role, const Now& now);
  // How long digits are not heard from anybody.
  [[nodiscard]] double digits_wait_s(const Now& now);
  // Whether a code is open; whether one is or somebody who guessed has to wait.
  [[nodiscard]] bool has_codes(const Now& now);
  [[nodiscard]] bool awaits_pairing(const Now& now);

  // Whoever knows an open code is let in by `add`.
  using Add = std::function<Expected<Pairing>(Role role, const std::string& name)>;
  [[nodiscard]] tl::expected<Pairing, PairingRefusal> redeem(const PairingAttempt& attempt,
                                                             const Now& now, const Add& add);

 private:
  using Code = PairingGuard::Code;
  struct Judged;
  [[nodiscard]] tl::expected<Pairing, PairingRefusal> redeem_secret(const PairingAttempt& attempt,
                                                                    const Now& now, const Add& add);
  [[nodiscard]] tl::expected<Pairing, PairingRefusal> redeem_digits(const PairingAttempt& attempt,
                                                                    const Now& now, const Add& add);
  [[nodiscard]] Expected<Judged> judge(std::vector<Code> codes,
                                       const PairingAttempt& attempt) const;

  const PairingDoorOptions options_;
  // Attempts are judged one after the other, or those that come at once would all be heard before
  // one of them counts. Proofs take a while, in which others that ask about codes must not wait.
  std::mutex attempt_mutex_;  // before the other
  std::mutex guard_mutex_;
  PairingGuard guard_;
};

}  // namespace roomwise::service
