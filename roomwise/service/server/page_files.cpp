#include "roomwise/service/server/page_files.h"

#include <algorithm>
#include <array>

namespace roomwise::service {
namespace {

namespace fs = std::filesystem;

// Names that are plain: no dots first, no slashes of other systems, no control characters.
bool is_plain(std::string_view name) {
  return !name.empty() && name.front() != '.' && std::ranges::all_of(name, [](char c) {
    return c != '\\' && c != ':' && static_cast<unsigned char>(c) >= 0x20;
  });
}

bool is_plain_path(std::string_view path) {
  if (!path.starts_with('/')) return false;
  path.remove_prefix(1);
  while (!path.empty()) {
    const std::size_t end = std::min(path.find('/'), path.size());
    if (!is_plain(path.substr(0, end))) return false;
    path.remove_prefix(std::min(end + 1, path.size()));
  }
  return true;
}

bool lies_in(const fs::path& file, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), file.begin(), file.end()).first ==
         folder.end();
}

}  // namespace

std::string_view content_type_of(const fs::path& file) {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 17> kTypes{{
      {".html", "text/html; charset=utf-8"},
      {".js", "text/javascript; charset=utf-8"},
      {".mjs", "text/javascript; charset=utf-8"},
      {".css", "text/css; charset=utf-8"},
      {".json", "application/json"},
      {".webmanifest", "application/manifest+json"},
      {".svg", "image/svg+xml"},
      {".png", "image/png"},
      {".jpg", "image/jpeg"},
      {".webp", "image/webp"},
      {".ico", "image/x-icon"},
      {".wav", "audio/wav"},
      {".mp3", "audio/mpeg"},
      {".ogg", "audio/ogg"},
      {".woff2", "font/woff2"},
      {".txt", "text/plain; charset=utf-8"},
      {".map", "application/json"},
  }};
  const std::string ending = file.extension().string();
  const auto found = std::ranges::find(kTypes, ending, [](const auto& type) { return type.first; });
  return found == kTypes.end() ? "application/octet-stream" : found->second;
}

Expected<PageFiles> PageFiles::open(const fs::path& folder) {
  PageFiles files;
  if (folder.empty()) return files;
  std::error_code error;
  files.folder_ = fs::canonical(folder, error);
  if (error || !fs::is_directory(files.folder_)) {
    return fail("{}: the folder of the pages is not there", folder.string());
  }
  return files;
}

std::optional<fs::path> PageFiles::find(std::string_view path) const {
  if (folder_.empty() || !is_plain_path(path)) return std::nullopt;
  std::string_view name = path.substr(1);
  while (name.ends_with('/')) name.remove_suffix(1);
  const fs::path file_name(name);
  for (const fs::path& candidate :
       {file_name, fs::path(fmt::format("{}.html", name)), file_name / "index.html"}) {
    std::error_code error;
    const fs::path file = fs::canonical(folder_ / candidate, error);
    if (!error && lies_in(file, folder_) && fs::is_regular_file(file, error)) return file;
  }
  return std::nullopt;
}

HttpAnswer PageFiles::answer(const HttpRequest& request) const {
  const std::optional<std::string> path = percent_decoded(request.path);
  const std::optional<fs::path> file = path ? find(*path) : std::nullopt;
  if (!file) return error_answer(404, "there is nothing under this address");
  if (file->filename() == "index.html" && !path->ends_with('/') && !path->ends_with(".html")) {
    // Its own links are relative to the folder.
    HttpAnswer moved;
    moved.status = 308;
    moved.headers = {{"Location", fmt::format("{}{}/", request.base, request.path)}};
    return moved;
  }
  if (file->filename() != "index.html" && path->ends_with('/')) {
    // Likewise: of a file they are relative to the folder that it is in.
    HttpAnswer moved;
    moved.status = 308;
    const std::size_t end = request.path.find_last_not_of('/') + 1;
    moved.headers = {{"Location", request.base + request.path.substr(0, end)}};
    return moved;
  }
  Expected<Bytes> bytes = read_file(*file);
  if (!bytes) return error_answer(404, "there is nothing under this address");
  HttpAnswer answer;
  const std::string tag = fmt::format("\"{}\"", sha256_hex(*bytes).substr(0, 32));
  // no-cache: may be kept, and is asked for again with its tag, so that a new version is seen at
  // once.
  answer.headers = {{"ETag", tag}, {"Cache-Control", "no-cache"}};
  if (request.header("if-none-match").find(tag) != std::string_view::npos) {
    answer.status = 304;
    return answer;
  }
  answer.content_type = content_type_of(*file);
  answer.body = *std::move(bytes);
  return answer;
}

}  // namespace roomwise::service
