#include "roomwise/home/passphrase.h"

#include <fcntl.h>
#include <sodium.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>

#include "roomwise/base/in_context.h"

namespace roomwise::home {

SecretBytes::SecretBytes(std::size_t size) : size_(size) {
  if (::sodium_init() < 0) throw std::runtime_error("libsodium found no random numbers");
  data_.reset(static_cast<std::uint8_t*>(::sodium_malloc(size)));
  if (!data_) throw std::bad_alloc();
}

void SecretBytes::Eraser::operator()(std::uint8_t* data) const {
  ::sodium_free(data);  // overwrites
}

Passphrase::Passphrase(std::string_view text) : bytes_(text.size()) {
  std::ranges::copy(text, bytes_.bytes().begin());
}

Expected<Passphrase> Passphrase::from(std::string_view text) {
  if (text.empty()) return fail("the passphrase is empty");
  if (text.size() > kMaxBytes) {
    return fail("the passphrase is longer than {} bytes", kMaxBytes);
  }
  return Passphrase(text);
}

Expected<Passphrase> Passphrase::read(const std::filesystem::path& file) {
  const int opened = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (opened < 0) {
    return fail("{}: cannot be read: {}; give a file that holds the passphrase", file.string(),
                std::strerror(errno));
  }
  // One byte more than is allowed and a line end, so that what is too long is seen.
  SecretBytes content(kMaxBytes + 2);
  std::size_t size = 0;
  ssize_t got = 0;
  while (size < content.bytes().size() &&
         (got = ::read(opened, content.data() + size, content.bytes().size() - size)) > 0) {
    size += static_cast<std::size_t>(got);
  }
  const int error = got < 0 ? errno : 0;
  ::close(opened);
  if (error != 0) return fail("{}: cannot be read: {}", file.string(), std::strerror(error));
  std::string_view text(reinterpret_cast<const char*>(content.data()), size);
  if (text.ends_with('\n')) text.remove_suffix(1);
  if (text.ends_with('\r')) text.remove_suffix(1);
  return in_context(file.string(), from(text));
}

bool Passphrase::operator==(const Passphrase& other) const {
  return bytes().size() == other.bytes().size() &&
         ::sodium_memcmp(bytes().data(), other.bytes().data(), bytes().size()) == 0;
}

}  // namespace roomwise::home
