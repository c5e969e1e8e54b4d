#include "serving/serve_parts.h"

#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>

#include "roomwise/service/credentials/private_folder.h"
#include "roomwise/service/server/page_files.h"
#include "serving/qr_code.h"

namespace roomwise::app {

namespace fs = std::filesystem;

void OperatorLog::write(std::string_view line) {
  const std::scoped_lock lock(mutex_);
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  localtime_r(&now, &parts);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%F %T", &parts);
  std::string one_line(line);  // names in it are other people's
  std::ranges::replace_if(
      one_line, [](unsigned char c) { return std::iscntrl(c) != 0; }, ' ');
  std::cerr << text.data() << "  " << one_line << '\n';
}

// A program in the background that reads from its terminal would be stopped.
EnterKey::EnterKey() {
  ::signal(SIGTTIN, SIG_IGN);
}

bool EnterKey::take() {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  if (at_end_ || ::poll(&input, 1, 0) != 1) return false;
  std::array<char, 256> typed{};
  const auto size = ::read(STDIN_FILENO, typed.data(), typed.size());
  if (size <= 0) at_end_ = true;
  return size > 0 && std::find(typed.begin(), typed.begin() + size, '\n') != typed.end();
}

void tell_of_code(const Expected<void>& shown) {
  if (!shown) std::cout << "No code: " << shown.error().message << std::endl;
}

fs::path brought_pages() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  const fs::path pages = program.parent_path().parent_path() / "share/roomwise/web";
  return fs::exists(pages / "index.html", error) ? pages : fs::path();
}

std::int64_t seconds_since_1970() {
  return std::chrono::duration_cast<std::chrono::seconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

std::vector<std::string> names_and(const std::vector<std::string>& more) {
  std::vector<std::string> names = service::host_names();
  names.insert(names.end(), more.begin(), more.end());
  return names;
}

std::string url_of(const ServeOptions& options, std::uint16_t port) {
  if (!options.public_address.empty()) return "https://" + options.public_address;
  std::string host = options.address;
  if (host == "0.0.0.0" || host == "::") {
    const std::vector<std::string> names = names_and(options.names);
    const auto local = std::ranges::find_if(
        names, [](const std::string& name) { return name.ends_with(".local"); });
    host = local != names.end() ? *local : names.front();
  }
  const bool is_v6 = host.find(':') != std::string::npos;
  return fmt::format("https://{}{}{}:{}", is_v6 ? "[" : "", host, is_v6 ? "]" : "", port);
}

Expected<void> check_pages(const ServeOptions& options) {
  if (options.pages.empty()) return {};
  ROOMWISE_RETURN_IF_ERROR(service::PageFiles::open(options.pages));
  return {};
}

std::string words_for_phones(const ServeOptions& options, const std::string& url,
                             const service::Certificate& certificate) {
  const std::string& host = options.address;
  const bool is_loopback = host.starts_with("127.") || host == "::1" || host == "localhost";
  if (is_loopback && options.public_address.empty()) {
    return fmt::format(
        "Other devices cannot reach it: it listens on {}, this computer alone. With --address "
        "0.0.0.0 phones in the home's network can\n",
        host);
  }
  if (!certificate.authority) return "";
  return fmt::format(
      "A phone that installs {}/authority.crt is warned no more; that one's fingerprint: {}\n", url,
      service::fingerprint_with_colons(certificate.authority->fingerprint));
}

fs::path house_folder(const fs::path& homes) {
  return homes / "house.access";
}

Expected<std::unique_ptr<service::AccountStore>> open_accounts(const fs::path& homes,
                                                               const std::string& address) {
  if (!address.empty()) {
    ROOMWISE_TRY(auto link, service::open_postgresql_link(address));
    return service::AccountStore::open(std::move(link));
  }
  std::error_code error;
  if (!fs::is_directory(homes, error)) return fail("{}: is no folder of homes", homes.string());
  ROOMWISE_RETURN_IF_ERROR(service::make_private_folder(house_folder(homes)));
  ROOMWISE_TRY(auto link, service::open_sqlite_link(house_folder(homes) / "accounts.sqlite"));
  return service::AccountStore::open(std::move(link));
}

Expected<void> print_code(const service::OpenCode& code, service::Role role,
                          const std::string& pair_address) {
  const std::string address = pair_address + "#" + code.secret;
  ROOMWISE_TRY(const auto rows, qr_rows(address));
  if (::isatty(STDOUT_FILENO) != 0) std::cout << qr_lines(rows);
  std::cout << fmt::format("To pair a {}: code {} {}, within five minutes, at {}\n",
                           to_string(role), code.digits.substr(0, 3), code.digits.substr(3),
                           address);
  return {};
}

}  // namespace roomwise::app
