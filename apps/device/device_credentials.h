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
[[nodiscard]] Expected<void> store_credentials(const std::filesystem::path& file,
                                               const std::string& server,
                                               const service::ServerCredentials& credentials);

}  // namespace roomwise::app
