#include "roomwise/service/access/pairing_door.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "roomwise/base/encodings.h"
#include "roomwise/base/name.h"
#include "roomwise/service/credentials/pairing_proof.h"
#include "roomwise/service/credentials/secrets.h"

namespace roomwise::service {
namespace {

Refusal refusal_to_wait(double seconds) {
  const auto wait_s = static_cast<std::int64_t>(std::ceil(seconds));
  return {429, fmt::format("too many wrong codes; wait {} s, then ask for a new code", wait_s),
          wait_s, "many_codes"};
}

Refusal refusal_of_proof(double seconds) {
  const auto wait_s = static_cast<std::int64_t>(std::ceil(seconds));
  return {429, fmt::format("too many proofs at once; try again in {} s", wait_s), wait_s};
}

tl::unexpected<Refusal> refuse(int status, std::string message, std::string key = {}) {
  return tl::unexpected(Refusal{status, std::move(message), 0, std::move(key)});
}

bool is_by_secret(const PairingAttempt& attempt) {
  return attempt.proves_secret || !attempt.secret.empty();
}

tl::unexpected<Refusal> refuse_code(const PairingAttempt& attempt) {
  return is_by_secret(attempt)
             ? refuse(401, "the link is no longer valid; ask for a new one", "link_over")
             : refuse(401, "the code is wrong or no longer valid; ask for a new one", "code_over");
}

std::string guesser(const PairingAttempt& attempt) {
  return fmt::format("{} {}", attempt.home, attempt.peer);
}

bool is_code(std::string_view code) {
  return code.size() == 6 && std::ranges::all_of(code, [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

bool is_device_name(std::string_view name) {
  return name.size() <= 64 && is_name(name);
}

ProofPlaces::Place ProofPlaces::take() {
  int left = left_->load();
  while (left > 0 && !left_->compare_exchange_weak(left, left - 1)) continue;
  if (left <= 0) return nullptr;
  return {left_.get(), [kept = left_](void*) { ++*kept; }};
}

double PeerGuesses::wait_s(const PairingAttempt& attempt, const Now& now) {
  const std::string key = guesser(attempt);
  const std::scoped_lock lock(mutex_);
  return guard_.counts(key) ? guard_.own_wait_s(key, now.steady_s) : 0;
}

bool PeerGuesses::is_known(const PairingAttempt& attempt, const Now& now) {
  const std::scoped_lock lock(mutex_);
  return guard_.is_known(guesser(attempt), now.steady_s);
}

void PeerGuesses::wrong(const PairingAttempt& attempt, const Now& now) {
  const std::scoped_lock lock(mutex_);
  guard_.wrong(guesser(attempt), now.steady_s);
}

void PeerGuesses::right(const PairingAttempt& attempt) {
  const std::scoped_lock lock(mutex_);
  guard_.right(guesser(attempt), "");
}

// The code that was meant, and the computer's own proof of it.
struct PairingDoor::Judged {
  std::optional<Code> known;
  std::string proof;
};

Expected<OpenCode> PairingDoor::make_code(Role role, const Now& now, std::int64_t maker) {
  const std::scoped_lock lock(guard_mutex_);
  ROOMWISE_TRY(std::string digits, random_code());
  ROOMWISE_TRY(const Bytes random, random_bytes(16));
  OpenCode code{std::move(digits), base64url(random)};
  guard_.open({code.digits, code.secret, role, now.steady_s + kCodeValid_s, maker}, now.steady_s);
  return code;
}

double PairingDoor::digits_wait_s(const Now& now) {
  const std::scoped_lock lock(guard_mutex_);
  return guard_.wait_s(now.steady_s);
}

bool PairingDoor::has_codes(const Now& now) {
  const std::scoped_lock lock(guard_mutex_);
  return !guard_.codes(now.steady_s).empty();
}

// All codes are compared, and where the door is secret as many as there can be, so that the time
// tells nothing.
Expected<PairingDoor::Judged> PairingDoor::judge(std::vector<Code> codes,
                                                 const PairingAttempt& attempt) const {
  const bool by_secret = is_by_secret(attempt);
  const bool by_proof = by_secret ? attempt.proves_secret : !attempt.proof.empty();
  const std::size_t open = codes.size();
  if (options_.guesses) {
    // Proven like others, and never right: they have no digits, and nobody knows the secret.
    codes.resize(std::max(open, PairingGuard::kMaxCodes),
                 Code{"none", std::string(kSecretLength, '-'), Role::kDevice, 0, 0});
  }
  Judged judged;
  for (std::size_t i = 0; i < codes.size(); ++i) {
    const Code& code = codes[i];
    const std::string& known_by = by_secret ? code.secret : code.digits;
    bool is_right = false;
    std::string proof;
    if (by_proof) {
      ROOMWISE_TRY(const PairingProof ours,
                   by_secret ? make_secret_proof(known_by, options_.fingerprint, attempt.nonce)
                             : make_pairing_proof(known_by, options_.fingerprint, attempt.nonce));
      is_right = equal_secrets(ours.device, attempt.proof);
      proof = ours.computer;
    } else {
      is_right = equal_secrets(known_by, by_secret ? attempt.secret : attempt.code);
    }
    if (i < open && is_right) judged = {code, std::move(proof)};
  }
  return judged;
}

tl::expected<PairingDoor::Judged, Refusal> PairingDoor::judge_digits(std::vector<Code> codes,
                                                                     const PairingAttempt& attempt,
                                                                     const Now& now) {
  ProofPlaces::Place place;  // until it is judged
  if (!attempt.proof.empty()) {
    auto given = place_for(attempt.peer, now);
    if (!given) return tl::unexpected(refusal_of_proof(given.error()));
    place = *std::move(given);
  }
  Expected<Judged> judged = judge(std::move(codes), attempt);
  if (!judged) return refuse(400, judged.error().message);
  return *std::move(judged);
}

tl::expected<ProofPlaces::Place, double> PairingDoor::place_for(const std::string& peer,
                                                                const Now& now) {
  if (options_.proof_place) return options_.proof_place(peer, now);
  if (ProofPlaces::Place place = places_.take()) return place;
  return tl::unexpected(1.0);
}

tl::expected<Pairing, Refusal> PairingDoor::let_in(const PairingAttempt& attempt, Code code,
                                                   std::string proof, const Now& now,
                                                   const Add& add) {
  Expected<std::optional<Pairing>> pairing = add(code.role, attempt.name, code.maker);
  if (!pairing) {
    const std::scoped_lock lock(guard_mutex_);
    guard_.put_back(std::move(code), now.steady_s);
    return refuse(500, pairing.error().message);
  }
  if (!*pairing) return refuse_code(attempt);
  (*pairing)->proof = std::move(proof);
  return **std::move(pairing);
}

tl::expected<Pairing, Refusal> PairingDoor::redeem_secret(const PairingAttempt& attempt,
                                                          const Now& now, const Add& add) {
  std::vector<Code> codes;
  {
    const std::scoped_lock lock(guard_mutex_);
    codes = guard_.codes(now.steady_s);
  }
  Expected<Judged> judged = judge(std::move(codes), attempt);
  if (!judged) return refuse(400, judged.error().message);
  std::optional<Code> code;
  if (judged->known) {
    const std::scoped_lock lock(guard_mutex_);
    code = guard_.take(judged->known->secret, now.steady_s);
  }
  if (!code) return refuse_code(attempt);
  return let_in(attempt, *std::move(code), std::move(judged->proof), now, add);
}

double PairingDoor::wait_s(const PairingAttempt& attempt, const Now& now) const {
  return options_.guesses ? options_.guesses->wait_s(attempt, now)
                          : guard_.wait_s(attempt.peer, now.steady_s);
}

// Where it is told nothing it may have to wait all the same.
bool PairingDoor::hears(const PairingAttempt& attempt, const Now& now) const {
  const bool is_known = options_.guesses && options_.guesses->is_known(attempt, now);
  return (is_known ? guard_.wait_of_known_s(now.steady_s) : guard_.wait_s(now.steady_s)) == 0;
}

tl::expected<PairingDoor::Code, Refusal> PairingDoor::count_digits(const PairingAttempt& attempt,
                                                                   const Judged& judged,
                                                                   const Now& now) {
  if (const double wait = wait_s(attempt, now); wait > 0) {
    return tl::unexpected(refusal_to_wait(wait));
  }
  std::optional<Code> code;
  if (judged.known && hears(attempt, now)) {
    code = guard_.take(judged.known->secret, now.steady_s);
  }
  if (!code) {
    if (options_.guesses) {
      guard_.wrong_of(options_.guesses->is_known(attempt, now), now.steady_s);
      options_.guesses->wrong(attempt, now);
    } else {
      guard_.wrong(attempt.peer, now.steady_s);
    }
    return refuse_code(attempt);
  }
  if (options_.guesses) options_.guesses->right(attempt);
  guard_.right(attempt.peer, code->digits);
  return *std::move(code);
}

tl::expected<Pairing, Refusal> PairingDoor::redeem_digits(const PairingAttempt& attempt,
                                                          const Now& now, const Add& add) {
  if (attempt.proof.empty() && !is_code(attempt.code)) {
    return refuse(400, "'code' must be the six digits that the computer shows");
  }
  std::vector<Code> codes;
  {
    const std::scoped_lock lock(guard_mutex_);
    if (const double wait = wait_s(attempt, now); wait > 0) {
      return tl::unexpected(refusal_to_wait(wait));
    }
    if (hears(attempt, now)) codes = guard_.codes(now.steady_s);
  }
  std::erase_if(codes, [](const Code& code) { return code.digits.empty(); });
  auto judged = judge_digits(std::move(codes), attempt, now);
  if (!judged) return tl::unexpected(std::move(judged).error());
  tl::expected<Code, Refusal> code;
  {
    const std::scoped_lock lock(guard_mutex_);
    code = count_digits(attempt, *judged, now);
  }
  if (!code) return tl::unexpected(std::move(code).error());
  return let_in(attempt, *std::move(code), std::move(judged->proof), now, add);
}

tl::expected<Pairing, Refusal> PairingDoor::redeem(const PairingAttempt& attempt, const Now& now,
                                                   const Add& add) {
  if (!is_device_name(attempt.name)) {
    return refuse(400,
                  "'name' must be a name of 1 to 64 bytes on one line, with a letter or digit");
  }
  return is_by_secret(attempt) ? redeem_secret(attempt, now, add)
                               : redeem_digits(attempt, now, add);
}

}  // namespace roomwise::service
