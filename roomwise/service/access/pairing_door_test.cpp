#include "roomwise/service/access/pairing_door.h"

#include <gtest/gtest.h>

#include "roomwise/service/credentials/pairing_proof.h"
#include "roomwise/service/credentials/secrets.h"

namespace roomwise::service {
namespace {

using Place = tl::expected<ProofPlaces::Place, double>;

class PairingDoorTest : public ::testing::Test {
 protected:
  // What is done while a proof is worked out: after its place was taken, and before it is given
  // back.
  std::function<void()> at_begin_ = [] {}, at_end_ = [] {};

  std::unique_ptr<PairingDoor> door(bool is_secret = false) {
    PairingDoorOptions options;
    options.fingerprint = std::string(64, 'a');
    if (is_secret) options.guesses = guesses_;
    options.proof_place = [this](const std::string&, const Now&) -> Place {
      std::exchange(at_begin_, [] {})();
      return ProofPlaces::Place(this, [](void* test) {
        std::exchange(static_cast<PairingDoorTest*>(test)->at_end_, [] {})();
      });
    };
    return std::make_unique<PairingDoor>(std::move(options));
  }
  int ask(PairingDoor& door, PairingAttempt attempt) {
    attempt.name = "Anna's phone";
    const auto add = [&](Role role, const std::string& name, std::int64_t maker) {
      using Added = Expected<std::optional<Pairing>>;
      return maker == gone_ ? Added(std::nullopt) : Added(Pairing{{1, name, role}, "token", ""});
    };
    const auto pairing = door.redeem(attempt, now_, add);
    return pairing ? 200 : pairing.error().status;
  }
  int prove(PairingDoor& door, const std::string& digits, const std::string& peer = "10.0.0.1") {
    const std::string nonce(32, '1');
    const auto proof = make_pairing_proof(digits, std::string(64, 'a'), nonce).value();
    return ask(door, {.nonce = nonce, .proof = proof.device, .peer = peer});
  }
  int guess(PairingDoor& door, const OpenCode& code, const std::string& peer) {
    const std::string other = fmt::format("{:06}", (std::stoi(code.digits) + 1) % 1'000'000);
    return ask(door, {.code = other, .peer = peer});
  }
  OpenCode open_code(PairingDoor& door) { return door.make_code(Role::kDevice, now_).value(); }

  static constexpr std::int64_t gone_ = 66;  // a maker of codes who may make none any more
  const std::shared_ptr<PeerGuesses> guesses_ = std::make_shared<PeerGuesses>();
  Now now_{1000, 1'700'000'000};
};

TEST_F(PairingDoorTest, WhileAProofIsWorkedOutOthersAreHeard) {
  const auto open = door();
  const OpenCode code = open_code(*open), by_link = open_code(*open);
  const auto others = [&] {
    EXPECT_EQ(ask(*open, {.secret = std::string(kSecretLength, 'A')}), 401);
    EXPECT_EQ(guess(*open, code, "10.0.0.2"), 401);
    EXPECT_TRUE(open->has_codes(now_));
  };
  at_begin_ = [&] {
    others();
    EXPECT_EQ(ask(*open, {.secret = by_link.secret}), 200);
  };
  at_end_ = others;
  EXPECT_EQ(prove(*open, code.digits), 200);
}

// Many at once are not heard more often than many in turn.
TEST_F(PairingDoorTest, AProofThatOtherGuessesOvertookIsNotHeard) {
  for (const bool is_secret : {false, true}) {
    const auto open = door(is_secret);
    const OpenCode code = open_code(*open);
    at_end_ = [&] {
      for (int i = 0; i < 3; ++i) EXPECT_EQ(guess(*open, code, "10.0.0.1"), 401);
    };
    EXPECT_EQ(prove(*open, code.digits, "10.0.0.1"), 429) << "its own";
    at_end_ = [&] {
      for (int i = 0; i < 2; ++i) EXPECT_EQ(guess(*open, code, "10.0.0.2"), 401);
    };
    EXPECT_EQ(prove(*open, code.digits, "10.0.0.3"), is_secret ? 401 : 429) << "those of all";
    EXPECT_EQ(ask(*open, {.secret = code.secret}), 200) << "its link is open";
  }
}

TEST_F(PairingDoorTest, ACodeThatALinkRedeemedMeanwhileIsNoLongerValid) {
  const auto open = door();
  const OpenCode code = open_code(*open);
  at_end_ = [&] { EXPECT_EQ(ask(*open, {.secret = code.secret}), 200); };
  EXPECT_EQ(prove(*open, code.digits), 401);
}

TEST_F(PairingDoorTest, ACodeLetsInOneThoughOthersAskMeanwhile) {
  const auto open = door();
  const OpenCode code = open_code(*open);
  const PairingAttempt attempt{.secret = code.secret, .name = "Anna's phone"};
  const auto full = open->redeem(attempt, now_, [&](Role, const std::string&, std::int64_t) {
    EXPECT_EQ(ask(*open, {.secret = code.secret}), 401);
    return Expected<std::optional<Pairing>>(fail("there are too many devices"));
  });
  EXPECT_EQ(full.error().status, 500);
  EXPECT_EQ(ask(*open, {.code = code.digits, .peer = "10.0.0.1"}), 200) << "it is open again";
}

TEST_F(PairingDoorTest, ACodeOfWhoMayMakeNoneAnyMoreIsAnsweredLikeAWrongOne) {
  for (const bool is_secret : {false, true}) {
    const auto open = door(is_secret);
    const auto make = [&] { return open->make_code(Role::kHelper, now_, gone_).value(); };
    EXPECT_EQ(ask(*open, {.secret = make().secret}), 401);
    EXPECT_EQ(ask(*open, {.code = make().digits, .peer = "10.0.0.1"}), 401);
    EXPECT_EQ(prove(*open, make().digits), 401);
    EXPECT_FALSE(open->has_codes(now_));
  }
}

TEST_F(PairingDoorTest, AProofForWhichThereIsNoPlaceIsSentAwayAtOnce) {
  ProofPlaces places(2);
  ProofPlaces::Place first = places.take();
  const ProofPlaces::Place second = places.take();
  EXPECT_TRUE(first);
  EXPECT_TRUE(second);
  EXPECT_FALSE(places.take());
  PairingDoor open({.fingerprint = std::string(64, 'a'),
                    .proof_place = [&](const std::string&, const Now&) -> Place {
                      if (auto place = places.take()) return place;
                      return tl::unexpected(1.0);
                    }});
  const OpenCode code = open_code(open);
  for (int i = 0; i < 9; ++i) EXPECT_EQ(prove(open, code.digits), 429) << "it is no guess";
  EXPECT_EQ(ask(open, {.secret = std::string(kSecretLength, 'A')}), 401) << "a link needs none";
  first.reset();
  EXPECT_EQ(prove(open, code.digits), 200);
  EXPECT_TRUE(places.take()) << "it was given back";
}

// Guesses at invented names fill what is kept: answers at a home with a code go on as at names
// that are nobody's, and its digits are void after five as ever.
TEST_F(PairingDoorTest, ANameWithCodesAnswersLikeOthersHoweverManyNamesWereGuessedAt) {
  const auto home = door(/*is_secret=*/true), nobodys = door(/*is_secret=*/true);
  const OpenCode code = open_code(*home);
  const std::string wrong = fmt::format("{:06}", (std::stoi(code.digits) + 1) % 1'000'000);
  const auto answers = [&](PairingDoor& at, const std::string& name, const std::string& peer) {
    std::vector<int> all;
    for (int i = 0; i < 4; ++i) all.push_back(ask(at, {.code = wrong, .home = name, .peer = peer}));
    return all;
  };
  EXPECT_EQ(answers(*home, "flat-1", "10.0.0.1"), (std::vector{401, 401, 401, 429}));
  EXPECT_EQ(answers(*nobodys, "none", "10.0.0.1"), (std::vector{401, 401, 401, 429}));
  for (int i = 0; i < 2000; ++i) (void)answers(*nobodys, std::to_string(i), "10.0.0.2");
  EXPECT_EQ(answers(*home, "flat-1", "10.0.0.1"), (std::vector{429, 429, 429, 429}));
  EXPECT_EQ(answers(*nobodys, "none", "10.0.0.1"), (std::vector{429, 429, 429, 429}));
  EXPECT_EQ(ask(*home, {.code = code.digits, .home = "flat-1", .peer = "10.0.0.3"}), 200);
  const OpenCode second = open_code(*home);
  EXPECT_EQ(answers(*home, "flat-1", "10.0.0.3"), answers(*nobodys, "none", "10.0.0.3"));
  EXPECT_EQ(answers(*home, "flat-1", "10.0.0.4"), answers(*nobodys, "none", "10.0.0.4"));
  EXPECT_EQ(ask(*home, {.code = second.digits, .home = "flat-1", .peer = "10.0.0.5"}), 401);
}

TEST_F(PairingDoorTest, OneAddressThatGoesOnGuessingVoidsNoDigits) {
  for (const bool is_secret : {false, true}) {
    const auto home = door(is_secret);
    const OpenCode code = open_code(*home);
    int refused = 0;
    for (const double wait_s : {30.0, 60.0, 120.0, 0.0}) {
      for (int i = 0; i < 3; ++i) refused += guess(*home, code, "10.0.0.1") == 401 ? 0 : 1;
      now_.steady_s += wait_s;
    }
    EXPECT_EQ(refused > 0, !is_secret) << "a secret door tells nobody to wait for all";
    EXPECT_EQ(ask(*home, {.code = code.digits, .peer = "10.0.0.2"}), 200);
  }
}

}  // namespace
}  // namespace roomwise::service
