#pragma once

#include <string>
#include <string_view>

#include "roomwise/base/expected.h"

namespace roomwise::service {

// How a device and the computer show each other that they know the same code without saying it:
// scrypt (RFC 7914; N = 2^15, r = 8, p = 1; 64 bytes) of the code, salted with the SHA-256
// fingerprint of the certificate that the device was shown, and a nonce that the device chose. The
// first half is sent by the device, the second by the computer in its answer. Who stands between
// them with a certificate of their own cannot pass the halves on, as they are made with another
// fingerprint, and must try out codes at the price of scrypt each.
struct PairingProof {
  std::string device;    // 64 hexadecimal digits
  std::string computer;  // 64 hexadecimal digits
};

// fingerprint: 64 hexadecimal digits; nonce: hexadecimal, 32 to 64 digits.
[[nodiscard]] Expected<PairingProof> make_pairing_proof(std::string_view code,
                                                        std::string_view fingerprint,
                                                        std::string_view nonce);

// The same of a code's secret, which nobody can try out: HMAC-SHA256 by the secret, of what salts
// the other and a word for each half.
[[nodiscard]] Expected<PairingProof> make_secret_proof(std::string_view secret,
                                                       std::string_view fingerprint,
                                                       std::string_view nonce);

// How many letters a secret has: 16 bytes in base64url without padding.
inline constexpr std::size_t kSecretLength = 22;

}  // namespace roomwise::service
