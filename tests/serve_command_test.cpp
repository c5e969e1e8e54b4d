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
#include "roomwise/base/testing.h"
#include "roomwise/service/client.h"
#include "roomwise/service/messages.h"
#include "run_program.h"

namespace roomwise::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// "roomwise serve" as a process of its own, from its first words until it is told to stop.
class ServeProcess {
 public:
  explicit ServeProcess(const std::vector<std::string>& arguments)
      : running_(start_roomwise(arguments)) {
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

}  // namespace
}  // namespace roomwise::testing
