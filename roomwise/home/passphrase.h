#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>

#include "roomwise/base/expected.h"

namespace roomwise::home {

// Bytes that nobody else should see: never swapped to the disk as far as the system's limit of
// locked memory allows, and overwritten when they go.
class SecretBytes {
 public:
  explicit SecretBytes(std::size_t size);

  [[nodiscard]] std::span<std::uint8_t> bytes() { return {data_.get(), size_}; }
  [[nodiscard]] std::span<const std::uint8_t> bytes() const { return {data_.get(), size_}; }
  [[nodiscard]] std::uint8_t* data() { return data_.get(); }
  [[nodiscard]] const std::uint8_t* data() const { return data_.get(); }

 private:
  struct Eraser {
    void operator()(std::uint8_t* data) const;
  };
  std::unique_ptr<std::uint8_t, Eraser> data_;
  std::size_t size_;
};

// What a person protects the pictures of a home with.
class Passphrase {
 public:
  static constexpr std::size_t kMaxBytes = 1024;

  // Fails where it is empty or longer than kMaxBytes.
  [[nodiscard]] static Expected<Passphrase> from(std::string_view text);
  // The file's content but for one line end at its end. Errors name the file.
  [[nodiscard]] static Expected<Passphrase> read(const std::filesystem::path& file);

  [[nodiscard]] std::span<const std::uint8_t> bytes() const { return bytes_.bytes(); }
  [[nodiscard]] bool operator==(const Passphrase& other) const;

 private:
  explicit Passphrase(std::string_view text);

  SecretBytes bytes_;
};

}  // namespace roomwise::home
