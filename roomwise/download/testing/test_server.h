#pragma once

#include <arpa/inet.h>
#include <fmt/format.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

// An https server on this machine whose answers a test makes up, wrong ones too.
namespace roomwise::download::testing {

struct Request {
  std::string head;  // as it came: "GET /file HTTP/1.1\r\nHost: ..."

  [[nodiscard]] std::string path() const { return head.substr(4, head.find(' ', 4) - 4); }
  // The value of a header, or nothing.
  [[nodiscard]] std::string value(const std::string& name) const {
    const std::size_t begin = head.find("\r\n" + name + ": ");
    if (begin == std::string::npos) return {};
    const std::size_t value = begin + name.size() + 4;
    return head.substr(value, head.find("\r\n", value) - value);
  }
};

struct Reply {
  std::string bytes;         // head and body, as they are sent
  bool stall_after = false;  // then nothing more comes until the client gives up
};

class TestServer {
 public:
  using Answer = std::function<Reply(const Request&)>;

  explicit TestServer(Answer answer) : answer_(std::move(answer)) {
    key_.reset(EVP_EC_gen("P-256"));
    make_certificate();
    context_.reset(SSL_CTX_new(TLS_server_method()));
    check(SSL_CTX_use_certificate(context_.get(), certificate_.get()) == 1);
    check(SSL_CTX_use_PrivateKey(context_.get(), key_.get()) == 1);
    listener_ = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    check(::bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0);
    check(::listen(listener_, 8) == 0);
    socklen_t size = sizeof address;
    check(::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) == 0);
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { serve(); });
  }
  ~TestServer() {
    closing_ = true;
    ::shutdown(listener_, SHUT_RDWR);
    thread_.join();
    ::close(listener_);
  }
  TestServer(const TestServer&) = delete;
  TestServer& operator=(const TestServer&) = delete;

  [[nodiscard]] std::string url(const std::string& path) const {
    return fmt::format("https://127.0.0.1:{}{}", port_, path);
  }
  void write_certificate(const std::filesystem::path& path) const {
    std::FILE* file = std::fopen(path.c_str(), "w");
    check(file != nullptr && PEM_write_X509(file, certificate_.get()) == 1);
    std::fclose(file);
  }
  [[nodiscard]] std::vector<Request> requests() const {
    const std::scoped_lock lock(mutex_);
    return requests_;
  }

 private:
  template <auto kFree>
  struct Freer {
    template <typename T>
    void operator()(T* pointer) const {
      kFree(pointer);
    }
  };
  static void check(bool worked) {
    if (!worked) std::abort();
  }

  void make_certificate() {
    certificate_.reset(X509_new());
    X509* x509 = certificate_.get();
    X509_set_version(x509, 2);
    ASN1_INTEGER_set(X509_get_serialNumber(x509), 1);
    X509_gmtime_adj(X509_getm_notBefore(x509), -3600);
    X509_gmtime_adj(X509_getm_notAfter(x509), 3600);
    X509_set_pubkey(x509, key_.get());
    X509_NAME* name = X509_get_subject_name(x509);
    X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC,
                               reinterpret_cast<const unsigned char*>("test"), -1, -1, 0);
    X509_set_issuer_name(x509, name);
    for (const auto& [kind, text] :
         {std::pair{NID_subject_alt_name, "IP:127.0.0.1"}, {NID_basic_constraints, "CA:TRUE"}}) {
      X509_EXTENSION* extension = X509V3_EXT_conf_nid(nullptr, nullptr, kind, text);
      check(extension != nullptr && X509_add_ext(x509, extension, -1) == 1);
      X509_EXTENSION_free(extension);
    }
    check(X509_sign(x509, key_.get(), EVP_sha256()) != 0);
  }

  // One connection after the other; each is closed after its answer.
  void serve() {
    while (true) {
      const int connection = ::accept(listener_, nullptr, nullptr);
      if (connection < 0 || closing_) return;
      const std::unique_ptr<SSL, Freer<SSL_free>> ssl(SSL_new(context_.get()));
      SSL_set_fd(ssl.get(), connection);
      if (SSL_accept(ssl.get()) == 1) answer(ssl.get());
      SSL_shutdown(ssl.get());
      ::close(connection);
    }
  }

  void answer(SSL* ssl) {
    Request request;
    char buffer[4096];
    while (request.head.find("\r\n\r\n") == std::string::npos) {
      const int count = SSL_read(ssl, buffer, sizeof buffer);
      if (count <= 0) return;
      request.head.append(buffer, static_cast<std::size_t>(count));
    }
    {
      const std::scoped_lock lock(mutex_);
      requests_.push_back(request);
    }
    const Reply reply = answer_(request);
    SSL_write(ssl, reply.bytes.data(), static_cast<int>(reply.bytes.size()));
    // Until the client has gone.
    while (reply.stall_after && SSL_read(ssl, buffer, sizeof buffer) > 0) continue;
  }

  Answer answer_;
  std::unique_ptr<EVP_PKEY, Freer<EVP_PKEY_free>> key_;
  std::unique_ptr<X509, Freer<X509_free>> certificate_;
  std::unique_ptr<SSL_CTX, Freer<SSL_CTX_free>> context_;
  int listener_ = -1;
  int port_ = 0;
  std::atomic<bool> closing_ = false;
  mutable std::mutex mutex_;
  std::vector<Request> requests_;
  std::thread thread_;
};

}  // namespace roomwise::download::testing
