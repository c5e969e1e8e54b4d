#pragma once

#include <cstdint>
#include <ctime>
#include <filesystem>
#include <iostream>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "command.h"
#include "networks.h"
#include "roomwise/service/access/access.h"
#include "roomwise/service/access/account_store.h"
#include "roomwise/service/credentials/certificate.h"

// What serving one home and serving a folder of homes share.
namespace roomwise::app {

struct ServeOptions {
  std::filesystem::path home;  // or a folder of homes
  std::string address = "127.0.0.1";
  std::uint16_t port = 8443;
  std::vector<std::string> names;
  std::vector<std::string> allowed_hosts;
  std::filesystem::path pages;
  std::string pair;
  std::string speak;
  std::string language = "en";
  NetworkOptions networks;
  // Of a folder alone.
  std::string one;  // home that codes are shown for
  std::size_t open_homes = 8;
  double close_after_s = 600;
  std::vector<std::string> proxies;
  std::string public_address;  // HOST or HOST:PORT; empty: its own
  std::filesystem::path passphrases;
  std::string accounts;  // "postgresql://…"; empty: a file in the folder
};

// Lines for the operator, each with its time, from any thread.
class OperatorLog {
 public:
  void write(std::string_view line);

 private:
  std::mutex mutex_;
};

// Whether Enter was pressed. Where there is nobody to type, it never was.
class EnterKey {
 public:
  EnterKey();
  // Since the last call.
  [[nodiscard]] bool take();

 private:
  bool at_end_ = false;
};

// What came of Enter: where no code can be made now, that is said, and the server goes on.
void tell_of_code(const Expected<void>& shown);

// The pages that come with Roomwise: ../share/roomwise/web of the program's; empty: there are none.
[[nodiscard]] std::filesystem::path brought_pages();
[[nodiscard]] std::int64_t seconds_since_1970();
// The names of this computer, and those that it was given.
[[nodiscard]] std::vector<std::string> names_and(const std::vector<std::string>& more);
// "https://HOST:PORT", by which others in the network find what listens there.
[[nodiscard]] std::string url_of(const ServeOptions& options, std::uint16_t port);
// Fails where a folder of pages is named and not there: before anything is opened or made.
[[nodiscard]] Expected<void> check_pages(const ServeOptions& options);
// Where phones get the authority that signed the certificate; or why no other device can.
[[nodiscard]] std::string words_for_phones(const ServeOptions& options, const std::string& url,
                                           const service::Certificate& certificate);
// Prints a code, as text and as QR code, of the page at this address.
[[nodiscard]] Expected<void> print_code(const service::OpenCode& code, service::Role role,
                                        const std::string& pair_address);

// The keys, certificate and accounts of a folder of homes: within it, readable by its owner alone.
[[nodiscard]] std::filesystem::path house_folder(const std::filesystem::path& homes);
// The accounts of that folder's staff: in a file there, or where the address says.
[[nodiscard]] Expected<std::unique_ptr<service::AccountStore>> open_accounts(
    const std::filesystem::path& homes, const std::string& address);

// Serves a folder of homes until it is told to stop.
[[nodiscard]] Expected<Answer> serve_house(const ServeOptions& options, Context& context);

}  // namespace roomwise::app
