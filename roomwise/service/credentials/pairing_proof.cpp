#include "roomwise/service/credentials/pairing_proof.h"

#include <openssl/evp.h>
#include <openssl/hmac.h>

#include <algorithm>
#include <array>

#include "roomwise/base/encodings.h"
#include "roomwise/service/credentials/secrets.h"

namespace roomwise::service {

namespace {

Expected<void> check_nonce(std::string_view nonce) {
  const auto is_hex = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); };
  if (nonce.size() < 32 || nonce.size() > 64 || !std::ranges::all_of(nonce, is_hex)) {
    return fail("'nonce' must have 32 to 64 hexadecimal digits in small letters");
  }
  return {};
}

std::string hmac(std::string_view key, const std::string& text) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> code{};
  unsigned int size = 0;
  HMAC(EVP_sha256(), key.data(), static_cast<int>(key.size()),
       reinterpret_cast<const unsigned char*>(text.data()), text.size(), code.data(), &size);
  return hexadecimal(std::span<const std::uint8_t>(code).first(size));
}

}  // namespace

Expected<PairingProof> make_secret_proof(std::string_view secret, std::string_view fingerprint,
                                         std::string_view nonce) {
  ROOMWISE_RETURN_IF_ERROR(check_nonce(nonce));
  const std::string salt = fmt::format("{}{}", fingerprint, nonce);
  return PairingProof{hmac(secret, salt + "device"), hmac(secret, salt + "computer")};
}

Expected<PairingProof> make_pairing_proof(std::string_view code, std::string_view fingerprint,
                                          std::string_view nonce) {
  ROOMWISE_RETURN_IF_ERROR(check_nonce(nonce));
  const std::string salt = fmt::format("{}{}", fingerprint, nonce);
  std::array<unsigned char, 64> key{};
  constexpr std::uint64_t kMaxMemory = std::uint64_t{64} << 20U;  // it takes 33 MB
  if (EVP_PBE_scrypt(code.data(), code.size(), reinterpret_cast<const unsigned char*>(salt.data()),
                     salt.size(), std::uint64_t{1} << 15U, 8, 1, kMaxMemory, key.data(),
                     key.size()) != 1) {
    return fail("the proof could not be worked out: out of memory?");
  }
  const std::span<const std::uint8_t> bytes(key);
  return PairingProof{hexadecimal(bytes.first(32)), hexadecimal(bytes.last(32))};
}

}  // namespace roomwise::service
