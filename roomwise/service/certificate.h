#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "roomwise/base/expected.h"

namespace roomwise::service {

// What the computer shows clients, so that they know it again.
struct Certificate {
  std::string certificate_pem;
  std::string key_pem;      // secret
  std::string fingerprint;  // SHA-256 of the certificate (DER), 64 hexadecimal digits
};

// The certificate in `folder` (certificate.pem and key.pem, readable by its owner only); at the
// first call it is made: self-signed, P-256, valid for ten years, for `names` (host names and
// addresses, as host_names() gives them). It is never made anew by itself, since clients know the
// computer by it: one that is damaged is an error.
[[nodiscard]] Expected<Certificate> own_certificate(const std::filesystem::path& folder,
                                                    const std::vector<std::string>& names);

// By what this computer may be called in its network: localhost, its name, its name with ".local",
// and the addresses of its network cards.
[[nodiscard]] std::vector<std::string> host_names();

// "ab12..." to "AB:12:...", as browsers show fingerprints.
[[nodiscard]] std::string fingerprint_with_colons(const std::string& fingerprint);

}  // namespace roomwise::service
