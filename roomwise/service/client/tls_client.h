#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/ssl/ssl_stream.hpp>
#include <chrono>
#include <optional>
#include <string>

#include "roomwise/service/client/client.h"

// What the client's source is made of; only client.cpp includes it (see server_core.h).
namespace roomwise::service {

namespace asio = boost::asio;
namespace beast = boost::beast;

// A TLS connection that is being made, step by step, each with what is left of the time.
class TlsClient {
 public:
  using Stream = beast::ssl_stream<beast::tcp_stream>;

  TlsClient(const ServerAddress& server, const ClientWait& wait);

  // Connects. The certificate is any; shown() says which.
  [[nodiscard]] Expected<void> connect();
  // The fingerprints of the certificate that was shown and of the authority that was shown with it,
  // where that signed it; empty: none.
  struct Shown {
    std::string own;
    std::string authority;
  };
  [[nodiscard]] Shown shown();
  // Whether it is the computer of that fingerprint, which was renewed perhaps by that authority.
  [[nodiscard]] bool is_known_by(const std::string& fingerprint);

  // Runs an operation, start(handler), to its end. `what` cannot be done where it fails.
  template <typename Start>
  [[nodiscard]] Expected<void> step(const Start& start, std::string_view what) {
    std::optional<boost::system::error_code> result;
    beast::get_lowest_layer(stream_).expires_at(deadline_);
    start([&](boost::system::error_code error, auto&&...) { result = error; });
    const Expected<void> ran = run_until(result);
    ROOMWISE_RETURN_IF_ERROR(ran);
    if (*result == beast::error::timeout) return fail("{} does not answer in time", name());
    if (*result) return fail("{}: {}: {}", name(), what, result->message());
    return {};
  }

  [[nodiscard]] asio::io_context& io() { return *io_; }
  [[nodiscard]] Stream& stream() { return stream_; }
  [[nodiscard]] std::string name() const;  // "the computer at HOST:PORT"
  // For the header Host.
  [[nodiscard]] std::string host() const;

 private:
  [[nodiscard]] Expected<void> run_until(const std::optional<boost::system::error_code>& result);

  ServerAddress server_;
  ClientWait wait_;
  std::chrono::steady_clock::time_point deadline_;
  std::shared_ptr<asio::io_context> io_ = std::make_shared<asio::io_context>(1);
  asio::ssl::context tls_{asio::ssl::context::tls_client};
  asio::ip::tcp::resolver resolver_{*io_};
  Stream stream_;
};

}  // namespace roomwise::service
