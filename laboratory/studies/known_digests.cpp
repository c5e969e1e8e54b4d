#include "laboratory/studies/known_digests.h"

#include <nlohmann/json.hpp>

#include "roomwise/base/file.h"

namespace roomwise::studies {

namespace fs = std::filesystem;

KnownDigests KnownDigests::read(const fs::path& kept) {
  KnownDigests digests;
  const auto text = read_text_file(kept);
  if (!text) return digests;
  try {
    const auto files = nlohmann::json::parse(*text);
    for (const auto& [file, known] : files.items())
      digests.files_[file] = {known.at("bytes"), known.at("changed"), known.at("sha256")};
  } catch (const nlohmann::json::exception&) {
    return {};
  }
  return digests;
}

Expected<void> KnownDigests::write(const fs::path& kept) const {
  nlohmann::json files = nlohmann::json::object();
  for (const auto& [file, known] : files_)
    files[file] = {{"bytes", known.bytes}, {"changed", known.changed}, {"sha256", known.sha256}};
  return write_file(kept, files.dump(2));
}

Expected<std::string> KnownDigests::of(const fs::path& file) {
  std::error_code error;
  const std::uintmax_t bytes = fs::file_size(file, error);
  const auto changed =
      error ? std::int64_t{0}
            : std::int64_t{fs::last_write_time(file, error).time_since_epoch().count()};
  Known& known = files_[fs::absolute(file).string()];
  if (error || known.sha256.empty() || known.bytes != bytes || known.changed != changed) {
    ROOMWISE_TRY(const Bytes content, read_file(file));
    known = {bytes, changed, sha256_hex(content)};
  }
  return known.sha256;
}

}  // namespace roomwise::studies
