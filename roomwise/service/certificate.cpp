#include "roomwise/service/certificate.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <openssl/pem.h>
#include <openssl/x509v3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <memory>

#include "roomwise/base/file.h"
#include "roomwise/service/allowed_hosts.h"
#include "roomwise/service/private_file.h"
#include "roomwise/service/private_folder.h"
#include "roomwise/service/secrets.h"

namespace roomwise::service {
namespace {

namespace fs = std::filesystem;

template <auto kFree>
struct Freer {
  template <typename T>
  void operator()(T* pointer) const {
    kFree(pointer);
  }
};
using Key = std::unique_ptr<EVP_PKEY, Freer<EVP_PKEY_free>>;
using X509Certificate = std::unique_ptr<X509, Freer<X509_free>>;
using Memory = std::unique_ptr<BIO, Freer<BIO_free_all>>;

constexpr long kValid_s = 10L * 365 * 86400;

std::string text_in(const Memory& memory) {
  char* data = nullptr;
  const long size = BIO_get_mem_data(memory.get(), &data);
  return {data, static_cast<std::size_t>(size)};
}

// Only what can stand in OpenSSL's list of names.
bool is_name(const std::string& name) {
  return !name.empty() && name.size() < 254 && std::ranges::all_of(name, [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '.' || c == '-' || c == ':';
  });
}

std::string alternative_names(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) {
    if (!is_name(name)) continue;
    if (!list.empty()) list += ",";
    list += (is_address(name) ? "IP:" : "DNS:") + name;
  }
  return list;
}

bool add_extension(X509* x509, int kind, const std::string& text) {
  X509_EXTENSION* extension = X509V3_EXT_conf_nid(nullptr, nullptr, kind, text.c_str());
  const bool added = extension != nullptr && X509_add_ext(x509, extension, -1) == 1;
  X509_EXTENSION_free(extension);
  return added;
}

Expected<X509Certificate> make_certificate(EVP_PKEY* key, const std::vector<std::string>& names) {
  X509Certificate certificate(X509_new());
  X509* const x509 = certificate.get();
  ROOMWISE_TRY(Bytes serial, random_bytes(16));
  serial[0] = static_cast<std::uint8_t>((serial[0] & 0x7FU) | 0x40U);  // positive, never short
  const std::unique_ptr<BIGNUM, Freer<BN_free>> number(
      BN_bin2bn(serial.data(), static_cast<int>(serial.size()), nullptr));
  bool made = X509_set_version(x509, 2) == 1 &&
              BN_to_ASN1_INTEGER(number.get(), X509_get_serialNumber(x509)) != nullptr &&
              // A device whose clock is a day behind must not be locked out.
              X509_gmtime_adj(X509_getm_notBefore(x509), -86400) != nullptr &&
              X509_gmtime_adj(X509_getm_notAfter(x509), kValid_s) != nullptr &&
              X509_set_pubkey(x509, key) == 1;
  X509_NAME* const name = X509_get_subject_name(x509);
  made = made &&
         X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_UTF8,
                                    reinterpret_cast<const unsigned char*>("Roomwise"), -1, -1,
                                    0) == 1 &&
         X509_set_issuer_name(x509, name) == 1 &&
         add_extension(x509, NID_subject_alt_name, alternative_names(names)) &&
         add_extension(x509, NID_basic_constraints, "critical,CA:FALSE") &&
         add_extension(x509, NID_key_usage, "critical,digitalSignature") &&
         add_extension(x509, NID_ext_key_usage, "serverAuth") &&
         X509_sign(x509, key, EVP_sha256()) != 0;
  if (!made) return fail("the certificate could not be made");
  return certificate;
}

Expected<void> make_files(const fs::path& folder, const std::vector<std::string>& names) {
  const Key key(EVP_EC_gen("P-256"));
  if (!key) return fail("no key could be made for the certificate");
  ROOMWISE_TRY(const X509Certificate certificate, make_certificate(key.get(), names));
  const Memory key_text(BIO_new(BIO_s_mem()));
  const Memory certificate_text(BIO_new(BIO_s_mem()));
  if (PEM_write_bio_PKCS8PrivateKey(key_text.get(), key.get(), nullptr, nullptr, 0, nullptr,
                                    nullptr) != 1 ||
      PEM_write_bio_X509(certificate_text.get(), certificate.get()) != 1) {
    return fail("the certificate could not be written");
  }
  // The certificate last: where it is, the key is too.
  ROOMWISE_CHECK_OK(write_private_file(folder / "key.pem", text_in(key_text)));
  return write_private_file(folder / "certificate.pem", text_in(certificate_text));
}

Expected<Certificate> read_files(const fs::path& folder) {
  Certificate read;
  ROOMWISE_TRY(read.certificate_pem, read_text_file(folder / "certificate.pem"));
  ROOMWISE_TRY(read.key_pem, read_text_file(folder / "key.pem"));
  const Memory certificate_text(
      BIO_new_mem_buf(read.certificate_pem.data(), static_cast<int>(read.certificate_pem.size())));
  const Memory key_text(
      BIO_new_mem_buf(read.key_pem.data(), static_cast<int>(read.key_pem.size())));
  const X509Certificate certificate(
      PEM_read_bio_X509(certificate_text.get(), nullptr, nullptr, nullptr));
  const Key key(PEM_read_bio_PrivateKey(key_text.get(), nullptr, nullptr, nullptr));
  if (!certificate || !key || X509_check_private_key(certificate.get(), key.get()) != 1) {
    return fail(
        "{}: certificate.pem and key.pem are damaged or do not belong together; put them back from "
        "a copy, or delete both: then every device must be paired anew",
        folder.string());
  }
  struct stat status {};
  if (::stat((folder / "key.pem").c_str(), &status) != 0 || (status.st_mode & 0077U) != 0) {
    return fail("{}: others may read it; make it private (chmod 600)",
                (folder / "key.pem").string());
  }
  read.fingerprint = fingerprint_of(certificate.get());
  return read;
}

}  // namespace

Expected<Certificate> own_certificate(const fs::path& folder,
                                      const std::vector<std::string>& names) {
  ROOMWISE_CHECK_OK(make_private_folder(folder));
  if (!fs::exists(folder / "certificate.pem")) ROOMWISE_CHECK_OK(make_files(folder, names));
  return read_files(folder);
}

std::vector<std::string> host_names() {
  std::vector<std::string> names{"localhost", "127.0.0.1", "::1"};
  std::array<char, 256> own{};
  if (::gethostname(own.data(), own.size() - 1) == 0 && own[0] != '\0') {
    const std::string name = own.data();
    names.push_back(name);
    if (name.find('.') == std::string::npos) names.push_back(name + ".local");
  }
  ifaddrs* list = nullptr;
  if (::getifaddrs(&list) != 0) return names;
  for (const ifaddrs* card = list; card != nullptr; card = card->ifa_next) {
    if (card->ifa_addr == nullptr || (card->ifa_flags & IFF_LOOPBACK) != 0) continue;
    std::array<char, INET6_ADDRSTRLEN> text{};
    const int family = card->ifa_addr->sa_family;
    const void* address = nullptr;
    if (family == AF_INET) {
      address = &reinterpret_cast<const sockaddr_in*>(card->ifa_addr)->sin_addr;
    } else if (family == AF_INET6) {
      address = &reinterpret_cast<const sockaddr_in6*>(card->ifa_addr)->sin6_addr;
    }
    if (address != nullptr && ::inet_ntop(family, address, text.data(), text.size()) != nullptr) {
      names.emplace_back(text.data());
    }
  }
  ::freeifaddrs(list);
  return names;
}

std::string fingerprint_with_colons(const std::string& fingerprint) {
  std::string text;
  for (std::size_t i = 0; i < fingerprint.size(); ++i) {
    if (i > 0 && i % 2 == 0) text += ':';
    text += static_cast<char>(std::toupper(static_cast<unsigned char>(fingerprint[i])));
  }
  return text;
}

}  // namespace roomwise::service
