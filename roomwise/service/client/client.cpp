#include "roomwise/service/client/client.h"

#include <fmt/format.h>
#include <netinet/tcp.h>
#include <openssl/ssl.h>
#include <sys/socket.h>

#include <algorithm>
#include <boost/asio/connect.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <boost/beast/websocket/ssl.hpp>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "roomwise/base/encodings.h"
#include "roomwise/service/client/tls_client.h"
#include "roomwise/service/credentials/pairing_proof.h"
#include "roomwise/service/credentials/secrets.h"
#include "roomwise/service/credentials/x509.h"
#include "roomwise/service/protocol/http.h"

namespace roomwise::service {
namespace {

namespace http = beast::http;
namespace websocket = beast::websocket;
using boost::system::error_code;
using Json = nlohmann::json;

constexpr std::size_t kMaxWaiting = 64;  // messages, in each direction
constexpr std::size_t kMaxMessageBytes = std::size_t{4} << 20U;
// What the system takes before it was sent, and what is handed to it at once: small, so that what
// is taken has nearly been sent.
constexpr int kSendBufferBytes = 32 << 10;
constexpr std::size_t kPieceBytes = std::size_t{8} << 10U;

// The answer to a POST request.
Expected<http::response<http::string_body>> post(TlsClient& client, const std::string& path,
                                                 const Json& json) {
  http::request<http::string_body> request(http::verb::post, path, 11);
  request.set(http::field::host, client.host());
  request.set(http::field::content_type, "application/json");
  request.body() = json.dump();
  request.prepare_payload();
  ROOMWISE_RETURN_IF_ERROR(
      client.step([&](auto done) { http::async_write(client.stream(), request, std::move(done)); },
                  "cannot be asked"));
  http::response<http::string_body> answer;
  beast::flat_buffer buffer;
  ROOMWISE_RETURN_IF_ERROR(client.step(
      [&](auto done) { http::async_read(client.stream(), buffer, answer, std::move(done)); },
      "gives no answer"));
  return answer;
}

PairingRefusal refusal_of(http::status status) {
  switch (status) {
    case http::status::unauthorized:
      return PairingRefusal::kCode;
    case http::status::bad_request:
      return PairingRefusal::kName;  // of what is sent the name alone is the person's own
    case http::status::too_many_requests:
      return PairingRefusal::kMustWait;
    default:
      return PairingRefusal::kNone;
  }
}

tl::expected<PairedWith, PairingError> read_pairing(const TlsClient& client,
                                                    const http::response<http::string_body>& answer,
                                                    const PairingProof& proof) {
  const Json json = Json::parse(answer.body(), nullptr, false);
  if (answer.result() == http::status::service_unavailable) {
    return fail("{} cannot pair just now; try again soon", client.name());
  }
  if (answer.result() != http::status::ok) {
    const bool says_why =
        json.is_object() && json.contains("error") && json.at("error").is_string();
    std::string why = says_why ? json.at("error").get<std::string>() : std::string(answer.reason());
    return tl::unexpected(PairingError(
        Error{fmt::format("{} refuses the pairing: {}", client.name(), why), ErrorCode::kRefused},
        refusal_of(answer.result())));
  }
  PairedWith paired;
  try {
    if (!equal_secrets(json.at("proof").get<std::string>(), proof.computer)) {
      return tl::unexpected(PairingError(
          Error{fmt::format("{} does not know the code: it is another computer that stands "
                            "between; pair in a network that you trust",
                            client.name()),
                ErrorCode::kRefused},
          PairingRefusal::kCode));
    }
    const auto role = parse_role(json.at("role").get<std::string>());
    if (!role) return fail("{} answers with a role that is not known", client.name());
    paired.credentials.token = json.at("token").get<std::string>();
    paired.who = {json.at("device").get<std::int64_t>(), "", *role};
  } catch (const Json::exception&) {
    return fail("{} does not answer as a Roomwise computer does", client.name());
  }
  return paired;
}

}  // namespace

// ---- TlsClient ----

TlsClient::TlsClient(const ServerAddress& server, const ClientWait& wait)
    : server_(server),
      wait_(wait),
      deadline_(std::chrono::steady_clock::now() + wait.timeout),
      stream_(*io_, tls_) {
  SSL_CTX_set_min_proto_version(tls_.native_handle(), TLS1_2_VERSION);
  // No authority that everybody trusts vouches for a home's computer: it, or its home's own
  // authority, is known by its fingerprint, which is compared before anything is sent.
  tls_.set_verify_mode(asio::ssl::verify_none);
}

std::string TlsClient::name() const {
  return fmt::format("the computer at {}", host());
}

std::string TlsClient::host() const {
  const bool v6 = server_.host.find(':') != std::string::npos;
  return fmt::format("{}{}{}:{}", v6 ? "[" : "", server_.host, v6 ? "]" : "", server_.port);
}

Expected<void> TlsClient::connect() {
  asio::ip::tcp::resolver::results_type found;
  ROOMWISE_RETURN_IF_ERROR(step(
      [&](auto done) {
        resolver_.async_resolve(server_.host, std::to_string(server_.port),
                                [&found, done](error_code error, auto results) mutable {
                                  found = std::move(results);
                                  done(error);
                                });
      },
      "its name is not known in this network"));
  ROOMWISE_RETURN_IF_ERROR(step(
      [&](auto done) { beast::get_lowest_layer(stream_).async_connect(found, std::move(done)); },
      "cannot be reached"));
  beast::get_lowest_layer(stream_).socket().set_option(asio::ip::tcp::no_delay(true));
  return step(
      [&](auto done) { stream_.async_handshake(asio::ssl::stream_base::client, std::move(done)); },
      "does not speak TLS");
}

TlsClient::Shown TlsClient::shown() {
  Shown shown;
  const STACK_OF(X509)* const chain = SSL_get_peer_cert_chain(stream_.native_handle());
  if (chain == nullptr || sk_X509_num(chain) == 0) return shown;
  X509* const own = sk_X509_value(chain, 0);
  shown.own = fingerprint_of(own);
  X509* const authority = sk_X509_num(chain) > 1 ? sk_X509_value(chain, 1) : nullptr;
  if (authority != nullptr && is_signed_by(own, authority)) {
    shown.authority = fingerprint_of(authority);
  }
  return shown;
}

bool TlsClient::is_known_by(const std::string& fingerprint) {
  const Shown now = shown();
  return equal_secrets(now.own, fingerprint) || equal_secrets(now.authority, fingerprint);
}

Expected<void> TlsClient::run_until(const std::optional<error_code>& result) {
  const auto give_up = [&](ErrorCode code, std::string_view why) {
    resolver_.cancel();
    beast::get_lowest_layer(stream_).close();
    // What was begun refers to the caller's frame and has to end first.
    while (!result) {
      io_->restart();
      io_->run_one();
    }
    return fail_with(code, "{} {}", name(), why);
  };
  while (!result) {
    io_->restart();
    io_->run_one_for(std::chrono::milliseconds(100));
    if (result) break;
    if (wait_.interruption != nullptr && wait_.interruption->interrupted()) {
      return give_up(ErrorCode::kInterrupted, "was not waited for: interrupted");
    }
    if (std::chrono::steady_clock::now() > deadline_) {
      return give_up(ErrorCode::kFailed, "does not answer in time");
    }
  }
  return {};
}

// ---- Pairing ----

Expected<ServerAddress> parse_server_address(std::string_view text) {
  const auto bad = [&] {
    return fail(
        "'{}' is no address of a computer; expected HOST:PORT or HOST:PORT/homes/NAME, for "
        "example flat.local:8443",
        text);
  };
  const std::string_view whole = text;
  const std::size_t slash = std::min(whole.find('/'), whole.size());
  std::string_view base = whole.substr(slash);
  while (base.ends_with('/')) base.remove_suffix(1);
  constexpr std::string_view kHomes = "/homes/";
  const bool is_home = base.starts_with(kHomes) && base.find('/', kHomes.size()) == base.npos;
  if (!base.empty() && (!is_home || base.find_first_of(" ?#%@") != base.npos)) return bad();
  text = whole.substr(0, slash);
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) return bad();
  std::string_view host = text.substr(0, colon);
  const std::string_view digits = text.substr(colon + 1);
  const auto port = number_of<std::uint16_t>(digits);
  if (!port || *port == 0) return bad();
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  if (host.empty() || host.find_first_of(" /[]@") != std::string_view::npos) return bad();
  return ServerAddress{std::string(host), *port, std::string(base)};
}

tl::expected<PairedWith, PairingError> pair_with(const ServerAddress& server,
                                                 const std::string& code, const std::string& name,
                                                 const ClientWait& wait) {
  TlsClient client(server, wait);
  ROOMWISE_RETURN_IF_ERROR(client.connect());
  const TlsClient::Shown shown = client.shown();
  const std::string& fingerprint = shown.authority.empty() ? shown.own : shown.authority;
  ROOMWISE_TRY(const Bytes random, random_bytes(16));
  const std::string nonce = hexadecimal(random);
  // A link ends with the secret, behind "#".
  std::string known = code.substr(code.rfind('#') + 1);
  const bool is_secret = known.size() == kSecretLength;
  // Digits are shown and said in groups.
  if (!is_secret) std::erase_if(known, [](char one) { return one == ' ' || one == '-'; });
  ROOMWISE_TRY(const PairingProof proof, is_secret ? make_secret_proof(known, fingerprint, nonce)
                                                   : make_pairing_proof(known, fingerprint, nonce));
  ROOMWISE_TRY(const auto answer, post(client, server.base + "/api/pair",
                                       {{is_secret ? "secret_proof" : "proof", proof.device},
                                        {"nonce", nonce},
                                        {"name", name}}));
  auto paired = read_pairing(client, answer, proof);
  if (!paired) return paired;
  paired->credentials.fingerprint = fingerprint;
  paired->who.name = name;
  return paired;
}

// ---- ServerConnection ----

namespace {

// One thread runs `io`, and all but what the mutex guards belongs to it.
class WebSocketConnection final : public ServerConnection {
 public:
  WebSocketConnection(const ServerAddress& server, const ClientWait& wait)
      : wait_(wait),
        client_(server, wait),
        address_(server.base + "/api/socket"),
        work_(client_.io().get_executor()) {}

  ~WebSocketConnection() override {
    if (!thread_.joinable()) return;
    lose("interrupted");
    client_.io().stop();
    thread_.join();
  }

  Expected<void> connect(const ServerCredentials& credentials) {
    ROOMWISE_RETURN_IF_ERROR(client_.connect());
    if (!client_.is_known_by(credentials.fingerprint)) {
      return fail(
          "{} shows another certificate than the one this device was paired with: it is another "
          "computer, or its certificate was made anew; if you know that it was, pair again",
          client_.name());
    }
    // Silence is watched here (watch()), since Beast's own timeout takes a connection that is busy
    // sending for a silent one.
    socket_.set_option(
        websocket::stream_base::timeout{wait_.timeout, websocket::stream_base::none(), false});
    socket_.control_callback([this](auto, auto) { alive(); });
    socket_.set_option(websocket::stream_base::decorator(
        [token = credentials.token](websocket::request_type& request) {
          request.set(http::field::authorization, "Bearer " + token);
          request.set(http::field::sec_websocket_protocol, "roomwise.1");
        }));
    socket_.read_message_max(kMaxMessageBytes);
    beast::get_lowest_layer(client_.stream())
        .socket()
        .set_option(asio::socket_base::send_buffer_size(kSendBufferBytes));
    return shake_hands();
  }

  void run() {
    thread_ = std::thread([this] { client_.io().run(); });
    asio::post(client_.io(), [this] {
      alive();
      read();
      watch();
    });
  }

  Expected<void> send(Message message) override {
    const std::scoped_lock lock(mutex_);
    if (lost_) return fail("{}", *lost_);
    if (outgoing_.size() >= kMaxWaiting) {
      return fail("{} takes nothing: too much waits to be sent", client_.name());
    }
    outgoing_.push_back(std::move(message));
    asio::post(client_.io(), [this] { write(); });
    return {};
  }

  Expected<std::optional<Message>> receive(std::chrono::milliseconds timeout) override {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, timeout, [&] { return !incoming_.empty() || lost_; });
    if (incoming_.empty()) {
      if (lost_) return fail("{}", *lost_);
      return std::optional<Message>();
    }
    std::optional<Message> message(std::move(incoming_.front()));
    incoming_.pop_front();
    if (paused_) {
      paused_ = false;
      asio::post(client_.io(), [this] { read(); });
    }
    return message;
  }

  void close() override {
    asio::post(client_.io(), [this] {
      closing_ = true;
      write();
    });
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, std::chrono::seconds(1), [&] { return lost_.has_value(); });
  }

 private:
  Expected<void> shake_hands() {
    websocket::response_type answer;
    beast::get_lowest_layer(client_.stream()).expires_never();
    const Expected<void> done = client_.step(
        [&](auto handler) {
          beast::get_lowest_layer(client_.stream()).expires_never();
          socket_.async_handshake(answer, client_.host(), address_, std::move(handler));
        },
        "opens no WebSocket");
    beast::get_lowest_layer(client_.stream()).expires_never();
    if (done) return {};
    if (answer.result() == http::status::unauthorized ||
        answer.result() == http::status::forbidden) {
      return fail_with(ErrorCode::kRefused,
                       "{} does not know this device (any more): pair it again", client_.name());
    }
    return Unexpected(done.error());
  }

  void read() {
    socket_.async_read(buffer_, [this](error_code error, std::size_t) {
      if (error) return lose(why(error));
      alive();
      const auto* begin = static_cast<const std::uint8_t*>(buffer_.data().data());
      Message message{socket_.got_text(), Bytes(begin, begin + buffer_.size())};
      buffer_.clear();
      {
        const std::scoped_lock lock(mutex_);
        incoming_.push_back(std::move(message));
        paused_ = incoming_.size() >= kMaxWaiting;
        changed_.notify_all();
        if (paused_) return;
      }
      read();
    });
  }

  void write() {
    if (writing_) return;
    {
      const std::scoped_lock lock(mutex_);
      if (lost_) return;
      if (outgoing_.empty()) {
        if (closing_) say_goodbye();
        return;
      }
      sending_ = std::move(outgoing_.front());
      outgoing_.pop_front();
    }
    writing_ = true;
    sent_ = 0;
    socket_.binary(!sending_.is_text);
    write_piece();
  }

  // In pieces, so that a slow network is told from a silent one: while the pieces of a large
  // message go out, the other side's acknowledgements of them are signs of life.
  void write_piece() {
    const std::size_t size = std::min(sending_.bytes.size() - sent_, kPieceBytes);
    const bool is_last = sent_ + size == sending_.bytes.size();
    socket_.async_write_some(is_last, asio::buffer(sending_.bytes.data() + sent_, size),
                             [this](error_code error, std::size_t written) {
                               if (error) return lose(why(error));
                               sent_ += written;
                               if (sending_.bytes.size() > kPieceBytes) see_acknowledgement();
                               if (sent_ < sending_.bytes.size()) return write_piece();
                               writing_ = false;
                               write();
                             });
  }

  void alive() { alive_at_ = std::chrono::steady_clock::now(); }

  // That a piece was taken says only that the system has room for it; when the other side last
  // acknowledged any, the system knows.
  void see_acknowledgement() {
    tcp_info info{};
    socklen_t size = sizeof info;
    const int socket = beast::get_lowest_layer(client_.stream()).socket().native_handle();
    if (::getsockopt(socket, IPPROTO_TCP, TCP_INFO, &info, &size) != 0) return;
    const auto at =
        std::chrono::steady_clock::now() - std::chrono::milliseconds(info.tcpi_last_ack_recv);
    alive_at_ = std::max(alive_at_, at);
  }

  // Asks for a sign of life after half of the silence that is borne, and gives up after all of it.
  void watch() {
    timer_.expires_after(wait_.silence / 10);
    timer_.async_wait([this](error_code error) {
      if (error) return;
      const auto silent = std::chrono::steady_clock::now() - alive_at_;
      if (silent >= wait_.silence) {
        lose(fmt::format("{} does not answer any more", client_.name()));
        beast::get_lowest_layer(client_.stream()).close();
        return;
      }
      if (silent >= wait_.silence / 2 && !pinging_) {
        pinging_ = true;
        socket_.async_ping({}, [this](error_code) { pinging_ = false; });
      }
      watch();
    });
  }

  void say_goodbye() {
    writing_ = true;
    socket_.async_close(websocket::close_code::normal,
                        [this](error_code) { lose("the connection was closed"); });
  }

  std::string why(error_code error) {
    if (error == websocket::error::closed) {
      const auto& reason = socket_.reason().reason;
      return fmt::format("{} closed the connection{}{}", client_.name(), reason.empty() ? "" : ": ",
                         std::string_view(reason.data(), reason.size()));
    }
    return fmt::format("the connection with {} is lost: {}", client_.name(), error.message());
  }

  void lose(std::string why) {
    const std::scoped_lock lock(mutex_);
    if (!lost_) lost_ = std::move(why);
    changed_.notify_all();
  }

  ClientWait wait_;
  TlsClient client_;
  const std::string address_;  // of the WebSocket, within the server
  websocket::stream<TlsClient::Stream&> socket_{client_.stream()};
  asio::executor_work_guard<asio::io_context::executor_type> work_;
  beast::flat_buffer buffer_;
  asio::steady_timer timer_{client_.io()};
  std::chrono::steady_clock::time_point alive_at_;  // when the computer last gave a sign of life
  bool pinging_ = false;
  Message sending_;
  std::size_t sent_ = 0;  // bytes of it
  bool writing_ = false;
  bool closing_ = false;
  std::thread thread_;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Message> incoming_;
  std::deque<Message> outgoing_;
  bool paused_ = false;  // nothing is read until something is received
  std::optional<std::string> lost_;
};

}  // namespace

Expected<std::unique_ptr<ServerConnection>> ServerConnection::open(
    const ServerAddress& server, const ServerCredentials& credentials, const ClientWait& wait) {
  auto connection = std::make_unique<WebSocketConnection>(server, wait);
  ROOMWISE_RETURN_IF_ERROR(connection->connect(credentials));
  connection->run();
  return connection;
}

}  // namespace roomwise::service
