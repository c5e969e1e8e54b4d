#include "roomwise/service/access/account_store.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <condition_variable>
#include <future>
#include <nlohmann/json.hpp>
#include <thread>

#include "roomwise/base/testing/testing.h"
#include "roomwise/service/server/staff_routes.h"
#include "roomwise/service/testing/postgresql_server.h"

namespace roomwise::service {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::Pair;

using namespace std::string_literals;

constexpr auto kAnnasPassword = "correct horse battery";
constexpr Now kNow{1000, 1'700'000'000};

// Each test with accounts in a file, and in a PostgreSQL of its own where that is installed.
class AccountStoreTest : public ::testing::TestWithParam<bool> {
 protected:
  static void TearDownTestSuite() { postgresql_.reset(); }

  void SetUp() override {
    if (is_postgresql()) {
      if (!has_postgresql()) GTEST_SKIP() << "built without libpq";
      if (const auto why = testing::PostgresqlServer::missing()) GTEST_SKIP() << *why;
      if (!postgresql_) postgresql_ = std::make_unique<testing::PostgresqlServer>();
      const auto link = open_postgresql_link(postgresql_->address());
      ASSERT_OK(link);
      for (const char* table : {"sessions", "roles", "accounts", "audit"}) {
        ASSERT_OK((*link)->run(fmt::format("DROP TABLE IF EXISTS roomwise_{}", table)));
      }
    }
    store_ = open();
  }

  [[nodiscard]] static bool is_postgresql() { return GetParam(); }
  // As another process would.
  [[nodiscard]] std::unique_ptr<AccountStore> open() const {
    auto link = is_postgresql() ? open_postgresql_link(postgresql_->address())
                                : open_sqlite_link(folder_ / "accounts.sqlite");
    return AccountStore::open(std::move(link).value()).value();
  }

  static std::unique_ptr<testing::PostgresqlServer> postgresql_;
  ::roomwise::testing::ScratchFolder folder_;
  std::unique_ptr<AccountStore> store_;
};
std::unique_ptr<testing::PostgresqlServer> AccountStoreTest::postgresql_;

// What a file does not have: a server, and its dislikes.
class PostgresqlAccountsTest : public AccountStoreTest {};
INSTANTIATE_TEST_SUITE_P(Backends, PostgresqlAccountsTest, ::testing::Values(true),
                         [](const auto&) { return "PostgreSQL"; });

INSTANTIATE_TEST_SUITE_P(Backends, AccountStoreTest, ::testing::Values(false, true),
                         [](const auto& backend) {
                           return backend.param ? "PostgreSQL" : "SQLite";
                         });

TEST_P(AccountStoreTest, WhoSignsInMayWhatTheirRolesSayInEachHome) {
  ASSERT_OK(store_->add("anna", kAnnasPassword));
  ASSERT_OK(store_->set_role("anna", "flat-1", Role::kHelper));
  ASSERT_OK(store_->set_role("anna", "flat-2", Role::kHelper));
  ASSERT_OK(store_->set_role("anna", "flat-2", Role::kDevice));
  const auto session = store_->sign_in("anna", kAnnasPassword, "10.0.0.1", kNow);
  ASSERT_TRUE(session);
  const auto elsewhere = open();  // another process
  const auto who = elsewhere->who(session->token, kNow);
  ASSERT_OK(who);
  ASSERT_TRUE(*who);
  EXPECT_EQ((*who)->name, "anna");
  EXPECT_THAT((*who)->homes,
              ElementsAre(Pair("flat-1", Role::kHelper), Pair("flat-2", Role::kDevice)));
  EXPECT_EQ(store_->role_now((*who)->id, "flat-1", kNow).value(), Role::kHelper);
  ASSERT_OK(elsewhere->set_role("anna", "flat-1", Role::kDevice));
  EXPECT_EQ(store_->role_now((*who)->id, "flat-1", kNow).value(), Role::kDevice);
  EXPECT_EQ(store_->role_in_home((*who)->id, "flat-1").value(), Role::kDevice);
  ASSERT_OK(store_->set_role("anna", "flat-1", std::nullopt));
  EXPECT_FALSE(store_->role_now((*who)->id, "flat-1", kNow).value());
  EXPECT_FALSE(store_->role_in_home((*who)->id, "flat-1").value());
  EXPECT_FALSE(elsewhere->who(session->token, {0, kNow.unix_s + kStaffSession_s}).value());
  EXPECT_FALSE(store_->who("nonsense", kNow).value());
  ASSERT_OK(elsewhere->sign_out(session->token));
  EXPECT_FALSE(store_->who(session->token, kNow).value());
  EXPECT_FALSE(store_->role_now((*who)->id, "flat-2", kNow).value());
  EXPECT_EQ(store_->role_in_home((*who)->id, "flat-2").value(), Role::kDevice);
}

TEST_P(AccountStoreTest, APasswordThatIsChangedOrAnAccountThatIsRemovedEndsSessions) {
  ASSERT_OK(store_->add("anna", kAnnasPassword));
  ASSERT_OK(store_->add("ben", "another password"));
  EXPECT_ERROR(store_->add("anna", "yet another one"), "there is an account 'anna' already");
  const auto anna = store_->sign_in("anna", kAnnasPassword, "10.0.0.1", kNow);
  const auto ben = store_->sign_in("ben", "another password", "10.0.0.1", kNow);
  ASSERT_TRUE(anna);
  ASSERT_TRUE(ben);
  ASSERT_OK(store_->set_password("anna", "a new password"));
  EXPECT_FALSE(store_->who(anna->token, kNow).value());
  EXPECT_FALSE(store_->sign_in("anna", kAnnasPassword, "10.0.0.1", kNow));
  EXPECT_TRUE(store_->sign_in("anna", "a new password", "10.0.0.1", kNow));
  ASSERT_OK(store_->remove("ben"));
  EXPECT_FALSE(store_->who(ben->token, kNow).value());
  EXPECT_FALSE(store_->sign_in("ben", "another password", "10.0.0.1", kNow));
  ASSERT_OK(store_->add("ben", "another password"));  // somebody else of that name
  EXPECT_NE(store_->sign_in("ben", "another password", "10.0.0.1", kNow)->account.id,
            ben->account.id);
  EXPECT_EQ(store_->accounts()->size(), 2u);
}

TEST_P(AccountStoreTest, WrongPasswordsAreCountedByNameAndAddress) {
  ASSERT_OK(store_->add("anna", kAnnasPassword));
  for (int tries = 0; tries < 3; ++tries) {
    EXPECT_EQ(store_->sign_in("anna", "wrong password", "10.0.0.1", kNow).error().status, 401);
  }
  const auto waits = store_->sign_in("anna", kAnnasPassword, "10.0.0.1", kNow);
  EXPECT_EQ(waits.error().status, 429);
  EXPECT_EQ(waits.error().wait_s, 30);
  EXPECT_TRUE(store_->sign_in("anna", kAnnasPassword, "10.0.0.2", kNow));
  EXPECT_TRUE(store_->sign_in("anna", kAnnasPassword, "10.0.0.1", {1031, kNow.unix_s}));
  const auto nobody = store_->sign_in("nobody", kAnnasPassword, "10.0.0.3", kNow);
  EXPECT_EQ(nobody.error().message,
            store_->sign_in("anna", "wrong password", "10.0.0.3", kNow).error().message);
}

TEST_P(AccountStoreTest, ANameThatIsNoneIsNobodysAndMeetsNoAccount) {
  ASSERT_OK(store_->add("anna", kAnnasPassword));
  const auto unknown = store_->sign_in("nobody", kAnnasPassword, "10.0.0.1", kNow).error();
  for (const std::string& name : {"anna\0x1"s, "anna\0"s, "anna "s}) {
    const auto refused = store_->sign_in(name, kAnnasPassword, "10.0.0.2", kNow);
    ASSERT_FALSE(refused) << ::testing::PrintToString(name);
    EXPECT_EQ(refused.error().status, unknown.status);
    EXPECT_EQ(refused.error().message, unknown.message);
  }
  // They are one guesser's, however they are spelled.
  EXPECT_EQ(store_->sign_in("anna\0x2"s, kAnnasPassword, "10.0.0.2", kNow).error().status, 429);
  EXPECT_TRUE(store_->sign_in("anna", kAnnasPassword, "10.0.0.2", kNow));
}

TEST_P(AccountStoreTest, AnAddressTriesFewPasswordsWhateverTheNames) {
  ASSERT_OK(store_->add("anna", kAnnasPassword));
  for (int tries = 0; tries < static_cast<int>(kTriesAtOnce); ++tries) {
    const std::string name = fmt::format("nobody-{}", tries);
    EXPECT_EQ(store_->sign_in(name, "wrong password", "10.0.0.1", kNow).error().status, 401);
  }
  const auto waits = store_->sign_in("one-more", "wrong password", "10.0.0.1", kNow);
  EXPECT_EQ(waits.error().status, 429);
  EXPECT_EQ(waits.error().wait_s, 2);
  EXPECT_TRUE(store_->sign_in("anna", kAnnasPassword, "10.0.0.2", kNow));
  // The right password costs nothing.
  const Now later{kNow.steady_s + 2, kNow.unix_s};
  EXPECT_TRUE(store_->sign_in("anna", kAnnasPassword, "10.0.0.1", later));
  EXPECT_TRUE(store_->sign_in("anna", kAnnasPassword, "10.0.0.1", later));
}

// A database that answers when it is let.
class HeldLink final : public SqlLink {
 public:
  explicit HeldLink(std::shared_future<void> let) : let_(std::move(let)) {}
  [[nodiscard]] Expected<std::vector<Row>> run(std::string_view sql,
                                               const std::vector<std::string>&) override {
    if (sql.starts_with("SELECT")) let_.wait();
    return std::vector<Row>{};
  }
  [[nodiscard]] std::string_view counting_key() const override { return ""; }

 private:
  const std::shared_future<void> let_;
};

class AccountStoreAloneTest : public ::testing::Test {
 protected:
  // Somebody tries a wrong password, as long as the database does not answer.
  void begin(const std::string& peer) {
    trying_.emplace_back([this, peer] {
      const auto refusal = store_->sign_in("anna", kAnnasPassword, peer, kNow).error();
      const std::scoped_lock lock(mutex_);
      refusals_.push_back(refusal);
      came_.notify_all();
    });
  }
  // The refusals once there are so many, or after ten seconds.
  std::vector<Refusal> refusals(std::size_t count) {
    std::unique_lock lock(mutex_);
    came_.wait_for(lock, std::chrono::seconds(10), [&] { return refusals_.size() >= count; });
    return refusals_;
  }

  std::promise<void> let_;
  std::unique_ptr<AccountStore> store_ =
      AccountStore::open(std::make_unique<HeldLink>(let_.get_future().share())).value();
  std::mutex mutex_;
  std::condition_variable came_;
  std::vector<Refusal> refusals_;
  std::vector<std::jthread> trying_;
};

TEST_F(AccountStoreAloneTest, WhereAllPlacesAreTakenOneMoreIsSentAway) {
  for (std::size_t one = 0; one <= kPasswordPlaces; ++one) begin(fmt::format("10.0.0.{}", one));
  const auto sent_away = refusals(1);
  let_.set_value();
  ASSERT_EQ(sent_away.size(), 1u);
  EXPECT_EQ(sent_away[0].status, 429);
  EXPECT_EQ(sent_away[0].wait_s, 1);
  trying_.clear();
  EXPECT_EQ(std::ranges::count(refusals_, 429, &Refusal::status), 1);
}

TEST_F(AccountStoreAloneTest, AnAddressHasOnePlace) {
  for (int one = 0; one < 20; ++one) begin("2001:db8:1:2::" + std::to_string(one));
  const auto sent_away = refusals(19);
  EXPECT_EQ(std::ranges::count(sent_away, 429, &Refusal::status), 19);
  begin("10.0.0.2");
  let_.set_value();
  trying_.clear();
  EXPECT_EQ(std::ranges::count(refusals_, 401, &Refusal::status), 2) << "its own and the other's";
}

TEST_P(AccountStoreTest, TheAddressesOfAnIpv6NetworkGuessPasswordsTogether) {
  ASSERT_OK(store_->add("anna", kAnnasPassword));
  for (int i = 0; i < 3; ++i) {
    const std::string peer = fmt::format("2001:db8::{}", i + 1);
    EXPECT_EQ(store_->sign_in("anna", "wrong password", peer, kNow).error().status, 401);
  }
  const auto waits = store_->sign_in("anna", kAnnasPassword, "2001:db8::9", kNow);
  EXPECT_EQ(waits.error().status, 429);
  EXPECT_TRUE(store_->sign_in("anna", kAnnasPassword, "2001:db8:0:1::9", kNow));
}

TEST_P(PostgresqlAccountsTest, PostgresqlIsGivenNoTextWithAZero) {
  const auto link = open_postgresql_link(postgresql_->address());
  ASSERT_OK(link);
  EXPECT_ERROR((*link)->run("SELECT 1 WHERE 'anna' = $1", {"anna\0x1"s}), "zero byte");
}

// What a client of PostgreSQL says first to one who has no TLS, and then.
std::string said_without_tls(const std::string& address) {
  const int listening = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in own{};
  own.sin_family = AF_INET;
  own.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof own;
  EXPECT_EQ(::bind(listening, reinterpret_cast<sockaddr*>(&own), size), 0);
  EXPECT_EQ(::listen(listening, 1), 0);
  ::getsockname(listening, reinterpret_cast<sockaddr*>(&own), &size);
  std::string said;
  std::jthread server([&] {
    const int client = ::accept(listening, nullptr, nullptr);
    char buffer[512];
    for (ssize_t count; (count = ::recv(client, buffer, sizeof buffer, 0)) > 0;) {
      said.append(buffer, static_cast<std::size_t>(count));
      if (said.size() != 8) break;  // it asked for no TLS, or has not done without
      EXPECT_EQ(::send(client, "N", 1, MSG_NOSIGNAL), 1);
    }
    ::close(client);
  });
  EXPECT_FALSE(open_postgresql_link(address + fmt::format(" port={}", ntohs(own.sin_port))));
  ::shutdown(listening, SHUT_RDWR);
  server.join();
  ::close(listening);
  return said;
}

TEST(PostgresqlLinkTest, AServerElsewhereIsToldNothingWithoutTls) {
  if (!has_postgresql()) GTEST_SKIP() << "built without PostgreSQL's client";
  const auto says_who = [](const std::string& address) {
    return said_without_tls(address + " user=roomwise gssencmode=disable").find("roomwise") !=
           std::string::npos;
  };
  EXPECT_FALSE(says_who("host=db.example hostaddr=127.0.0.1"));
  EXPECT_FALSE(says_who("host=127.example hostaddr=127.0.0.1"));
  EXPECT_TRUE(says_who("host=127.0.0.1"));
  EXPECT_TRUE(says_who("hostaddr=127.0.0.1"));
  EXPECT_TRUE(says_who("host=db.example hostaddr=127.0.0.1 sslmode=prefer"));
}

TEST(PairingGuardTest, WhoInventsPeersEndsNobodysWait) {
  PairingGuard guard;
  for (int guess = 0; guess < 3; ++guess) guard.wrong("anna", 1000);
  for (int peer = 0; peer < 3000; ++peer) guard.wrong(fmt::format("invented {}", peer), 1001);
  EXPECT_EQ(guard.wait_s("anna", 1001), 29);
  EXPECT_EQ(guard.wait_s("new", 1001), 0);
  EXPECT_LE(guard.peers(), 1024u);
}

TEST(PairingGuardTest, NobodyNewIsHeardWhileAllOthersWait) {
  PairingGuard guard;
  for (int peer = 0; peer < 1024; ++peer) {
    for (int guess = 0; guess < 3; ++guess) guard.wrong(fmt::format("{}", peer), 1000 + peer / 64);
  }
  EXPECT_EQ(guard.wait_s("new", 1020), 10);
  guard.wrong("new", 1020);
  EXPECT_EQ(guard.peers(), 1024u);
  EXPECT_GT(guard.wait_s("0", 1020), 0);
  EXPECT_EQ(guard.wait_s("new", 1030), 0);
}

TEST_P(AccountStoreTest, PasswordsAndTokensAreNotKept) {
  ASSERT_OK(store_->add("anna", kAnnasPassword));
  const auto session = store_->sign_in("anna", kAnnasPassword, "10.0.0.1", kNow);
  const auto link = is_postgresql() ? open_postgresql_link(postgresql_->address())
                                    : open_sqlite_link(folder_ / "accounts.sqlite");
  ASSERT_OK(link);
  const auto hash = (*link)->run("SELECT password FROM roomwise_accounts");
  EXPECT_THAT(hash->front().front(), HasSubstr("$argon2id$"));
  EXPECT_THAT(hash->front().front(), Not(HasSubstr("horse")));
  const auto token = (*link)->run("SELECT token_sha256 FROM roomwise_sessions");
  EXPECT_NE(token->front().front(), session->token);
  EXPECT_ERROR(store_->add("ben", "short"), "a password has 10 to 256 bytes");
  EXPECT_ERROR(store_->add("two words", kAnnasPassword), "is no name of an account");
}

TEST_P(AccountStoreTest, WhatWasDoneIsKeptTheNewestFirst) {
  const AuditLine first{1'700'000'000, "anna", "flat-1", "POST /api/learn", "200", "10.0.0.1"};
  const AuditLine second{1'700'000'000, "Ben's; DROP TABLE", "flat-2", "signed in", "done", ""};
  ASSERT_OK(store_->note(first));
  ASSERT_OK(store_->note(second));
  EXPECT_THAT(store_->audit(10).value(), ElementsAre(second, first));
  EXPECT_THAT(store_->audit(1).value(), ElementsAre(second));
  EXPECT_THAT(store_->audit(10, "flat-1").value(), ElementsAre(first));
  EXPECT_THAT(store_->audit(10, "flat-3").value(), IsEmpty());
}

TEST_P(AccountStoreTest, TheStaffsRequestsSignInListHomesAndSignOut) {
  ASSERT_OK(store_->add("anna", kAnnasPassword));
  ASSERT_OK(store_->set_role("anna", "flat-1", Role::kHelper));
  ASSERT_OK(store_->set_role("anna", "gone", Role::kHelper));
  std::int64_t left = 0;
  StaffRoutesContext context;
  context.clock = [] { return kNow; };
  context.homes = [] { return std::vector<std::string>{"flat-1", "flat-2"}; };
  context.on_signed_out = [&](std::int64_t account) { left = account; };
  const Router router(staff_routes(*store_, std::move(context)));
  const auto ask = [&](const char* method, const char* path, const std::string& body,
                       const std::string& cookie) {
    HttpRequest request;
    request.method = method;
    request.path = path;
    request.body = Bytes(body.begin(), body.end());
    request.headers["cookie"] = cookie;
    request.peer = "10.0.0.1";
    return router.answer(request);
  };
  EXPECT_EQ(ask("GET", "/api/staff/me", "", "").status, 401);
  EXPECT_EQ(ask("POST", "/api/staff/sign-in", R"({"name":"anna","password":"x"})", "").status, 401);
  const HttpAnswer in =
      ask("POST", "/api/staff/sign-in",
          nlohmann::json({{"name", "anna"}, {"password", kAnnasPassword}}).dump(), "");
  ASSERT_EQ(in.status, 200);
  EXPECT_EQ(std::string(in.body.begin(), in.body.end()),
            R"({"homes":[{"name":"flat-1","role":"helper"}],"name":"anna"})");
  ASSERT_EQ(in.headers.front().first, "Set-Cookie");
  const std::string set = in.headers.front().second;
  EXPECT_THAT(set, HasSubstr("Secure; HttpOnly; SameSite=Strict"));
  const std::string cookie = set.substr(0, set.find(';'));
  EXPECT_EQ(ask("GET", "/api/staff/me", "", cookie).status, 200);
  HttpRequest request;
  request.headers["cookie"] = cookie;
  const auto in_flat = staff_in_home(*store_, request, "flat-1", kNow);
  ASSERT_OK(in_flat);
  ASSERT_TRUE(*in_flat);
  EXPECT_LT((*in_flat)->device, 0);
  EXPECT_EQ((*in_flat)->role, Role::kHelper);
  EXPECT_FALSE(staff_in_home(*store_, request, "flat-2", kNow).value());
  EXPECT_EQ(ask("POST", "/api/staff/sign-out", "{}", cookie).status, 200);
  EXPECT_EQ(left, -(*in_flat)->device);
  EXPECT_FALSE(staff_in_home(*store_, request, "flat-1", kNow).value());
  const auto lines = store_->audit(10).value();
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[0].what, "signed out");
  EXPECT_EQ(lines[2].outcome, "refused");
  EXPECT_EQ(lines[2].who, "somebody");
}

TEST_P(PostgresqlAccountsTest, AServerThatWasStartedAnewIsAskedAgain) {
  ASSERT_OK(store_->add("anna", kAnnasPassword));
  ASSERT_TRUE(postgresql_->stop());
  EXPECT_ERROR(store_->accounts(), "PostgreSQL");
  EXPECT_EQ(store_->sign_in("anna", kAnnasPassword, "10.0.0.1", kNow).error().status, 503);
  ASSERT_TRUE(postgresql_->start());
  EXPECT_OK(store_->accounts());
}

TEST_P(PostgresqlAccountsTest, WhatWritesReachesAServerThatWasStartedAnewOnce) {
  ASSERT_TRUE(postgresql_->stop());
  ASSERT_TRUE(postgresql_->start());
  const AuditLine line{1'700'000'000, "anna", "flat-1", "POST /api/learn", "200", "10.0.0.1"};
  EXPECT_OK(store_->note(line));
  EXPECT_THAT(store_->audit(10).value(), ElementsAre(line));
}

TEST_P(PostgresqlAccountsTest, WhereTheConnectionBreaksWhatOnlyAsksIsAskedAgainAndWhatWritesIsNot) {
  const auto link = open_postgresql_link(postgresql_->address());
  ASSERT_OK(link);
  ASSERT_OK((*link)->run("DROP TABLE IF EXISTS ended"));
  ASSERT_OK((*link)->run("CREATE TABLE ended (number BIGINT, is_ended BOOLEAN)"));
  ASSERT_OK((*link)->run("DROP SEQUENCE IF EXISTS tries"));
  ASSERT_OK((*link)->run("CREATE SEQUENCE tries"));  // counts also what is not kept
  const auto tries = [&] {
    return (*link)->run("SELECT last_value FROM tries").value().at(0).at(0);
  };
  constexpr auto kBreaks = "SELECT nextval('tries'), pg_terminate_backend(pg_backend_pid())";
  EXPECT_ERROR((*link)->run(fmt::format("INSERT INTO ended {}", kBreaks)),
               "may have been carried out or not");
  EXPECT_EQ(tries(), "1");
  EXPECT_ERROR((*link)->run(kBreaks), "PostgreSQL");
  EXPECT_EQ(tries(), "3");
}

TEST_P(PostgresqlAccountsTest, AStatementThatHangsIsGivenUp) {
  const auto link = open_postgresql_link(postgresql_->address());
  ASSERT_OK(link);
  EXPECT_EQ((*link)->run("SHOW statement_timeout").value().at(0).at(0), "5s");
  const auto told =
      open_postgresql_link(postgresql_->address() + "&options=-c%20statement_timeout%3D7s");
  ASSERT_OK(told);
  EXPECT_EQ((*told)->run("SHOW statement_timeout").value().at(0).at(0), "7s");
}

}  // namespace
}  // namespace roomwise::service
