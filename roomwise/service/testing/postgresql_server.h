#pragma once

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

// A PostgreSQL server of a test's own. Not part of the product.
namespace roomwise::service::testing {

// Runs in a folder of its own and is reached by a socket in it, so it takes no port. Where this is
// root, it runs as Debian's user postgres, since it refuses to run as root.
class PostgresqlServer {
 public:
  // Why there can be none; nothing: there can.
  static std::optional<std::string> missing() {
    if (programs().empty()) return "PostgreSQL (Debian: postgresql) is not installed";
    const bool can_run = ::getuid() != 0 || std::system("id postgres >/dev/null 2>&1") == 0;
    return can_run ? std::nullopt : std::optional<std::string>("there is no user postgres");
  }

  PostgresqlServer() {
    std::string name = "/tmp/roomwise-postgresql-XXXXXX";
    folder_ = ::mkdtemp(name.data());
    if (::getuid() == 0) shell(fmt::format("chown postgres {}", folder_));
    run(fmt::format("initdb -D {}/data -U roomwise -A trust --no-sync", folder_));
    start();
  }
  ~PostgresqlServer() {
    stop();
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  PostgresqlServer(const PostgresqlServer&) = delete;
  PostgresqlServer& operator=(const PostgresqlServer&) = delete;

  bool start() {
    return run(fmt::format(
        "pg_ctl -w -D {0}/data -l {0}/log -o \"-c listen_addresses= -c unix_socket_directories={0} "
        "-c fsync=off\" start",
        folder_));
  }
  bool stop() { return run(fmt::format("pg_ctl -w -D {}/data -m immediate stop", folder_)); }
  [[nodiscard]] std::string address() const {
    return fmt::format("postgresql://roomwise@/postgres?host={}", folder_);
  }

 private:
  static std::string programs() {
    std::error_code error;
    std::string newest;
    for (const auto& entry : std::filesystem::directory_iterator("/usr/lib/postgresql", error)) {
      const std::string bin = entry.path().string() + "/bin";
      if (std::filesystem::exists(bin + "/initdb", error) && bin > newest) newest = bin;
    }
    return newest;
  }
  static bool shell(const std::string& command) {
    return std::system((command + " >/dev/null 2>&1 </dev/null").c_str()) == 0;
  }
  static bool run(const std::string& command) {
    const std::string whole = programs() + "/" + command;
    return shell(::getuid() == 0 ? "cd /tmp && runuser -u postgres -- " + whole : whole);
  }

  std::string folder_;
};

}  // namespace roomwise::service::testing
