#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/base/file.h"
#include "roomwise/service/access/access.h"
#include "roomwise/service/credentials/certificate.h"
#include "roomwise/service/server/connection_table.h"
#include "roomwise/service/server/router.h"
#include "roomwise/service/server/served_home.h"

namespace roomwise::service {

// The way back to a connected client. Thread-safe; does nothing once the connection is closed.
class SocketOut {
 public:
  virtual ~SocketOut() = default;
  // Queues a text message. A client that does not read is closed when more waits for it than
  // ServerLimits says.
  virtual void send_text(std::string text) = 0;
  // Sends what waits, then closes. `reason` (at most 123 bytes) is sent along and logged.
  virtual void close(std::string reason) = 0;
};

// One connected client, as the server tells of it. Its functions are called one after the other,
// never two at once, on a thread that serves several sessions: they should be short. While one runs
// no more of this client is read.
class SocketSession {
 public:
  virtual ~SocketSession() = default;
  virtual void on_text(std::string_view text) = 0;
  virtual void on_message(Bytes bytes) = 0;  // a binary message
  virtual void on_closed() = 0;              // once, last
  // Whether the client has said who it is. One that has not after ServerLimits::hello_s is closed.
  [[nodiscard]] virtual bool greeted() const { return true; }
};

// Makes the sessions.
class SocketHandler {
 public:
  virtual ~SocketHandler() = default;
  // Called like a session's functions; nullptr closes the connection ("unavailable").
  virtual std::unique_ptr<SocketSession> connect(const Identity& who,
                                                 std::shared_ptr<SocketOut> out) = 0;
};

struct ServerLimits : ConnectionLimits {
  std::size_t header_bytes = 8 * 1024;
  std::size_t message_bytes = 4'000'000;  // of a WebSocket message from a client
  // Of one WebSocket: so many messages and bytes at once, then so many a second. Far more than a
  // device sends whose frames are acknowledged one by one; more closes it.
  double burst_messages = 1000;
  double rate_messages = 200;
  double burst_bytes = 100e6;
  double rate_bytes = 50e6;
  std::size_t waiting_bytes = 1'000'000;  // of messages that wait for one client
  std::size_t waiting_messages = 256;
  std::size_t waiting_requests = 64;  // that no worker has taken yet; more are answered by 503
  double handshake_s = 5;             // TLS, and until a connection's first request is whole
  double request_s = 30;              // for a request to come, an answer to go
  double idle_s = 20;                 // a connection that asks nothing
  double socket_idle_s = 15;  // a WebSocket is pinged after half of it, closed after all of it
  double hello_s = 10;        // from a WebSocket's opening until its client has said hello
  double stop_s = 2;          // for the closing of WebSockets when the server stops
  // Requests: so many at once, then so many a second.
  double burst_per_peer = 120;
  double rate_per_peer = 40;
  double burst_per_device = 240;
  double rate_per_device = 80;
};

struct ServerOptions {
  std::string address = "127.0.0.1";  // "0.0.0.0" or "::": every network card
  std::uint16_t port = 0;             // 0: any that is free
  Certificate certificate;
  // Names by which strangers may call it (AllowedHosts); addresses always are.
  std::vector<std::string> allowed_hosts;
  // Addresses of proxies, which say by the header X-Forwarded-For for whom they ask. Of others that
  // header counts nothing.
  std::set<std::string> proxies;
  std::filesystem::path pages;  // folder of files for everyone; empty: none
  ServerLimits limits;
  std::size_t workers = 2;          // threads that answer requests
  std::size_t session_threads = 1;  // threads that sessions are called on
  std::function<Now()> clock = Now::read;
  // One line for each event, without its end; never a token or a code. Called on any thread, one
  // line at a time.
  std::function<void(std::string_view line)> log = [](std::string_view) {};
};

// Since the start.
struct ServerCounts {
  std::uint64_t connections = 0;
  std::uint64_t sockets = 0;
  std::map<int, std::uint64_t> answers;           // by status
  std::map<std::string, std::uint64_t> refusals;  // connections and requests, by reason
  std::uint64_t messages_in = 0;
  std::uint64_t message_bytes_in = 0;
  std::uint64_t messages_out = 0;
  std::uint64_t messages_dropped = 0;  // to clients that did not read
  std::size_t open_connections = 0;    // now
  std::size_t open_sockets = 0;        // now
};

// HTTPS and WebSockets on one port, in front of a home. TLS 1.2 and later; HTTP/1.1. Requests go to
// the router's handlers on worker threads, GET requests for other paths to the files of the pages.
// A WebSocket opens at GET /api/socket (subprotocol "roomwise.1") for who may what Role::kDevice
// may.
class Server {
 public:
  // Takes the port: who connects waits until serve(). `access` and `sockets` must outlive it.
  [[nodiscard]] static Expected<std::unique_ptr<Server>> open(ServerOptions options, Router router,
                                                              AccessRegister& access,
                                                              SocketHandler& sockets);
  // The same in front of many homes, which must outlive it.
  [[nodiscard]] static Expected<std::unique_ptr<Server>> open(ServerOptions options,
                                                              HomesAtPort& homes);
  // Serves until stop(), which ends it for good. Once.
  virtual void serve() = 0;
  // Both, where no handler needs the server itself.
  [[nodiscard]] static Expected<std::unique_ptr<Server>> start(ServerOptions options, Router router,
                                                               AccessRegister& access,
                                                               SocketHandler& sockets);
  virtual ~Server() = default;  // stop()

  // Takes no more connections, ends requests that are worked on, closes WebSockets ("the computer
  // stops") and returns when every session's on_closed() has been called. May be called twice. Not
  // from a handler or a session.
  virtual void stop() = 0;

  [[nodiscard]] virtual std::uint16_t port() const = 0;
  [[nodiscard]] virtual ServerCounts counts() const = 0;
  // The devices of the home that have a WebSocket open; `home`: its ServedHome::name().
  [[nodiscard]] virtual std::set<std::int64_t> online(const std::string& home) const = 0;
  [[nodiscard]] std::set<std::int64_t> online() const { return online({}); }
  // The same with the role in which each was opened.
  [[nodiscard]] virtual std::set<std::pair<std::int64_t, Role>> roles_online(
      const std::string& home) const = 0;
  // Shows connections to come another certificate.
  virtual void use_certificate(Certificate certificate) = 0;
  // Closes all connections of a device: after its token was revoked.
  virtual void disconnect(DeviceOfHome device, std::string reason) = 0;
  void disconnect(std::int64_t device, std::string reason) {
    disconnect(DeviceOfHome{{}, device}, std::move(reason));
  }
};

}  // namespace roomwise::service
