#include "roomwise/service/server/server.h"

#include <gmock/gmock.h>
#include <signal.h>
#include <sys/resource.h>

#include <atomic>
#include <nlohmann/json.hpp>

#include "roomwise/service/testing/testing_service.h"

namespace roomwise::service {
namespace {

using testing::Answer;
using ::testing::AnyOf;
using testing::bearer;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::RawClient;
using testing::TestServer;

Route route(const char* method, const char* pattern, std::optional<Role> role,
            std::size_t max_body = 1024) {
  return {method, pattern, role,
          [pattern](const HttpRequest& request, const Placeholders& placeholders) {
            nlohmann::json json = {{"pattern", pattern}, {"body", request.body.size()}};
            for (const auto& [name, value] : placeholders) json[name] = value;
            return json_answer(json);
          },
          max_body};
}

std::string concrete(std::string pattern) {
  for (std::size_t at; (at = pattern.find('{')) != std::string::npos;) {
    pattern.replace(at, pattern.find('}') - at + 1, "7");
  }
  return pattern;
}

TEST(ServerTest, EveryRouteAsksForItsRole) {
  TestServer home({route("GET", "/health", std::nullopt), route("GET", "/metrics", Role::kHelper),
                   route("GET", "/api/home", Role::kDevice),
                   route("PUT", "/api/rooms/{name}", Role::kHelper),
                   route("POST", "/api/test", Role::kHelper, 1'000'000)});
  const TestServer neighbour;
  const auto cookie = [](const std::string& token) {
    return "Cookie: a=b; roomwise=" + token + "\r\n";
  };
  for (const Route& row : home.routes) {
    // They end what the test needs, and have tests of their own.
    if (row.pattern == "/api/leave" || row.pattern == "/api/devices/{device}") continue;
    SCOPED_TRACE(row.method + " " + row.pattern);
    const auto status = [&](const std::string& header) {
      return home.ask(row.method, concrete(row.pattern), header, row.method == "GET" ? "" : "{}")
          .status;
    };
    // The handlers of pairing refuse an empty body with 400: they were reached.
    const auto reached = AnyOf(200, 400);
    for (const std::string& header :
         {std::string(), bearer("nonsense"), bearer(""), bearer(neighbour.helper.token),
          cookie(neighbour.helper.token), cookie("")}) {
      if (row.role) {
        EXPECT_EQ(status(header), 401) << header;
      } else {
        EXPECT_THAT(status(header), reached) << header;
      }
    }
    for (const std::string& header : {bearer(home.device.token), cookie(home.device.token)}) {
      if (row.role == Role::kHelper) {
        EXPECT_EQ(status(header), 403);
      } else {
        EXPECT_THAT(status(header), reached);
      }
    }
    for (const std::string& header : {bearer(home.helper.token), cookie(home.helper.token)}) {
      EXPECT_THAT(status(header), reached);
    }
  }
}

TEST(ServerTest, SaysWhatIsPossible) {
  TestServer home({route("GET", "/api/home", Role::kDevice),
                   route("PUT", "/api/rooms/{name}", Role::kHelper),
                   route("DELETE", "/api/rooms/{name}", Role::kHelper)});
  const Answer wrong_method = home.ask("POST", "/api/rooms/a", bearer(home.helper.token));
  EXPECT_EQ(wrong_method.status, 405);
  EXPECT_EQ(wrong_method.headers.at("allow"), "PUT, DELETE");
  EXPECT_EQ(home.ask("GET", "/api/nothing", bearer(home.helper.token)).status, 404);
  const Answer named = home.ask("PUT", "/api/rooms/bath%2Froom%20two", bearer(home.helper.token));
  EXPECT_EQ(nlohmann::json::parse(named.body)["name"], "bath/room two");
  EXPECT_EQ(home.ask("GET", "/api/%zz").status, 400);
  const Answer head = home.ask("HEAD", "/api/home", bearer(home.device.token));
  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head.headers.at("content-length"),
            std::to_string(home.ask("GET", "/api/home", bearer(home.device.token)).body.size()));
}

TEST(ServerTest, EveryAnswerHasTheHeadersOfSecurity) {
  TestServer home({route("GET", "/api/home", Role::kDevice)});
  for (const Answer& answer :
       {home.ask("GET", "/api/home", bearer(home.device.token)), home.ask("GET", "/nothing"),
        home.ask("GET", "/api/home"), home.ask("GET", "/%")}) {
    EXPECT_THAT(answer.headers.at("content-security-policy"),
                HasSubstr("default-src 'none'; script-src 'self'"));
    EXPECT_THAT(answer.headers.at("content-security-policy"), HasSubstr("wss://127.0.0.1;"));
    EXPECT_EQ(answer.headers.at("x-content-type-options"), "nosniff");
    EXPECT_EQ(answer.headers.at("referrer-policy"), "no-referrer");
    EXPECT_EQ(answer.headers.at("cache-control"), "no-store");
    EXPECT_FALSE(answer.headers.contains("strict-transport-security"));
  }
}

TEST(ServerTest, RefusesPagesOfOtherSites) {
  TestServer home({route("GET", "/api/home", Role::kDevice)});
  const auto status = [&](const std::string& headers) {
    return home.ask("GET", "/api/home", bearer(home.device.token) + headers).status;
  };
  EXPECT_EQ(status("Origin: https://127.0.0.1\r\n"), 200);
  EXPECT_EQ(status("Origin: https://evil.example\r\n"), 403);
  EXPECT_EQ(status("Origin: http://127.0.0.1\r\n"), 403);
  EXPECT_EQ(status("Origin: null\r\n"), 403);
  EXPECT_EQ(status("Origin: https://127.0.0.1.evil.example\r\n"), 403);
  EXPECT_EQ(status("Sec-Fetch-Site: cross-site\r\n"), 403);
  EXPECT_EQ(status("Sec-Fetch-Site: same-origin\r\n"), 200);
  EXPECT_EQ(status("Sec-Fetch-Site: cross-site\r\nSec-Fetch-Mode: navigate\r\n"), 200);
  RawClient client(home.port());
  ASSERT_TRUE(client.shake_hands());
  client.send("GET /api/home HTTP/1.1\r\nHost: a b\r\n\r\n");
  EXPECT_EQ(client.receive().status, 400);
}

TEST(ServerTest, StrangersMustCallTheComputerByANameOfItsOwn) {
  TestServer home({route("GET", "/health", std::nullopt)});
  const auto status = [&](const std::string& host, const std::string& more = "") {
    RawClient client(home.port());
    if (!client.shake_hands()) return 0;
    client.send(fmt::format("GET /health HTTP/1.1\r\nHost: {}\r\n{}\r\n", host, more));
    return client.receive().status;
  };
  EXPECT_EQ(status("localhost:8443"), 200);
  EXPECT_EQ(status("192.168.1.5"), 200);
  // Another site's name that was made to lead here, also where its page says that it is its own.
  EXPECT_EQ(status("evil.example"), 421);
  EXPECT_EQ(status("evil.example", "Origin: https://evil.example\r\n"), 421);
  EXPECT_EQ(status("evil.example", bearer("guessed")), 421);
  EXPECT_EQ(home.server->counts().refusals.at("a name that is not this computer's"), 3u);
  // Who was paired under a name of their network is known by the token.
  EXPECT_EQ(status("flat.example", bearer(home.device.token)), 200);
}

TEST(ServerTest, OfWhatAProxySaysOnlyTheAddressCounts) {
  Route peer = route("GET", "/peer", std::nullopt);
  peer.handler = [](const HttpRequest& request, const Placeholders&) {
    return text_answer(request.peer);
  };
  TestServer home({peer});
  home.options.proxies = {"127.0.0.1"};
  home.start();
  const auto seen = [&](const std::string& forwarded) {
    return home.ask("GET", "/peer", "X-Forwarded-For: " + forwarded + "\r\n").body;
  };
  EXPECT_EQ(seen("10.0.0.5"), "10.0.0.5");
  EXPECT_EQ(seen("10.0.0.5, 2001:db8::1"), "2001:db8::1");
  EXPECT_EQ(seen("fe80::1%eth0"), "fe80::1");
  EXPECT_EQ(seen("fe80::1%: device 9 (anna) connected"), "fe80::1");
  for (const char* none : {"10.0.0.5%1", "10.0.0.5%device 9", "anna", "", "%", "10.0.0.5:80"}) {
    EXPECT_EQ(seen(none), "127.0.0.1") << none;
  }
}

TEST(ServerTest, LimitsWhatIsSent) {
  TestServer home(
      {route("POST", "/api/test", Role::kHelper, 1000), route("POST", "/open", std::nullopt, 10)});
  const std::string helper = bearer(home.helper.token);
  EXPECT_EQ(home.ask("POST", "/api/test", helper, std::string(1000, 'a')).status, 200);
  EXPECT_EQ(home.ask("POST", "/api/test", helper, std::string(1001, 'a')).status, 413);
  EXPECT_EQ(home.ask("POST", "/api/test", "X: " + std::string(9000, 'a') + "\r\n").status, 431);
  // The body of somebody who may not is never waited for.
  RawClient refused(home.port());
  ASSERT_TRUE(refused.shake_hands());
  refused.send("POST /api/test HTTP/1.1\r\nHost: h\r\nContent-Length: 999\r\n\r\n");
  EXPECT_EQ(refused.receive().status, 401);
  // A body that does not say how long it is.
  RawClient chunked(home.port());
  ASSERT_TRUE(chunked.shake_hands());
  chunked.send("POST /open HTTP/1.1\r\nHost: h\r\nTransfer-Encoding: chunked\r\n\r\n");
  chunked.send("14\r\n" + std::string(20, 'a') + "\r\n0\r\n\r\n");
  EXPECT_EQ(chunked.receive().status, 413);
  // Who asks before sending is told to go on, or not to.
  RawClient careful(home.port());
  ASSERT_TRUE(careful.shake_hands());
  careful.send(
      "POST /open HTTP/1.1\r\nHost: h\r\nContent-Length: 5\r\nExpect: 100-continue\r\n\r\n");
  EXPECT_EQ(careful.receive().status, 100);
  careful.send("12345");
  EXPECT_EQ(careful.receive().status, 200);
}

TEST(ServerTest, WhoIsRemovedEndsNoRequestThatTheyBegan) {
  std::atomic<int> done = 0;
  Route change = route("POST", "/api/change", Role::kDevice);
  change.handler = [&](const HttpRequest&, const Placeholders&) {
    ++done;
    return text_answer("done");
  };
  TestServer home({change});
  const auto begin = [&](RawClient& client, const std::string& token) {
    ASSERT_TRUE(client.shake_hands());
    client.send(
        "POST /api/change HTTP/1.1\r\nHost: a\r\nContent-Length: 2\r\nExpect: "
        "100-continue\r\n" +
        bearer(token) + "\r\n");
    EXPECT_EQ(client.receive().status, 100) << "the server knows who asks";
    client.send("{");
  };
  RawClient removed(home.port()), stays(home.port());
  begin(removed, home.device.token);
  begin(stays, home.helper.token);
  EXPECT_EQ(home.ask("DELETE", fmt::format("/api/devices/{}", home.device.who.device),
                     bearer(home.helper.token))
                .status,
            200);
  removed.send("}");
  EXPECT_EQ(removed.receive().status, 401);
  EXPECT_EQ(done, 0);
  stays.send("}");
  EXPECT_EQ(stays.receive().status, 200);
}

TEST(ServerTest, SurvivesWhatIsNoRequest) {
  TestServer home({route("GET", "/health", std::nullopt)});
  for (const std::string& bytes :
       {std::string("\0\1\2\3\r\n\r\n", 8), std::string("GET\r\n\r\n"),
        std::string("GET / HTTP/9.9\r\n\r\n"),
        std::string("GET http://a/ HTTP/1.1\r\nHost: a\r\n\r\n"),
        std::string("GET / HTTP/1.1\r\nHost\r\n\r\n"),
        std::string("POST /health HTTP/1.1\r\nHost: a\r\nContent-Length: -1\r\n\r\n"),
        std::string(
            "POST /health HTTP/1.1\r\nHost: a\r\nContent-Length: 99999999999999999999999\r\n\r\n"),
        std::string("GET * HTTP/1.1\r\nHost: a\r\n\r\n"),
        std::string("GET /%00 HTTP/1.1\r\nHost: a\r\n\r\n")}) {
    RawClient client(home.port());
    ASSERT_TRUE(client.shake_hands());
    client.send(bytes);
    EXPECT_THAT(client.receive().status, AnyOf(400, 0)) << bytes;
  }
  {
    RawClient broken_off(home.port());
    ASSERT_TRUE(broken_off.shake_hands());
    broken_off.send("GET /health HTT");
  }
  RawClient plain(home.port());
  plain.send_plain("GET / HTTP/1.1\r\nHost: a\r\n\r\n");
  EXPECT_TRUE(plain.is_closed());
  RawClient old(home.port());
  EXPECT_FALSE(old.shake_hands(TLS1_1_VERSION));
  RawClient today(home.port());
  EXPECT_TRUE(today.shake_hands(TLS1_2_VERSION));
  EXPECT_EQ(home.ask("GET", "/health").status, 200);
  EXPECT_TRUE(
      home.log.wait([&] { return home.log_text.find("HTTP without TLS") != std::string::npos; }));
}

TEST(ServerTest, ServesSeveralRequestsOfAConnection) {
  TestServer home({route("GET", "/health", std::nullopt)});
  RawClient client(home.port());
  ASSERT_TRUE(client.shake_hands());
  // At once, without waiting for the answers.
  client.send("GET /health HTTP/1.1\r\nHost: a\r\n\r\nGET /none HTTP/1.1\r\nHost: a\r\n\r\n");
  EXPECT_EQ(client.receive().status, 200);
  EXPECT_EQ(client.receive().status, 404);
  client.send("GET /health HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n");
  EXPECT_EQ(client.receive().status, 200);
  EXPECT_TRUE(client.is_closed());
}

TEST(ServerTest, AFailingHandlerFailsAlone) {
  Route failing = route("GET", "/fails", std::nullopt);
  failing.handler = [](const HttpRequest&, const Placeholders&) -> HttpAnswer {
    throw std::runtime_error("the secret path /home/anna");
  };
  TestServer home({failing});
  const Answer answer = home.ask("GET", "/fails");
  EXPECT_EQ(answer.status, 500);
  EXPECT_THAT(answer.body, Not(HasSubstr("anna")));
  // Its operator learns what is wrong.
  EXPECT_TRUE(home.log.wait([&] {
    return home.log_text.find("GET /fails went wrong: the secret path") != std::string::npos;
  }));
}

TEST(ServerTest, ASlowRequestHoldsUpNoOther) {
  testing::Signal signal;
  bool go = false;
  Route slow = route("GET", "/slow", std::nullopt);
  slow.handler = [&](const HttpRequest&, const Placeholders&) {
    EXPECT_TRUE(signal.wait([&] { return go; }));
    return text_answer("at last");
  };
  TestServer home({slow, route("GET", "/health", std::nullopt)});
  RawClient waiting(home.port());
  ASSERT_TRUE(waiting.shake_hands());
  waiting.send("GET /slow HTTP/1.1\r\nHost: a\r\n\r\n");
  EXPECT_EQ(home.ask("GET", "/health").status, 200);
  signal.change([&] { go = true; });
  EXPECT_EQ(waiting.receive().body, "at last");
}

TEST(ServerTest, AnswersOnlySoManyRequestsASecond) {
  ServerLimits limits;
  limits.burst_per_peer = 3;
  limits.rate_per_peer = 1;
  TestServer home({route("GET", "/health", std::nullopt)}, limits);
  RawClient client(home.port());
  ASSERT_TRUE(client.shake_hands());
  for (int i = 0; i < 3; ++i) EXPECT_EQ(client.ask("GET", "/health").status, 200);
  const Answer refused = client.ask("GET", "/health");
  EXPECT_EQ(refused.status, 429);
  EXPECT_EQ(refused.headers.at("retry-after"), "1");
  EXPECT_THAT(refused.body, HasSubstr(R"("message":"many_requests")"));
  EXPECT_EQ(home.ask("GET", "/health", "", "", "127.0.0.2").status, 200);
  EXPECT_EQ(home.ask("GET", "/api/me", bearer(home.device.token)).status, 200);
  home.steady_s = home.steady_s + 1;
  EXPECT_EQ(client.ask("GET", "/health").status, 200);
}

// Homes of which one knows who says so, and "Authorization: Bearer broken" finds a fault.
class NotingHomes final : public HomesAtPort {
 public:
  class Home final : public ServedHome {
   public:
    [[nodiscard]] const std::string& name() const override { return name_; }
    [[nodiscard]] const Router& router() const override { return router_; }
    [[nodiscard]] Expected<std::optional<Identity>> identify(const HttpRequest&,
                                                             const Now&) override {
      return kAnna;
    }
    [[nodiscard]] Expected<SocketHandler*> sockets() override {
      throw std::runtime_error("the secret path /home/anna");
    }
    inline static const Identity kAnna{1, "Anna's phone", Role::kDevice};

   private:
    const std::string name_ = "flat-1";
    const Router router_{{route("GET", "/api/me", Role::kDevice), socket_route()}};
  };
  std::variant<ResolvedRequest, HttpAnswer> resolve(const HttpRequest& request,
                                                    const Now&) override {
    ++requests;
    if (request.header("authorization").empty()) return error_answer(401, "nobody");
    if (request.header("authorization") == "Bearer broken") {
      throw std::runtime_error("the secret path /home/anna");
    }
    return ResolvedRequest{std::make_shared<Home>(), "", Home::kAnna};
  }
  std::atomic<int> requests = 0;
};

TEST(ServerTest, ARequestWhoseHomeCannotBeFoundOrOpenedForAFaultFailsAlone) {
  const TestServer own;
  NotingHomes homes;
  testing::Signal log;
  std::string log_text;
  ServerOptions options;
  options.certificate = own.certificate;
  options.log = [&](std::string_view line) {
    log.change([&] { log_text += std::string(line) + "\n"; });
  };
  const auto server = Server::open(std::move(options), homes);
  ASSERT_OK(server);
  (*server)->serve();
  const auto ask = [&](const std::string& target, const std::string& headers) {
    RawClient client((*server)->port());
    return client.shake_hands() ? client.ask("GET", target, headers) : Answer();
  };
  const Answer not_found = ask("/api/me", bearer("broken"));
  EXPECT_EQ(not_found.status, 500);
  EXPECT_THAT(not_found.body, Not(HasSubstr("anna")));
  const Answer not_opened = ask("/api/socket", bearer("x") +
                                                   "Connection: Upgrade\r\nUpgrade: websocket\r\n"
                                                   "Sec-WebSocket-Version: 13\r\n"
                                                   "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
                                                   "Sec-WebSocket-Protocol: roomwise.1\r\n");
  EXPECT_EQ(not_opened.status, 500);
  EXPECT_THAT(not_opened.body, Not(HasSubstr("anna")));
  EXPECT_TRUE(log.wait([&] {
    return log_text.find("GET at /api/socket went wrong: the secret path") != std::string::npos;
  }));
  EXPECT_EQ(ask("/api/me", bearer("x")).status, 200) << "it goes on";
}

TEST(ServerTest, WhoAsksTooOftenIsNotEvenLookedUp) {
  const TestServer own;
  NotingHomes homes;
  ServerOptions options;
  options.certificate = own.certificate;
  options.clock = [] { return Now{1000, 1'700'000'000}; };
  options.limits.burst_per_peer = 3;
  const auto server = Server::open(std::move(options), homes);
  ASSERT_OK(server);
  (*server)->serve();
  RawClient client((*server)->port());
  ASSERT_TRUE(client.shake_hands());
  // Who is known is counted for themselves.
  for (int i = 0; i < 5; ++i) EXPECT_EQ(client.ask("GET", "/api/me", bearer("x")).status, 200);
  RawClient stranger((*server)->port());
  ASSERT_TRUE(stranger.shake_hands());
  for (int i = 0; i < 3; ++i) EXPECT_EQ(stranger.ask("GET", "/api/me").status, 401);
  EXPECT_EQ(homes.requests, 8);
  EXPECT_EQ(stranger.ask("GET", "/api/me").status, 429);
  EXPECT_EQ(homes.requests, 8);
}

// The tests' process holds both ends of every connection.
void allow_open_files(rlim_t most) {
  rlimit limit{};
  ::getrlimit(RLIMIT_NOFILE, &limit);
  limit.rlim_cur = std::max(limit.rlim_cur, std::min(limit.rlim_max, most));
  ::setrlimit(RLIMIT_NOFILE, &limit);
}

TEST(ServerTest, AThousandIdleConnectionsKeepNobodyOut) {
  allow_open_files(4096);
  ::signal(SIGPIPE, SIG_IGN);  // who is sent away while shaking hands
  TestServer home({route("GET", "/health", std::nullopt)});
  std::vector<std::unique_ptr<RawClient>> idle;
  for (int i = 0; i < 1000; ++i) {
    idle.push_back(std::make_unique<RawClient>(home.port(), fmt::format("127.0.1.{}", 1 + i / 20)));
    if (i % 10 == 0) (void)idle.back()->shake_hands();  // and ask nothing; some find no place
  }
  // From an address that is not among them, and from one that is.
  EXPECT_EQ(home.ask("GET", "/api/me", bearer(home.device.token), "", "127.0.2.1").status, 200);
  const ServerCounts counts = home.server->counts();
  EXPECT_LE(counts.open_connections, 64u + 1);
  EXPECT_GE(counts.refusals.at("made room for a newer connection"), 900u);
}

// Each limit by itself, so that a slow machine is not taken for a client that does not go on.
TEST(ServerTest, ClosesWhoDoesNotGoOn) {
  constexpr double kSoon_s = 0.3;
  const std::vector<Route> routes{route("GET", "/health", std::nullopt),
                                  route("POST", "/open", std::nullopt)};
  const auto soon = [](double ServerLimits::*limit) {
    ServerLimits limits;
    limits.*limit = kSoon_s;
    return limits;
  };
  {
    TestServer home(routes, soon(&ServerLimits::handshake_s));
    RawClient silent(home.port());
    EXPECT_TRUE(silent.is_closed()) << "shakes no hands";
    RawClient mute(home.port());
    (void)mute.shake_hands();
    EXPECT_TRUE(mute.is_closed()) << "asks nothing";
  }
  {
    TestServer home(routes, soon(&ServerLimits::request_s));
    RawClient slow(home.port());
    ASSERT_TRUE(slow.shake_hands());
    slow.send("POST /open HTTP/1.1\r\nHost: h\r\nContent-Length: 5\r\n\r\n12");
    EXPECT_TRUE(slow.is_closed()) << "never ends what it asks";
  }
  {
    TestServer home(routes, soon(&ServerLimits::idle_s));
    RawClient idle(home.port());
    ASSERT_TRUE(idle.shake_hands());
    EXPECT_EQ(idle.ask("GET", "/health").status, 200);
    EXPECT_TRUE(idle.is_closed()) << "asks nothing more";
  }
}

TEST(ServerTest, RequestsThatNoWorkerCanTakeAreSentAway) {
  ServerLimits limits;
  limits.waiting_requests = 0;
  TestServer home({route("GET", "/health", std::nullopt)}, limits);
  EXPECT_EQ(home.ask("GET", "/health").status, 503);
}

TEST(ServerTest, StopsWhileClientsAreConnected) {
  TestServer home({route("GET", "/health", std::nullopt)});
  RawClient idle(home.port());
  ASSERT_TRUE(idle.shake_hands());
  EXPECT_EQ(idle.ask("GET", "/health").status, 200);
  RawClient silent(home.port());
  const auto port = home.port();
  home.server->stop();
  EXPECT_TRUE(idle.is_closed());
  EXPECT_TRUE(silent.is_closed());
  EXPECT_FALSE(RawClient(port).shake_hands());
  home.server->stop();
  home.start();  // at the same port
  EXPECT_EQ(home.port(), port);
  EXPECT_EQ(home.ask("GET", "/health").status, 200);
}

TEST(ServerTest, ListensOnlyWhereItCan) {
  TestServer home;
  testing::NotingSockets sockets;
  ServerOptions options = home.options;
  const auto start = [&] { return Server::start(options, Router({}), *home.access, sockets); };
  EXPECT_ERROR(start(), "is another server running?");
  options.port = 0;
  options.address = "nowhere";
  EXPECT_ERROR(start(), "'nowhere' is no address");
  options.address = "127.0.0.1";
  options.pages = "/none/such";
  EXPECT_ERROR(start(), "the folder of the pages is not there");
}

}  // namespace
}  // namespace roomwise::service
