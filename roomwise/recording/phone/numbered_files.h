#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "roomwise/base/expected.h"

// Files whose names are a number between two texts, as phone apps write them.
namespace roomwise::recording {

using NumberedFiles = std::map<std::uint64_t, std::filesystem::path>;

// 12 of "frame_00012.json"; nothing where it is another file.
[[nodiscard]] std::optional<std::uint64_t> number_in_name(const std::string& name,
                                                          std::string_view before,
                                                          std::string_view after);

// Those of a folder by their numbers. Fails where it cannot be read.
[[nodiscard]] Expected<NumberedFiles> numbered_files(const std::filesystem::path& folder,
                                                     std::string_view before,
                                                     std::string_view after);
// Whether a folder has one; false where it cannot be read.
[[nodiscard]] bool has_numbered_file(const std::filesystem::path& folder, std::string_view before,
                                     std::string_view after);

// An empty path where there is none.
[[nodiscard]] std::filesystem::path file_or_none(const NumberedFiles& files, std::uint64_t number);

}  // namespace roomwise::recording
