#pragma once

#include <openssl/types.h>

#include <cstddef>
#include <string>
#include <string_view>

#include "roomwise/base/expected.h"
#include "roomwise/base/file.h"

// Random bytes and their texts, from OpenSSL.
namespace roomwise::service {

// Fails where the system has no randomness to give.
[[nodiscard]] Expected<Bytes> random_bytes(std::size_t count);
// Six digits, each code as likely as any other.
[[nodiscard]] Expected<std::string> random_code();

// Takes as long for texts that differ early as for equal ones.
[[nodiscard]] bool equal_secrets(std::string_view a, std::string_view b);

// SHA-256 of a certificate (DER), hexadecimal.
[[nodiscard]] std::string fingerprint_of(const X509* certificate);
[[nodiscard]] std::string sha256_of(std::string_view text);  // hexadecimal

}  // namespace roomwise::service
