#pragma once

#include <arpa/inet.h>
#include <fmt/format.h>
#include <openssl/ssl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <chrono>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "roomwise/base/testing/testing.h"
#include "roomwise/service/server/access_routes.h"
#include "roomwise/service/server/server.h"

// A server on this machine and clients that may say anything. Not part of the product.
namespace roomwise::service::testing {

// Waits until something is true, ten seconds at most.
class Signal {
 public:
  template <typename Change>
  void change(Change change) {
    const std::scoped_lock lock(mutex_);
    change();
    changed_.notify_all();
  }
  template <typename Condition>
  [[nodiscard]] bool wait(Condition condition) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, std::chrono::seconds(10), condition);
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
};

struct Answer {
  int status = 0;
  std::map<std::string, std::string> headers;  // names in small letters
  std::string body;
};

// A TLS connection from any address of this machine; everything waits ten seconds at most.
class RawClient {
 public:
  explicit RawClient(std::uint16_t port, const std::string& from = "127.0.0.1") {
    socket_ = ::socket(AF_INET, SOCK_STREAM, 0);
    const timeval most{10, 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &most, sizeof most);
    ::setsockopt(socket_, SOL_SOCKET, SO_SNDTIMEO, &most, sizeof most);
    sockaddr_in own = address_of(from, 0);
    sockaddr_in server = address_of("127.0.0.1", port);
    connected_ = ::bind(socket_, reinterpret_cast<sockaddr*>(&own), sizeof own) == 0 &&
                 ::connect(socket_, reinterpret_cast<sockaddr*>(&server), sizeof server) == 0;
  }
  ~RawClient() {
    SSL_free(ssl_);
    SSL_CTX_free(context_);
    ::close(socket_);
  }
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;

  bool shake_hands(int highest_version = TLS1_3_VERSION) {
    if (!connected_) return false;
    context_ = SSL_CTX_new(TLS_client_method());
    SSL_CTX_set_security_level(context_, 0);
    SSL_CTX_set_max_proto_version(context_, highest_version);
    ssl_ = SSL_new(context_);
    SSL_set_fd(ssl_, socket_);
    return SSL_connect(ssl_) == 1;
  }

  bool send(std::string_view bytes) {
    return ssl_ != nullptr && SSL_write(ssl_, bytes.data(), static_cast<int>(bytes.size())) ==
                                  static_cast<int>(bytes.size());
  }
  // Without TLS.
  void send_plain(std::string_view bytes) const {
    (void)!::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  }

  // The next answer; status 0 where the connection ends before.
  Answer receive() {
    Answer answer;
    std::size_t head = 0;
    while ((head = received_.find("\r\n\r\n")) == std::string::npos) {
      if (!receive_some()) return answer;
    }
    read_head(received_.substr(0, head + 2), answer);
    received_.erase(0, head + 4);
    if (!answer.headers.contains("content-length")) return answer;
    const std::size_t size = std::stoul(answer.headers["content-length"]);
    while (!is_head_ && received_.size() < size && receive_some()) continue;
    answer.body = received_.substr(0, is_head_ ? 0 : size);
    received_.erase(0, answer.body.size());
    return answer;
  }

  Answer ask(const std::string& method, const std::string& target, const std::string& headers = "",
             const std::string& body = "") {
    is_head_ = method == "HEAD";
    const std::string length =
        body.empty() && method == "GET" ? "" : fmt::format("Content-Length: {}\r\n", body.size());
    send(fmt::format("{} {} HTTP/1.1\r\nHost: 127.0.0.1\r\n{}{}\r\n{}", method, target, headers,
                     length, body));
    return receive();
  }

  // Whether the other side has closed, or closes within the time.
  bool is_closed() {
    while (receive_some()) received_.clear();
    return errno_ != EAGAIN && errno_ != EWOULDBLOCK;
  }

  // Everything until the other side closes.
  std::string receive_all() {
    while (receive_some()) continue;
    return std::move(received_);
  }
  bool receive_some() {
    char buffer[4096];
    errno = 0;
    const auto count = ssl_ != nullptr
                           ? SSL_read(ssl_, buffer, sizeof buffer)
                           : static_cast<int>(::recv(socket_, buffer, sizeof buffer, 0));
    errno_ = errno;
    if (count <= 0) return false;
    received_.append(buffer, static_cast<std::size_t>(count));
    return true;
  }

 private:
  static sockaddr_in address_of(const std::string& text, std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    ::inet_pton(AF_INET, text.c_str(), &address.sin_addr);
    return address;
  }
  static void read_head(const std::string& head, Answer& answer) {
    answer.status = std::stoi(head.substr(9, 3));
    for (std::size_t at = head.find("\r\n") + 2; at < head.size();) {
      const std::size_t end = head.find("\r\n", at);
      const std::size_t colon = head.find(": ", at);
      std::string name = head.substr(at, colon - at);
      std::ranges::transform(name, name.begin(),
                             [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
      answer.headers[name] = head.substr(colon + 2, end - colon - 2);
      at = end + 2;
    }
  }

  int socket_;
  bool connected_ = false;
  int errno_ = 0;
  bool is_head_ = false;
  SSL_CTX* context_ = nullptr;
  SSL* ssl_ = nullptr;
  std::string received_;
};

inline std::string bearer(const std::string& token) {
  return fmt::format("Authorization: Bearer {}\r\n", token);
}

// Sessions that note what they are told; a text "send N" has them send N texts of a kilobyte,
// "close" has them close, any other text comes back.
class NotingSockets final : public SocketHandler {
 public:
  std::unique_ptr<SocketSession> connect(const Identity& who,
                                         std::shared_ptr<SocketOut> out) override {
    signal.change([&] {
      ++opened;
      last = who;
      last_out = out;
    });
    return std::make_unique<Session>(*this, std::move(out));
  }

  bool want_hello = false;  // a client counts as known when it has said "hello"
  Signal signal;
  int opened = 0;
  int closed = 0;
  std::vector<std::string> texts;
  std::vector<std::size_t> binaries;  // sizes
  std::optional<Identity> last;
  std::shared_ptr<SocketOut> last_out;

 private:
  class Session final : public SocketSession {
   public:
    Session(NotingSockets& all, std::shared_ptr<SocketOut> out) : all_(all), out_(std::move(out)) {}
    void on_text(std::string_view text) override {
      all_.signal.change([&] { all_.texts.emplace_back(text); });
      if (text == "hello") greeted_ = true;
      if (text.starts_with("send ")) {
        const int count = std::stoi(std::string(text.substr(5)));
        for (int i = 0; i < count; ++i) out_->send_text(std::string(1024, 'x'));
      } else if (text == "close") {
        out_->close("you asked for it");
      } else if (text == "throw") {
        throw std::runtime_error("thrown by a test");
      } else {
        out_->send_text(std::string(text));
      }
    }
    void on_message(Bytes bytes) override {
      all_.signal.change([&] { all_.binaries.push_back(bytes.size()); });
    }
    void on_closed() override {
      all_.signal.change([&] { ++all_.closed; });
    }
    [[nodiscard]] bool greeted() const override { return greeted_ || !all_.want_hello; }

   private:
    NotingSockets& all_;
    std::shared_ptr<SocketOut> out_;
    bool greeted_ = false;
  };
};

// A home's server with a device and a helper.
class TestServer {
 public:
  explicit TestServer(std::vector<Route> more_routes = {}, ServerLimits limits = {},
                      std::filesystem::path pages = {}) {
    const auto folder = folder_ / "flat.home.access";
    std::filesystem::create_directory(folder);
    std::filesystem::permissions(folder, std::filesystem::perms::owner_all);
    certificate = own_certificate(folder, {"localhost", "127.0.0.1"}, now().unix_s).value();
    access = AccessRegister::open(folder, certificate.fingerprint).value();
    device = access->pair_here(Role::kDevice, "Anna's phone", now()).value();
    helper = access->pair_here(Role::kHelper, "Ben's tablet", now()).value();
    routes = std::move(more_routes);
    for (Route& route : access_routes(*access, context())) routes.push_back(std::move(route));
    options.certificate = certificate;
    options.allowed_hosts = {"localhost", "a", "h"};
    options.limits = limits;
    options.pages = std::move(pages);
    options.clock = [this] { return now(); };
    options.log = [this](std::string_view line) {
      log.change([&] { log_text += std::string(line) + "\n"; });
    };
    start();
  }
  ~TestServer() { server.reset(); }

  void start() {
    server.reset();
    auto started = Server::start(options, Router(routes), *access, sockets);
    if (!started) std::fprintf(stderr, "%s\n", started.error().message.c_str());
    server = std::move(started).value();
    options.port = server->port();
  }

  [[nodiscard]] std::filesystem::path access_files() const { return folder_ / "flat.home.access"; }
  [[nodiscard]] Now now() const { return {steady_s, 1'700'000'000}; }
  [[nodiscard]] std::uint16_t port() const { return server->port(); }

  // One request over a connection of its own.
  Answer ask(const std::string& method, const std::string& target, const std::string& headers = "",
             const std::string& body = "", const std::string& from = "127.0.0.1") const {
    RawClient client(port(), from);
    if (!client.shake_hands()) return {};
    return client.ask(method, target, headers, body);
  }

  std::atomic<double> steady_s = 1000;
  Certificate certificate;
  std::unique_ptr<AccessRegister> access;
  Pairing device;
  Pairing helper;
  NotingSockets sockets;
  Signal log;
  std::string log_text;
  ServerOptions options;
  std::vector<Route> routes;
  std::unique_ptr<Server> server;

 private:
  AccessRoutesContext context() {
    return {[this] { return now(); },
            [this] { return server->online(); },
            [this](std::int64_t gone) { server->disconnect(gone, "removed"); },
            [] { return std::string("https://flat.local:8443/pair"); },
            [this] { return certificate.authority; },
            {}};
  }

  ::roomwise::testing::ScratchFolder folder_;
};

}  // namespace roomwise::service::testing
