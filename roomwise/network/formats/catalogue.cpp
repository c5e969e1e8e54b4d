#include "roomwise/network/formats/catalogue.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "roomwise/network/formats/built_in_cards.h"

namespace roomwise::network {
namespace {

using Json = nlohmann::json;

// The texts of an entry; the last two may be missing, together.
constexpr std::pair<const char*, std::string CatalogueEntry::*> kTexts[] = {
    {"name", &CatalogueEntry::name},
    {"file", &CatalogueEntry::file},
    {"address", &CatalogueEntry::address},
    {"license", &CatalogueEntry::license},
    {"about", &CatalogueEntry::about},
    {"sha256_begin", &CatalogueEntry::sha256_begin},
    {"digest_from", &CatalogueEntry::digest_from}};
constexpr std::size_t kNeededTexts = 5;

bool is_hexadecimal(std::string_view text) {
  return std::ranges::all_of(
      text, [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

// A name that can stand in any folder and leads to no other.
bool is_file_name(std::string_view text) {
  return !text.empty() && text.front() != '.' && text.find('/') == std::string_view::npos;
}

Expected<void> check(const CatalogueEntry& entry, const std::string& where) {
  if (!is_file_name(entry.file)) return fail("{}.file: '{}' is no file's name", where, entry.file);
  if (!entry.address.starts_with("https://")) {
    return fail("{}.address: expected an https address, not '{}'", where, entry.address);
  }
  const std::string& digest = entry.sha256_begin;
  if (!digest.empty() && (digest.size() < 8 || digest.size() > 64 || !is_hexadecimal(digest))) {
    return fail("{}.sha256_begin: expected 8 to 64 lower-case hexadecimal digits", where);
  }
  if (digest.empty() != entry.digest_from.empty()) {
    return fail("{}: gives one of sha256_begin and digest_from without the other", where);
  }
  return {};
}

Expected<CatalogueEntry> parse_entry(const Json& json, const std::string& where) {
  if (!json.is_object()) return fail("{}: expected {{ ... }}", where);
  CatalogueEntry entry;
  std::set<std::string> known{"bytes"};
  for (std::size_t i = 0; i < std::size(kTexts); ++i) {
    const auto& [key, field] = kTexts[i];
    known.insert(key);
    if (!json.contains(key) && i >= kNeededTexts) continue;
    if (!json.contains(key) || !json.at(key).is_string() || json.at(key) == "") {
      return fail("{}.{}: expected a text in quotes", where, key);
    }
    entry.*field = json.at(key).get<std::string>();
  }
  for (const auto& [key, value] : json.items()) {
    if (!known.contains(key)) return fail("{}.{}: unknown field", where, key);
  }
  if (json.contains("bytes")) {
    if (!json.at("bytes").is_number_unsigned()) {
      return fail("{}.bytes: expected a whole number", where);
    }
    entry.bytes = json.at("bytes").get<std::uint64_t>();
  }
  ROOMWISE_RETURN_IF_ERROR(check(entry, where));
  return entry;
}

}  // namespace

Expected<std::vector<CatalogueEntry>> parse_catalogue(std::string_view json,
                                                      const std::string& origin) {
  const Json list = Json::parse(json, nullptr, /*allow_exceptions=*/false);
  if (!list.is_array()) return fail("{}: is not a JSON list of networks", origin);
  std::vector<CatalogueEntry> entries;
  for (std::size_t i = 0; i < list.size(); ++i) {
    ROOMWISE_TRY(CatalogueEntry entry,
                 parse_entry(list[i], fmt::format("{}: entry {}", origin, i + 1)));
    for (const CatalogueEntry& other : entries) {
      if (other.name == entry.name || other.file == entry.file) {
        return fail("{}: entry {}: {} ({}) stands there twice", origin, i + 1, entry.name,
                    entry.file);
      }
    }
    entries.push_back(std::move(entry));
  }
  return entries;
}

const std::vector<CatalogueEntry>& catalogue() {
  static const std::vector<CatalogueEntry> kEntries = [] {
    auto entries = parse_catalogue(built_in_catalogue(), "models/catalogue.json");
    if (!entries) throw std::logic_error(entries.error().message);  // a test reads it
    return *std::move(entries);
  }();
  return kEntries;
}

}  // namespace roomwise::network
