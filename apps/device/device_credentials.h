#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "roomwise/service/client/client.h"

namespace roomwise::app {

// $XDG_CONFIG_HOME/roomwise/device.json, else ~/.config/roomwise/device.json.
[[nodiscard]] Expected<std::filesystem::path> credentials_file();

// What this device keeps of the computers that it is paired with, by their addresses "HOST:PORT".
// Nobody else can read the file. Fails where it is damaged; nothing where it does not know the
// server.
[[nodiscard]] Expected<std::optional<service::ServerCredentials>> stored_credentials(
    const std::filesystem::path& file, const std::string& server);
// The credentials that this device speaks to a computer with.
struct DevicePairing {
  service::ServerCredentials credentials;
  bool is_new = false;  // it was paired just now
};
// Those of an earlier pairing, as long as the computer knows them or is not there; else of a new
// one by `code`, which are stored. So a command line that holds a code that was used starts again.
// An empty code: an earlier pairing alone.
[[nodiscard]] tl::expected<DevicePairing, service::PairingError> find_pairing(
    const std::filesystem::path& file, const std::string& server, const std::string& code,
    const std::string& name, const service::ClientWait& wait);
[[nodiscard]] Expected<void> store_credentials(const std::filesystem::path& file,
                                               const std::string& server,
                                               const service::ServerCredentials& credentials);

}  // namespace roomwise::app
