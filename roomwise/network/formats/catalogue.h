#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/base/expected.h"

namespace roomwise::network {

// A network that somebody has published.
struct CatalogueEntry {
  std::string name;     // for the command line: "yolox-nano"
  std::string file;     // as its publisher calls it
  std::string address;  // https
  std::optional<std::uint64_t> bytes;
  // The digits of its SHA-256 that are known, from the first on: all 64, some, or none.
  std::string sha256_begin;
  std::string digest_from;  // who says so; empty where none are known
  std::string license;
  std::string about;
};

// The published networks that Roomwise knows: models/catalogue.json, compiled in. Nothing of it is
// part of Roomwise.
[[nodiscard]] const std::vector<CatalogueEntry>& catalogue();

// Reads such a list. Fails, naming `origin`, entry and field, on anything missing, unknown, given
// twice or out of range.
[[nodiscard]] Expected<std::vector<CatalogueEntry>> parse_catalogue(std::string_view json,
                                                                    const std::string& origin);

}  // namespace roomwise::network
