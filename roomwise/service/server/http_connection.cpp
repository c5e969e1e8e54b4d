#include <fmt/format.h>
#include <openssl/err.h>
#include <openssl/ssl.h>

#include <array>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <exception>
#include <limits>
#include <optional>

#include "roomwise/service/server/request_checks.h"
#include "roomwise/service/server/server_core.h"

namespace roomwise::service {
namespace {

namespace http = beast::http;
using boost::system::error_code;

std::string string_of(boost::string_view text) {
  return {text.data(), text.size()};
}

// Small letters; a header that comes twice is joined as RFC 9110 says.
std::map<std::string, std::string> headers_of(const BeastRequest& message) {
  std::map<std::string, std::string> headers;
  for (const auto& field : message) {
    std::string name = string_of(field.name_string());
    std::ranges::transform(name, name.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    std::string& value = headers[name];
    if (!value.empty()) value += name == "cookie" ? "; " : ", ";
    value += string_of(field.value());
  }
  return headers;
}

// All but the body; gives why the request is none.
Expected<void> read_head_into(HttpRequest& request, const BeastRequest& message,
                              const std::string& peer) {
  request.method = string_of(message.method_string());
  if (request.method == "HEAD") request.method = "GET";
  request.headers = headers_of(message);
  request.peer = peer;
  const std::string target = string_of(message.target());
  const std::size_t end = std::min(target.find('?'), target.size());
  request.path = target.substr(0, end);
  auto query = parse_query(std::string_view(target).substr(std::min(end + 1, target.size())));
  if (!request.path.starts_with('/') || !percent_decoded(request.path) || !query) {
    return fail("the address of the request is damaged");
  }
  request.query = *std::move(query);
  return {};
}

// Whether the client asks for our subprotocol, among others perhaps.
bool asks_for_subprotocol(const HttpRequest& request) {
  const std::string_view asked = request.header("sec-websocket-protocol");
  for (const auto& token : http::token_list(boost::string_view(asked.data(), asked.size()))) {
    if (token == "roomwise.1") return true;
  }
  return false;
}

class HttpConnection final : public Connection,
                             public std::enable_shared_from_this<HttpConnection> {
 public:
  HttpConnection(std::shared_ptr<TableEntry> entry, asio::ip::tcp::socket socket, std::string peer)
      : entry_(std::move(entry)),
        core_(entry_->core()),
        connected_(std::move(peer)),
        peer_(connected_),
        stream_(std::move(socket), core_.tls) {}

  void start() {
    idle_ = true;
    expires_after(core_.options.limits.handshake_s);
    stream_.async_handshake(asio::ssl::stream_base::server,
                            [self = shared_from_this()](error_code error) {
                              if (error) return self->on_no_handshake(error);
                              self->read_head();
                            });
  }

  void end(const std::string&) override {
    ending_ = true;
    if (idle_) cut();
  }

  void cut() override { beast::get_lowest_layer(stream_).close(); }

 private:
  using Parser = http::request_parser<http::vector_body<std::uint8_t>>;

  // ---- reading ----

  void on_no_handshake(error_code error) {
    const bool plain =
        error.category() == asio::error::get_ssl_category() &&
        ERR_GET_REASON(static_cast<unsigned long>(error.value())) == SSL_R_HTTP_REQUEST;
    refuse(plain ? "HTTP without TLS" : "no TLS handshake");
  }

  // A connection's first request must be there as soon as the handshake, later ones may come when
  // they like.
  void read_head() {
    if (ending_) return shut_down();
    idle_ = true;
    request_ = {};
    parser_.emplace();
    parser_->header_limit(static_cast<std::uint32_t>(core_.options.limits.header_bytes));
    // Each route has its own limit; until it is known which, the parser is to judge nothing.
    parser_->body_limit(std::numeric_limits<std::uint64_t>::max());
    if (served_ > 0) expires_after(core_.options.limits.idle_s);
    http::async_read_header(stream_, buffer_, *parser_,
                            [self = shared_from_this()](error_code error, std::size_t) {
                              self->idle_ = false;
                              self->on_head(error);
                            });
  }

  void on_head(error_code error) {
    ++served_;
    if (error) return on_unreadable(error);
    keep_alive_ = parser_->get().keep_alive();
    is_head_ = parser_->get().method() == http::verb::head;
    if (const auto head = read_head_into(request_, parser_->get(), peer_); !head) {
      return answer_at_once(error_answer(400, head.error().message));
    }
    if (core_.options.proxies.contains(connected_)) take_peer_from_proxy();
    expires_after(core_.options.limits.request_s);
    if (auto refusal = refuse_foreign(request_)) return answer_at_once(*std::move(refusal));
    find_home();
  }

  // A proxy puts the address of who asks last. A zone is of the proxy's networks, and may be any
  // text.
  void take_peer_from_proxy() {
    const std::string_view all = request_.header("x-forwarded-for");
    std::string_view last = all.substr(all.rfind(',') + 1);
    last.remove_prefix(std::min(last.find_first_not_of(' '), last.size()));
    peer_ = is_address(last) ? std::string(without_zone(last)) : connected_;
    request_.peer = peer_;
  }

  // Whose home the request is for, and whom it is from.
  void find_home() {
    home_.reset();
    took_of_peer_ = false;
    if (core_.homes->resolves_at_once()) {
      return on_resolved(core_.homes->resolve(request_, core_.now()));
    }
    // Finding it takes a worker, files and perhaps a database: not for whoever asks too often. Who
    // turns out to be known is counted as a device alone.
    if (!core_.peer_rate.take(peer_key(peer_), core_.now().steady_s)) {
      return answer_at_once(refused_too_many());
    }
    took_of_peer_ = true;
    const auto resolve = [this] { return core_.homes->resolve(request_, core_.now()); };
    on_worker(resolve, [this](auto resolved) { on_resolved(std::move(resolved)); });
  }

  void on_resolved(std::variant<ResolvedRequest, HttpAnswer> outcome) {
    if (auto* refusal = std::get_if<HttpAnswer>(&outcome)) {
      return answer_at_once(std::move(*refusal));
    }
    auto& resolved = std::get<ResolvedRequest>(outcome);
    home_ = std::move(resolved.home);
    request_.who = std::move(resolved.who);
    request_.base = std::move(resolved.base);
    request_.path.erase(0, request_.base.size());
    if (auto refusal = refuse_too_many()) return answer_at_once(*std::move(refusal));
    if (auto refusal = refuse_other_names()) return answer_at_once(*std::move(refusal));
    find_handler();
  }

  void on_unreadable(error_code error) {
    if (error == http::error::header_limit || error == http::error::buffer_overflow) {
      return answer_at_once(error_answer(431, "the header of the request is too large"));
    }
    if (error == http::error::body_limit) {
      return answer_at_once(error_answer(413, "the body of the request is too large"));
    }
    if (error.category() == make_error_code(http::error::bad_method).category() &&
        error != http::error::end_of_stream && error != http::error::partial_message) {
      return answer_at_once(error_answer(400, "this is no HTTP request"));
    }
    if (error == beast::error::timeout && served_ == 1) return refuse("no request in time");
    if (error == http::error::end_of_stream) shut_down();
  }

  std::optional<HttpAnswer> refuse_too_many() {
    const Now now = core_.now();
    const bool device = request_.who.has_value();
    const bool took_of_peer = std::exchange(took_of_peer_, false);
    if (device && took_of_peer) core_.peer_rate.give_back(peer_key(peer_));
    if (!device && took_of_peer) return std::nullopt;
    if (device && !core_.table.identify(entry_->number(), {home_->name(), request_.who->device},
                                        request_.who->role)) {
      core_.events.refused("too many connections of one device", peer_, now.steady_s);
      return too_many("this device has too many connections");
    }
    if (device ? core_.device_rate.take(fmt::format("{} {}", home_->name(), request_.who->device),
                                        now.steady_s)
               : core_.peer_rate.take(peer_key(peer_), now.steady_s)) {
      return std::nullopt;
    }
    return refused_too_many();
  }

  HttpAnswer refused_too_many() {
    core_.events.refused("too many requests", peer_, core_.now().steady_s);
    return too_many("too many requests; wait a second");
  }

  // Who has shown a token was paired under that name, which no other site's page can be.
  std::optional<HttpAnswer> refuse_other_names() {
    const std::string_view host = request_.header("host");
    if (request_.who || core_.hosts.allows(host)) return std::nullopt;
    core_.events.refused("a name that is not this computer's", peer_, core_.now().steady_s);
    return error_answer(
        421, fmt::format("'{}' is no name of this computer; if it is, whoever runs it says so: "
                         "roomwise serve --allowed-host NAME",
                         host));
  }

  static HttpAnswer too_many(std::string_view what) {
    HttpAnswer answer = error_answer(429, what, "many_requests");
    answer.headers.emplace_back("Retry-After", "1");
    return answer;
  }

  void find_handler() {
    if (request_.method == "GET" && !home_->router().knows(request_.path) &&
        !request_.path.starts_with("/api/")) {
      where_ = "a page";
      leave_body();
      return work([this] { return core_.pages.answer(request_); });
    }
    auto found = home_->router().find(request_);
    if (auto* refusal = std::get_if<HttpAnswer>(&found)) return answer_at_once(std::move(*refusal));
    match_ = std::get<RouteMatch>(std::move(found));
    where_ = request_.base + match_.route->pattern;
    if (match_.route->pattern == "/api/socket" && beast::websocket::is_upgrade(parser_->get()))
      return upgrade();
    read_body();
  }

  void read_body() {
    const std::uint64_t most = match_.route->max_body_bytes;
    if (parser_->content_length().value_or(0) > most) {
      return answer_at_once(error_answer(
          413, fmt::format("the body of the request is too large: at most {} bytes", most)));
    }
    parser_->body_limit(most);
    if (request_.header("expect") == "100-continue") return say_continue();
    http::async_read(stream_, buffer_, *parser_,
                     [self = shared_from_this()](error_code error, std::size_t) {
                       if (error) return self->on_unreadable(error);
                       self->request_.body = std::move(self->parser_->get().body());
                       self->work([connection = self.get()] { return connection->handle(); });
                     });
  }

  // Who asks, as it is now: while the body came, or before the table knew of them, they may have
  // been removed. The answer where that cannot be told.
  std::optional<HttpAnswer> identify_again() {
    if (!request_.who) return std::nullopt;
    auto who = home_->identify(request_, core_.now());
    if (!who) return unavailable(who.error().message);
    request_.who = *std::move(who);
    return std::nullopt;
  }

  static HttpAnswer unavailable(std::string_view why) {
    HttpAnswer answer = error_answer(503, why);
    answer.headers.emplace_back("Retry-After", "1");
    return answer;
  }

  // On a worker.
  HttpAnswer handle() {
    if (auto refusal = identify_again()) return *std::move(refusal);
    HttpAnswer answer = home_->router().answer(request_);
    if (request_.who && request_.method != "GET") {
      home_->note_done(request_, *match_.route, answer.status);
    }
    return answer;
  }

  void say_continue() {
    request_.headers.erase("expect");
    auto go_on = std::make_shared<http::response<http::empty_body>>(http::status::continue_, 11);
    http::async_write(stream_, *go_on,
                      [self = shared_from_this(), go_on](error_code error, std::size_t) {
                        if (!error) self->read_body();
                      });
  }

  void upgrade() {
    if (!asks_for_subprotocol(request_)) {
      return answer_at_once(error_answer(400, "the WebSocket's subprotocol must be roomwise.1"));
    }
    if (buffer_.size() > 0) {
      return answer_at_once(error_answer(400, "the client must wait until the WebSocket is open"));
    }
    const auto prepare = [this] { return prepare_socket(); };
    if (core_.homes->resolves_at_once()) return on_prepared(prepare());
    on_worker(prepare, [this](auto sockets) { on_prepared(std::move(sockets)); });
  }

  tl::expected<SocketHandler*, HttpAnswer> prepare_socket() {
    if (auto refusal = identify_again()) return tl::unexpected(*std::move(refusal));
    auto found = home_->router().find(request_);
    if (auto* refusal = std::get_if<HttpAnswer>(&found)) return tl::unexpected(std::move(*refusal));
    const auto sockets = home_->sockets();
    if (!sockets) return tl::unexpected(unavailable(sockets.error().message));
    return *sockets;
  }

  void on_prepared(tl::expected<SocketHandler*, HttpAnswer> prepared) {
    if (!prepared) return answer_at_once(std::move(prepared.error()));
    if (ending_) return shut_down();
    // From here on the stream is another's; this connection ends with this function.
    serve_socket(std::move(entry_), std::move(stream_), parser_->release(),
                 {std::move(home_), *prepared, *request_.who}, peer_);
  }

  // ---- answering ----

  // Has a worker make the answer.
  template <typename Make>
  void work(Make make) {
    on_worker(std::move(make), [this](HttpAnswer answer) { write(std::move(answer)); });
  }

  // Has a worker make something, with which it goes on here. Where that throws this request fails,
  // and nothing else: on a worker an exception would end the program.
  template <typename Make, typename GoOn>
  void on_worker(Make make, GoOn go_on) {
    if (core_.waiting_requests >= core_.options.limits.waiting_requests) {
      core_.events.refused("too many requests at once", peer_, core_.now().steady_s);
      return answer_at_once(error_answer(503, "the computer is busy; try again soon", "later"));
    }
    ++core_.waiting_requests;
    beast::get_lowest_layer(stream_).expires_never();
    asio::post(core_.workers, [self = shared_from_this(), make, go_on]() mutable {
      std::shared_ptr<decltype(make())> made;
      try {
        made = std::make_shared<decltype(make())>(make());
      } catch (const std::exception& fault) {
        // What went wrong may name files or other people's things: it is not for whoever asks.
        self->core_.events.say(fmt::format("{} at {} went wrong: {}", self->request_.method,
                                           self->where_, fault.what()));
      }
      ServerCore& core = self->core_;
      --core.waiting_requests;
      asio::post(core.io, [self = std::move(self), made = std::move(made), go_on] {
        self->expires_after(self->core_.options.limits.request_s);
        if (!made) return self->answer_at_once(internal_error_answer());
        go_on(std::move(*made));
      });
    });
  }

  // Where a body is left unread the connection cannot go on.
  void leave_body() {
    drain_ = !parser_->is_done();
    if (drain_) keep_alive_ = false;
  }

  void answer_at_once(HttpAnswer answer) {
    leave_body();
    expires_after(core_.options.limits.request_s);
    write(std::move(answer));
  }

  void write(HttpAnswer answer) {
    core_.events.answered(answer.status, string_of(parser_->get().method_string()), where_, peer_,
                          core_.now().steady_s);
    where_ = "an unknown address";
    match_ = {};
    home_.reset();  // it may be closed now
    keep_alive_ = keep_alive_ && !ending_;
    make_response(std::move(answer));
    http::async_write(stream_, *response_,
                      [self = shared_from_this()](error_code error, std::size_t) {
                        if (error) return;
                        if (self->keep_alive_) return self->read_head();
                        self->left_to_drain_ = self->drain_ ? kMaxDrained : 0;
                        self->drain();
                      });
  }

  void make_response(HttpAnswer answer) {
    response_.emplace(static_cast<http::status>(answer.status), 11);
    response_->keep_alive(keep_alive_);
    bool keeps = false;
    for (const auto& [name, value] : answer.headers) {
      response_->insert(name, value);
      keeps = keeps || name == "Cache-Control";
    }
    if (!keeps) response_->set(http::field::cache_control, "no-store");
    for (const auto& [name, value] : security_headers(request_)) response_->set(name, value);
    if (!answer.content_type.empty()) {
      response_->set(http::field::content_type, answer.content_type);
    }
    const std::size_t bytes = answer.body.size();
    if (!is_head_) response_->body() = std::move(answer.body);
    if (answer.status != 304 && answer.status != 204) response_->content_length(bytes);
  }

  // ---- ending ----

  // What the client still sends is thrown away for a while: closing at once would make its system
  // throw away the answer.
  void drain() {
    if (left_to_drain_ == 0) return shut_down();
    expires_after(2);
    stream_.async_read_some(asio::buffer(scratch_),
                            [self = shared_from_this()](error_code error, std::size_t bytes) {
                              if (error) return self->cut();
                              self->left_to_drain_ -= std::min(self->left_to_drain_, bytes);
                              self->drain();
                            });
  }

  void shut_down() {
    expires_after(2);
    stream_.async_shutdown([self = shared_from_this()](error_code) { self->cut(); });
  }

  void refuse(const std::string& reason) {
    core_.events.refused(reason, peer_, core_.now().steady_s);
    cut();
  }

  void expires_after(double seconds) {
    beast::get_lowest_layer(stream_).expires_after(milliseconds_of(seconds));
  }

  static constexpr std::size_t kMaxDrained = std::size_t{1} << 20U;

  std::shared_ptr<TableEntry> entry_;
  ServerCore& core_;
  const std::string connected_;  // the address at the other end
  std::string peer_;             // who asks: another where that is a proxy
  TlsStream stream_;
  beast::flat_buffer buffer_{std::size_t{1} << 16U};
  std::optional<Parser> parser_;
  std::optional<http::response<http::vector_body<std::uint8_t>>> response_;
  HttpRequest request_;
  std::shared_ptr<ServedHome> home_;  // before what refers to it
  RouteMatch match_;
  std::string where_ = "an unknown address";  // for the log
  std::array<std::uint8_t, 4096> scratch_{};
  std::size_t left_to_drain_ = 0;
  std::uint64_t served_ = 0;
  bool keep_alive_ = false;
  bool is_head_ = false;
  bool took_of_peer_ = false;  // this request was counted among its address's
  bool drain_ = false;
  bool idle_ = false;  // nobody waits for an answer
  bool ending_ = false;
};

}  // namespace

void serve_http(const std::shared_ptr<ServerCore>& core, asio::ip::tcp::socket socket,
                const std::string& peer) {
  auto entry = std::make_shared<TableEntry>(core, peer);
  const ConnectionTable::Number number = entry->number();
  auto connection = std::make_shared<HttpConnection>(std::move(entry), std::move(socket), peer);
  core->table.set(number, connection);
  connection->start();
}

}  // namespace roomwise::service
