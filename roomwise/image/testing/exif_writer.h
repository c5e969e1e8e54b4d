#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/base/file.h"

// Exif as phones write it, for tests and as seeds of fuzzing.
namespace roomwise::image::testing {

// A first directory with the address of the second, which has `entries`.
struct ExifEntry {
  std::uint16_t tag, kind;
  std::uint32_t value, under = 0;  // a RATIONAL is value / under
};
class ExifWriter {
 public:
  explicit ExifWriter(bool big_endian) : big_endian_(big_endian) {}
  Bytes write(const std::vector<ExifEntry>& entries) {
    bytes_ = {'E', 'x', 'i', 'f', 0, 0};
    bytes_.insert(bytes_.end(), 2, big_endian_ ? 'M' : 'I');
    number(42, 2);
    number(8, 4);
    constexpr std::uint32_t kExif = 8 + 2 + 2 * 12 + 4;
    directory({{0x0112, 3, 6}, {0x8769, 4, kExif}}, kExif);
    directory(entries, kExif + 2 + 12 * static_cast<std::uint32_t>(entries.size()) + 4);
    for (const ExifEntry& entry : entries) {
      if (entry.kind != 5) continue;
      number(entry.value, 4);
      number(entry.under, 4);
    }
    return bytes_;
  }

 private:
  void number(std::uint32_t value, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) {
      bytes_.push_back(static_cast<std::uint8_t>(value >> 8 * (big_endian_ ? size - 1 - i : i)));
    }
  }
  void directory(const std::vector<ExifEntry>& entries, std::uint32_t values_at) {
    number(static_cast<std::uint32_t>(entries.size()), 2);
    for (const ExifEntry& entry : entries) {
      number(entry.tag, 2);
      number(entry.kind, 2);
      number(1, 4);
      if (entry.kind == 5) {
        number(values_at, 4);
        values_at += 8;
      } else {
        number(entry.value, entry.kind == 3 ? 2 : 4);
        if (entry.kind == 3) number(0, 2);
      }
    }
    number(0, 4);
  }
  bool big_endian_;
  Bytes bytes_;
};

inline const std::vector<ExifEntry> kPhoneExif{
    {0x920A, 5, 425, 100}, {0xA002, 4, 4032}, {0xA003, 3, 3024}, {0xA20E, 5, 72000, 9},
    {0xA210, 3, 3},        {0xA404, 5, 3, 2}, {0xA405, 3, 26}};

// What a phone writes of where, with what and by whom a picture was taken: 50 degrees, 6 minutes
// and 43.21 seconds north, by kSecretDevice, by kSecretOwner.
constexpr std::string_view kSecretDevice = "SecretPhone", kSecretOwner = "Jane Secret";
inline const Bytes kSecretLatitude{50, 0, 0, 0, 1,    0,    0, 0, 6,   0, 0, 0,
                                   1,  0, 0, 0, 0xE1, 0x10, 0, 0, 100, 0, 0, 0};
inline Bytes exif_with_place(std::uint8_t orientation) {
  constexpr std::uint8_t kMake = 62, kArtist = 74, kGps = 86, kLatitude = 116;  // from "II" on
  Bytes exif{'E',  'x',  'i',  'f',  0,    0, 'I',     'I', 42,          0, 8,     0,    0,    0,
             4,    0,    0x0F, 0x01, 2,    0, 12,      0,   0,           0, kMake, 0,    0,    0,
             0x12, 0x01, 3,    0,    1,    0, 0,       0,   orientation, 0, 0,     0,    0x3B, 0x01,
             2,    0,    12,   0,    0,    0, kArtist, 0,   0,           0, 0x25,  0x88, 4,    0,
             1,    0,    0,    0,    kGps, 0, 0,       0,   0,           0, 0,     0};
  for (const std::string_view name : {kSecretDevice, kSecretOwner}) {
    exif.insert(exif.end(), name.begin(), name.end());
    exif.push_back(0);
  }
  const Bytes gps{2, 0, 1, 0, 2, 0, 2, 0,         0, 0, 'N', 0, 0, 0, 2,
                  0, 5, 0, 3, 0, 0, 0, kLatitude, 0, 0, 0,   0, 0, 0, 0};
  exif.insert(exif.end(), gps.begin(), gps.end());
  exif.insert(exif.end(), kSecretLatitude.begin(), kSecretLatitude.end());
  return exif;
}

// Which of the above stands somewhere in the bytes.
inline std::string secrets_in(std::string_view bytes) {
  std::string found;
  const std::string_view latitude(reinterpret_cast<const char*>(kSecretLatitude.data()),
                                  kSecretLatitude.size());
  if (bytes.find(kSecretDevice) != bytes.npos) found += "device ";
  if (bytes.find(kSecretOwner) != bytes.npos) found += "owner ";
  if (bytes.find(latitude) != bytes.npos) found += "place ";
  return found;
}
inline std::string secrets_in(const Bytes& bytes) {
  return secrets_in(std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

// The JPEG with the Exif in it.
inline Bytes with_exif(Bytes jpeg, const Bytes& exif) {
  const std::size_t size = exif.size() + 2;
  Bytes segment{0xFF, 0xE1, static_cast<std::uint8_t>(size >> 8U), static_cast<std::uint8_t>(size)};
  segment.insert(segment.end(), exif.begin(), exif.end());
  jpeg.insert(jpeg.begin() + 2, segment.begin(), segment.end());
  return jpeg;
}

}  // namespace roomwise::image::testing
