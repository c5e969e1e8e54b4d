#pragma once

#include <openssl/bio.h>
#include <openssl/evp.h>
#include <openssl/x509.h>

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/base/file.h"

// Certificates and keys by OpenSSL: made, signed, written and read. What a home does with them
// stands in certificate.h.
namespace roomwise::service {

template <auto kFree>
struct Freer {
  template <typename T>
  void operator()(T* pointer) const {
    kFree(pointer);
  }
};
using Key = std::unique_ptr<EVP_PKEY, Freer<EVP_PKEY_free>>;
using X509Certificate = std::unique_ptr<X509, Freer<X509_free>>;

// What a certificate says.
struct CertificateFacts {
  std::string name;                       // CN
  std::int64_t begins_s = 0, ends_s = 0;  // since 1970
  // OpenSSL's names and texts: {NID_basic_constraints, "critical,CA:FALSE"}.
  std::vector<std::pair<int, std::string>> extensions;
};
// A certificate and the key whose it is.
struct KeyedCertificate {
  X509Certificate certificate;
  Key key;
};

// A new P-256 key with its certificate, signed by `authority`; nullptr: by itself.
[[nodiscard]] Expected<KeyedCertificate> make_certificate(const CertificateFacts& facts,
                                                          const KeyedCertificate* authority);

[[nodiscard]] Expected<std::string> pem_of(const X509* certificate);
[[nodiscard]] Expected<std::string> pem_of_key(const EVP_PKEY* key);
[[nodiscard]] Expected<Bytes> der_of(const X509* certificate);
// Fail where one of the two is damaged, or they do not belong together.
[[nodiscard]] Expected<KeyedCertificate> read_certificate(const std::string& certificate_pem,
                                                          const std::string& key_pem);

// Whether the key of `authority`, which may sign, signed it. Looks at no time and no name.
[[nodiscard]] bool is_signed_by(X509* certificate, X509* authority);
[[nodiscard]] std::int64_t end_s_of(const X509* certificate);  // since 1970
// Whether it is for all of these host names and addresses.
[[nodiscard]] bool names_all(X509* certificate, const std::vector<std::string>& names);

}  // namespace roomwise::service
