#pragma once

#include <cstdint>
#include <filesystem>

#include "roomwise/base/expected.h"
#include "roomwise/home/home.h"

namespace roomwise::live {

struct BackupOptions {
  bool with_walks = true;  // the recordings of walks, which are large
};

struct Backup {
  std::size_t files = 0;
  std::uintmax_t bytes = 0;
};

// Copies a home, and what lies beside it (paired devices, photos of rooms, recorded walks, lenses),
// into a new folder, which is there whole or not at all. Programs that write the home may go on.
// Uploads that are not whole are left out. Only its owner may open the folder.
[[nodiscard]] Expected<Backup> back_up(const home::Home& home, const std::filesystem::path& folder,
                                       const BackupOptions& options = {});

struct RestoreOptions {
  // Those that were paired when the backup was made, also who was removed since.
  bool with_devices = true;
};

struct Restored : Backup {
  std::size_t devices = 0;  // that are paired
};

// The way back, to a home of any name. Fails where something of that name is there, and where the
// folder does not hold one whole home.
[[nodiscard]] Expected<Restored> restore(const std::filesystem::path& folder,
                                         const std::filesystem::path& home,
                                         const RestoreOptions& options = {});

}  // namespace roomwise::live
