#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/service/credentials/identity.h"

namespace roomwise::service {

// The two clocks, read at once: a steady one for waiting, and that of the calendar for people.
struct Now {
  double steady_s = 0;
  std::int64_t unix_s = 0;

  [[nodiscard]] static Now read();
};

inline constexpr double kCodeValid_s = 300;

// The open codes, and how often they may be guessed at. Six digits are guessed in half a million
// tries; so there are few tries: each peer has three, then it waits, and after five wrong ones of
// all peers together the digits of every open code are void and nobody is heard for a while. Waits
// double each time. A peer that had to wait is known for a day to guess: what it guesses then locks
// nobody else out, but after five wrong ones of all who are known none of them is heard for a
// while. So one address costs its neighbours nothing, and many get no more than twice the tries. A
// code's secret, which comes by a link or a QR code, cannot be guessed: it is neither counted nor
// made to wait, so that whoever guesses digits, also from the same address, keeps nobody out. Knows
// nothing of what a guess looks like. Not thread-safe.
class PairingGuard {
 public:
  struct Code {
    std::string digits;  // empty: void
    std::string secret;
    Role role = Role::kDevice;
    double until_s = 0;
    std::int64_t maker = 0;  // device that it was made for, of staff below 0; 0: the computer
  };

  static constexpr std::size_t kMaxCodes = 4;
  // Takes a code; the oldest goes where too many are open.
  void open(Code code, double now_s);
  // How long nobody is heard any more, or (with a peer) that one is not; 0: guess.
  [[nodiscard]] double wait_s(double now_s) const;
  [[nodiscard]] double wait_s(const std::string& peer, double now_s) const;
  // How long that peer is not heard because of what it, or others who are known, guessed.
  [[nodiscard]] double own_wait_s(const std::string& peer, double now_s) const;
  // The codes that can be redeemed now.
  [[nodiscard]] std::vector<Code> codes(double now_s);
  // What came of a guess.
  void right(const std::string& peer, std::string_view digits);
  // Takes a code away, which is known by its secret; nothing where it is no longer open.
  [[nodiscard]] std::optional<Code> take(std::string_view secret, double now_s);
  // Opens again what was taken, where there is room.
  void put_back(Code code, double now_s);
  // While nobody is heard it counts against its peer alone.
  void wrong(const std::string& peer, double now_s);
  // The same where somebody else counts its peer's, and knows whether it is known.
  void wrong_of(bool is_known, double now_s);
  // Whether that peer had to wait already, not longer ago than a day.
  [[nodiscard]] bool is_known(const std::string& peer, double now_s) const;
  // How long those who are known are not heard, nor anybody else where nobody is.
  [[nodiscard]] double wait_of_known_s(double now_s) const;

  // Bounded: who waits is kept until the wait is over, and nobody new is heard where all wait.
  [[nodiscard]] std::size_t peers() const { return peers_.size(); }
  [[nodiscard]] bool counts(const std::string& peer) const { return peers_.contains(peer); }

 private:
  struct Guesses {
    int wrong = 0;
    int waits = 0;  // so far: each is twice as long
    double until_s = 0;
    double last_s = 0;
  };
  [[nodiscard]] static bool is_old(const Guesses& guesses, double now_s);
  static void count(Guesses& guesses, int most, double now_s);
  // The peer's, or nullptr where there is no room for one more.
  [[nodiscard]] Guesses* of(const std::string& peer, double now_s);
  [[nodiscard]] double wait_for_room_s(double now_s) const;

  std::vector<Code> codes_;
  Guesses all_;    // of all who are not known
  Guesses known_;  // of all who are
  std::map<std::string, Guesses> peers_;
};

}  // namespace roomwise::service
