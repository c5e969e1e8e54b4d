#include "roomwise/service/credentials/certificate.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <openssl/x509v3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "roomwise/base/encodings.h"
#include "roomwise/service/credentials/allowed_hosts.h"
#include "roomwise/service/credentials/private_file.h"
#include "roomwise/service/credentials/private_folder.h"
#include "roomwise/service/credentials/secrets.h"
#include "roomwise/service/credentials/x509.h"

namespace roomwise::service {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kDay_s = 86400;
constexpr std::int64_t kAuthority_s = 20 * 365 * kDay_s;
// Phones refuse certificates that last longer than 398 days.
constexpr std::int64_t kCertificate_s = 397 * kDay_s;
constexpr std::int64_t kRenewed_s = 60 * kDay_s;     // before the end
constexpr std::int64_t kEarliest_s = 1'600'000'000;  // a clock that says less was not set

// What no computer outside a home can have: names that are reserved for networks of homes, and
// addresses that lead nowhere else.
constexpr const char* kHomeNames[] = {"local", "localhost", "home.arpa", "internal"};
constexpr const char* kHomeAddresses[] = {"10.0.0.0/255.0.0.0",
                                          "172.16.0.0/255.240.0.0",
                                          "192.168.0.0/255.255.0.0",
                                          "169.254.0.0/255.255.0.0",
                                          "127.0.0.0/255.0.0.0",
                                          "100.64.0.0/255.192.0.0",
                                          "fc00::/fe00::",
                                          "fe80::/ffc0::",
                                          "::1/ffff:ffff:ffff:ffff:ffff:ffff:ffff:ffff"};

bool can_be_named(const std::string& name) {
  return is_host_name(name) && name.find('%') == std::string::npos;
}

std::string name_constraints(const std::vector<std::string>& names) {
  std::string text = "critical";
  for (const char* name : kHomeNames) text += fmt::format(",permitted;DNS:{}", name);
  for (const std::string& name : names) {
    if (can_be_named(name) && !is_address(name)) text += fmt::format(",permitted;DNS:{}", name);
  }
  for (const char* addresses : kHomeAddresses) text += fmt::format(",permitted;IP:{}", addresses);
  return text;
}

std::string alternative_names(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) {
    if (!list.empty()) list += ",";
    list += (is_address(name) ? "IP:" : "DNS:") + name;
  }
  return list;
}

Expected<KeyedCertificate> make_authority(const std::vector<std::string>& names,
                                          std::int64_t now_s) {
  std::array<char, 65> host{};
  (void)::gethostname(host.data(), host.size() - 1);
  ROOMWISE_TRY(const Bytes random, random_bytes(3));  // tells two homes apart
  CertificateFacts facts;
  // A name may have 64 letters.
  facts.name = fmt::format("Roomwise, home of {:.32} ({})", host.data(), hexadecimal(random));
  facts.begins_s = now_s - kDay_s;
  facts.ends_s = now_s + kAuthority_s;
  facts.extensions = {{NID_basic_constraints, "critical,CA:TRUE,pathlen:0"},
                      {NID_key_usage, "critical,keyCertSign,cRLSign"},
                      {NID_ext_key_usage, "serverAuth"},
                      {NID_name_constraints, name_constraints(names)},
                      {NID_subject_key_identifier, "hash"}};
  return make_certificate(facts, nullptr);
}

Expected<KeyedCertificate> make_own(const KeyedCertificate& authority,
                                    const std::vector<std::string>& names, std::int64_t now_s) {
  CertificateFacts facts;
  facts.name = "Roomwise";
  // A device whose clock is a day behind must not be locked out.
  facts.begins_s = now_s - kDay_s;
  facts.ends_s = std::min(now_s - kDay_s + kCertificate_s, end_s_of(authority.certificate.get()));
  facts.extensions = {{NID_subject_alt_name, alternative_names(names)},
                      {NID_basic_constraints, "critical,CA:FALSE"},
                      {NID_key_usage, "critical,digitalSignature"},
                      {NID_ext_key_usage, "serverAuth"},
                      {NID_subject_key_identifier, "hash"},
                      {NID_authority_key_identifier, "keyid"}};
  return make_certificate(facts, &authority);
}

// Whether the authority's constraints allow that name, by OpenSSL's own rules.
bool may_sign_for(X509* authority, X509* certificate) {
  NAME_CONSTRAINTS* const constraints = static_cast<NAME_CONSTRAINTS*>(
      X509_get_ext_d2i(authority, NID_name_constraints, nullptr, nullptr));
  if (constraints == nullptr) return true;
  // What it compares is read from the certificate by this alone.
  X509_check_purpose(certificate, -1, 0);
  const bool may = NAME_CONSTRAINTS_check(certificate, constraints) == X509_V_OK;
  NAME_CONSTRAINTS_free(constraints);
  return may;
}

// The names that the authority may sign for; a network card may have others.
Expected<std::vector<std::string>> names_it_may(const KeyedCertificate& authority,
                                                const std::vector<std::string>& names,
                                                std::int64_t now_s) {
  std::vector<std::string> allowed;
  for (const std::string& name : names) {
    if (!can_be_named(name)) continue;
    ROOMWISE_TRY(const KeyedCertificate tried, make_own(authority, {name}, now_s));
    if (may_sign_for(authority.certificate.get(), tried.certificate.get())) {
      allowed.push_back(name);
    }
  }
  return allowed;
}

// The key first: where a certificate is, its key is too.
Expected<void> write_files(const KeyedCertificate& made, const fs::path& certificate,
                           const fs::path& key) {
  ROOMWISE_TRY(const std::string key_text, pem_of_key(made.key.get()));
  ROOMWISE_TRY(const std::string text, pem_of(made.certificate.get()));
  ROOMWISE_RETURN_IF_ERROR(write_private_file(key, key_text));
  return write_private_file(certificate, text);
}

Expected<KeyedCertificate> read_files(const fs::path& certificate, const fs::path& key) {
  struct stat status {};
  if (::stat(key.c_str(), &status) == 0 && (status.st_mode & 0077U) != 0) {
    return fail_with(ErrorCode::kRefused, "{}: others may read it; make it private (chmod 600)",
                     key.string());
  }
  ROOMWISE_TRY(const std::string text, read_text_file(certificate));
  ROOMWISE_TRY(const std::string key_text, read_text_file(key));
  return read_certificate(text, key_text);
}

// Clients know the computer by it: it is never made anew by itself.
Unexpected lost(const fs::path& folder, const char* files, const Error& why) {
  if (why.code == ErrorCode::kRefused) return Unexpected(why);
  return fail(
      "{}: {}: {}; put them back from a copy, or delete both: then every device must be paired "
      "anew",
      folder.string(), files, why.message);
}

// From before there were authorities.
Expected<Certificate> self_signed(const fs::path& folder) {
  auto read = read_files(folder / "certificate.pem", folder / "key.pem");
  if (!read) return lost(folder, "certificate.pem and key.pem", read.error());
  X509* const own = read->certificate.get();
  if (X509_NAME_cmp(X509_get_issuer_name(own), X509_get_subject_name(own)) != 0) {
    return lost(folder, "authority.pem and authority-key.pem", Error{"they are gone"});
  }
  Certificate certificate;
  ROOMWISE_TRY(certificate.certificate_pem, pem_of(read->certificate.get()));
  ROOMWISE_TRY(certificate.key_pem, pem_of_key(read->key.get()));
  certificate.fingerprint = fingerprint_of(read->certificate.get());
  certificate.own_fingerprint = certificate.fingerprint;
  certificate.ends_s = end_s_of(read->certificate.get());
  return certificate;
}

Expected<KeyedCertificate> own_authority(const fs::path& folder,
                                         const std::vector<std::string>& names,
                                         std::int64_t now_s) {
  const fs::path certificate = folder / "authority.pem";
  const fs::path key = folder / "authority-key.pem";
  if (!fs::exists(certificate)) {
    if (now_s < kEarliest_s) {
      return fail("the computer's clock was not set: set it, or certificates would be of no use");
    }
    ROOMWISE_TRY(const KeyedCertificate made, make_authority(names, now_s));
    ROOMWISE_RETURN_IF_ERROR(write_files(made, certificate, key));
  }
  auto read = read_files(certificate, key);
  if (!read) return lost(folder, "authority.pem and authority-key.pem", read.error());
  if (end_s_of(read->certificate.get()) <= now_s) {
    return lost(folder, "authority.pem and authority-key.pem",
                Error{"the authority is over, or the computer's clock is wrong"});
  }
  return read;
}

// Whether the one in the folder still does.
bool still_does(const KeyedCertificate& own, const KeyedCertificate& authority,
                const std::vector<std::string>& names, std::int64_t now_s) {
  const std::int64_t left_s = end_s_of(own.certificate.get()) - now_s;
  // One that lasts longer than any is made by a clock that was wrong.
  return left_s > kRenewed_s && left_s <= kCertificate_s &&
         is_signed_by(own.certificate.get(), authority.certificate.get()) &&
         names_all(own.certificate.get(), names);
}

}  // namespace

Expected<Certificate> own_certificate(const fs::path& folder, const std::vector<std::string>& names,
                                      std::int64_t now_s) {
  ROOMWISE_RETURN_IF_ERROR(make_private_folder(folder));
  const fs::path own_file = folder / "certificate.pem";
  const fs::path key_file = folder / "key.pem";
  if (fs::exists(own_file) && !fs::exists(folder / "authority.pem")) return self_signed(folder);
  ROOMWISE_TRY(const KeyedCertificate authority, own_authority(folder, names, now_s));
  ROOMWISE_TRY(const auto allowed, names_it_may(authority, names, now_s));
  auto own = read_files(own_file, key_file);
  if (!own || !still_does(*own, authority, allowed, now_s)) {
    ROOMWISE_TRY(const KeyedCertificate made, make_own(authority, allowed, now_s));
    ROOMWISE_RETURN_IF_ERROR(write_files(made, own_file, key_file));
    own = read_files(own_file, key_file);
    if (!own) return Unexpected(std::move(own).error().with_context(own_file.string()));
  }
  X509* const signing = authority.certificate.get();
  ROOMWISE_TRY(const std::string own_pem, pem_of(own->certificate.get()));
  ROOMWISE_TRY(const std::string signing_pem, pem_of(signing));
  Certificate certificate;
  certificate.certificate_pem = own_pem + signing_pem;
  ROOMWISE_TRY(certificate.key_pem, pem_of_key(own->key.get()));
  certificate.fingerprint = fingerprint_of(signing);
  certificate.own_fingerprint = fingerprint_of(own->certificate.get());
  certificate.ends_s = end_s_of(own->certificate.get());
  ROOMWISE_TRY(Bytes der, der_of(signing));
  std::array<char, 128> name{};
  X509_NAME_get_text_by_NID(X509_get_subject_name(signing), NID_commonName, name.data(),
                            static_cast<int>(name.size()));
  certificate.authority =
      Authority{std::move(der), name.data(), certificate.fingerprint, end_s_of(signing)};
  return certificate;
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
