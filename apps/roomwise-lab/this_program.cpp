#include "this_program.h"

#include <span>
#include <vector>

#include "networks.h"
#include "roomwise/base/file.h"

namespace roomwise::app {

Expected<std::filesystem::path> this_program() {
  std::error_code error;
  std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) return fail("this program's own file is not known: {}", error.message());
  return program;
}

Expected<std::string> version_of_programs(studies::KnownDigests& known) {
  ROOMWISE_TRY(const std::filesystem::path own, this_program());
  std::vector<std::filesystem::path> files = installed_networks();
  files.push_back(own.parent_path() / "roomwise");
  files.push_back(own);
  std::string digests;
  for (const std::filesystem::path& file : files) {
    ROOMWISE_TRY(const std::string digest, known.of(file));
    digests += digest;
  }
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(digests.data()), digests.size());
  constexpr std::size_t kShown = 12;
  return fmt::format("{} ({})", ROOMWISE_VERSION, sha256_hex(bytes).substr(0, kShown));
}

}  // namespace roomwise::app
