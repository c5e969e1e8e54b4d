#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "roomwise/base/expected.h"
#include "roomwise/service/access/pairing_guard.h"
#include "roomwise/service/credentials/identity.h"

namespace roomwise::service {

// What somebody sends who wants to be paired: the code itself, or a proof of knowing it.
struct PairingAttempt {
  std::string code = {};       // "123456"; empty where there is a proof or a secret
  std::string secret = {};     // of a link
  std::string nonce = {};      // chosen by the device, 32 hexadecimal digits or more
  std::string proof = {};      // hexadecimal; see pairing_proof.h
  bool proves_secret = false;  // and not the digits
  std::string name = {};       // that the device gives itself: "Anna's phone"
  std::string home = {};       // that it asks for, of several
  std::string peer = {};       // that it comes from; see peer_key
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

// A name that can be spoken, shown and logged on one line.
[[nodiscard]] bool is_device_name(std::string_view name);

// How many proofs of digits are worked out at once: each takes a processor for half a second, and
// whoever finds no place is told so and does not wait for one with a thread. Thread-safe.
class ProofPlaces {
 public:
  using Place = std::shared_ptr<void>;  // given back when it goes
  explicit ProofPlaces(int places) : left_(std::make_shared<std::atomic<int>>(places)) {}
  // Nullptr where all are taken.
  [[nodiscard]] Place take();

 private:
  std::shared_ptr<std::atomic<int>> left_;
};

// Wrong digits by home and peer, for the doors of homes of which nobody learns whether they are
// there: so they are counted, kept and forgotten at names that are nobody's as at others. Bounded:
// where all that are kept have to wait, a new one is heard, since otherwise who guesses at invented
// names would keep others from their homes; a door still counts those of all. Thread-safe.
class PeerGuesses {
 public:
  [[nodiscard]] double wait_s(const PairingAttempt& attempt, const Now& now);
  // PairingGuard::is_known().
  [[nodiscard]] bool is_known(const PairingAttempt& attempt, const Now& now);
  void wrong(const PairingAttempt& attempt, const Now& now);
  void right(const PairingAttempt& attempt);

 private:
  std::mutex mutex_;
  PairingGuard guard_;  // without codes
};

struct PairingDoorOptions {
  // Of the computer's certificate, which proofs are bound to.
  std::string fingerprint;
  // Makes it the door of a home among others, of which nobody learns here whether it is there, or
  // has a code open: a wrong attempt gets the same answer after the same work as at a door without
  // codes. So those are told nothing who have to wait for what others guessed: their digits are
  // wrong. Shared by all such doors; empty: the door has one home, and tells.
  std::shared_ptr<PeerGuesses> guesses = {};
  // A place for a proof of digits by that peer, held while it is worked out, or how long until
  // there may be one, s. Empty: the door has one place.
  std::function<tl::expected<ProofPlaces::Place, double>(const std::string& peer, const Now&)>
      proof_place = {};
};

// Where a home's codes are open and attempts at them are judged. Thread-safe. Times are passed in.
//
// Attempts are judged side by side, since a proof takes a while in which nobody else should wait.
// What comes of one is said only once it was counted, one after the other: where its peer has to
// wait by then, or its code is gone, it was not heard. So many at once learn no more than as many
// in turn.
class PairingDoor {
 public:
  explicit PairingDoor(PairingDoorOptions options) : options_(std::move(options)) {}

  // A new code: redeemed once, within kCodeValid_s. While guessing is answered by waiting, only its
  // secret is heard.
  // `maker`: the device, or of staff the number below zero, that asked for it; 0: the computer.
  [[nodiscard]] Expected<OpenCode> make_code(Role role, const Now& now, std::int64_t maker = 0);
  // How long digits are not heard from anybody.
  [[nodiscard]] double digits_wait_s(const Now& now);
  // Whether a code is open.
  [[nodiscard]] bool has_codes(const Now& now);

  // Whoever knows an open code is let in by `add`, which gives nothing where its maker may make
  // none any more: then the code is void.
  using Add = std::function<Expected<std::optional<Pairing>>(Role role, const std::string& name,
                                                             std::int64_t maker)>;
  [[nodiscard]] tl::expected<Pairing, Refusal> redeem(const PairingAttempt& attempt, const Now& now,
                                                      const Add& add);

 private:
  using Code = PairingGuard::Code;
  struct Judged;
  [[nodiscard]] tl::expected<Pairing, Refusal> redeem_secret(const PairingAttempt& attempt,
                                                             const Now& now, const Add& add);
  [[nodiscard]] tl::expected<Pairing, Refusal> redeem_digits(const PairingAttempt& attempt,
                                                             const Now& now, const Add& add);
  [[nodiscard]] Expected<Judged> judge(std::vector<Code> codes,
                                       const PairingAttempt& attempt) const;
  // The same, with a place for what takes a while.
  [[nodiscard]] tl::expected<Judged, Refusal> judge_digits(std::vector<Code> codes,
                                                           const PairingAttempt& attempt,
                                                           const Now& now);
  [[nodiscard]] tl::expected<ProofPlaces::Place, double> place_for(const std::string& peer,
                                                                   const Now& now);
  // How long that peer's digits are not heard, s. With guard_mutex_ held, as the next.
  [[nodiscard]] double wait_s(const PairingAttempt& attempt, const Now& now) const;
  [[nodiscard]] bool hears(const PairingAttempt& attempt, const Now& now) const;
  // Counts what came of an attempt at digits: the code that is redeemed by it.
  [[nodiscard]] tl::expected<Code, Refusal> count_digits(const PairingAttempt& attempt,
                                                         const Judged& judged, const Now& now);
  // Lets them in who know the code that was taken for them.
  [[nodiscard]] tl::expected<Pairing, Refusal> let_in(const PairingAttempt& attempt, Code code,
                                                      std::string proof, const Now& now,
                                                      const Add& add);

  const PairingDoorOptions options_;
  ProofPlaces places_{1};
  std::mutex guard_mutex_;  // held for as long as nothing is worked out
  PairingGuard guard_;
};

}  // namespace roomwise::service
