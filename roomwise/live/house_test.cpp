#include "roomwise/live/house.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "roomwise/live/routes/home_routes.h"
#include "roomwise/pipeline/edits/edit_rooms.h"
#include "roomwise/pipeline/edits/walk_edits.h"
#include "roomwise/pipeline/rooms/room_learning.h"
#include "roomwise/service/client/client.h"
#include "roomwise/service/credentials/pairing_proof.h"
#include "roomwise/service/testing/testing_service.h"

namespace roomwise::live {
namespace {

namespace fs = std::filesystem;
using service::Role;
using service::testing::Answer;
using service::testing::bearer;
using service::testing::RawClient;
using ::testing::AnyOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

// A folder of homes and a process that serves it. Its clock stands still until it is told on.
class ServedHouse {
  std::mutex log_mutex_;  // first: the homes write to the log to their end
  std::string log_;
  std::string acts_;

 public:
  struct Options {
    std::size_t max_open = 8;
    std::function<Expected<std::optional<service::Identity>>(const service::HttpRequest&,
                                                             const std::string&)>
        known = [](const auto&, const auto&) { return std::nullopt; };
    std::function<Expected<std::optional<Role>>(std::int64_t, const std::string&)> role_of_account =
        [](std::int64_t, const auto&) { return std::nullopt; };
    // Called before a home is taken into the house, and before it is opened.
    std::function<void(const std::string& home)> takes_in = [](const auto&) {};
    std::function<void(const std::string& home)> opens = [](const auto&) {};
  };
  ServedHouse(const fs::path& folder, const Options& options) {
    const fs::path own = folder / "house.access";
    fs::create_directory(own);
    fs::permissions(own, fs::perms::owner_all);
    certificate = service::own_certificate(own, {"localhost", "127.0.0.1"}, 1'700'000'000).value();
    HouseOptions house_options;
    house_options.max_open = options.max_open;
    house_options.fingerprint = certificate.fingerprint;
    house_options.networks = [opens = options.opens](const fs::path& file) {
      opens(file.stem().string());
      return std::make_shared<const pipeline::Networks>();
    };
    house_options.clock = [this] { return now(); };
    house_options.home.log = [this](std::string_view line) {
      const std::scoped_lock lock(log_mutex_);
      log_ += std::string(line) + "\n";
    };
    house_options.access = [this, takes_in = options.takes_in](const std::string& home) {
      takes_in(home);
      service::AccessRoutesContext context;
      context.clock = [this] { return now(); };
      context.online = [this, home] { return server->online(home); };
      context.disconnect = [this, home](std::int64_t device) {
        server->disconnect(service::DeviceOfHome{home, device}, "removed");
      };
      return context;
    };
    house_options.audit = [this](const HouseAct& act) {
      const std::scoped_lock lock(log_mutex_);
      acts_ += fmt::format("{}: {} {} {}\n", act.home, act.who.name, act.what, act.status);
    };
    house_options.known_to_house = options.known;
    house_options.role_of_account = options.role_of_account;
    house = House::open(folder, finders, std::move(house_options)).value();
    service::ServerOptions server_options;
    server_options.certificate = certificate;
    server_options.clock = [this] { return now(); };
    server_options.workers = 4;
    server_options.limits.burst_per_device = 1e6;
    server_options.limits.burst_per_peer = 1e6;
    server = service::Server::open(std::move(server_options), *house).value();
    server->serve();
  }

  [[nodiscard]] service::Now now() const { return {steady_s, 1'700'000'000}; }
  Answer ask(const std::string& method, const std::string& target, const std::string& headers = "",
             const std::string& body = "") const {
    RawClient client(server->port());
    if (!client.shake_hands()) return {};
    return client.ask(method, target, headers, body);
  }
  // A token of a device that is paired by a code, as people do it.
  std::string pair(const std::string& home, Role role) {
    const auto code = house->make_code(home, role).value();
    const Answer answer =
        ask("POST", "/homes/" + home + "/api/pair", "",
            nlohmann::json({{"secret", code.secret}, {"name", home + "'s device"}}).dump());
    return nlohmann::json::parse(answer.body).value("token", answer.body);
  }
  // Opens the home and waits until its job is done; the status of the answer.
  [[nodiscard]] int open(const std::string& home, const std::string& token) const {
    const int status = ask("GET", "/homes/" + home + "/api/home", bearer(token)).status;
    while (ask("GET", "/homes/" + home + "/api/job", bearer(token)).body.find("running") !=
           std::string::npos) {
      continue;
    }
    return status;
  }
  [[nodiscard]] service::ServerAddress address(const std::string& home) const {
    return {"127.0.0.1", server->port(), "/homes/" + home};
  }
  [[nodiscard]] std::string log() {
    const std::scoped_lock lock(log_mutex_);
    return log_;
  }
  [[nodiscard]] std::string acts() {
    const std::scoped_lock lock(log_mutex_);
    return acts_;
  }

  std::atomic<double> steady_s = 1000;
  service::Certificate certificate;
  objects::ObjectFinders finders;
  std::unique_ptr<House> house;
  std::unique_ptr<service::Server> server;
};

class HouseTest : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const char* name : {"flat-1", "flat-2", "flat-3"}) {
      ASSERT_OK(pipeline::create_home(folder_ / (std::string(name) + ".home"), {}));
    }
  }
  [[nodiscard]] std::unique_ptr<ServedHouse> serve(const ServedHouse::Options& options = {}) const {
    return std::make_unique<ServedHouse>(folder_ / "", options);
  }

  ::roomwise::testing::ScratchFolder folder_;
};

std::string concrete(std::string pattern) {
  for (std::size_t at; (at = pattern.find('{')) != std::string::npos;) {
    pattern.replace(at, pattern.find('}') - at + 1, "7");
  }
  return pattern;
}

// Everything that a home answers, and who may; as its routes and docs/protocol.md have it.
std::vector<HomeRoute> all_routes() {
  std::vector<HomeRoute> routes = home_routes();
  for (const char* path : {"/api/devices", "/metrics"}) {
    routes.push_back({"GET", path, Role::kHelper, {}});
  }
  for (const char* path : {"/api/me", "/api/socket"}) {
    routes.push_back({"GET", path, Role::kDevice, {}});
  }
  routes.push_back({"PUT", "/api/devices/{device}", Role::kHelper, {}});
  routes.push_back({"DELETE", "/api/devices/{device}", Role::kHelper, {}});
  routes.push_back({"POST", "/api/codes", Role::kHelper, {}});
  routes.push_back({"POST", "/api/leave", Role::kDevice, {}});
  return routes;
}

TEST_F(HouseTest, ATokenOfOneHomeIsNobodysInAnother) {
  const auto serving = serve();
  const std::string neighbour = serving->pair("flat-2", Role::kHelper);
  const std::string helper = serving->pair("flat-1", Role::kHelper);
  const std::string device = serving->pair("flat-1", Role::kDevice);
  const auto cookie = [](const std::string& token) { return "Cookie: roomwise=" + token + "\r\n"; };
  for (const HomeRoute& row : all_routes()) {
    SCOPED_TRACE(row.method + " " + row.pattern);
    const auto status = [&](const std::string& home, const std::string& header) {
      return serving
          ->ask(row.method, "/homes/" + home + concrete(row.pattern), header,
                row.method == "GET" ? "" : "{}")
          .status;
    };
    for (const char* home : {"flat-1", "flat-3", "flat-9"}) {  // the last is not there
      for (const std::string& header : {std::string(), bearer("nonsense"), bearer(neighbour),
                                        cookie(neighbour), cookie("") + bearer(neighbour)}) {
        EXPECT_EQ(status(home, header), 401) << home << " " << header;
      }
    }
    EXPECT_EQ(status("flat-2", bearer(helper)), 401);
    EXPECT_EQ(status("flat-2", bearer(device)), 401);
    if (row.role == Role::kHelper) {
      EXPECT_EQ(status("flat-1", bearer(device)), 403);
    } else if (row.pattern != "/api/leave") {
      EXPECT_THAT(status("flat-1", bearer(device)), AnyOf(200, 426));
    }
  }
  // Whether a home is there is not to be had by asking what it lacks, or what is the house's.
  for (const auto& [method, path] :
       {std::pair("GET", "/api/authority"), std::pair("GET", "/api/nothing"),
        std::pair("PUT", "/api/authority"), std::pair("PATCH", "/api/home"),
        std::pair("GET", "/api/pair"), std::pair("GET", "/api/")}) {
    SCOPED_TRACE(std::string(method) + " " + path);
    const auto answer = [&](const std::string& home) {
      return serving->ask(method, "/homes/" + home + path, "", *method == 'G' ? "" : "{}");
    };
    const Answer there = answer("flat-1");
    const Answer not_there = answer("flat-9");
    EXPECT_EQ(there.status, not_there.status);
    EXPECT_EQ(there.body, not_there.body);
    EXPECT_EQ(there.headers, not_there.headers);
  }
  EXPECT_EQ(serving->ask("GET", "/homes/flat-9/api/nothing").status, 401);
  EXPECT_EQ(serving->ask("GET", "/homes/flat-1/api/nothing", bearer(helper)).status, 404);
  EXPECT_EQ(serving->ask("GET", "/homes/flat-9/api/authority").body,
            serving->ask("GET", "/api/authority").body);
  // Who was refused opened nothing.
  EXPECT_THAT(serving->house->open_homes(), ElementsAre("flat-1"));
  EXPECT_EQ(serving->ask("GET", "/homes/flat-1/api/home", bearer(helper)).status, 200);
  // Nothing of a home is to be had under the house's own addresses.
  for (const char* path : {"/api/me", "/api/home", "/api/devices", "/api/socket", "/metrics"}) {
    EXPECT_EQ(serving->ask("GET", path, bearer(helper)).status, 404);
  }
}

TEST_F(HouseTest, ACodeAndACookieAreOfOneHome) {
  const auto serving = serve();
  const auto code = serving->house->make_code("flat-1", Role::kHelper).value();
  const std::string by_secret =
      nlohmann::json({{"secret", code.secret}, {"name", "a"}, {"cookie", true}}).dump();
  const std::string by_digits = nlohmann::json({{"code", code.digits}, {"name", "a"}}).dump();
  for (const std::string& body : {by_secret, by_digits}) {
    EXPECT_EQ(serving->ask("POST", "/homes/flat-2/api/pair", "", body).status, 401);
    EXPECT_EQ(serving->ask("POST", "/homes/flat-9/api/pair", "", body).status, 401);
  }
  const Answer paired = serving->ask("POST", "/homes/flat-1/api/pair", "", by_secret);
  EXPECT_EQ(paired.status, 200);
  EXPECT_THAT(paired.headers.at("set-cookie"), HasSubstr("Path=/homes/flat-1/;"));
  EXPECT_EQ(serving->ask("GET", "/homes/flat-1").headers.at("location"), "/homes/flat-1/");
}

TEST_F(HouseTest, ACodeEndsWithTheRightsOfWhoMadeIt) {
  std::atomic<Role> role_of_anna = Role::kHelper;
  ServedHouse::Options options;
  options.known = [](const service::HttpRequest& request, const auto&) {
    return request.header("cookie") == "roomwise-staff=anna"
               ? std::optional(service::Identity{-5, "anna", Role::kHelper})
               : std::nullopt;
  };
  options.role_of_account = [&](std::int64_t account, const std::string& home) {
    return account == 5 && home == "flat-1" ? std::optional<Role>(role_of_anna) : std::nullopt;
  };
  const auto serving = serve(options);
  const std::string helper = bearer(serving->pair("flat-1", Role::kHelper));
  const std::string staff = "Cookie: roomwise-staff=anna\r\n";
  const auto make = [&](const std::string& who) {
    const Answer answer =
        serving->ask("POST", "/homes/flat-1/api/codes", who, R"({"role": "helper"})");
    return nlohmann::json::parse(answer.body).value("code", answer.body);
  };
  const auto redeem = [&](const std::string& digits) {
    return serving
        ->ask("POST", "/homes/flat-1/api/pair", "",
              nlohmann::json({{"code", digits}, {"name", "a"}}).dump())
        .status;
  };
  EXPECT_EQ(redeem(make(helper)), 200);
  EXPECT_EQ(redeem(make(staff)), 200);
  const std::string of_helper = make(helper), of_staff = make(staff);
  EXPECT_EQ(serving
                ->ask("DELETE", "/homes/flat-1/api/devices/1",
                      bearer(serving->pair("flat-1", Role::kHelper)))
                .status,
            200);
  role_of_anna = Role::kDevice;
  EXPECT_EQ(redeem(of_helper), 401);
  EXPECT_EQ(redeem(of_staff), 401);
}

// They may be removed after a request was found to be theirs, and before the server could end it.
TEST_F(HouseTest, WhoIsRemovedMeanwhileGetsNoSocketAndNoAnswer) {
  std::atomic<int> asked = 0;
  ServedHouse::Options options;
  options.known = [&](const service::HttpRequest& request, const auto&) {
    return request.header("cookie") == "roomwise-staff=anna" && ++asked % 2 == 1
               ? std::optional(service::Identity{-5, "anna", Role::kHelper})
               : std::nullopt;
  };
  const auto serving = serve(options);
  const std::string staff = "Cookie: roomwise-staff=anna\r\n";
  EXPECT_EQ(serving->ask("GET", "/homes/flat-1/api/devices", staff).status, 401);
  EXPECT_EQ(asked, 2);
  const Answer socket = serving->ask("GET", "/homes/flat-1/api/socket",
                                     staff +
                                         "Connection: Upgrade\r\nUpgrade: websocket\r\n"
                                         "Sec-WebSocket-Version: 13\r\n"
                                         "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
                                         "Sec-WebSocket-Protocol: roomwise.1\r\n");
  EXPECT_EQ(socket.status, 401);
  EXPECT_EQ(asked, 4);
  EXPECT_THAT(serving->house->open_homes(), IsEmpty());
}

// What somebody without an identity is told who asks to be paired with one home after the other:
// of flat-1 a code is open, of flat-2 none, flat-3 nobody has asked for, flat-9 is not there.
TEST_F(HouseTest, WhoGuessesACodeDoesNotLearnWhichHomesThereAre) {
  const auto serving = serve();
  const auto code = serving->house->make_code("flat-1", Role::kHelper).value();
  EXPECT_EQ(serving->ask("GET", "/homes/flat-2/api/me", bearer("nonsense")).status, 401);
  const std::string wrong = fmt::format("{:06}", (std::stoi(code.digits) + 1) % 1'000'000);
  const std::string proof(64, 'a'), nonce(32, '1');
  const std::vector<nlohmann::json> attempts{
      {{"code", "12345"}, {"name", "a"}},
      {{"code", wrong}, {"name", ""}},
      {{"secret", std::string(22, 'A')}, {"name", "a"}},
      {{"secret_proof", proof}, {"nonce", nonce}, {"name", "a"}},
      {{"secret_proof", proof}, {"nonce", "short"}, {"name", "a"}},
      {{"proof", proof}, {"nonce", "short"}, {"name", "a"}},
      {{"proof", proof}, {"nonce", nonce}, {"name", "a"}},
      {{"code", wrong}, {"name", "a"}, {"cookie", true}},
      {{"code", wrong}, {"name", "a"}},
      {{"code", wrong}, {"name", "a"}},  // from here on this address has to wait
      {{"secret", std::string(22, 'A')}, {"name", "a"}},
  };
  const auto answers = [&](const std::string& home) {
    std::vector<std::tuple<int, std::string, std::map<std::string, std::string>>> all;
    for (const nlohmann::json& attempt : attempts) {
      const Answer answer =
          serving->ask("POST", "/homes/" + home + "/api/pair", "", attempt.dump());
      all.emplace_back(answer.status, answer.body, answer.headers);
    }
    serving->steady_s += 30;  // the wait is over; two more wrong ones make five
    for (int i = 0; i < 3; ++i) {
      const Answer answer =
          serving->ask("POST", "/homes/" + home + "/api/pair", "", attempts[8].dump());
      all.emplace_back(answer.status, answer.body, answer.headers);
    }
    return all;
  };
  const auto of_one = answers("flat-1");
  EXPECT_EQ(std::get<int>(of_one[0]), 400);
  EXPECT_EQ(std::get<int>(of_one[6]), 401);
  EXPECT_EQ(std::get<int>(of_one[9]), 429);
  for (const char* home : {"flat-2", "flat-3", "flat-9"}) {
    EXPECT_EQ(answers(home), of_one) << home;
  }
  EXPECT_THAT(serving->house->open_homes(), IsEmpty());
  EXPECT_FALSE(fs::exists(folder_ / "flat-3.home.access")) << "nothing was looked up";
  EXPECT_FALSE(fs::exists(folder_ / "flat-9.home.access"));
}

TEST_F(HouseTest, DigitsThatWereGuessedAtAreVoidWithoutAWord) {
  const auto serving = serve();
  const auto ask = [&](const std::string& home, const std::string& digits,
                       const std::string& from = "127.0.0.4") {
    RawClient client(serving->server->port(), from);
    EXPECT_TRUE(client.shake_hands());
    return client
        .ask("POST", "/homes/" + home + "/api/pair", "",
             nlohmann::json({{"code", digits}, {"name", "a"}}).dump())
        .status;
  };
  const auto code = serving->house->make_code("flat-1", Role::kHelper).value();
  const std::string wrong = fmt::format("{:06}", (std::stoi(code.digits) + 1) % 1'000'000);
  for (const char* home : {"flat-1", "flat-9"}) {
    for (int i = 0; i < 3; ++i) EXPECT_EQ(ask(home, wrong, "127.0.0.2"), 401);
    for (int i = 0; i < 2; ++i) EXPECT_EQ(ask(home, wrong, "127.0.0.3"), 401);
  }
  // Five of all: the digits are void, and new ones are not heard before the wait is over.
  EXPECT_EQ(ask("flat-1", code.digits), 401);
  EXPECT_EQ(ask("flat-9", code.digits), 401);
  serving->steady_s += 60;
  const auto later = serving->house->make_code("flat-1", Role::kHelper).value();
  EXPECT_EQ(ask("flat-1", code.digits), 401);
  EXPECT_EQ(ask("flat-1", later.digits), 200);
}

// Checking one takes long, and at names that are not there nobody has to wait after three.
TEST_F(HouseTest, ProofsOfOneAddressDoNotUseUpWhatAllHave) {
  const auto serving = serve();
  const std::string nonce(32, '1');
  const auto prove = [&](const std::string& from, const std::string& home,
                         const std::string& proof) {
    RawClient client(serving->server->port(), from);
    EXPECT_TRUE(client.shake_hands());
    return client
        .ask("POST", "/homes/" + home + "/api/pair", "",
             nlohmann::json({{"proof", proof}, {"nonce", nonce}, {"name", "a"}}).dump())
        .status;
  };
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(prove("127.0.0.2", fmt::format("none-{}", i), std::string(64, 'a')), 401);
  }
  for (int i = 4; i < 30; ++i) {
    EXPECT_EQ(prove("127.0.0.2", fmt::format("none-{}", i), std::string(64, 'a')), 429);
  }
  const auto code = serving->house->make_code("flat-1", Role::kDevice).value();
  const auto proof =
      service::make_pairing_proof(code.digits, serving->certificate.fingerprint, nonce).value();
  EXPECT_EQ(prove("127.0.0.2", "flat-1", proof.device), 429);
  EXPECT_EQ(prove("127.0.0.3", "flat-1", proof.device), 200);
}

TEST_F(HouseTest, GuessesAtInventedNamesKeepNobodyFromAHome) {
  const auto serving = serve();
  const auto guess = [&](const std::string& home, const std::string& digits) {
    return serving
        ->ask("POST", "/homes/" + home + "/api/pair", "",
              nlohmann::json({{"code", digits}, {"name", "a"}}).dump())
        .status;
  };
  for (int name = 0; name < 256; ++name) {
    for (int i = 0; i < 3; ++i) {
      ASSERT_EQ(guess(fmt::format("none-{}", name), "123456"), 401);
    }
  }
  // What is answered at one more name does not tell whether a home of that name is in use.
  const auto code = serving->house->make_code("flat-1", Role::kDevice).value();
  const std::string wrong = fmt::format("{:06}", (std::stoi(code.digits) + 1) % 1'000'000);
  for (const char* home : {"none-256", "flat-1", "flat-2"}) {
    for (int i = 0; i < 3; ++i) EXPECT_EQ(guess(home, wrong), 401) << home;
    EXPECT_EQ(guess(home, wrong), 429) << home;
  }
  serving->steady_s += 31;
  EXPECT_EQ(guess("none-256", wrong), 401);
  EXPECT_EQ(guess("flat-1", code.digits), 200);
}

TEST_F(HouseTest, DevicesOfOneNumberInTwoHomesAreTwo) {
  const auto serving = serve();
  const std::string first = serving->pair("flat-1", Role::kDevice);
  const std::string second = serving->pair("flat-2", Role::kHelper);
  const std::string fingerprint = serving->certificate.fingerprint;
  const auto one =
      service::ServerConnection::open(serving->address("flat-1"), {fingerprint, first});
  ASSERT_OK(one);
  const auto other =
      service::ServerConnection::open(serving->address("flat-2"), {fingerprint, second});
  ASSERT_OK(other);
  EXPECT_ERROR(service::ServerConnection::open(serving->address("flat-2"), {fingerprint, first}),
               "does not know this device");
  EXPECT_THAT(serving->server->online("flat-1"), ElementsAre(1));
  EXPECT_THAT(serving->server->online("flat-2"), ElementsAre(1));
  // The helper of one home removes its device 1, and so nobody of another.
  const Answer removed =
      serving->ask("DELETE", "/homes/flat-2/api/devices/1", bearer(second), "{}");
  EXPECT_EQ(removed.status, 200);
  const auto gone = (*other)->receive(std::chrono::seconds(10));
  EXPECT_TRUE(!gone || !*gone);
  EXPECT_EQ(serving->ask("GET", "/homes/flat-1/api/me", bearer(first)).status, 200);
  EXPECT_THAT(serving->server->online("flat-1"), ElementsAre(1));
}

TEST_F(HouseTest, HoldsNoMoreHomesThanItMay) {
  const auto serving = serve({.max_open = 2});
  std::map<std::string, std::string> tokens;
  for (const char* home : {"flat-1", "flat-2", "flat-3"}) {
    tokens[home] = serving->pair(home, Role::kHelper);
    serving->steady_s = serving->steady_s + 1;
  }
  const auto opens = [&](const std::string& home) {
    serving->steady_s = serving->steady_s + 1;
    return serving->open(home, tokens[home]);
  };
  EXPECT_THAT(serving->house->open_homes(), IsEmpty());
  EXPECT_EQ(opens("flat-1"), 200);
  EXPECT_EQ(opens("flat-2"), 200);
  EXPECT_EQ(opens("flat-1"), 200);
  EXPECT_EQ(opens("flat-3"), 200);  // for the one that was used least
  EXPECT_THAT(serving->house->open_homes(), ElementsAre("flat-1", "flat-3"));
  const service::ServerCredentials first{serving->certificate.fingerprint, tokens["flat-1"]};
  const service::ServerCredentials third{serving->certificate.fingerprint, tokens["flat-3"]};
  auto in_first = service::ServerConnection::open(serving->address("flat-1"), first);
  auto in_third = service::ServerConnection::open(serving->address("flat-3"), third);
  ASSERT_OK(in_first);
  ASSERT_OK(in_third);
  const Answer full = serving->ask("GET", "/homes/flat-2/api/home", bearer(tokens["flat-2"]));
  EXPECT_EQ(full.status, 503);
  EXPECT_EQ(full.headers.at("retry-after"), "2");
  EXPECT_THAT(full.body, HasSubstr("2 homes are in use"));
  EXPECT_ERROR(
      service::ServerConnection::open(serving->address("flat-2"),
                                      {serving->certificate.fingerprint, tokens["flat-2"]}),
      "opens no WebSocket");
}

TEST_F(HouseTest, AFaultInOneHomeTakesNothingFromTheOthers) {
  std::atomic<bool> is_broken = false;
  const auto break_down = [&](const std::string& home) {
    if (is_broken && home == "flat-1") throw std::runtime_error("a fault");
  };
  const auto serving = serve({.max_open = 1, .takes_in = break_down, .opens = break_down});
  const std::string second = serving->pair("flat-2", Role::kHelper);
  const std::string first = serving->pair("flat-1", Role::kHelper);
  is_broken = true;
  EXPECT_EQ(serving->open("flat-1", first), 503) << "it cannot be opened";
  EXPECT_THAT(serving->log(), HasSubstr("flat-1: cannot be opened: internal error, please report "
                                        "it: a fault\n"));
  const auto metrics = [&] {
    service::MetricsText text;
    serving->house->write_metrics(text);
    return text.text();
  };
  EXPECT_THAT(metrics(), HasSubstr("roomwise_home_cannot_open{home=\"flat-1\"} 1\n"
                                   "roomwise_home_cannot_open{home=\"flat-2\"} 0\n"));
  EXPECT_EQ(serving->open("flat-2", second), 200) << "the one place is free";
  serving->steady_s = serving->steady_s + 700;
  serving->house->tidy();  // nobody has the homes any more
  const auto ask = [&] {
    return serving->ask("GET", "/homes/flat-1/api/home", bearer(first)).status;
  };
  EXPECT_EQ(ask(), 500) << "it cannot be taken in";
  EXPECT_EQ(ask(), 500) << "nobody waits for ever for one who tried before";
  is_broken = false;
  EXPECT_EQ(serving->open("flat-1", first), 200);
  EXPECT_THAT(metrics(), HasSubstr("roomwise_home_cannot_open{home=\"flat-1\"} 0\n"));
}

TEST_F(HouseTest, ClosesWhatNobodyUses) {
  const auto serving = serve();
  const std::string token = serving->pair("flat-1", Role::kHelper);
  EXPECT_EQ(serving->open("flat-1", token), 200);
  serving->steady_s = serving->steady_s + 599;
  serving->house->tidy();
  EXPECT_THAT(serving->house->open_homes(), ElementsAre("flat-1"));
  (void)serving->house->make_code("flat-1", Role::kDevice).value();
  serving->steady_s = serving->steady_s + 299;
  serving->house->tidy();
  serving->steady_s = serving->steady_s + 2;  // the code is over
  serving->house->tidy();
  EXPECT_THAT(serving->house->open_homes(), ElementsAre("flat-1"));  // it was used to make the code
  serving->steady_s = serving->steady_s + 600;
  serving->house->tidy();
  EXPECT_THAT(serving->house->open_homes(), IsEmpty());
  EXPECT_THAT(serving->log(), HasSubstr("flat-1: opened\n"));
  EXPECT_THAT(serving->log(), HasSubstr("flat-1: closed\n"));
  EXPECT_EQ(serving->ask("GET", "/homes/flat-1/api/home", bearer(token)).status, 200);
}

TEST_F(HouseTest, OneProcessHasAHomeUntilItEndsOrHasNoUseForIt) {
  auto first = serve();
  const auto second = serve();
  const std::string token = first->pair("flat-1", Role::kHelper);
  EXPECT_EQ(first->open("flat-1", token), 200);
  const auto asked = [&](const ServedHouse& house) {
    return house.ask("GET", "/homes/flat-1/api/home", bearer(token));
  };
  const Answer elsewhere = asked(*second);
  EXPECT_EQ(elsewhere.status, 503);
  EXPECT_EQ(elsewhere.headers.at("retry-after"), "1");
  EXPECT_THAT(elsewhere.body, HasSubstr("another process has this home"));
  // Nor does the second judge codes, which lie with the first.
  const std::string guess = R"({"code":"123456","name":"a"})";
  EXPECT_EQ(second->ask("POST", "/homes/flat-1/api/pair", "", guess).body, elsewhere.body);
  // The first is not using it: it hands it over.
  first->house->tidy();
  EXPECT_EQ(second->open("flat-1", token), 200);
  EXPECT_EQ(asked(*first).status, 503);
  second->house->tidy();
  EXPECT_EQ(asked(*first).status, 200);
  // It is using it: it keeps it.
  auto socket = service::ServerConnection::open(first->address("flat-1"),
                                                {first->certificate.fingerprint, token});
  ASSERT_OK(socket);
  EXPECT_EQ(asked(*second).status, 503);
  first->house->tidy();
  EXPECT_EQ(asked(*second).status, 503);
  first.reset();
  EXPECT_EQ(asked(*second).status, 200);
}

TEST_F(HouseTest, WhatWasRemovedComesBackThoughTheHomeWasClosedUntilTheProcessEnds) {
  const fs::path walk = folder_ / "flat-1.home.walks" / "monday";
  const auto walks_left = [&] {
    return home::Home::open_read_only(folder_ / "flat-1.home")->recordings()->size();
  };
  home::EditId removed = 0;
  {
    home::Home home = home::Home::open(folder_ / "flat-1.home").value();
    geometry::PinholeCamera camera;
    camera.width = 8;
    camera.height = 6;
    camera.fx = camera.fy = 5;
    const auto id = home.add_recording({"monday", walk.string(), camera, 10}).value();
    ASSERT_OK(home.commit(
        {.recording = id, .keyframes = {}, .edges = {}, .frames = {}, .next_frame_index = 10}));
    ASSERT_OK(home.finish_recording(id));
    fs::create_directories(walk);
    const pipeline::EditAuthor anna{"Anna", 1'700'000'000};
    const auto labels = recording::RoomLabels::from_ranges({{0, 9, "kitchen", 1}}).value();
    ASSERT_OK(pipeline::name_frames(home, anna, id, labels));
    removed = pipeline::remove_room(home, anna, "kitchen").value();
    ASSERT_OK(pipeline::take_walk_away(home, anna, id));
  }
  auto first = serve();
  auto second = serve();
  const std::string token = first->pair("flat-1", Role::kHelper);
  EXPECT_EQ(first->open("flat-1", token), 200);
  first->steady_s = first->steady_s + 601;
  first->house->tidy();
  EXPECT_THAT(first->house->open_homes(), IsEmpty());
  EXPECT_EQ(first->open("flat-1", token), 200);
  // Another process asks for it and has it.
  EXPECT_EQ(second->ask("GET", "/homes/flat-1/api/home", bearer(token)).status, 503);
  first->house->tidy();
  const Answer home = second->ask("GET", "/homes/flat-1/api/home", bearer(token));
  ASSERT_EQ(home.status, 200);
  EXPECT_THAT(nlohmann::json::parse(home.body).at("to_erase").at("walks"), ::testing::SizeIs(1));
  const std::string undo = fmt::format("/homes/flat-1/api/edits/{}", removed);
  EXPECT_EQ(second->ask("DELETE", undo, bearer(token), "{}").status, 200);
  first.reset();
  EXPECT_TRUE(fs::exists(walk)) << "that process does not have the home";
  EXPECT_EQ(walks_left(), 1U);
  second.reset();
  EXPECT_FALSE(fs::exists(walk));
  EXPECT_EQ(walks_left(), 0U);
}

TEST_F(HouseTest, OnlyPlainFilesWithNamesForAddressesAreHomes) {
  fs::create_symlink(folder_ / "flat-1.home", folder_ / "link.home");
  fs::copy_file(folder_ / "flat-1.home", folder_ / "two words.home");
  fs::copy_file(folder_ / "flat-1.home", folder_ / ".hidden.home");
  fs::create_directory(folder_ / "folder.home");
  const auto serving = serve();
  EXPECT_THAT(serving->house->names(), ElementsAre("flat-1", "flat-2", "flat-3"));
  for (const char* name :
       {"link", "two%20words", ".hidden", "folder", "..", "%2e%2e", "", "a%00"}) {
    const int status = serving->ask("GET", fmt::format("/homes/{}/api/me", name)).status;
    EXPECT_THAT(status, AnyOf(401, 400)) << name;
  }
  EXPECT_ERROR(House::open(folder_ / "flat-1.home", serving->finders, {}), "is no folder of homes");
}

TEST_F(HouseTest, FiguresAndDeedsAreToldByHome) {
  const auto serving = serve();
  const std::string first = serving->pair("flat-1", Role::kHelper);
  const std::string second = serving->pair("flat-2", Role::kHelper);
  EXPECT_THAT(serving->ask("GET", "/homes/flat-1/metrics", bearer(first)).body,
              HasSubstr("roomwise_frames_looked_at_total 0\n"));
  EXPECT_EQ(serving->ask("GET", "/homes/flat-2/api/home", bearer(second)).status, 200);
  service::MetricsText text;
  serving->house->write_metrics(text);
  EXPECT_THAT(text.text(), HasSubstr("roomwise_frames_looked_at_total{home=\"flat-1\"} 0\n"
                                     "roomwise_frames_looked_at_total{home=\"flat-2\"} 0\n"));
  EXPECT_THAT(text.text(), HasSubstr("roomwise_homes_open 2\n"));
  serving->ask("POST", "/homes/flat-2/api/learn", bearer(second), "{}");
  serving->ask("PUT", "/homes/flat-2/api/uploads/a/0", bearer(second), "{}");
  EXPECT_THAT(serving->acts(), HasSubstr("flat-2: flat-2's device POST /api/pair "));
  EXPECT_THAT(serving->acts(), HasSubstr("flat-2: flat-2's device POST /api/learn "));
  EXPECT_THAT(serving->acts(), Not(HasSubstr("uploads")));
}

TEST_F(HouseTest, WhoIsKnownToTheHouseMayWhatTheHouseSays) {
  const auto serving =
      serve({.known = [](const service::HttpRequest& request,
                         const auto& home) -> Expected<std::optional<service::Identity>> {
        if (request.header("cookie").find("staff=anna") == std::string_view::npos)
          return std::nullopt;
        if (home == "flat-1")
          return service::Identity{service::Identity::device_of_account(1), "Anna", Role::kHelper};
        if (home == "flat-2")
          return service::Identity{service::Identity::device_of_account(1), "Anna", Role::kDevice};
        if (home == "flat-3") return fail("the accounts are away");
        return std::nullopt;
      }});
  const std::string anna = "Cookie: staff=anna\r\n";
  EXPECT_EQ(serving->ask("GET", "/homes/flat-1/api/devices", anna).status, 200);
  EXPECT_EQ(serving->ask("GET", "/homes/flat-2/api/devices", anna).status, 403);
  EXPECT_EQ(serving->ask("GET", "/homes/flat-2/api/home", anna).status, 200);
  EXPECT_EQ(serving->ask("GET", "/homes/flat-3/api/home", anna).status, 503);
  EXPECT_EQ(serving->ask("GET", "/homes/flat-3/api/home", "").status, 401);
  EXPECT_EQ(serving->ask("GET", "/homes/flat-9/api/home", anna).status, 401);
}

}  // namespace
}  // namespace roomwise::live
