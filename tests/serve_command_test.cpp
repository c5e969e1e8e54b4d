#include <fcntl.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <regex>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/service/client/client.h"
#include "roomwise/service/protocol/messages.h"
#include "roomwise/service/testing/testing_service.h"
#include "run_program.h"

namespace roomwise::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// "roomwise serve" as a process of its own, from its first words until it is told to stop.
class ServeProcess {
 public:
  explicit ServeProcess(const std::vector<std::string>& arguments,
                        const std::string& input = "/dev/null")
      : running_(start_roomwise(arguments, input)) {
    // "https://127.0.0.1:43210 serves ..." to "Ctrl-C stops it."
    for (std::string line; said_.find("Ctrl-C") == std::string::npos;) {
      if (!running_.read_line(line)) break;
      said_ += line + "\n";
    }
    std::smatch found;
    if (std::regex_search(said_, found, std::regex("https://127\\.0\\.0\\.1:(\\d+)"))) {
      server = {"127.0.0.1", static_cast<std::uint16_t>(std::stoi(found[1]))};
    }
  }

  // The six digits of the code that was shown for this role; empty: none was.
  [[nodiscard]] std::string code(const std::string& role) const {
    std::smatch found;
    const std::regex shown("To pair a " + role + ": code (\\d{3}) (\\d{3})");
    return std::regex_search(said_, found, shown) ? found[1].str() + found[2].str() : "";
  }
  [[nodiscard]] const std::string& said() const { return said_; }
  [[nodiscard]] std::string next_line() {
    std::string line;
    EXPECT_TRUE(running_.read_line(line)) << errors();
    return line;
  }
  // Sends the signal; the exit code, 128 + the signal that ended it.
  int end(int signal) { return running_.end(signal); }
  [[nodiscard]] std::string errors() const { return running_.errors(); }

  service::ServerAddress server;

 private:
  RunningProgram running_;
  std::string said_;
};

std::vector<std::string> serve(const std::filesystem::path& home,
                               const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments{"serve", home.string(), "--port", "0"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

// Says hello over a new connection and asks where the bed is; the answer.
std::string ask_for_the_bed(const service::ServerAddress& server,
                            const service::ServerCredentials& credentials) {
  const auto connection = service::ServerConnection::open(server, credentials);
  if (!connection) return connection.error().message;
  service::Hello hello;
  hello.version = 1;
  hello.name = "belt";
  EXPECT_OK((*connection)->send_text(write(service::DeviceMessage(hello))));
  EXPECT_OK((*connection)
                ->send_text(write(service::DeviceMessage(
                    service::Ask{1, 0, service::Question::kWhereIs, "bed"}))));
  for (;;) {
    const auto message = (*connection)->receive(std::chrono::seconds(20));
    if (!message) return message.error().message;
    if (!*message) return "no answer came";
    const auto read = service::read_home_message(
        {reinterpret_cast<const char*>((*message)->bytes.data()), (*message)->bytes.size()});
    EXPECT_OK(read);
    if (!read) return "";
    if (const auto* prompt = std::get_if<service::PromptMessage>(&*read)) return prompt->text;
  }
}

TEST(Serve, APlaceOfPagesThatIsNotThereIsNoticedBeforeAnythingIsMade) {
  const ScratchFolder folder;
  const ProgramResult result =
      run_roomwise(serve(folder / "new.home", {"--pages", (folder / "none").string()}));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.errors, HasSubstr("the folder of the pages is not there"));
  EXPECT_FALSE(std::filesystem::exists(folder / "new.home"));
}

TEST(Serve, SaysWhetherOtherDevicesReachIt) {
  const ScratchFolder folder;
  const ServeProcess alone(serve(folder / "one.home"));
  EXPECT_THAT(alone.said(), HasSubstr("Other devices cannot reach it"));
  EXPECT_THAT(alone.said(), Not(HasSubstr("authority.crt")));
  const ServeProcess open(serve(folder / "two.home", {"--address", "0.0.0.0"}));
  EXPECT_THAT(open.said(), HasSubstr("/authority.crt is warned no more"));
}

TEST(Serve, ADeviceThatWasPairedIsKnownAfterAKill) {
  const ScratchFolder folder;
  ServeProcess first(serve(folder / "new.home", {"--pair", "device"}));
  ASSERT_NE(first.server.port, 0) << first.said() << first.errors();
  EXPECT_NE(first.code("helper"), "");  // no helper is paired yet
  const auto paired = service::pair_with(first.server, first.code("device"), "belt");
  ASSERT_OK(paired);
  EXPECT_EQ(paired->who.role, service::Role::kDevice);
  EXPECT_EQ(ask_for_the_bed(first.server, paired->credentials), "I know no bed here.");
  EXPECT_EQ(first.end(SIGKILL), 128 + SIGKILL);

  ServeProcess second(serve(folder / "new.home"));
  ASSERT_NE(second.server.port, 0) << second.said() << second.errors();
  EXPECT_EQ(ask_for_the_bed(second.server, paired->credentials), "I know no bed here.");
  service::ServerCredentials other = paired->credentials;
  other.token.back() = other.token.back() == 'A' ? 'B' : 'A';
  EXPECT_THAT(ask_for_the_bed(second.server, other), Not(HasSubstr("bed")));
  EXPECT_EQ(second.end(SIGTERM), 0);
  EXPECT_THAT(second.errors(), Not(HasSubstr(paired->credentials.token)));
}

TEST(Serve, SaysTheCodeToWhoCannotReadIt) {
  const ScratchFolder folder;
  ServeProcess process(serve(folder / "new.home", {"--pair", "device", "--speak", "text"}));
  const std::string code = process.code("device");
  ASSERT_EQ(code.size(), 6U) << process.said() << process.errors();
  std::string spaced;
  for (std::size_t i = 0; i < code.size(); ++i) {
    spaced += fmt::format("{}{}", i == 0 ? "" : i == 3 ? ", " : " ", code[i]);
  }
  for (int times = 0; times < 2; ++times) {
    EXPECT_EQ(process.next_line(), "(answer) The code is " + spaced + ".");
  }
  EXPECT_EQ(process.end(SIGTERM), 0);
  ServeProcess silent(serve(folder / "new.home", {"--speak", "shout"}));
  EXPECT_EQ(silent.end(SIGTERM), 1);
  EXPECT_THAT(silent.errors(), HasSubstr("'shout' is no way to speak"));
}

TEST(Serve, ADeviceSaysHowItsPairingWent) {
  const ScratchFolder folder;
  ServeProcess process(serve(folder / "new.home", {"--pair", "device"}));
  ASSERT_NE(process.server.port, 0) << process.said() << process.errors();
  const std::string server = fmt::format("127.0.0.1:{}", process.server.port);
  const auto said_by = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"device", "--server", server, "--speak", "text"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramResult result = run_roomwise(arguments);
    EXPECT_EQ(result.exit_code, 1);
    return result.output;
  };
  EXPECT_THAT(said_by({}), HasSubstr("This device is not paired. Ask your helper."));
  std::string wrong = process.code("device");
  wrong.back() = wrong.back() == '1' ? '2' : '1';
  EXPECT_THAT(said_by({"--pair", wrong}), HasSubstr("This code is wrong or too old."));
  EXPECT_EQ(process.end(SIGTERM), 0);
  EXPECT_THAT(said_by({"--pair", wrong}), HasSubstr("The connection is lost."));
}

TEST(Serve, ADeviceSaysWhatOfItIsMissing) {
  const ScratchFolder folder;
  ::setenv("XDG_CONFIG_HOME", (folder / "config").c_str(), 1);
  ServeProcess process(serve(folder / "new.home", {"--pair", "device"}));
  ASSERT_NE(process.server.port, 0) << process.said() << process.errors();
  std::vector<std::string> device{"device",
                                  "--server",
                                  fmt::format("127.0.0.1:{}", process.server.port),
                                  "--speak",
                                  "text",
                                  "--pair",
                                  process.code("device")};
  const auto said_without = [&](const std::string& part) {
    std::vector<std::string> arguments = device;
    arguments.insert(arguments.end(), {part, folder / "none"});
    const ProgramResult result = run_roomwise(arguments);
    EXPECT_EQ(result.exit_code, 1);
    device.resize(5);  // it is paired from now on
    return result.output;
  };
  EXPECT_THAT(said_without("--recording"), HasSubstr("The camera does not work."));
  EXPECT_THAT(said_without("--buttons"), HasSubstr("The buttons do not work."));
  ::unsetenv("XDG_CONFIG_HOME");
}

TEST(Serve, TwoServersDoNotOpenOneHome) {
  const ScratchFolder folder;
  ServeProcess first(serve(folder / "new.home"));
  ASSERT_NE(first.server.port, 0) << first.said() << first.errors();
  const ProgramResult second = run_roomwise(serve(folder / "new.home"));
  EXPECT_EQ(second.exit_code, 1);
  EXPECT_THAT(second.errors, HasSubstr("new.home"));
  EXPECT_EQ(first.end(SIGINT), 0);
}

TEST(Serve, RefusesWhatItCannotServe) {
  const ScratchFolder folder;
  ASSERT_OK(write_file(folder / "no.home", std::string_view("not a home")));
  EXPECT_EQ(run_roomwise(serve(folder / "no.home")).exit_code, 1);
  const ProgramResult address = run_roomwise(serve(folder / "a.home", {"--address", "300.0.0.1"}));
  EXPECT_EQ(address.exit_code, 1);
  EXPECT_THAT(address.errors, HasSubstr("300.0.0.1"));
  EXPECT_EQ(run_roomwise({"serve"}).exit_code, 2);
  EXPECT_EQ(run_roomwise(serve(folder / "a.home", {"--pair", "king"})).exit_code, 2);
}

TEST(Serve, AHomeThatIsMadeWithAPassphraseIsServedWithItAlone) {
  const ScratchFolder folder;
  ASSERT_OK(write_file(folder / "phrase", std::string_view("seven small owls\n")));
  const std::vector<std::string> phrase = {"--passphrase-file", (folder / "phrase").string()};
  for (int start = 0; start < 2; ++start) {
    ServeProcess home(serve(folder / "new.home", phrase));
    ASSERT_NE(home.server.port, 0) << home.said() << home.errors();
    EXPECT_EQ(home.end(SIGTERM), 0);
  }
  const ProgramResult without = run_roomwise(serve(folder / "new.home"));
  EXPECT_EQ(without.exit_code, 1);
  EXPECT_THAT(without.errors, HasSubstr("protected by a passphrase"));
  ASSERT_OK(write_file(folder / "phrase", std::string_view("eight small owls\n")));
  const ProgramResult wrong = run_roomwise(serve(folder / "new.home", phrase));
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_THAT(wrong.errors, HasSubstr("the passphrase is wrong"));
}

TEST(Serve, GivesHelpersFiguresAndTakesNamesThatWereAllowed) {
  const ScratchFolder folder;
  ServeProcess home(serve(folder / "new.home", {"--allowed-host", "flat.example"}));
  ASSERT_NE(home.server.port, 0) << home.said() << home.errors();
  const auto helper = service::pair_with(home.server, home.code("helper"), "page");
  ASSERT_OK(helper);
  EXPECT_THAT(ask_for_the_bed(home.server, helper->credentials), HasSubstr("bed"));
  service::testing::RawClient client(home.server.port);
  ASSERT_TRUE(client.shake_hands());
  const auto metrics =
      client.ask("GET", "/metrics", service::testing::bearer(helper->credentials.token));
  EXPECT_EQ(metrics.headers.at("content-type"), "text/plain; version=0.0.4");
  EXPECT_THAT(metrics.body,
              HasSubstr("roomwise_question_seconds_count{question=\"where_is\"} 1\n"));
  EXPECT_THAT(metrics.body, HasSubstr("\nroomwise_disk_free_bytes "));
  EXPECT_THAT(metrics.body, HasSubstr("\nroomwise_sockets_total 1\n"));
  const auto status = [&](const std::string& host) {
    client.send("GET /health HTTP/1.1\r\nHost: " + host + "\r\n\r\n");
    return client.receive().status;
  };
  EXPECT_EQ(status("flat.example:8443"), 200);
  EXPECT_EQ(status("evil.example:8443"), 421);
  EXPECT_EQ(home.end(SIGTERM), 0);
  const auto wrong = run_roomwise(serve(folder / "a.home", {"--allowed-host", "https://flat"}));
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_THAT(wrong.errors, HasSubstr("'https://flat' is no name of a computer"));
}

// A row of the table of requests in docs/protocol.md.
struct DocumentedRequest {
  std::string method, path, role;  // "-": everyone
};

std::vector<DocumentedRequest> documented_requests() {
  std::vector<DocumentedRequest> requests;
  std::ifstream file(ROOMWISE_PROTOCOL_TEXT);
  const std::regex row(R"(^\| `(GET|PUT|POST|DELETE) ([^` ]+)`.*\| (-|device|helper) \|)");
  for (std::string line; std::getline(file, line);) {
    std::smatch found;
    if (!std::regex_search(line, found, row) || found[2] == "/") continue;  // the pages' files
    // ID, N and NAME stand for values: for some that no home has.
    const std::string path =
        std::regex_replace(found[2].str(), std::regex("ID|N$|NAME|N(?=/)"), "987654");
    requests.push_back({found[1], path, found[3]});
  }
  return requests;
}

// Every request of the table, at a server as it is run, from everybody who may come: each sees what
// the table says they may. What a request does where it is allowed is tested elsewhere: here its
// body is empty and what it names is not there.
TEST(Serve, WhoMayWhatIsAsTheProtocolSays) {
  const ScratchFolder folder;
  ServeProcess neighbour(serve(folder / "neighbour.home"));
  const auto stranger =
      service::pair_with(neighbour.server, neighbour.code("helper"), "the neighbour's page");
  ASSERT_OK(stranger);
  EXPECT_EQ(neighbour.end(SIGTERM), 0);
  ServeProcess home(serve(folder / "new.home", {"--pair", "device"}));
  const auto device = service::pair_with(home.server, home.code("device"), "belt");
  const auto helper = service::pair_with(home.server, home.code("helper"), "page");
  ASSERT_OK(device);
  ASSERT_OK(helper);
  std::string wrong = helper->credentials.token;
  wrong.front() = wrong.front() == 'A' ? 'B' : 'A';

  const auto requests = documented_requests();
  ASSERT_GT(requests.size(), 25U);
  int peer = 0;
  for (const DocumentedRequest& request : requests) {
    SCOPED_TRACE(request.method + " " + request.path + " (" + request.role + ")");
    // From an address of its own each, so that nobody asks too often.
    const std::string from = fmt::format("127.0.2.{}", ++peer);
    const auto ask = [&](const std::string& headers) {
      service::testing::RawClient client(home.server.port, from);
      EXPECT_TRUE(client.shake_hands());
      return client.ask(request.method, request.path, headers, request.method == "GET" ? "" : "{}");
    };
    const auto is_served = [](const service::testing::Answer& answer) {
      return answer.status != 401 && answer.status != 403 && answer.status != 405 &&
             answer.status != 0 &&
             answer.body.find("nothing under this address") == std::string::npos;
    };
    for (const std::string& headers :
         {std::string(), service::testing::bearer(wrong),
          service::testing::bearer(stranger->credentials.token),
          "Cookie: roomwise=" + stranger->credentials.token + "\r\n"}) {
      const auto answer = ask(headers);
      if (request.role == "-") {
        EXPECT_TRUE(is_served(answer)) << answer.status;
      } else {
        EXPECT_EQ(answer.status, 401) << answer.body;
      }
    }
    if (request.path == "/api/leave") continue;  // it would be nobody's token afterwards
    const auto of_device = ask(service::testing::bearer(device->credentials.token));
    if (request.role == "helper") {
      EXPECT_EQ(of_device.status, 403) << of_device.body;
    } else {
      EXPECT_TRUE(is_served(of_device)) << of_device.status << of_device.body;
    }
    const auto of_helper = ask(service::testing::bearer(helper->credentials.token));
    EXPECT_TRUE(is_served(of_helper)) << of_helper.status << of_helper.body;
    // A page of another site has the helper's cookie at most, and may nothing.
    const auto cross_site = ask("Cookie: roomwise=" + helper->credentials.token +
                                "\r\nOrigin: https://elsewhere.example\r\n");
    EXPECT_EQ(cross_site.status, 403) << cross_site.body;
  }
  const auto leaves = [&](const std::string& token) {
    service::testing::RawClient client(home.server.port);
    EXPECT_TRUE(client.shake_hands());
    return client.ask("POST", "/api/leave", service::testing::bearer(token), "{}").status;
  };
  EXPECT_EQ(leaves(device->credentials.token), 200);
  EXPECT_EQ(leaves(device->credentials.token), 401);
  EXPECT_EQ(home.end(SIGTERM), 0);
}

// ---- a folder of homes ----

// A folder with homes that hold nothing yet.
void make_homes(const std::filesystem::path& folder, const std::vector<std::string>& names) {
  std::filesystem::create_directory(folder);
  for (const std::string& name : names) {
    ServeProcess once(serve(folder / (name + ".home")));
    EXPECT_EQ(once.end(SIGTERM), 0) << once.errors();
  }
}

TEST(ServeHouse, AHomeWhoseProcessWasKilledIsAnsweredByAnother) {
  const ScratchFolder folder;
  const std::filesystem::path homes = folder / "homes";
  make_homes(homes, {"flat-1", "flat-2"});
  const auto serve_homes = [&](const std::vector<std::string>& more = {}) {
    return ServeProcess(serve(homes, more));
  };
  ServeProcess first = serve_homes({"--pair", "device", "--home", "flat-1"});
  ASSERT_NE(first.server.port, 0) << first.said() << first.errors();
  ServeProcess second = serve_homes();
  ASSERT_NE(second.server.port, 0) << second.said() << second.errors();
  service::ServerAddress address = first.server;
  address.base = "/homes/flat-1";
  const auto paired = service::pair_with(address, first.code("device"), "belt");
  ASSERT_OK(paired);
  EXPECT_EQ(ask_for_the_bed(address, paired->credentials), "I know no bed here.");
  service::ServerAddress neighbour = address;
  neighbour.base = "/homes/flat-2";
  EXPECT_THAT(ask_for_the_bed(neighbour, paired->credentials),
              HasSubstr("does not know this device"));

  service::ServerAddress elsewhere = second.server;
  elsewhere.base = "/homes/flat-1";
  service::testing::RawClient client(second.server.port);
  ASSERT_TRUE(client.shake_hands());
  const auto ask = [&] { return client.ask("GET", "/homes/flat-1/api/me").status; };
  const auto connection = service::ServerConnection::open(address, paired->credentials);
  ASSERT_OK(connection);  // so that the first does not hand the home over
  EXPECT_EQ(ask(), 503);
  EXPECT_EQ(first.end(SIGKILL), 128 + SIGKILL);
  EXPECT_EQ(ask(), 401);
  // The processes share the house's certificate, which the device knows.
  EXPECT_EQ(ask_for_the_bed(elsewhere, paired->credentials), "I know no bed here.");
  EXPECT_EQ(second.end(SIGTERM), 0);
  EXPECT_THAT(second.errors(), HasSubstr("flat-1: opened"));
}

TEST(ServeHouse, GoesOnWhereNoCodeCanBeMade) {
  const ScratchFolder folder;
  std::filesystem::create_directory(folder / "homes");
  ASSERT_OK(write_file(folder / "enter", std::string_view("\n")));
  ServeProcess process(serve(folder / "homes", {"--home", "flat-1"}), folder / "enter");
  EXPECT_THAT(process.next_line(), HasSubstr("No code: "));
  EXPECT_EQ(process.end(SIGTERM), 0);
}

TEST(ServeHouse, AFolderThatIsNotThereDoesNotBecomeAHome) {
  const ScratchFolder folder;
  for (const auto& of_folder :
       std::vector<std::vector<std::string>>{{"--accounts", "postgresql://keeper@localhost/homes"},
                                             {"--passphrases", folder.path().string()},
                                             {"--proxy", "127.0.0.1"},
                                             {"--public-address", "homes.example"},
                                             {"--home", "flat-1"},
                                             {"--open-homes", "3"},
                                             {"--close-after", "30"}}) {
    const ProgramResult result = run_roomwise(serve(folder / "hmes", of_folder));
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_THAT(result.errors, HasSubstr("hmes: is no folder, and " + of_folder[0]));
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "hmes"));
}

TEST(ServeHouse, StaffHaveAccountsWhoseDeedsAreKept) {
  const ScratchFolder folder;
  const std::filesystem::path homes = folder / "homes";
  make_homes(homes, {"flat-1"});
  const std::filesystem::path password = folder / "password";
  std::ofstream(password) << "correct horse battery\n";
  const auto accounts = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "accounts");
    return run_roomwise(arguments);
  };
  EXPECT_EQ(
      accounts({"add", homes.string(), "anna", "--password-file", password.string()}).exit_code, 0);
  EXPECT_EQ(accounts({"role", homes.string(), "anna", "flat-1", "helper"}).exit_code, 0);
  EXPECT_THAT(accounts({"role", homes.string(), "anna", "flat-9", "helper"}).errors,
              HasSubstr("there is no home 'flat-9'"));
  EXPECT_EQ(accounts({"list", homes.string()}).output, "anna\n  flat-1: helper\n");

  ServeProcess process(serve(homes));
  ASSERT_NE(process.server.port, 0) << process.said() << process.errors();
  const auto ask = [&](const std::string& method, const std::string& path,
                       const std::string& headers, const std::string& body) {
    service::testing::RawClient client(process.server.port);
    EXPECT_TRUE(client.shake_hands());
    return client.ask(method, path, headers, body);
  };
  EXPECT_EQ(ask("GET", "/", "", "").headers.at("location"), "/staff");
  const auto in = ask("POST", "/api/staff/sign-in", "",
                      R"({"name": "anna", "password": "correct horse battery"})");
  ASSERT_EQ(in.status, 200) << in.body;
  const std::string set = in.headers.at("set-cookie");
  const std::string cookie = "Cookie: " + set.substr(0, set.find(';')) + "\r\n";
  EXPECT_EQ(ask("GET", "/homes/flat-1/api/devices", cookie, "").status, 200);
  EXPECT_EQ(ask("POST", "/homes/flat-1/api/codes", cookie, R"({"role": "device"})").status, 200);
  const std::string token = "Authorization: Bearer " + std::string([&] {
                              std::ifstream in_file(homes / "house.access/metrics-token");
                              std::string text;
                              in_file >> text;
                              return text;
                            }()) +
                            "\r\n";
  EXPECT_EQ(ask("GET", "/metrics", cookie, "").status, 401);
  EXPECT_THAT(ask("GET", "/metrics", token, "").body, HasSubstr("roomwise_homes_open 0\n"));
  EXPECT_EQ(accounts({"role", homes.string(), "anna", "flat-1", "none"}).exit_code, 0);
  EXPECT_EQ(ask("GET", "/homes/flat-1/api/devices", cookie, "").status, 401);
  EXPECT_EQ(process.end(SIGTERM), 0);
  const std::string deeds = accounts({"audit", homes.string(), "--home", "flat-1"}).output;
  EXPECT_THAT(deeds, HasSubstr("anna  flat-1  POST /api/codes: 200  127.0.0.1"));
  EXPECT_THAT(deeds, HasSubstr("the computer's keeper  flat-1  role none in flat-1 anna: done"));
}

TEST(ServeHouse, TheProxysConfigurationIsOneThatHaproxyTakes) {
  const std::string haproxy = "/usr/sbin/haproxy";
  if (!std::filesystem::exists(haproxy)) GTEST_SKIP() << "haproxy is not installed";
  const ScratchFolder folder;
  const std::filesystem::path homes = folder / "homes";
  std::filesystem::create_directory(homes);
  ServeProcess process(serve(homes));
  ASSERT_NE(process.server.port, 0) << process.said() << process.errors();
  EXPECT_EQ(process.end(SIGTERM), 0);
  std::ifstream in(std::string(ROOMWISE_SOURCES) + "/packaging/homes/haproxy.cfg");
  std::string text((std::istreambuf_iterator<char>(in)), {});
  const std::string there = "/var/lib/roomwise/homes";
  for (std::size_t at = 0; (at = text.find(there, at)) != std::string::npos;) {
    text.replace(at, there.size(), homes.string());
  }
  std::ofstream(folder / "haproxy.cfg") << text;
  const ProgramResult checked =
      run_program(haproxy, {"-c", "-f", (folder / "haproxy.cfg").string()});
  EXPECT_EQ(checked.exit_code, 0) << checked.output << checked.errors;
}

TEST(ServeHouse, SaysWhatIsForOneHomeAlone) {
  const ScratchFolder folder;
  const std::string homes = (folder / "").string();
  EXPECT_THAT(run_roomwise({"serve", homes, "--port", "0", "--pair", "device"}).errors,
              HasSubstr("--home NAME"));
  EXPECT_THAT(run_roomwise({"serve", homes, "--port", "0", "--speak", "text"}).errors,
              HasSubstr("--speak is for one home"));
  EXPECT_THAT(run_roomwise({"accounts", "list", homes + "/none"}).errors,
              HasSubstr("is no folder of homes"));
}

}  // namespace
}  // namespace roomwise::testing
