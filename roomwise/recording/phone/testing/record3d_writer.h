#pragma once

#include <zip.h>

#include <filesystem>
#include <map>
#include <string>

#include "roomwise/image/codec.h"
#include "roomwise/recording/messages/testing/byte_writer.h"

// Small .r3d files, for tests and as seeds of fuzzing.
namespace roomwise::recording::testing {

using ZipContents = std::map<std::string, Bytes>;

inline Bytes bytes_of(std::string_view text) {
  return {text.begin(), text.end()};
}

// False where it cannot be written.
inline bool write_zip(const std::filesystem::path& path, const ZipContents& files) {
  int code = 0;
  zip_t* archive = zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &code);
  if (archive == nullptr) return false;
  bool is_fine = true;
  for (const auto& [name, bytes] : files) {
    zip_source_t* source = zip_source_buffer(archive, bytes.data(), bytes.size(), 0);
    const zip_int64_t place = zip_file_add(archive, name.c_str(), source, ZIP_FL_ENC_UTF_8);
    // The same bytes at any time.
    is_fine = place >= 0 && is_fine &&
              zip_file_set_mtime(archive, static_cast<zip_uint64_t>(place), 1'000'000'000, 0) == 0;
  }
  return zip_close(archive) == 0 && is_fine;
}

// One plain block of LZFSE.
inline Bytes lzfse(const Bytes& plain) {
  return ByteWriter().text("bvx-").counted<std::uint32_t>(plain).text("bvx$").all();
}

constexpr int kDepthWidth = 12, kDepthHeight = 16;

inline Bytes depth_of_metres(float metres) {
  ByteWriter out;
  for (int i = 0; i < kDepthWidth * kDepthHeight; ++i) out.number<float>(metres);
  return out.all();
}

// Two portraits of 48x64 pixels; the app turns the pose by a quarter about y in between.
inline ZipContents phone_files() {
  ZipContents files;
  files["metadata"] = bytes_of(R"({"w": 48, "h": 64, "dw": 12, "dh": 16, "fps": 60,
    "K": [60, 0, 0, 0, 61, 0, 23.5, 31.5, 1], "cameraType": 1,
    "frameTimestamps": [10.5, 10.6],
    "poses": [[0, 0, 0, 1, 1, 2, 3], [0, 0.70710678, 0, 0.70710678, 1, 2, 4]]})");
  for (const char* number : {"0", "1"}) {
    const std::string name = std::string("rgbd/") + number;
    files[name + ".jpg"] = image::encode_jpeg(image::ColorImage(48, 64, {100, 100, 100}), 90);
    files[name + ".depth"] = lzfse(depth_of_metres(1.25F));
    files[name + ".conf"] = lzfse(Bytes(kDepthWidth * kDepthHeight, 2));
  }
  return files;
}

}  // namespace roomwise::recording::testing
