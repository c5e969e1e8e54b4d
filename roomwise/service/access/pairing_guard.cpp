#include "roomwise/service/access/pairing_guard.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

namespace roomwise::service {
namespace {
constexpr std::size_t kMaxPeers = 1024;
constexpr int kWrongOfAll = 5;
constexpr int kWrongOfPeer = 3;
constexpr double kFirstWait_s = 30;
constexpr double kLongestWait_s = 3600;
constexpr double kForgotten_s = 86400;
}  // namespace

Now Now::read() {
  using std::chrono::duration;
  using std::chrono::duration_cast;
  return {duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(),
          duration_cast<std::chrono::seconds>(std::chrono::system_clock::now().time_since_epoch())
              .count()};
}

void PairingGuard::open(Code code, double now_s) {
  codes_ = codes(now_s);
  if (codes_.size() >= kMaxCodes) codes_.erase(codes_.begin());
  codes_.push_back(std::move(code));
}

double PairingGuard::wait_s(double now_s) const {
  return std::max(0.0, all_.until_s - now_s);
}

double PairingGuard::own_wait_s(const std::string& peer, double now_s) const {
  const auto found = peers_.find(peer);
  if (found == peers_.end()) return wait_for_room_s(now_s);
  const double until_s = is_known(peer, now_s) ? std::max(known_.until_s, found->second.until_s)
                                               : found->second.until_s;
  return std::max(0.0, until_s - now_s);
}

bool PairingGuard::is_known(const std::string& peer, double now_s) const {
  const auto found = peers_.find(peer);
  return found != peers_.end() && found->second.waits > 0 && !is_old(found->second, now_s);
}

double PairingGuard::wait_of_known_s(double now_s) const {
  return std::max(wait_s(now_s), known_.until_s - now_s);
}

double PairingGuard::wait_s(const std::string& peer, double now_s) const {
  return std::max(own_wait_s(peer, now_s), wait_s(now_s));
}

double PairingGuard::wait_for_room_s(double now_s) const {
  if (peers_.size() < kMaxPeers) return 0;
  const auto first =
      std::ranges::min_element(peers_, {}, [](const auto& entry) { return entry.second.until_s; });
  return std::max(0.0, first->second.until_s - now_s);
}

std::vector<PairingGuard::Code> PairingGuard::codes(double now_s) {
  std::erase_if(codes_, [&](const Code& code) { return code.until_s <= now_s; });
  return codes_;
}

void PairingGuard::right(const std::string& peer, std::string_view digits) {
  std::erase_if(codes_, [&](const Code& code) { return code.digits == digits; });
  peers_.erase(peer);
  all_ = {};
}

std::optional<PairingGuard::Code> PairingGuard::take(std::string_view secret, double now_s) {
  codes_ = codes(now_s);
  const auto found = std::ranges::find(codes_, secret, &Code::secret);
  if (found == codes_.end()) return std::nullopt;
  Code code = std::move(*found);
  codes_.erase(found);
  return code;
}

void PairingGuard::put_back(Code code, double now_s) {
  if (codes(now_s).size() >= kMaxCodes) return;
  if (wait_s(now_s) > 0) code.digits.clear();
  codes_.insert(codes_.begin(), std::move(code));
}

void PairingGuard::wrong(const std::string& peer, double now_s) {
  const bool was_known = is_known(peer, now_s);
  if (Guesses* const own = of(peer, now_s)) count(*own, kWrongOfPeer, now_s);
  wrong_of(was_known, now_s);
}

void PairingGuard::wrong_of(bool is_known, double now_s) {
  if (wait_s(now_s) > 0) return;
  // Where nothing can be guessed, guessing must not lock others out.
  const auto open = codes(now_s);
  if (std::ranges::all_of(open, [](const Code& code) { return code.digits.empty(); })) return;
  count(is_known ? known_ : all_, kWrongOfAll, now_s);
  if (wait_s(now_s) == 0) return;
  for (Code& code : codes_) code.digits.clear();
}

bool PairingGuard::is_old(const Guesses& guesses, double now_s) {
  return now_s - guesses.last_s > kForgotten_s;
}

void PairingGuard::count(Guesses& guesses, int most, double now_s) {
  if (is_old(guesses, now_s)) guesses = {};
  guesses.last_s = now_s;
  if (++guesses.wrong < most) return;
  guesses.wrong = 0;
  guesses.until_s =
      now_s + std::min(kLongestWait_s, kFirstWait_s * std::exp2(std::min(guesses.waits++, 16)));
}

PairingGuard::Guesses* PairingGuard::of(const std::string& peer, double now_s) {
  if (!peers_.contains(peer) && peers_.size() >= kMaxPeers) {
    // Whoever invents peers must not end the wait of one.
    if (wait_for_room_s(now_s) > 0) return nullptr;
    peers_.erase(std::ranges::min_element(peers_, {}, [&](const auto& entry) {
      return std::pair(entry.second.until_s > now_s, entry.second.last_s);
    }));
  }
  return &peers_.try_emplace(peer, Guesses{.last_s = now_s}).first->second;
}

}  // namespace roomwise::service
