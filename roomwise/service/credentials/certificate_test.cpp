#include "roomwise/service/credentials/certificate.h"

#include <gmock/gmock.h>
#include <openssl/pem.h>
#include <openssl/x509v3.h>
#include <sys/stat.h>

#include "roomwise/base/testing/testing.h"
#include "roomwise/service/credentials/private_file.h"
#include "roomwise/service/credentials/x509.h"

namespace roomwise::service {
namespace {

using ::testing::Contains;

constexpr std::int64_t kNow_s = 1'800'000'000;
constexpr std::int64_t kDay_s = 86400;
const std::vector<std::string> kNames{"localhost", "flat.local", "Flat", "192.168.1.5", "fe80::1"};

// What a phone that has installed the authority finds.
class Phone {
 public:
  explicit Phone(const Authority& authority) : store_(X509_STORE_new()) {
    const unsigned char* data = authority.certificate.data();
    const X509Certificate trusted(
        d2i_X509(nullptr, &data, static_cast<long>(authority.certificate.size())));
    X509_STORE_add_cert(store_.get(), trusted.get());
  }

  // Empty: it is trusted for that name; else why not.
  [[nodiscard]] std::string why_not(X509* certificate, const std::string& name,
                                    std::int64_t now_s) const {
    const std::unique_ptr<X509_STORE_CTX, Freer<X509_STORE_CTX_free>> context(X509_STORE_CTX_new());
    X509_STORE_CTX_init(context.get(), store_.get(), certificate, nullptr);
    X509_VERIFY_PARAM* const wanted = X509_STORE_CTX_get0_param(context.get());
    X509_VERIFY_PARAM_set_purpose(wanted, X509_PURPOSE_SSL_SERVER);
    X509_VERIFY_PARAM_set_time(wanted, now_s);
    if (X509_VERIFY_PARAM_set1_ip_asc(wanted, name.c_str()) != 1) {
      X509_VERIFY_PARAM_set1_host(wanted, name.c_str(), name.size());
    }
    if (X509_verify_cert(context.get()) == 1) return "";
    return X509_verify_cert_error_string(X509_STORE_CTX_get_error(context.get()));
  }
  [[nodiscard]] std::string why_not(const Certificate& shown, const std::string& name,
                                    std::int64_t now_s = kNow_s) const {
    const auto read = read_certificate(shown.certificate_pem, shown.key_pem);
    return why_not(read.value().certificate.get(), name, now_s);
  }

 private:
  std::unique_ptr<X509_STORE, Freer<X509_STORE_free>> store_;
};

class CertificateTest : public ::testing::Test {
 protected:
  Expected<Certificate> own(const std::vector<std::string>& names = kNames,
                            std::int64_t now_s = kNow_s) {
    return own_certificate(folder_.path(), names, now_s);
  }
  [[nodiscard]] KeyedCertificate authority() const {
    return read_certificate(read_text_file(folder_ / "authority.pem").value(),
                            read_text_file(folder_ / "authority-key.pem").value())
        .value();
  }

  roomwise::testing::ScratchFolder folder_;
};

TEST_F(CertificateTest, IsMadeOnceAndKept) {
  const auto made = own();
  ASSERT_OK(made);
  EXPECT_EQ(made->fingerprint.size(), 64u);
  EXPECT_EQ(made->fingerprint, made->authority->fingerprint);
  const auto again = own(kNames, kNow_s + 100 * kDay_s);
  ASSERT_OK(again);
  EXPECT_EQ(again->own_fingerprint, made->own_fingerprint);
  EXPECT_EQ(again->key_pem, made->key_pem);
  for (const char* file : {"key.pem", "authority-key.pem"}) {
    struct stat status {};
    ASSERT_EQ(::stat((folder_ / file).c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777U, 0600u) << file;
  }
  EXPECT_EQ(fingerprint_with_colons("ab12"), "AB:12");
  EXPECT_THAT(host_names(), Contains("localhost"));
}

TEST_F(CertificateTest, APhoneThatHasInstalledTheAuthorityIsNotWarned) {
  const auto made = own();
  ASSERT_OK(made);
  const Phone phone(*made->authority);
  for (const std::string& name : kNames) EXPECT_EQ(phone.why_not(*made, name), "") << name;
  EXPECT_NE(phone.why_not(*made, "other.local"), "");
  EXPECT_NE(phone.why_not(*made, "localhost", made->ends_s + 1), "");
  EXPECT_LE(made->ends_s - kNow_s, 398 * kDay_s) << "longer ones are refused by phones";
}

TEST_F(CertificateTest, IsRenewedBeforeItEndsWithoutANewInstallation) {
  const auto made = own();
  ASSERT_OK(made);
  const Phone phone(*made->authority);
  const std::int64_t later_s = made->ends_s - 59 * kDay_s;
  const auto renewed = own(kNames, later_s);
  ASSERT_OK(renewed);
  EXPECT_NE(renewed->own_fingerprint, made->own_fingerprint);
  EXPECT_EQ(renewed->fingerprint, made->fingerprint) << "devices know it again";
  EXPECT_EQ(phone.why_not(*renewed, "flat.local", later_s), "");
}

TEST_F(CertificateTest, IsMadeAnewForANewAddressAndWhereItIsDamaged) {
  const auto made = own();
  ASSERT_OK(made);
  std::vector<std::string> names = kNames;
  names.emplace_back("10.1.2.3");
  const auto moved = own(names);
  ASSERT_OK(moved);
  const Phone phone(*made->authority);
  EXPECT_EQ(phone.why_not(*moved, "10.1.2.3"), "");
  ASSERT_OK(write_private_file(folder_ / "key.pem", "damaged"));
  const auto mended = own(names);
  ASSERT_OK(mended);
  EXPECT_NE(mended->key_pem, moved->key_pem);
  EXPECT_EQ(mended->fingerprint, made->fingerprint);
}

TEST_F(CertificateTest, LeavesOutNamesThatTheAuthorityMayNotSignFor) {
  ASSERT_OK(own());
  const auto made = own({"localhost", "2001:db8::1", "later.example", "a b"});
  ASSERT_OK(made);
  const Phone phone(*made->authority);
  EXPECT_EQ(phone.why_not(*made, "localhost"), "");
  EXPECT_NE(phone.why_not(*made, "2001:db8::1"), "");
  EXPECT_NE(phone.why_not(*made, "later.example"), "");
  // A name that was given before the authority was made is one of the home.
  const roomwise::testing::ScratchFolder other;
  const auto named = own_certificate(other.path(), {"localhost", "flat.example"}, kNow_s);
  ASSERT_OK(named);
  EXPECT_EQ(Phone(*named->authority).why_not(*named, "flat.example"), "");
}

// Who steals the key of a home's authority cannot pass for others to a phone that has installed it.
TEST_F(CertificateTest, ItsAuthorityVouchesForHomesAlone) {
  const auto made = own();
  ASSERT_OK(made);
  const Phone phone(*made->authority);
  const KeyedCertificate stolen = authority();
  for (const std::string name : {"DNS:bank.example", "IP:8.8.8.8", "IP:2001:db8::1"}) {
    CertificateFacts facts{"x", kNow_s - 1, kNow_s + kDay_s, {{NID_subject_alt_name, name}}};
    const auto forged = make_certificate(facts, &stolen);
    ASSERT_OK(forged);
    EXPECT_NE(phone.why_not(forged->certificate.get(), name.substr(name.find(':') + 1), kNow_s), "")
        << name;
  }
  // And no authority below it.
  CertificateFacts facts{
      "y",
      kNow_s - 1,
      kNow_s + kDay_s,
      {{NID_basic_constraints, "critical,CA:TRUE"}, {NID_subject_alt_name, "DNS:flat.local"}}};
  const auto below = make_certificate(facts, &stolen);
  ASSERT_OK(below);
  EXPECT_FALSE(is_signed_by(authority().certificate.get(), below->certificate.get()));
}

TEST_F(CertificateTest, ItsAuthorityIsNeverMadeAnewByItself) {
  ASSERT_OK(own());
  std::filesystem::permissions(folder_ / "authority-key.pem", std::filesystem::perms(0644));
  EXPECT_ERROR(own(), "others may read it; make it private");
  ASSERT_OK(write_private_file(folder_ / "authority-key.pem", "damaged"));
  EXPECT_ERROR(own(), "authority.pem and authority-key.pem: they are damaged");
  std::filesystem::remove(folder_ / "authority.pem");
  EXPECT_ERROR(own(), "authority.pem and authority-key.pem: they are gone");
}

TEST_F(CertificateTest, AClockThatIsWrongMakesNoAuthority) {
  EXPECT_ERROR(own(kNames, 3600), "clock was not set");
  ASSERT_OK(own());
  EXPECT_ERROR(own(kNames, kNow_s + 21LL * 365 * kDay_s), "the authority is over");
}

TEST_F(CertificateTest, OneFromBeforeThereWereAuthoritiesIsUsedAsItIs) {
  CertificateFacts facts{
      "Roomwise", kNow_s - 1, kNow_s + 3650 * kDay_s, {{NID_subject_alt_name, "DNS:localhost"}}};
  const auto made = make_certificate(facts, nullptr);
  ASSERT_OK(made);
  ASSERT_OK(write_private_file(folder_ / "key.pem", pem_of_key(made->key.get()).value()));
  ASSERT_OK(
      write_private_file(folder_ / "certificate.pem", pem_of(made->certificate.get()).value()));
  std::filesystem::permissions(folder_.path(), std::filesystem::perms::owner_all);
  const auto read = own();
  ASSERT_OK(read);
  EXPECT_FALSE(read->authority);
  EXPECT_EQ(read->fingerprint, read->own_fingerprint);
  ASSERT_OK(write_private_file(folder_ / "key.pem", "damaged"));
  EXPECT_ERROR(own(), "do not belong together");
}

}  // namespace
}  // namespace roomwise::service
