#include "roomwise/service/credentials/x509.h"

#include <openssl/pem.h>
#include <openssl/x509v3.h>

#include <algorithm>
#include <ctime>

#include "roomwise/service/credentials/allowed_hosts.h"
#include "roomwise/service/credentials/secrets.h"

namespace roomwise::service {
namespace {

using Memory = std::unique_ptr<BIO, Freer<BIO_free_all>>;

std::string text_in(const Memory& memory) {
  char* data = nullptr;
  const long size = BIO_get_mem_data(memory.get(), &data);
  return {data, static_cast<std::size_t>(size)};
}

Memory memory_of(const std::string& text) {
  return Memory(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
}

bool set_serial(X509* x509, const Bytes& random) {
  Bytes serial = random;
  serial[0] = static_cast<std::uint8_t>((serial[0] & 0x7FU) | 0x40U);  // positive, never short
  const std::unique_ptr<BIGNUM, Freer<BN_free>> number(
      BN_bin2bn(serial.data(), static_cast<int>(serial.size()), nullptr));
  return BN_to_ASN1_INTEGER(number.get(), X509_get_serialNumber(x509)) != nullptr;
}

bool set_times(X509* x509, const CertificateFacts& facts) {
  return ASN1_TIME_set(X509_getm_notBefore(x509), facts.begins_s) != nullptr &&
         ASN1_TIME_set(X509_getm_notAfter(x509), facts.ends_s) != nullptr;
}

bool set_name(X509* x509, const std::string& name) {
  return X509_NAME_add_entry_by_txt(X509_get_subject_name(x509), "CN", MBSTRING_UTF8,
                                    reinterpret_cast<const unsigned char*>(name.c_str()), -1, -1,
                                    0) == 1;
}

bool add_extensions(X509* x509, X509* issuer, const CertificateFacts& facts) {
  X509V3_CTX context{};
  X509V3_set_ctx(&context, issuer, x509, nullptr, nullptr, 0);
  return std::ranges::all_of(facts.extensions, [&](const auto& one) {
    X509_EXTENSION* extension =
        X509V3_EXT_conf_nid(nullptr, &context, one.first, one.second.c_str());
    const bool added = extension != nullptr && X509_add_ext(x509, extension, -1) == 1;
    X509_EXTENSION_free(extension);
    return added;
  });
}

}  // namespace

Expected<KeyedCertificate> make_certificate(const CertificateFacts& facts,
                                            const KeyedCertificate* authority) {
  KeyedCertificate made{X509Certificate(X509_new()), Key(EVP_EC_gen("P-256"))};
  if (!made.key) return fail("no key could be made for the certificate");
  ROOMWISE_TRY(const Bytes random, random_bytes(16));
  X509* const x509 = made.certificate.get();
  X509* const issuer = authority != nullptr ? authority->certificate.get() : x509;
  EVP_PKEY* const signing = authority != nullptr ? authority->key.get() : made.key.get();
  const bool well =
      X509_set_version(x509, 2) == 1 && set_serial(x509, random) && set_times(x509, facts) &&
      X509_set_pubkey(x509, made.key.get()) == 1 && set_name(x509, facts.name) &&
      X509_set_issuer_name(x509, X509_get_subject_name(issuer)) == 1 &&
      add_extensions(x509, issuer, facts) && X509_sign(x509, signing, EVP_sha256()) != 0;
  if (!well) return fail("the certificate could not be made");
  return made;
}

Expected<std::string> pem_of(const X509* certificate) {
  const Memory memory(BIO_new(BIO_s_mem()));
  if (PEM_write_bio_X509(memory.get(), certificate) != 1) {
    return fail("the certificate could not be written");
  }
  return text_in(memory);
}

Expected<std::string> pem_of_key(const EVP_PKEY* key) {
  const Memory memory(BIO_new(BIO_s_mem()));
  if (PEM_write_bio_PKCS8PrivateKey(memory.get(), key, nullptr, nullptr, 0, nullptr, nullptr) !=
      1) {
    return fail("the certificate's key could not be written");
  }
  return text_in(memory);
}

Expected<Bytes> der_of(const X509* certificate) {
  unsigned char* data = nullptr;
  const int size = i2d_X509(certificate, &data);
  if (size <= 0) return fail("the certificate could not be written");
  Bytes bytes(data, data + size);
  OPENSSL_free(data);
  return bytes;
}

Expected<KeyedCertificate> read_certificate(const std::string& certificate_pem,
                                            const std::string& key_pem) {
  KeyedCertificate read{
      X509Certificate(
          PEM_read_bio_X509(memory_of(certificate_pem).get(), nullptr, nullptr, nullptr)),
      Key(PEM_read_bio_PrivateKey(memory_of(key_pem).get(), nullptr, nullptr, nullptr))};
  if (!read.certificate || !read.key ||
      X509_check_private_key(read.certificate.get(), read.key.get()) != 1) {
    return fail("they are damaged or do not belong together");
  }
  return read;
}

bool is_signed_by(X509* certificate, X509* authority) {
  return X509_check_ca(authority) == 1 &&
         X509_NAME_cmp(X509_get_issuer_name(certificate), X509_get_subject_name(authority)) == 0 &&
         X509_verify(certificate, X509_get0_pubkey(authority)) == 1;
}

std::int64_t end_s_of(const X509* certificate) {
  std::tm end{};
  if (ASN1_TIME_to_tm(X509_get0_notAfter(certificate), &end) != 1) return 0;
  return ::timegm(&end);
}

bool names_all(X509* certificate, const std::vector<std::string>& names) {
  return std::ranges::all_of(names, [&](const std::string& name) {
    return is_address(name)
               ? X509_check_ip_asc(certificate, name.c_str(), 0) == 1
               : X509_check_host(certificate, name.c_str(), name.size(), 0, nullptr) == 1;
  });
}

}  // namespace roomwise::service
