#include "roomwise/service/credentials/secrets.h"

#include <openssl/crypto.h>
#include <openssl/rand.h>
#include <openssl/x509.h>

#include <array>

#include "roomwise/base/encodings.h"

namespace roomwise::service {

Expected<Bytes> random_bytes(std::size_t count) {
  Bytes bytes(count);
  if (RAND_bytes(bytes.data(), static_cast<int>(count)) != 1) {
    return fail("the system gives no random numbers");
  }
  return bytes;
}

Expected<std::string> random_code() {
  constexpr std::uint32_t kCodes = 1'000'000;
  // What is left over at the top of 32 bits is drawn again: it would make some codes likelier.
  constexpr std::uint32_t kUseful = UINT32_MAX / kCodes * kCodes;
  for (;;) {
    ROOMWISE_TRY(const Bytes bytes, random_bytes(4));
    std::uint32_t number = 0;
    for (const std::uint8_t byte : bytes) number = (number << 8U) | byte;
    if (number < kUseful) return fmt::format("{:06}", number % kCodes);
  }
}

bool equal_secrets(std::string_view a, std::string_view b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

std::string fingerprint_of(const X509* certificate) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int size = 0;
  X509_digest(certificate, EVP_sha256(), digest.data(), &size);
  return hexadecimal(std::span(digest).first(size));
}

std::string sha256_of(std::string_view text) {
  return sha256_hex({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

}  // namespace roomwise::service
