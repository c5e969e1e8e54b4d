#include "roomwise/service/server/server.h"

#include <fmt/format.h>
#include <openssl/ssl.h>

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/ip/v6_only.hpp>
#include <boost/asio/steady_timer.hpp>
#include <thread>

#include "roomwise/service/server/server_core.h"

namespace roomwise::service {
namespace {

using Tcp = asio::ip::tcp;
using boost::system::error_code;

// An IPv4 address that came over an IPv6 socket is the same address.
std::string address_text(asio::ip::address address) {
  if (address.is_v6() && address.to_v6().is_v4_mapped()) {
    address = asio::ip::make_address_v4(asio::ip::v4_mapped, address.to_v6());
  }
  return address.to_string();
}

Router with_socket(const Router& router, std::function<void(std::string_view)> log) {
  std::vector<Route> routes = router.routes();
  routes.push_back(socket_route());
  return Router(std::move(routes), std::move(log));
}

Expected<void> prepare_tls(asio::ssl::context& tls, const Certificate& certificate) {
  SSL_CTX* const context = tls.native_handle();
  SSL_CTX_set_min_proto_version(context, TLS1_2_VERSION);
  SSL_CTX_set_options(context, SSL_OP_NO_RENEGOTIATION | SSL_OP_NO_COMPRESSION);
  SSL_CTX_set_cipher_list(context, "ECDHE+AESGCM:ECDHE+CHACHA20");
  error_code error;
  tls.use_certificate_chain(asio::buffer(certificate.certificate_pem), error);
  if (error) return fail("the certificate cannot be used: {}", error.message());
  tls.use_private_key(asio::buffer(certificate.key_pem), asio::ssl::context::pem, error);
  if (error) return fail("the certificate's key cannot be used: {}", error.message());
  return {};
}

}  // namespace

ServerCore::ServerCore(ServerOptions options_, AllowedHosts hosts_, PageFiles pages_)
    : options(std::move(options_)),
      hosts(std::move(hosts_)),
      pages(std::move(pages_)),
      events(options.log),
      table(options.limits, options.proxies),
      peer_rate(options.limits.burst_per_peer, options.limits.rate_per_peer),
      device_rate(options.limits.burst_per_device, options.limits.rate_per_device),
      workers(std::max<std::size_t>(1, options.workers)),
      session_threads(std::max<std::size_t>(1, options.session_threads)) {}

namespace {

class ListeningServer final : public Server {
 public:
  explicit ListeningServer(std::shared_ptr<ServerCore> core)
      : core_(std::move(core)),
        acceptor_(core_->io),
        pause_(core_->io),
        work_(core_->io.get_executor()) {}
  ~ListeningServer() override { ListeningServer::stop(); }
  ListeningServer(const ListeningServer&) = delete;
  ListeningServer& operator=(const ListeningServer&) = delete;

  Expected<void> listen() {
    error_code error;
    const std::string& address = core_->options.address;
    const asio::ip::address parsed = asio::ip::make_address(address, error);
    if (error)
      return fail("'{}' is no address to listen at; use 127.0.0.1, 0.0.0.0 or ::", address);
    const Tcp::endpoint endpoint(parsed, core_->options.port);
    acceptor_.open(endpoint.protocol(), error);
    if (!error) acceptor_.set_option(asio::socket_base::reuse_address(true), error);
    if (!error && parsed.is_v6()) acceptor_.set_option(asio::ip::v6_only(false), error);
    if (!error) acceptor_.bind(endpoint, error);
    if (!error) acceptor_.listen(asio::socket_base::max_listen_connections, error);
    if (!error) port_ = acceptor_.local_endpoint(error).port();
    if (error) {
      return fail("cannot listen at {} port {}: {}; is another server running?", address,
                  core_->options.port, error.message());
    }
    return {};
  }

  void serve() override {
    accept();
    thread_ = std::thread([this] { core_->io.run(); });
    core_->events.say(fmt::format("listening at {} port {}", core_->options.address, port_));
  }

  void stop() override {
    if (!thread_.joinable()) return;
    asio::post(core_->io, [this] {
      core_->stopping = true;
      error_code ignored;
      acceptor_.close(ignored);
      pause_.cancel(ignored);
      for (const auto& connection : core_->table.all()) connection->end("the computer stops");
    });
    if (!core_->table.wait_until_empty(milliseconds_of(core_->options.limits.stop_s))) {
      asio::post(core_->io, [this] {
        for (const auto& connection : core_->table.all()) connection->cut();
      });
      core_->table.wait_until_empty();  // what handlers work on
    }
    work_.reset();
    thread_.join();
    core_->workers.join();
    core_->session_threads.join();
    core_->events.say("stopped");
  }

  void disconnect(DeviceOfHome device, std::string reason) override {
    asio::post(core_->io, [core = core_, device = std::move(device), reason = std::move(reason)] {
      for (const auto& connection : core->table.of(device)) connection->end(reason);
    });
  }

  void use_certificate(Certificate certificate) override {
    asio::post(core_->io, [core = core_, certificate = std::move(certificate)] {
      const auto used = prepare_tls(core->tls, certificate);
      core->events.say(used ? "another certificate is shown from now on" : used.error().message);
    });
  }

  [[nodiscard]] std::uint16_t port() const override { return port_; }
  [[nodiscard]] ServerCounts counts() const override {
    ServerCounts counts = core_->events.counts();
    counts.open_connections = core_->table.size();
    counts.open_sockets = core_->table.sockets();
    return counts;
  }
  [[nodiscard]] std::set<std::int64_t> online(const std::string& home) const override {
    return core_->table.online(home);
  }
  [[nodiscard]] std::set<std::pair<std::int64_t, Role>> roles_online(
      const std::string& home) const override {
    return core_->table.roles_online(home);
  }

 private:
  void accept() {
    acceptor_.async_accept([this](error_code error, Tcp::socket socket) {
      if (core_->stopping || error == asio::error::operation_aborted) return;
      if (error) return accept_later(error);
      take(std::move(socket));
      accept();
    });
  }

  // No more descriptors, for example: trying again at once would only burn time.
  void accept_later(error_code error) {
    core_->events.refused("cannot accept: " + error.message(), "-", core_->now().steady_s);
    pause_.expires_after(std::chrono::milliseconds(100));
    pause_.async_wait([this](error_code cancelled) {
      if (!cancelled && !core_->stopping) accept();
    });
  }

  void take(Tcp::socket socket) {
    error_code error;
    const Tcp::endpoint from = socket.remote_endpoint(error);
    if (error) return;  // already gone
    const std::string peer = address_text(from.address());
    const ConnectionTable::Verdict verdict = core_->table.ask(peer);
    if (!verdict.refused.empty()) {
      return core_->events.refused(verdict.refused, peer, core_->now().steady_s);
    }
    if (verdict.cut) {
      core_->events.refused("made room for a newer connection", peer, core_->now().steady_s);
      verdict.cut->cut();
    }
    socket.set_option(Tcp::no_delay(true), error);
    core_->events.opened_connection();
    serve_http(core_, std::move(socket), peer);
  }

  std::shared_ptr<ServerCore> core_;
  Tcp::acceptor acceptor_;
  asio::steady_timer pause_;
  asio::executor_work_guard<asio::io_context::executor_type> work_;
  std::uint16_t port_ = 0;
  std::thread thread_;
};

Expected<std::shared_ptr<ServerCore>> make_core(ServerOptions options) {
  ROOMWISE_TRY(PageFiles pages, PageFiles::open(options.pages));
  ROOMWISE_TRY(AllowedHosts hosts, AllowedHosts::of(options.allowed_hosts));
  for (const std::string& proxy : options.proxies) {
    if (!is_address(proxy)) return fail("'{}' is no address of a proxy, as 192.168.1.7 is", proxy);
  }
  auto core = std::make_shared<ServerCore>(std::move(options), std::move(hosts), std::move(pages));
  ROOMWISE_RETURN_IF_ERROR(prepare_tls(core->tls, core->options.certificate));
  return core;
}

Expected<std::unique_ptr<Server>> listening(std::shared_ptr<ServerCore> core) {
  auto server = std::make_unique<ListeningServer>(std::move(core));
  ROOMWISE_RETURN_IF_ERROR(server->listen());
  return server;
}

}  // namespace

Expected<std::unique_ptr<Server>> Server::open(ServerOptions options, Router router,
                                               AccessRegister& access, SocketHandler& sockets) {
  ROOMWISE_TRY(auto core, make_core(std::move(options)));
  const auto log = [raw = core.get()](std::string_view line) {
    raw->events.say(std::string(line));
  };
  core->own_homes = only_home(with_socket(router, log), access, sockets);
  core->homes = core->own_homes.get();
  return listening(std::move(core));
}

Expected<std::unique_ptr<Server>> Server::open(ServerOptions options, HomesAtPort& homes) {
  ROOMWISE_TRY(auto core, make_core(std::move(options)));
  core->homes = &homes;
  return listening(std::move(core));
}

Expected<std::unique_ptr<Server>> Server::start(ServerOptions options, Router router,
                                                AccessRegister& access, SocketHandler& sockets) {
  ROOMWISE_TRY(auto server, open(std::move(options), std::move(router), access, sockets));
  server->serve();
  return server;
}

}  // namespace roomwise::service
