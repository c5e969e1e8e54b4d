#pragma once

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/vector_body.hpp>
#include <boost/beast/ssl/ssl_stream.hpp>
#include <chrono>
#include <memory>

#include "roomwise/service/credentials/allowed_hosts.h"
#include "roomwise/service/server/connection_table.h"
#include "roomwise/service/server/page_files.h"
#include "roomwise/service/server/server.h"
#include "roomwise/service/server/server_events.h"

// What the server's sources share. It draws in Asio and Beast, which take long to compile: only
// server.cpp, http_connection.cpp and socket_connection.cpp include it.
namespace roomwise::service {

namespace asio = boost::asio;
namespace beast = boost::beast;
using TlsStream = beast::ssl_stream<beast::tcp_stream>;
using BeastRequest = beast::http::request<beast::http::vector_body<std::uint8_t>>;

inline std::chrono::milliseconds milliseconds_of(double seconds) {
  return std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1000));
}

// Connections share it, so that it outlives the last of them. One thread runs `io`; all that is
// not said to be thread-safe belongs to it.
struct ServerCore {
  ServerCore(ServerOptions options, AllowedHosts hosts, PageFiles pages);

  [[nodiscard]] Now now() const { return options.clock(); }

  const ServerOptions options;
  const AllowedHosts hosts;
  const PageFiles pages;
  std::unique_ptr<HomesAtPort> own_homes;  // where there is one
  HomesAtPort* homes = nullptr;            // set once, before anything is served
  ServerEvents events;
  ConnectionTable table;
  RateLimit peer_rate;
  RateLimit device_rate;
  bool stopping = false;
  std::atomic<std::size_t> waiting_requests = 0;

  asio::io_context io{1};
  asio::ssl::context tls{asio::ssl::context::tls_server};
  asio::thread_pool workers;
  asio::thread_pool session_threads;
};

// A connection's line in the table, from its first moment to its last; the first member of a
// connection, so that it goes last. Handed on where a request becomes a WebSocket.
class TableEntry {
 public:
  TableEntry(std::shared_ptr<ServerCore> core, const std::string& peer)
      : core_(std::move(core)), number_(core_->table.add(peer)) {}
  ~TableEntry() { core_->table.remove(number_); }
  TableEntry(const TableEntry&) = delete;
  TableEntry& operator=(const TableEntry&) = delete;

  [[nodiscard]] ServerCore& core() const { return *core_; }
  [[nodiscard]] ConnectionTable::Number number() const { return number_; }

 private:
  std::shared_ptr<ServerCore> core_;
  ConnectionTable::Number number_;
};

// Serves an accepted connection until it ends.
void serve_http(const std::shared_ptr<ServerCore>& core, asio::ip::tcp::socket socket,
                const std::string& peer);

// The client of a WebSocket: who it is, what hears it, and its home, which stays open as long as
// this is held.
struct SocketClient {
  std::shared_ptr<ServedHome> home;
  SocketHandler* sockets = nullptr;
  Identity who;
};

// Goes on with a connection whose request asks for a WebSocket and may have one.
void serve_socket(std::shared_ptr<TableEntry> entry, TlsStream stream, BeastRequest request,
                  SocketClient client, std::string peer);

}  // namespace roomwise::service
