#include "device_credentials.h"

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "roomwise/base/file.h"
#include "roomwise/service/credentials/private_file.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

Expected<nlohmann::json> read_computers(const fs::path& file) {
  std::error_code error;
  if (!fs::exists(file, error)) return nlohmann::json::object();
  ROOMWISE_TRY(const std::string text, read_text_file(file));
  nlohmann::json computers = nlohmann::json::parse(text, nullptr, false);
  if (!computers.is_object()) {
    return fail("{}: is damaged; delete it and pair again (--pair CODE)", file.string());
  }
  return computers;
}

}  // namespace

Expected<fs::path> credentials_file() {
  const char* config = std::getenv("XDG_CONFIG_HOME");
  if (config != nullptr && *config != '\0') return fs::path(config) / "roomwise/device.json";
  const char* home = std::getenv("HOME");
  if (home == nullptr || *home == '\0') {
    return fail("there is no place for the device's token: set HOME or XDG_CONFIG_HOME");
  }
  return fs::path(home) / ".config/roomwise/device.json";
}

Expected<std::optional<service::ServerCredentials>> stored_credentials(const fs::path& file,
                                                                       const std::string& server) {
  ROOMWISE_TRY(const nlohmann::json computers, read_computers(file));
  const auto found = computers.find(server);
  if (found == computers.end()) return std::optional<service::ServerCredentials>();
  try {
    return service::ServerCredentials{found->at("fingerprint").get<std::string>(),
                                      found->at("token").get<std::string>()};
  } catch (const nlohmann::json::exception&) {
    return fail("{}: is damaged; delete it and pair again (--pair CODE)", file.string());
  }
}

Expected<void> store_credentials(const fs::path& file, const std::string& server,
                                 const service::ServerCredentials& credentials) {
  ROOMWISE_TRY(nlohmann::json computers, read_computers(file));
  computers[server] = {{"fingerprint", credentials.fingerprint}, {"token", credentials.token}};
  std::error_code error;
  fs::create_directories(file.parent_path(), error);
  if (error) return fail("{}: cannot be made: {}", file.parent_path().string(), error.message());
  return service::write_private_file(file, computers.dump(2) + "\n");
}

tl::expected<DevicePairing, service::PairingError> find_pairing(const fs::path& file,
                                                                const std::string& server,
                                                                const std::string& code,
                                                                const std::string& name,
                                                                const service::ClientWait& wait) {
  ROOMWISE_TRY(const auto address, service::parse_server_address(server));
  ROOMWISE_TRY(const auto stored, stored_credentials(file, server));
  if (code.empty()) {
    if (stored) return DevicePairing{*stored};
    return fail(
        "this device is not paired with {}: run 'roomwise serve HOME --pair device' there, and "
        "give the code here: --pair CODE",
        server);
  }
  bool holds = false;  // as far as is known: a computer that is busy or not there says nothing
  if (stored) {
    const auto open = service::ServerConnection::open(address, *stored, wait);
    if (open) return DevicePairing{*stored};
    holds = open.error().code != ErrorCode::kRefused;
  }
  auto paired = service::pair_with(address, code, name, wait);
  if (!paired) {
    if (holds) return DevicePairing{*stored};
    return tl::unexpected(std::move(paired).error());
  }
  ROOMWISE_RETURN_IF_ERROR(store_credentials(file, server, paired->credentials));
  return DevicePairing{std::move(paired->credentials), true};
}

}  // namespace roomwise::app
