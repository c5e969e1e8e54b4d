#include "roomwise/recording/personal_files.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "roomwise/image/codec.h"
#include "roomwise/image/metadata.h"

namespace roomwise::recording {
namespace {

namespace fs = std::filesystem;
using image::PersonalData;

constexpr std::uintmax_t kMaxJsonBytes = std::uintmax_t{1} << 27;
constexpr int kMaxJsonDepth = 64;  // no app's files come near it

// What a member of this name says: "deviceModel", "device_model" and "Device Model" are one.
PersonalData facts_of_name(const std::string& name) {
  std::string letters;
  for (const unsigned char c : name) {
    if (std::isalpha(c) != 0) letters += static_cast<char>(std::tolower(c));
  }
  const auto has = [&](std::initializer_list<const char*> parts) {
    return std::ranges::any_of(
        parts, [&](const char* part) { return letters.find(part) != std::string::npos; });
  };
  const auto is = [&](std::initializer_list<const char*> names) {
    return std::ranges::find(names, letters) != names.end();
  };
  return {has({"latitude", "longitude", "altitude", "gps", "geolocation", "address"}) ||
              is({"lat", "lon", "lng", "location", "city", "country"}),
          has({"device", "serialnumber", "hostname"}) || is({"make", "model", "phone", "udid"}),
          has({"owner", "author", "username", "email", "artist", "creator"}) || is({"user"})};
}

bool says_something(const nlohmann::json& value) {
  if (value.is_number()) return value.get<double>() != 0;
  if (value.is_boolean()) return value.get<bool>();
  if (value.is_string()) return !value.get_ref<const std::string&>().empty();
  return !value.empty();
}

PersonalData facts_down_to(const nlohmann::json& value, int depth) {
  PersonalData facts;
  if (!value.is_structured() || depth == 0) return facts;
  for (const auto& [name, below] : value.items()) {
    if (value.is_object() && says_something(below)) facts |= facts_of_name(name);
    facts |= facts_down_to(below, depth - 1);
  }
  return facts;
}

// Whether there were any. The order of the others stays.
bool take_out(nlohmann::ordered_json& value) {
  bool is_changed = false;
  if (value.is_object()) {
    for (auto member = value.begin(); member != value.end();) {
      const bool is_personal = facts_of_name(member.key()).any();
      member = is_personal ? value.erase(member) : std::next(member);
      is_changed = is_changed || is_personal;
    }
  }
  if (!value.is_structured()) return is_changed;
  for (auto& below : value) is_changed = take_out(below) || is_changed;
  return is_changed;
}

Expected<void> take_out_of_json(const fs::path& path) {
  std::error_code error;
  if (fs::file_size(path, error) > kMaxJsonBytes) return write_file(path, std::string_view());
  ROOMWISE_TRY(const std::string text, read_text_file(path));
  bool is_too_deep = false;
  auto parsed = nlohmann::ordered_json::parse(
      text,
      [&](int depth, auto, auto&) {
        is_too_deep = is_too_deep || depth > kMaxJsonDepth;
        return !is_too_deep;
      },
      /*allow_exceptions=*/false);
  if (is_too_deep || parsed.is_discarded()) return write_file(path, std::string_view());
  return take_out(parsed) ? write_file(path, parsed.dump()) : Expected<void>();
}

Expected<void> take_out_of_picture(const fs::path& path) {
  ROOMWISE_TRY(const Bytes bytes, read_file(path));
  const auto bare = image::without_metadata(bytes);
  return bare && *bare != bytes ? write_file(path, *bare) : Expected<void>();
}

// By its first bytes, however it is called.
bool is_picture(const fs::path& path) {
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored)) return false;
  constexpr std::size_t kHead = 12;
  std::array<char, kHead> head{};
  std::ifstream(path, std::ios::binary).read(head.data(), kHead);
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(head.data()), kHead);
  return image::is_jpeg(bytes) || image::is_png(bytes) || image::is_webp(bytes);
}

// The ending in small letters.
std::string ending_of(const fs::path& path) {
  std::string ending = path.extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return std::tolower(c); });
  return ending;
}

// Whether a reader takes files of such a name. Any other may say where somebody lives, or who.
bool is_read(const fs::path& path) {
  constexpr std::array kEndings{".jpg",  ".jpeg", ".png",  ".webp", ".exr", ".depth",
                                ".conf", ".mp4",  ".json", ".txt",  ".csv", ".pincam",
                                ".traj", ".sens", ".bag",  ".mcap", ".r3d", ".oni"};
  std::string name = path.stem().string();
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
  return std::ranges::find(kEndings, ending_of(path)) != kEndings.end() &&
         name.find("gps") == std::string::npos && name.find("location") == std::string::npos;
}

Expected<void> take_out_of_file(const fs::path& path) {
  if (is_picture(path)) return take_out_of_picture(path);
  if (ending_of(path) == ".json") return take_out_of_json(path);
  std::error_code error;
  if (!is_read(path)) fs::remove(path, error);
  if (error) return fail("{}: cannot be removed: {}", path.string(), error.message());
  return {};
}

}  // namespace

PersonalData personal_data_of_some(std::size_t pictures,
                                   const std::function<Expected<Bytes>(std::size_t)>& read) {
  PersonalData facts;
  if (pictures == 0) return facts;
  for (const std::size_t one : std::set{std::size_t{0}, pictures / 2, pictures - 1}) {
    if (const auto bytes = read(one)) facts |= image::personal_data_of(*bytes);
  }
  return facts;
}

PersonalData personal_data_of_json(const nlohmann::json& value) {
  return facts_down_to(value, kMaxJsonDepth);
}

PersonalData personal_data_of_json_file(const fs::path& path) {
  std::error_code error;
  const auto size = fs::file_size(path, error);
  if (error || size > kMaxJsonBytes) return {};
  const auto text = read_text_file(path);
  const auto parsed = text ? nlohmann::json::parse(*text, nullptr, false) : nlohmann::json();
  return parsed.is_discarded() ? PersonalData() : personal_data_of_json(parsed);
}

Expected<void> leave_out_personal_data(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  fs::recursive_directory_iterator entry(folder, error);
  for (; !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    if (entry->is_regular_file()) files.push_back(entry->path());
  }
  if (error) return fail("{}: cannot be read: {}", folder.string(), error.message());
  for (const fs::path& file : files) ROOMWISE_RETURN_IF_ERROR(take_out_of_file(file));
  return {};
}

}  // namespace roomwise::recording
