#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/base/file.h"

namespace roomwise::service {

// The home's own authority, which signs its computer's certificate: who installs it on a phone is
// warned no more, also when that certificate is renewed.
struct Authority {
  Bytes certificate;        // DER, for everybody
  std::string name;         // as phones show it: "Roomwise, home of anna-pc (3f9c2a)"
  std::string fingerprint;  // SHA-256 of the certificate, 64 hexadecimal digits
  std::int64_t ends_s = 0;  // since 1970
};

// What the computer shows clients, so that they know it again.
struct Certificate {
  std::string certificate_pem;  // its own, and the authority's after it
  std::string key_pem;          // secret
  // What devices know the computer by, and pairing is bound to: of the authority, which stays; of
  // the certificate itself where a home has one from before there was an authority.
  std::string fingerprint;
  std::string own_fingerprint;  // of the certificate itself, as browsers show it for the page
  std::int64_t ends_s = 0;      // since 1970
  std::optional<Authority> authority;
};

// The certificate in `folder` (readable by its owner only), for `names` (host names and addresses,
// as host_names() gives them), signed by the home's authority. The authority (authority.pem,
// authority-key.pem) is made at the first call and lasts twenty years; it can sign for names and
// addresses of home networks and for the `names` of that first call, and for no others, so that who
// steals its key cannot pass for a bank. The certificate (certificate.pem, key.pem) lasts 397 days
// and is made anew where fewer than 60 of them are left, where it lacks one of the names, or where
// it is damaged. Fails where the authority is damaged or over, since clients know the computer by
// it. A self-signed certificate that lies there without an authority is used as it is. `now_s`:
// seconds since 1970; fails where the clock was not set.
[[nodiscard]] Expected<Certificate> own_certificate(const std::filesystem::path& folder,
                                                    const std::vector<std::string>& names,
                                                    std::int64_t now_s);

// By what this computer may be called in its network: localhost, its name, its name with ".local",
// and the addresses of its network cards.
[[nodiscard]] std::vector<std::string> host_names();

// "ab12..." to "AB:12:...", as browsers show fingerprints.
[[nodiscard]] std::string fingerprint_with_colons(const std::string& fingerprint);

}  // namespace roomwise::service
