#include <gmock/gmock.h>

#include "roomwise/service/client/client.h"
#include "roomwise/service/testing/testing_service.h"

namespace roomwise::service {
namespace {

using std::chrono::milliseconds;
using testing::bearer;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::RawClient;
using testing::TestServer;

// Long enough for the slowest machine; nothing waits that long where all is well.
constexpr milliseconds kMax{10000};

std::string upgrade(const std::string& more) {
  return "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
         "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" +
         more;
}
const std::string kSubprotocol = "Sec-WebSocket-Protocol: chat, roomwise.1\r\n";

// A frame of a WebSocket from a client, its mask nothing but zeros.
std::string frame(char opcode, const std::string& payload) {
  std::string bytes{static_cast<char>(0x80 | opcode)};
  if (payload.size() < 126) {
    bytes += static_cast<char>(0x80 | payload.size());
  } else {
    bytes += static_cast<char>(0x80 | 127);
    for (int shift = 56; shift >= 0; shift -= 8)
      bytes += static_cast<char>(payload.size() >> shift);
  }
  return bytes + std::string(4, '\0') + payload;
}

class SocketTest : public ::testing::Test {
 protected:
  [[nodiscard]] ServerAddress address() const { return {"127.0.0.1", home_.port()}; }
  [[nodiscard]] ServerCredentials credentials(const Pairing& pairing) const {
    return {home_.certificate.fingerprint, pairing.token};
  }
  [[nodiscard]] std::unique_ptr<ServerConnection> connect() const { return connect(home_.device); }
  [[nodiscard]] std::unique_ptr<ServerConnection> connect(const Pairing& as) const {
    auto opened =
        ServerConnection::open(address(), credentials(as), {.timeout = kMax, .silence = kMax});
    EXPECT_OK(opened);
    return opened ? *std::move(opened) : nullptr;
  }
  static std::string text_of(const ServerConnection::Message& message) {
    return {message.bytes.begin(), message.bytes.end()};
  }
  // A connection with an open WebSocket whose other end may do anything.
  std::unique_ptr<RawClient> raw() const {
    auto client = std::make_unique<RawClient>(home_.port());
    EXPECT_TRUE(client->shake_hands());
    EXPECT_EQ(client->ask("GET", "/api/socket", upgrade(kSubprotocol + bearer(home_.device.token)))
                  .status,
              101);
    return client;
  }

  TestServer home_;
};

TEST_F(SocketTest, CarriesTextsAndFrames) {
  const auto connection = connect();
  ASSERT_TRUE(connection);
  ASSERT_OK(connection->send_text("hello"));
  const auto echo = connection->receive(kMax);
  ASSERT_OK(echo);
  ASSERT_TRUE(echo->has_value());
  EXPECT_TRUE((*echo)->is_text);
  EXPECT_EQ(text_of(**echo), "hello");
  ASSERT_OK(connection->send_binary(Bytes(1'000'000, 7)));
  EXPECT_TRUE(home_.sockets.signal.wait([&] { return !home_.sockets.binaries.empty(); }));
  EXPECT_THAT(home_.sockets.binaries, ElementsAre(1'000'000u));
  EXPECT_EQ(home_.sockets.last, home_.device.who);
  EXPECT_THAT(home_.server->online(), ElementsAre(home_.device.who.device));
  const auto nothing = connection->receive(milliseconds(0));
  ASSERT_OK(nothing);
  EXPECT_FALSE(nothing->has_value());
  connection->close();
  EXPECT_ERROR(connection->receive(kMax), "closed");
  EXPECT_TRUE(home_.sockets.signal.wait([&] { return home_.sockets.closed == 1; }));
}

TEST_F(SocketTest, OpensOnlyForWhoMay) {
  const auto status = [&](const std::string& headers) {
    return home_.ask("GET", "/api/socket", headers).status;
  };
  const std::string token = bearer(home_.device.token);
  EXPECT_EQ(status(upgrade(kSubprotocol)), 401);
  EXPECT_EQ(status(upgrade(kSubprotocol + bearer("other"))), 401);
  EXPECT_EQ(status(upgrade(token)), 400);  // no subprotocol
  EXPECT_EQ(status(upgrade(token + "Sec-WebSocket-Protocol: roomwise.2\r\n")), 400);
  EXPECT_EQ(status(token), 426);
  EXPECT_EQ(status(upgrade(token + kSubprotocol + "Origin: https://evil.example\r\n")), 403);
  EXPECT_EQ(status(upgrade(token + kSubprotocol + "Origin: https://127.0.0.1\r\n")), 101);
  EXPECT_EQ(status(upgrade("Cookie: roomwise=" + home_.helper.token + "\r\n" + kSubprotocol)), 101);
}

TEST_F(SocketTest, RefusesAMessageThatIsTooLarge) {
  const auto connection = connect();
  ASSERT_TRUE(connection);
  ASSERT_OK(connection->send_binary(Bytes(4'000'000, 7)));
  EXPECT_TRUE(home_.sockets.signal.wait([&] { return home_.sockets.binaries.size() == 1; }));
  ASSERT_OK(connection->send_binary(Bytes(4'000'001, 7)));
  EXPECT_ERROR(connection->receive(kMax), "a message has at most 4000000 bytes");
  EXPECT_TRUE(home_.sockets.signal.wait([&] { return home_.sockets.closed == 1; }));
  const auto another = connect();
  ASSERT_TRUE(another);
  ASSERT_OK(another->send_binary(Bytes(20'000'000, 7)));
  EXPECT_ERROR(another->receive(kMax), "a message has at most 4000000 bytes");
  EXPECT_TRUE(home_.sockets.signal.wait([&] { return home_.sockets.closed == 2; }));
  EXPECT_EQ(home_.sockets.binaries.size(), 1u);
  EXPECT_EQ(home_.server->counts().refusals.at("a message that is too large"), 2u);
}

TEST_F(SocketTest, ClosesAClientThatSendsTooManyMessagesAndSaysWhy) {
  home_.options.limits.burst_messages = 3;
  home_.options.limits.rate_messages = 1;
  home_.start();
  const auto flooding = connect();
  const auto neighbour = connect(home_.helper);
  ASSERT_TRUE(flooding && neighbour);
  for (int i = 0; i < 4; ++i) ASSERT_OK(flooding->send_text("more"));
  Expected<std::optional<ServerConnection::Message>> last = flooding->receive(kMax);
  for (int i = 0; i < 3 && last; ++i) last = flooding->receive(kMax);
  EXPECT_ERROR(last, "too many messages: at most 1 a second");
  EXPECT_EQ(home_.server->counts().refusals.at("too many messages of one client"), 1u);
  // The other has a limit of its own, also from the same address.
  ASSERT_OK(neighbour->send_text("still here"));
  EXPECT_OK(neighbour->receive(kMax));
  EXPECT_TRUE(home_.sockets.signal.wait([&] { return home_.sockets.closed == 1; }));
  EXPECT_LE(home_.sockets.texts.size(), 4u);
}

TEST_F(SocketTest, PingsAndPongsCountAsMessages) {
  home_.options.limits.burst_messages = 3;
  home_.options.limits.rate_messages = 1;
  home_.start();
  for (const char opcode : {'\x09', '\x0A'}) {
    const auto client = raw();
    for (int i = 0; i < 3; ++i) client->send(frame(opcode, "p"));
    client->send(frame(1, "one more"));
    client->send(frame(8, ""));
    EXPECT_THAT(client->receive_all(), HasSubstr("too many messages: at most 1 a second"));
  }
  EXPECT_TRUE(home_.sockets.signal.wait([&] { return home_.sockets.closed == 2; }));
  EXPECT_THAT(home_.sockets.texts, ::testing::IsEmpty());
}

TEST_F(SocketTest, EmptyPiecesOfAMessageCountAsMessages) {
  home_.options.limits.burst_messages = 20;
  home_.options.limits.rate_messages = 1;
  home_.start();
  const auto flooding = raw();
  const auto piece = [](char opcode, const std::string& payload, bool is_last) {
    std::string bytes = frame(opcode, payload);
    if (!is_last) bytes[0] = opcode;
    return bytes;
  };
  flooding->send(piece(1, "", false));
  for (int i = 0; i < 30; ++i) flooding->send(piece(0, "", false));
  flooding->send(piece(0, "never heard", true));
  flooding->send(frame(8, ""));
  EXPECT_THAT(flooding->receive_all(), HasSubstr("too many messages: at most 1 a second"));
  // A message in pieces that hold something counts as one.
  const auto client = raw();
  for (int message = 0; message < 10; ++message) {
    for (int i = 0; i < 30; ++i) client->send(piece(i == 0 ? '\1' : '\0', "some", i == 29));
  }
  EXPECT_TRUE(home_.sockets.signal.wait([&] { return home_.sockets.texts.size() == 10; }));
}

TEST_F(SocketTest, ClosesAClientThatSendsTooManyBytesAndSaysWhy) {
  home_.options.limits.burst_bytes = 3000;
  home_.options.limits.rate_bytes = 1000;
  home_.start();
  const auto client = connect();
  ASSERT_TRUE(client);
  ASSERT_OK(client->send_binary(Bytes(2000, 7)));
  ASSERT_OK(client->send_binary(Bytes(2000, 7)));
  EXPECT_ERROR(client->receive(kMax), "too many bytes: at most 1000 a second");
  EXPECT_TRUE(home_.sockets.signal.wait([&] { return home_.sockets.closed == 1; }));
  EXPECT_THAT(home_.sockets.binaries, ElementsAre(2000u));
}

TEST_F(SocketTest, RefusesWhatIsNoFrame) {
  for (const std::string& bytes : {std::string(20, '\xFF'), frame(1, "\xC3\x28"),
                                   std::string("\x81\x05hello", 7),  // not masked
                                   frame(9, std::string(126, 'p'))}) {
    const auto client = raw();
    client->send(bytes);
    EXPECT_TRUE(client->is_closed());
  }
  EXPECT_TRUE(home_.sockets.signal.wait([&] { return home_.sockets.closed == 4; }));
  EXPECT_TRUE(home_.sockets.texts.empty());
}

TEST_F(SocketTest, ClosesAClientThatDoesNotRead) {
  const auto client = raw();
  // Far more than what the systems between buffer, and than may wait.
  client->send(frame(1, "send 20000"));
  EXPECT_TRUE(home_.sockets.signal.wait([&] { return home_.sockets.closed == 1; }));
  const ServerCounts counts = home_.server->counts();
  EXPECT_EQ(counts.refusals.at("a client that does not read"), 1u);
  EXPECT_GE(counts.messages_dropped, 1u);
  EXPECT_LE(counts.messages_dropped, 257u);
}

TEST_F(SocketTest, ClosesAClientThatNeverSaysHello) {
  home_.sockets.want_hello = true;
  home_.options.limits.hello_s = 5;
  home_.start();
  const auto greeted = connect();
  ASSERT_TRUE(greeted);
  ASSERT_OK(greeted->send_text("hello"));
  ASSERT_OK(greeted->receive(kMax));  // the echo
  const auto silent = connect(home_.helper);
  const auto talking = connect(home_.helper);
  ASSERT_TRUE(silent && talking);
  ASSERT_OK(talking->send_text("where am I?"));
  ASSERT_OK(talking->receive(kMax));
  EXPECT_ERROR(silent->receive(kMax), "no hello came");
  EXPECT_ERROR(talking->receive(kMax), "no hello came");
  EXPECT_EQ(home_.server->counts().refusals.at("a client that says no hello"), 2u);
  ASSERT_OK(greeted->send_text("still here"));
  EXPECT_OK(greeted->receive(kMax));
}

TEST_F(SocketTest, ASessionMayCloseOrFail) {
  for (const std::string text : {"close", "throw"}) {
    const auto connection = connect();
    ASSERT_TRUE(connection);
    ASSERT_OK(connection->send_text(text));
    const auto ended = connection->receive(kMax);
    EXPECT_ERROR(ended, text == "close" ? "you asked for it" : "the computer made a mistake");
  }
  EXPECT_TRUE(home_.sockets.signal.wait([&] { return home_.sockets.closed == 2; }));
  EXPECT_THAT(home_.log_text, HasSubstr("thrown by a test"));
}

TEST_F(SocketTest, WhoIsRemovedIsClosed) {
  const auto connection = connect();
  ASSERT_TRUE(connection);
  EXPECT_TRUE(home_.sockets.signal.wait([&] { return home_.sockets.opened == 1; }));
  EXPECT_EQ(home_
                .ask("DELETE", fmt::format("/api/devices/{}", home_.device.who.device),
                     bearer(home_.helper.token))
                .status,
            200);
  EXPECT_ERROR(connection->receive(kMax), "removed");
  EXPECT_EQ(home_.ask("GET", "/api/me", bearer(home_.device.token)).status, 401);
  const auto refused = ServerConnection::open(address(), credentials(home_.device));
  EXPECT_ERROR(refused, "pair it again");
  EXPECT_EQ(refused.error().code, ErrorCode::kRefused);
}

TEST_F(SocketTest, WhoIsRemovedAndTakesNothingIsCutOffAndHeardNoMore) {
  home_.options.limits.handshake_s = 5;
  home_.options.limits.waiting_messages = 100'000;
  home_.options.limits.waiting_bytes = 100'000'000;
  home_.start();
  const auto client = raw();
  // Far more than what the systems between buffer: the sending stalls.
  client->send(frame(1, "send 20000"));
  client->send(frame(1, "all sent"));
  EXPECT_TRUE(home_.sockets.signal.wait([&] { return home_.sockets.texts.size() == 2; }));
  EXPECT_EQ(home_
                .ask("DELETE", fmt::format("/api/devices/{}", home_.device.who.device),
                     bearer(home_.helper.token))
                .status,
            200);
  client->send(frame(1, "heard?"));
  home_.sockets.last_out->send_text("where somebody is");
  EXPECT_TRUE(home_.sockets.signal.wait([&] { return home_.sockets.closed == 1; }));
  EXPECT_THAT(home_.sockets.texts, ElementsAre("send 20000", "all sent"));
  const std::string received = client->receive_all();
  EXPECT_LT(received.size(), 20'000U * 1024) << "the sending had not stalled";
  EXPECT_THAT(received, Not(HasSubstr("where somebody is")));
}

TEST_F(SocketTest, ADevicesNewestConnectionsStay) {
  const auto first = connect();
  const auto second = connect();
  EXPECT_TRUE(home_.sockets.signal.wait([&] { return home_.sockets.opened == 2; }));
  const auto third = connect();
  EXPECT_ERROR(first->receive(kMax), "connected again");
  ASSERT_OK(third->send_text("still here"));
  EXPECT_OK(third->receive(kMax));
}

TEST_F(SocketTest, StopsWithOpenSockets) {
  const auto connection = connect();
  ASSERT_TRUE(connection);
  EXPECT_TRUE(home_.sockets.signal.wait([&] { return home_.sockets.opened == 1; }));
  home_.server->stop();
  EXPECT_EQ(home_.sockets.closed, 1);
  EXPECT_ERROR(connection->receive(kMax), "the computer stops");
  home_.sockets.last_out->send_text("to nobody");  // harmless
  home_.start();
  EXPECT_TRUE(connect());
}

TEST_F(SocketTest, TrustsOneCertificateOnly) {
  const TestServer impostor;
  EXPECT_ERROR(ServerConnection::open({"127.0.0.1", impostor.port()}, credentials(home_.device)),
               "shows another certificate");
  // Not even the token was sent.
  EXPECT_EQ(impostor.server->counts().answers.size(), 0u);
}

TEST_F(SocketTest, KnowsTheComputerAgainWhenItsCertificateWasRenewed) {
  const auto before = home_.ask("GET", "/api/authority");
  EXPECT_EQ(before.status, 200);
  const Certificate renewed =
      own_certificate(home_.access_files(), {"localhost", "127.0.0.1", "10.1.2.3"},
                      home_.now().unix_s)
          .value();
  ASSERT_NE(renewed.own_fingerprint, home_.certificate.own_fingerprint);
  home_.server->use_certificate(renewed);
  EXPECT_TRUE(connect()) << "it is signed by the same authority";
  EXPECT_EQ(home_.ask("GET", "/api/authority").body, before.body);
  // Who knows this certificate alone, as before there were authorities, takes the next for
  // another's.
  const ServerCredentials old{renewed.own_fingerprint, home_.device.token};
  EXPECT_OK(ServerConnection::open(address(), old, {.timeout = kMax}));
  home_.server->use_certificate(home_.certificate);
  EXPECT_ERROR(ServerConnection::open(address(), old, {.timeout = kMax}),
               "shows another certificate");
}

TEST_F(SocketTest, GivesTheAuthorityToWhoeverAsks) {
  const testing::Answer file = home_.ask("GET", "/authority.crt");
  EXPECT_EQ(file.status, 200);
  EXPECT_EQ(file.headers.at("content-type"), "application/x-x509-ca-cert");
  const Bytes& der = home_.certificate.authority->certificate;
  EXPECT_EQ(file.body, std::string(der.begin(), der.end()));
  EXPECT_THAT(home_.ask("GET", "/api/authority").body,
              HasSubstr(fingerprint_with_colons(home_.certificate.fingerprint)));
}

TEST_F(SocketTest, CanBeInterrupted) {
  struct Stopped final : Interruption {
    [[nodiscard]] bool interrupted() const override { return true; }
  } stopped;
  const auto opened = ServerConnection::open(address(), credentials(home_.device),
                                             {.timeout = kMax, .interruption = &stopped});
  EXPECT_ERROR(opened, "interrupted");
  EXPECT_EQ(opened.error().code, ErrorCode::kInterrupted);
}

TEST_F(SocketTest, NothingSecretIsLogged) {
  const auto connection = connect();
  (void)home_.ask("GET", "/api/me?token=" + home_.device.token, bearer(home_.helper.token));
  (void)home_.ask("GET", "/" + home_.device.token, bearer(home_.helper.token));
  const auto code = home_.access->make_code(Role::kDevice, home_.now());
  ASSERT_OK(code);
  (void)home_.ask("POST", "/api/pair", "", "{\"code\":\"" + code->digits + "\",\"name\":\"new\"}");
  home_.server->stop();
  for (const std::string& secret :
       {home_.device.token, home_.helper.token, code->digits, code->secret}) {
    EXPECT_THAT(home_.log_text, Not(HasSubstr(secret)));
  }
  EXPECT_THAT(home_.log_text, HasSubstr("Anna's phone"));
}

TEST_F(SocketTest, PairsWithoutSayingTheCode) {
  const auto code = home_.access->make_code(Role::kHelper, home_.now());
  ASSERT_OK(code);
  const ClientWait wait{.timeout = kMax};
  const std::string wrong = code->digits == "000000" ? "000001" : "000000";
  const auto refused = pair_with(address(), wrong, "Cap", wait);
  EXPECT_ERROR(refused, "the code is wrong");
  EXPECT_EQ(refused.error().refusal, PairingRefusal::kCode);
  const auto unnamed = pair_with(address(), code->digits, std::string(65, 'x'), wait);
  ASSERT_FALSE(unnamed);
  EXPECT_EQ(unnamed.error().refusal, PairingRefusal::kName) << unnamed.error().message;
  const std::string in_groups = code->digits.substr(0, 3) + " - " + code->digits.substr(3);
  const auto paired = pair_with(address(), in_groups, "Cap", wait);
  ASSERT_OK(paired);
  EXPECT_EQ(paired->who.role, Role::kHelper);
  EXPECT_EQ(paired->credentials.fingerprint, home_.certificate.fingerprint);
  EXPECT_OK(ServerConnection::open(address(), paired->credentials, wait));
  EXPECT_ERROR(pair_with(address(), code->digits, "Cap", wait), "the code is wrong");
}

TEST_F(SocketTest, PairsByALinkWithoutSayingItsSecret) {
  const auto code = home_.access->make_code(Role::kDevice, home_.now());
  ASSERT_OK(code);
  const ClientWait wait{.timeout = kMax};
  const std::string link = "https://flat.local:8443/pair#" + code->secret;
  const auto paired = pair_with(address(), link, "Cap", wait);
  ASSERT_OK(paired);
  EXPECT_EQ(paired->who.role, Role::kDevice);
  EXPECT_ERROR(pair_with(address(), link, "Cap", wait), "the link is no longer valid");
  home_.server->stop();
  EXPECT_THAT(home_.log_text, Not(HasSubstr(code->secret)));
}

TEST_F(SocketTest, PairsWithNobodyWhoDoesNotKnowTheCode) {
  // One who takes any code, to be sent pictures.
  const Route pair{"POST", "/api/pair", std::nullopt, [](const HttpRequest&, const Placeholders&) {
                     HttpAnswer answer =
                         text_answer(R"({"role":"device","device":1,"token":"t","proof":")" +
                                     std::string(64, '0') + R"("})");
                     return answer;
                   }};
  TestServer impostor({pair});
  const auto paired = pair_with({"127.0.0.1", impostor.port()}, "123456", "Cap", {.timeout = kMax});
  EXPECT_ERROR(paired, "does not know the code");
  EXPECT_EQ(paired.error().code, ErrorCode::kRefused);
}

TEST_F(SocketTest, GuessesThroughHttpAreAnsweredByWaiting) {
  const auto code = home_.access->make_code(Role::kDevice, home_.now());
  const auto guess = [&](const std::string& digits, const std::string& from) {
    return home_.ask("POST", "/api/pair", "",
                     fmt::format(R"({{"code": "{}", "name": "x"}})", digits), from);
  };
  const std::string wrong = code->digits == "000000" ? "000001" : "000000";
  for (int i = 0; i < 3; ++i) {
    const testing::Answer answer = guess(wrong, "127.0.0.5");
    EXPECT_EQ(answer.status, 401);
    EXPECT_THAT(answer.body, ::testing::HasSubstr(R"("message":"code_over")"));
  }
  for (int i = 0; i < 50; ++i) {
    const testing::Answer answer = guess(wrong, "127.0.0.5");
    ASSERT_EQ(answer.status, 429);
    ASSERT_EQ(answer.headers.at("retry-after"), "30");
  }
  const testing::Answer paired =
      home_.ask("POST", "/api/pair", "",
                fmt::format(R"({{"code": "{}", "name": "page", "cookie": true}})", code->digits));
  EXPECT_EQ(paired.status, 200);
  EXPECT_THAT(paired.headers.at("set-cookie"),
              HasSubstr("; Path=/; Max-Age=34560000; Secure; HttpOnly; SameSite=Strict"));
  EXPECT_THAT(paired.body, Not(HasSubstr("token")));
}

TEST_F(SocketTest, ADeviceMayLeave) {
  const std::string token = bearer(home_.device.token);
  EXPECT_THAT(home_.ask("GET", "/api/me", token).body, HasSubstr("Anna's phone"));
  const testing::Answer left = home_.ask("POST", "/api/leave", token);
  EXPECT_EQ(left.status, 200);
  EXPECT_THAT(left.headers.at("set-cookie"), HasSubstr("roomwise=; Path=/; Max-Age=0;"));
  EXPECT_EQ(home_.ask("GET", "/api/me", token).status, 401);
  EXPECT_THAT(home_.ask("GET", "/api/devices", bearer(home_.helper.token)).body,
              Not(HasSubstr("Anna")));
}

TEST(ServerAddressTest, IsHostAndPort) {
  EXPECT_EQ(parse_server_address("flat.local:8443")->host, "flat.local");
  EXPECT_EQ(parse_server_address("[fe80::1]:8443")->host, "fe80::1");
  EXPECT_EQ(parse_server_address("10.0.0.1:1")->port, 1);
  EXPECT_EQ(parse_server_address("10.0.0.1:1")->base, "");
  const auto one_of_many = parse_server_address("[::1]:8443/homes/flat-7/");
  ASSERT_OK(one_of_many);
  EXPECT_EQ(one_of_many->host, "::1");
  EXPECT_EQ(one_of_many->base, "/homes/flat-7");
  for (const char* bad :
       {"", "flat", "flat:", ":1", "flat:0", "flat:65536", "flat:1x", "https://flat:1", "a b:1",
        "flat:1/homes", "flat:1/homes/", "flat:1/homes/a/b", "flat:1/else", "flat:1/homes/a?b"}) {
    EXPECT_ERROR(parse_server_address(bad), "HOST:PORT");
  }
}

}  // namespace
}  // namespace roomwise::service
