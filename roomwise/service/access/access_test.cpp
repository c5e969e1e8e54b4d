#include "roomwise/service/access/access.h"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <set>

#include "roomwise/base/testing/testing.h"
#include "roomwise/service/access/rate_limit.h"
#include "roomwise/service/credentials/pairing_proof.h"
#include "roomwise/service/credentials/secrets.h"

namespace roomwise::service {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string kFingerprint(64, 'a');
const std::string kNonce(32, '1');

class AccessTest : public ::testing::Test {
 protected:
  AccessTest() { open(); }
  void open() {
    access_.reset();
    auto opened = AccessRegister::open(folder_ / "flat.home.access", kFingerprint);
    ASSERT_OK(opened);
    access_ = *std::move(opened);
  }
  OpenCode open_code(Role role = Role::kDevice) { return access_->make_code(role, now_).value(); }
  std::string code(Role role = Role::kDevice) { return open_code(role).digits; }
  auto redeem(const std::string& code, const std::string& peer = "10.0.0.1") {
    return access_->redeem({.code = code, .name = "Anna's phone", .peer = peer}, now_);
  }
  int status(const std::string& code, const std::string& peer = "10.0.0.1") {
    const auto pairing = redeem(code, peer);
    return pairing ? 200 : pairing.error().status;
  }
  static std::string other_than(const std::string& code) {
    return fmt::format("{:06}", (std::stoi(code) + 1) % 1'000'000);
  }

  // Names that nobody can be told, or that look like others.
  const std::vector<std::string> unfit_{
      "", "a\nb", "   ", "\u200b", "\u202eevil", "a\u0085b", "a\u009b31mb", std::string(65, 'a')};
  roomwise::testing::ScratchFolder folder_;
  std::unique_ptr<AccessRegister> access_;
  Now now_{1000, 1'700'000'000};
};

TEST_F(AccessTest, ACodePairsOnce) {
  const std::string open_code = code(Role::kHelper);
  EXPECT_EQ(open_code.size(), 6u);
  const auto pairing = redeem(open_code);
  ASSERT_TRUE(pairing.has_value());
  EXPECT_EQ(pairing->who, (Identity{1, "Anna's phone", Role::kHelper}));
  EXPECT_EQ(pairing->token.size(), 43u);  // 256 bits
  EXPECT_EQ(access_->identify(pairing->token, now_), pairing->who);
  EXPECT_EQ(status(open_code), 401);
}

TEST_F(AccessTest, ACodeEndsWithWhoMadeIt) {
  const auto maker = redeem(code(Role::kHelper)), other = redeem(code(Role::kHelper));
  const auto make = [&](const auto& pairing) {
    return access_->make_code(Role::kHelper, now_, pairing->who.device).value().digits;
  };
  EXPECT_EQ(status(make(maker)), 200);
  const std::string makers = make(maker), others = make(other);
  EXPECT_EQ(access_->revoke(maker->who.device), true);
  EXPECT_EQ(status(makers), 401);
  EXPECT_EQ(status(make(maker)), 401) << "asked for before, made after";
  EXPECT_EQ(status(others), 200);
}

TEST_F(AccessTest, ACodeIsValidForFiveMinutes) {
  const std::string first = code();
  now_.steady_s += 299;
  const std::string second = code();
  EXPECT_EQ(status(first), 200);
  now_.steady_s += 300;
  EXPECT_EQ(status(second), 401);
}

TEST_F(AccessTest, WhatIsStoredLetsNobodyIn) {
  const auto pairing = redeem(code());
  ASSERT_TRUE(pairing.has_value());
  const auto bytes = read_text_file(folder_ / "flat.home.access" / "devices.sqlite");
  ASSERT_OK(bytes);
  EXPECT_THAT(*bytes, Not(HasSubstr(pairing->token)));
  EXPECT_FALSE(access_->identify(sha256_of(pairing->token), now_));
  EXPECT_FALSE(access_->identify("", now_));
  for (const char* name : {"", "devices.sqlite"}) {
    struct stat status {};
    ASSERT_EQ(::stat((folder_ / "flat.home.access" / name).c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0077U, 0u) << name;
  }
}

TEST_F(AccessTest, ARestartKeepsDevicesAndForgetsCodes) {
  const auto pairing = redeem(code());
  const std::string forgotten = code();
  now_.unix_s += 100;
  EXPECT_TRUE(access_->identify(pairing->token, now_));
  open();
  EXPECT_EQ(status(forgotten), 401);
  EXPECT_EQ(access_->identify(pairing->token, now_), pairing->who);
  ASSERT_EQ(access_->devices().size(), 1u);
  EXPECT_EQ(access_->devices()[0].paired_s, 1'700'000'000);
  EXPECT_EQ(access_->devices()[0].last_seen_s, 1'700'000'100);
}

TEST_F(AccessTest, AListThatWasEmptiedIsSaidSo) {
  access_.reset();
  const auto file = folder_ / "flat.home.access" / "devices.sqlite";
  std::filesystem::resize_file(file, 0);
  EXPECT_ERROR(AccessRegister::open(folder_ / "flat.home.access", kFingerprint),
               "devices.sqlite: is damaged: the list of paired devices is gone from it");
  EXPECT_EQ(std::filesystem::file_size(file), 0U);
  std::filesystem::remove(file);
  open();
  EXPECT_THAT(access_->devices(), ::testing::IsEmpty());
}

TEST_F(AccessTest, ARemovedDevicesNumberIsNotGivenAgain) {
  const auto pairing = redeem(code());
  EXPECT_TRUE(access_->revoke(pairing->who.device).value());
  EXPECT_FALSE(access_->revoke(pairing->who.device).value());
  EXPECT_FALSE(access_->identify(pairing->token, now_));
  open();
  EXPECT_EQ(redeem(code())->who.device, 2);
}

TEST_F(AccessTest, ADeviceIsCalledAsAHelperSays) {
  const auto pairing = redeem(code());
  EXPECT_TRUE(access_->rename(pairing->who.device, "Anna's belt").value());
  EXPECT_EQ(access_->identify(pairing->token, now_)->name, "Anna's belt");
  EXPECT_FALSE(access_->rename(99, "Anna's belt").value());
  for (const std::string& name : unfit_) {
    EXPECT_ERROR(access_->rename(pairing->who.device, name), "1 to 64 bytes");
  }
  open();
  EXPECT_EQ(access_->devices()[0].who.name, "Anna's belt") << "also after a restart";
}

TEST_F(AccessTest, BadRequestsAreNoGuesses) {
  const std::string open_code = code();
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(status("12345"), 400);
    EXPECT_EQ(status("12345a"), 400);
  }
  for (const std::string& name : unfit_) {
    const auto refused = access_->redeem({.code = open_code, .name = name, .peer = "p"}, now_);
    ASSERT_FALSE(refused.has_value());
    EXPECT_EQ(refused.error().status, 400);
  }
  EXPECT_EQ(status(open_code), 200);
}

TEST_F(AccessTest, APeerHasThreeGuesses) {
  const std::string open_code = code();
  const std::string wrong = other_than(open_code);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(status(wrong), 401);
  const auto waits = redeem(open_code);
  ASSERT_FALSE(waits.has_value());
  EXPECT_EQ(waits.error().status, 429);
  EXPECT_EQ(waits.error().wait_s, 30);
  EXPECT_EQ(waits.error().key, "many_codes");
  EXPECT_EQ(status(open_code, "10.0.0.2"), 200);  // others are heard
  now_.steady_s += 30;
  EXPECT_EQ(status(code()), 200);
}

TEST_F(AccessTest, FiveWrongGuessesVoidAllCodes) {
  const std::string first = code();
  const std::string second = code();
  std::string wrong = other_than(first);
  if (wrong == second) wrong = other_than(second);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(status(wrong, fmt::format("10.0.0.{}", i)), 401);
  EXPECT_EQ(status(first, "10.0.0.9"), 429);
  EXPECT_EQ(access_->digits_wait_s(now_), 30);
  now_.steady_s += 30;
  EXPECT_EQ(status(first, "10.0.0.9"), 401);
  EXPECT_EQ(status(second, "10.0.0.9"), 401);
  EXPECT_EQ(status(code(), "10.0.0.9"), 200);
}

// It waits longer each time, and others can go on pairing by digits.
TEST_F(AccessTest, OneAddressThatGuessesAllDayLocksNobodyElseOut) {
  std::vector<std::int64_t> waits;
  int heard = 0;
  for (int second = 0; second < 20'000; ++second) {
    const std::string open_code = code();
    // Of one computer, which takes addresses as it likes.
    const auto answer =
        redeem(other_than(open_code), peer_key(fmt::format("2001:db8:1:2::{:x}", second)));
    ASSERT_FALSE(answer.has_value());
    if (answer.error().status == 401) ++heard;
    if (answer.error().wait_s > 0 && (waits.empty() || answer.error().wait_s > waits.back()))
      waits.push_back(answer.error().wait_s);
    if (second % 2000 == 0) {
      EXPECT_EQ(status(open_code, peer_key("2001:db8:1:3::1")), 200) << "a neighbour, " << second;
    }
    now_.steady_s += 1;
  }
  EXPECT_THAT(waits, ElementsAre(29, 59, 119, 239, 479, 959, 1919, 3599))
      << "a second after the guess that began each";
  EXPECT_LE(heard, 3 * 12);
  // Who lives at that address, too, pairs when its wait is over.
  now_.steady_s += 3600;
  EXPECT_EQ(status(code(), peer_key("2001:db8:1:2::7")), 200);
  EXPECT_EQ(status(other_than(code()), peer_key("2001:db8:1:2::7")), 401) << "and is as new";
}

// Addresses that are known to guess lock out each other.
TEST_F(AccessTest, ManyAddressesThatAreKnownToGuessGetNoMoreTriesThanAllOthers) {
  int compared = 0;
  for (int second = 0; second < 100'000; ++second) {
    const std::string wrong = other_than(code());
    compared += status(wrong, fmt::format("10.0.0.{}", second % 200)) == 401 ? 1 : 0;
    now_.steady_s += 1;
  }
  // Five, and an hour's wait: of those who are not known yet, and of those who are.
  EXPECT_LE(compared, 2 * 5 * (8 + 28));
}

// Ten thousand guesses, from as many addresses as an attacker likes, while a helper asks for new
// codes as often as it gets one: how many are compared with a code at all.
TEST_F(AccessTest, TenThousandGuessesHardlyEverMeetACode) {
  int compared = 0;
  for (int i = 0; i < 10'000; ++i) {
    const auto open_code = access_->make_code(Role::kDevice, now_);
    const std::string guess =
        open_code ? other_than(open_code->digits) : fmt::format("{:06}", i % 1'000'000);
    const int answer = status(guess, fmt::format("10.0.{}.{}", i / 250, i % 250));
    ASSERT_THAT(answer, ::testing::AnyOf(401, 429));
    compared += answer == 401 ? 1 : 0;
    now_.steady_s += 1;
  }
  // Waits of 30, 60, ... 3600 s: nine times five guesses in 10,000 s.
  EXPECT_LE(compared, 50);
}

// All devices of a home may have one address to the computer: behind a router or a proxy.
TEST_F(AccessTest, WhoGuessesKeepsNobodyOutWhoHasTheLink) {
  const auto redeem_secret = [&](const std::string& secret) {
    return access_->redeem({.secret = secret, .name = "Anna's phone", .peer = "10.0.0.1"}, now_);
  };
  const OpenCode shown = open_code(Role::kHelper);
  ASSERT_EQ(shown.secret.size(), kSecretLength);
  // From the same address until it is not heard any more, and from others until nobody is.
  for (int i = 0; i < 3; ++i) EXPECT_EQ(status(other_than(shown.digits)), 401);
  for (int i = 0; i < 9; ++i) (void)status(other_than(shown.digits), fmt::format("10.0.0.{}", i));
  EXPECT_EQ(status(shown.digits), 429);
  EXPECT_EQ(redeem_secret(std::string(kSecretLength, 'A')).error().status, 401);
  const auto pairing = redeem_secret(shown.secret);
  ASSERT_TRUE(pairing.has_value());
  EXPECT_EQ(pairing->who.role, Role::kHelper);
  EXPECT_EQ(redeem_secret(shown.secret).error().status, 401) << "it pairs once";
  // A new code can be made meanwhile; its digits wait, its link does not.
  const OpenCode second = open_code();
  EXPECT_EQ(status(second.digits), 429);
  EXPECT_TRUE(redeem_secret(second.secret).has_value());
  const OpenCode third = open_code();
  now_.steady_s += 301;
  EXPECT_EQ(redeem_secret(third.secret).error().status, 401) << "it is valid for five minutes";
  // What guessers are made to wait is not forgotten because somebody else has a link.
  EXPECT_EQ(status(code()), 200);
}

TEST_F(AccessTest, AProofOfTheSecretPairsAndProvesAndIsNotMadeToWait) {
  const OpenCode shown = open_code();
  for (int i = 0; i < 9; ++i) (void)status(other_than(shown.digits), fmt::format("10.0.0.{}", i));
  const auto attempt = [&](const std::string& proof) {
    return access_->redeem({.nonce = kNonce, .proof = proof, .proves_secret = true, .name = "Cap"},
                           now_);
  };
  const PairingProof relayed =
      make_secret_proof(shown.secret, std::string(64, 'b'), kNonce).value();
  EXPECT_EQ(attempt(relayed.device).error().status, 401);
  const PairingProof proof = make_secret_proof(shown.secret, kFingerprint, kNonce).value();
  EXPECT_EQ(attempt(proof.computer).error().status, 401);
  const auto pairing = attempt(proof.device);
  ASSERT_TRUE(pairing.has_value());
  EXPECT_EQ(pairing->proof, proof.computer);
}

TEST_F(AccessTest, GuessingWithoutCodesLocksNobodyOut) {
  for (int i = 0; i < 100; ++i) (void)status("123456", fmt::format("10.0.1.{}", i));
  EXPECT_EQ(status(code()), 200);
}

TEST_F(AccessTest, AProofPairsAndProves) {
  const std::string open_code = code();
  const PairingProof proof = make_pairing_proof(open_code, kFingerprint, kNonce).value();
  const auto attempt = [&](const std::string& proof_text, const std::string& nonce) {
    return access_->redeem({.nonce = nonce, .proof = proof_text, .name = "Cap", .peer = "10.0.0.1"},
                           now_);
  };
  // Made for the certificate of somebody in between.
  const PairingProof relayed = make_pairing_proof(open_code, std::string(64, 'b'), kNonce).value();
  EXPECT_EQ(attempt(relayed.device, kNonce).error().status, 401);
  EXPECT_EQ(attempt(proof.computer, kNonce).error().status, 401);
  EXPECT_EQ(attempt(proof.device, "short").error().status, 400);
  const auto pairing = attempt(proof.device, kNonce);
  ASSERT_TRUE(pairing.has_value());
  EXPECT_EQ(pairing->proof, proof.computer);
  EXPECT_EQ(attempt(proof.device, kNonce).error().status, 401);  // replayed
}

TEST_F(AccessTest, RefusesAFolderThatOthersRead) {
  std::filesystem::create_directory(folder_ / "open");
  std::filesystem::permissions(folder_ / "open", std::filesystem::perms(0755));
  EXPECT_ERROR(AccessRegister::open(folder_ / "open", kFingerprint), "chmod -R go=");
  ASSERT_OK(write_file(folder_ / "file", "x"));
  EXPECT_ERROR(AccessRegister::open(folder_ / "file", kFingerprint), "is no folder");
}

TEST(SecretsTest, CodesAreSpreadEvenly) {
  std::set<std::string> codes;
  std::array<int, 10> first{};
  for (int i = 0; i < 2000; ++i) {
    const std::string code = random_code().value();
    codes.insert(code);
    ++first[static_cast<std::size_t>(code[0] - '0')];
  }
  EXPECT_GT(codes.size(), 1980u);
  for (const int count : first) EXPECT_GT(count, 120);  // 200 expected; 6 standard deviations
}

TEST(SecretsTest, AreEqualOnlyAsAWhole) {
  EXPECT_TRUE(equal_secrets("abc", "abc"));
  EXPECT_FALSE(equal_secrets("abc", "abd"));
  EXPECT_FALSE(equal_secrets("abc", "abcd"));
}

}  // namespace
}  // namespace roomwise::service
