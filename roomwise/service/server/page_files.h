#pragma once

#include <filesystem>
#include <string_view>

#include "roomwise/service/protocol/http.h"

namespace roomwise::service {

// The files of a folder, for everyone. "/" is index.html, "/device" is device.html or
// device/index.html. Nothing outside the folder is ever read: not by "..", not through links, and
// no file whose name begins with a dot.
class PageFiles {
 public:
  // An empty folder name: there are no files.
  [[nodiscard]] static Expected<PageFiles> open(const std::filesystem::path& folder);

  // The answer to a GET request: 200, 304 (where the ETag is still right) or 404.
  [[nodiscard]] HttpAnswer answer(const HttpRequest& request) const;

 private:
  [[nodiscard]] std::optional<std::filesystem::path> find(std::string_view path) const;

  std::filesystem::path folder_;  // without links
};

// By the name's ending; "application/octet-stream" where it is not known.
[[nodiscard]] std::string_view content_type_of(const std::filesystem::path& file);

}  // namespace roomwise::service
