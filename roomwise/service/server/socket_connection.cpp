#include <boost/asio/steady_timer.hpp>
#include <boost/asio/strand.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/fields.hpp>
#include <boost/beast/websocket.hpp>
#include <boost/beast/websocket/ssl.hpp>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>

#include "roomwise/service/server/server_core.h"

namespace roomwise::service {
namespace {

namespace websocket = beast::websocket;
using boost::system::error_code;

constexpr std::size_t kPieceBytes = 64 * 1024;  // of a message, read at once

class SocketConnection;

// A stream that tells when it is read from: Beast says nothing of empty pieces of a message.
class HeardStream : public TlsStream {
 public:
  explicit HeardStream(TlsStream stream) : TlsStream(std::move(stream)) {}

  std::function<void()> on_read;
  template <typename Buffers, typename Handler>
  auto async_read_some(const Buffers& buffers, Handler&& handler) {
    if (on_read) on_read();
    return TlsStream::async_read_some(buffers, std::forward<Handler>(handler));
  }
};

// By which Beast ends it.
template <typename Handler>
void async_teardown(beast::role_type role, HeardStream& stream, Handler&& handler) {
  beast::async_teardown(role, static_cast<TlsStream&>(stream), std::forward<Handler>(handler));
}

// What waits for a client. Others hold it as long as they like; it holds nothing.
class Outbox final : public SocketOut, public std::enable_shared_from_this<Outbox> {
 public:
  Outbox(const ServerLimits& limits, std::weak_ptr<SocketConnection> connection)
      : max_bytes_(limits.waiting_bytes),
        max_messages_(limits.waiting_messages),
        connection_(std::move(connection)) {}

  void send_text(std::string text) override;
  void close(std::string reason) override;

  // For the connection, on its thread. The next message, whose bytes still count until it is sent.
  [[nodiscard]] std::optional<std::string> next();
  void sent(std::size_t bytes);
  // Whether the client is still spoken with. Thread-safe, as the next.
  [[nodiscard]] bool is_open() {
    const std::scoped_lock lock(mutex_);
    return open_;
  }
  void shut() {
    const std::scoped_lock lock(mutex_);
    open_ = false;
    waiting_.clear();
  }

 private:
  const std::size_t max_bytes_;
  const std::size_t max_messages_;
  const std::weak_ptr<SocketConnection> connection_;
  std::mutex mutex_;
  std::deque<std::string> waiting_;
  std::size_t bytes_ = 0;
  bool open_ = true;
};

class SocketConnection final : public Connection,
                               public std::enable_shared_from_this<SocketConnection> {
 public:
  SocketConnection(std::shared_ptr<TableEntry> entry, TlsStream stream, SocketClient client,
                   std::string peer)
      : entry_(std::move(entry)),
        core_(entry_->core()),
        client_(std::move(client)),
        who_(client_.who),
        known_as_(client_.home->name().empty()
                      ? fmt::format("device {}", who_.device)
                      : fmt::format("{}: device {}", client_.home->name(), who_.device)),
        peer_(std::move(peer)),
        stream_(std::move(stream)),
        buffer_(core_.options.limits.message_bytes + kPieceBytes),
        messages_(core_.options.limits.burst_messages, core_.options.limits.rate_messages),
        bytes_(core_.options.limits.burst_bytes, core_.options.limits.rate_bytes),
        hello_timer_(core_.io),
        end_timer_(core_.io),
        strand_(asio::make_strand(core_.session_threads.get_executor())) {}

  void start(BeastRequest request) {
    out_ = std::make_shared<Outbox>(core_.options.limits, weak_from_this());
    const ServerLimits& limits = core_.options.limits;
    beast::get_lowest_layer(stream_).expires_never();  // the WebSocket has a clock of its own
    stream_.set_option(websocket::stream_base::timeout{
        milliseconds_of(limits.handshake_s), milliseconds_of(limits.socket_idle_s), true});
    stream_.set_option(websocket::stream_base::decorator([](websocket::response_type& answer) {
      answer.set(beast::http::field::sec_websocket_protocol, "roomwise.1");
    }));
    stream_.control_callback([weak = weak_from_this()](websocket::frame_type type, auto) {
      const auto self = weak.lock();
      if (!self || type == websocket::frame_type::close) return;
      self->reads_ = 0;
      self->count_within_reading();
    });
    // A header and what follows it may be read apart; what is read though nothing comes of it holds
    // empty pieces.
    stream_.next_layer().on_read = [this] {
      if (++reads_ > 2) count_within_reading();
    };
    stream_.read_message_max(0);  // it would end without a reason; see read_on()
    auto kept = std::make_shared<BeastRequest>(std::move(request));
    stream_.async_accept(*kept, [self = shared_from_this(), kept](error_code error) {
      if (error) return;
      self->on_open();
    });
  }

  // ---- on the network thread ----

  // Nothing that waits is sent any more, and the session hears nothing.
  void end(const std::string& reason) override {
    out_->shut();
    end_after_what_waits(reason);
  }

  void end_after_what_waits(const std::string& reason) {
    begin_end(core_.stopping ? websocket::close_code::going_away : websocket::close_code::normal,
              reason);
  }

  void cut() override { beast::get_lowest_layer(stream_).close(); }

  // The client does not read.
  void overflow() {
    if (closed_) return;
    core_.events.refused("a client that does not read", peer_, core_.now().steady_s);
    cut();
  }

  // Sends what waits, one message after the other, and closes once that is done and wanted.
  void flush() {
    if (!open_ || writing_ || closing_) return;
    std::optional<std::string> message = out_->next();
    if (!message) {
      if (ending_) close();
      return;
    }
    writing_ = true;
    auto text = std::make_shared<std::string>(*std::move(message));
    stream_.text(true);
    stream_.async_write(asio::buffer(*text),
                        [self = shared_from_this(), text](error_code error, std::size_t) {
                          self->writing_ = false;
                          if (error) return self->cut();
                          self->core_.events.message_out();
                          self->out_->sent(text->size());
                          self->flush();
                        });
  }

  [[nodiscard]] ServerCore& core() const { return core_; }

 private:
  // Whoever does not take what is sent, or does not close, is cut off soon all the same.
  void begin_end(websocket::close_code code, const std::string& reason) {
    if (!ending_) {
      ending_ = code;
      end_reason_ = reason;
      end_timer_.expires_after(milliseconds_of(core_.options.limits.handshake_s));
      end_timer_.async_wait([weak = weak_from_this()](error_code error) {
        const auto self = weak.lock();
        if (!error && self) self->cut();
      });
    }
    flush();
  }

  void on_open() {
    open_ = true;
    core_.events.opened_socket();
    core_.events.say(fmt::format("{}: {} ({}) connected", peer_, known_as_, who_.name));
    for (const auto& older : core_.table.open_socket(entry_->number())) {
      older->end("this device has connected again");
    }
    await_hello();
    on_session([self = shared_from_this()] {
      if (!self->out_->is_open()) return;  // was told to go before it was open
      self->session_ = self->client_.sockets->connect(self->who_, self->out_);
      if (!self->session_) self->out_->close("unavailable");
    });
    flush();
  }

  void await_hello() {
    hello_timer_.expires_after(milliseconds_of(core_.options.limits.hello_s));
    hello_timer_.async_wait([weak = weak_from_this()](error_code error) {
      const auto self = weak.lock();
      if (error || !self || self->greeted_) return;
      self->core_.events.refused("a client that says no hello", self->peer_,
                                 self->core_.now().steady_s);
      self->end("no hello came");
    });
  }

  // Calls something of the session where sessions are called, then reads on.
  template <typename Call>
  void on_session(Call call) {
    asio::post(strand_, [self = shared_from_this(), call = std::move(call)]() mutable {
      try {
        call();
      } catch (const std::exception& exception) {
        self->core_.events.say(
            fmt::format("{}: its session failed: {}", self->known_as_, exception.what()));
        self->out_->close("the computer made a mistake");
      }
      ServerCore& core = self->core_;
      const bool greeted = self->session_ && self->session_->greeted();
      asio::post(core.io, [self = std::move(self), greeted] {
        self->greeted_ = greeted;
        if (greeted) self->hello_timer_.cancel();
        self->read();
      });
    });
  }

  void read() {
    if (closed_) return;
    buffer_.clear();
    read_on();
  }

  // Piece by piece: a stream that reached a limit of its own can say nothing any more.
  void read_on() {
    stream_.async_read_some(
        buffer_, kPieceBytes, [self = shared_from_this()](error_code error, std::size_t) {
          self->reads_ = 0;
          const std::size_t most = self->core_.options.limits.message_bytes;
          if (error) return self->on_closed(error);
          if (self->ending_) return self->read_to_the_end();
          if (self->buffer_.size() > most) {
            self->refuse("a message that is too large", websocket::close_code::too_big,
                         fmt::format("a message has at most {} bytes", most));
            return self->read_to_the_end();
          }
          if (self->stream_.is_message_done()) return self->on_message();
          self->read_on();
        });
  }

  void on_message() {
    core_.events.message_in(buffer_.size());
    if (const std::string why = why_too_much(buffer_.size()); !why.empty()) refuse_flood(why);
    if (ending_) return read_to_the_end();
    const auto* begin = static_cast<const std::uint8_t*>(buffer_.data().data());
    auto bytes = std::make_shared<Bytes>(begin, begin + buffer_.size());
    on_session([self = shared_from_this(), bytes, is_text = stream_.got_text()] {
      if (!self->session_ || !self->out_->is_open()) return;
      if (!is_text) return self->session_->on_message(std::move(*bytes));
      self->session_->on_text({reinterpret_cast<const char*>(bytes->data()), bytes->size()});
    });
  }

  void count_within_reading() {
    if (ending_) return;
    std::string why = why_too_much(0);
    if (why.empty()) return;
    asio::post(core_.io,
               [self = shared_from_this(), why = std::move(why)] { self->refuse_flood(why); });
  }

  // Counts a message, a ping, a pong or empty pieces; why it is more than the client may send, or
  // nothing.
  std::string why_too_much(std::size_t bytes) {
    const ServerLimits& limits = core_.options.limits;
    const double now_s = core_.now().steady_s;
    if (!messages_.take("", now_s)) {
      return fmt::format("too many messages: at most {:.0f} a second", limits.rate_messages);
    }
    if (!bytes_.take("", now_s, static_cast<double>(bytes))) {
      return fmt::format("too many bytes: at most {:.0f} a second", limits.rate_bytes);
    }
    return "";
  }

  // What it sent is not read any more.
  void refuse_flood(const std::string& why) {
    if (ending_) return;
    refuse("too many messages of one client", websocket::close_code::policy_error, why);
  }

  void refuse(const std::string& what, websocket::close_code code, const std::string& why) {
    core_.events.refused(what, peer_, core_.now().steady_s);
    out_->shut();
    begin_end(code, why);
  }

  // Until the other side has closed, too.
  void read_to_the_end() {
    buffer_.clear();
    stream_.async_read_some(buffer_, kPieceBytes,
                            [self = shared_from_this()](error_code error, std::size_t) {
                              if (error) return self->on_closed(error);
                              self->read_to_the_end();
                            });
  }

  void close() {
    closing_ = true;
    websocket::close_reason reason(*ending_);
    // Control frames hold 123 bytes of reason.
    const std::string text = end_reason_.substr(0, 123);
    reason.reason = boost::string_view(text.data(), text.size());
    stream_.async_close(reason, [self = shared_from_this()](error_code) { self->cut(); });
  }

  // The last reading has failed: there is no more to come.
  void on_closed(error_code error) {
    if (closed_) return;
    closed_ = true;
    hello_timer_.cancel();
    out_->shut();
    if (error == beast::error::timeout) {
      core_.events.refused("a client that is gone", peer_, core_.now().steady_s);
    }
    core_.events.say(fmt::format("{}: {} ({}) gone{}", peer_, known_as_, who_.name,
                                 end_reason_.empty() ? "" : ": " + end_reason_));
    if (!closing_) cut();
    asio::post(strand_, [self = shared_from_this()] {
      try {
        if (self->session_) self->session_->on_closed();
      } catch (const std::exception& exception) {
        self->core_.events.say(
            fmt::format("{}: its session failed: {}", self->known_as_, exception.what()));
      }
      self->session_.reset();
    });
  }

  std::shared_ptr<TableEntry> entry_;
  ServerCore& core_;
  const SocketClient client_;  // before what it keeps open
  const Identity who_;
  const std::string known_as_;  // in the log
  const std::string peer_;
  websocket::stream<HeardStream> stream_;
  beast::flat_buffer buffer_;
  RateLimit messages_;
  RateLimit bytes_;
  asio::steady_timer hello_timer_;
  asio::steady_timer end_timer_;
  asio::strand<asio::thread_pool::executor_type> strand_;
  std::shared_ptr<Outbox> out_;
  std::unique_ptr<SocketSession> session_;  // belongs to the strand
  std::optional<websocket::close_code> ending_;
  std::string end_reason_;
  int reads_ = 0;  // of the stream since something came
  bool open_ = false;
  bool greeted_ = false;
  bool writing_ = false;
  bool closing_ = false;
  bool closed_ = false;
};

void Outbox::send_text(std::string text) {
  const auto connection = connection_.lock();
  const std::scoped_lock lock(mutex_);
  if (!open_ || !connection) return;
  ServerCore& core = connection->core();
  if (waiting_.size() >= max_messages_ || bytes_ + text.size() > max_bytes_) {
    open_ = false;
    for (std::size_t i = 0; i <= waiting_.size(); ++i) core.events.message_dropped();
    waiting_.clear();
    asio::post(core.io, [connection] { connection->overflow(); });
    return;
  }
  bytes_ += text.size();
  waiting_.push_back(std::move(text));
  asio::post(core.io, [connection] { connection->flush(); });
}

void Outbox::close(std::string reason) {
  const auto connection = connection_.lock();
  const std::scoped_lock lock(mutex_);
  if (!open_ || !connection) return;
  open_ = false;  // what waits is sent, nothing more is taken
  asio::post(connection->core().io, [connection, reason = std::move(reason)] {
    connection->end_after_what_waits(reason);
  });
}

std::optional<std::string> Outbox::next() {
  const std::scoped_lock lock(mutex_);
  if (waiting_.empty()) return std::nullopt;
  std::string text = std::move(waiting_.front());
  waiting_.pop_front();
  return text;
}

void Outbox::sent(std::size_t bytes) {
  const std::scoped_lock lock(mutex_);
  bytes_ -= bytes;
}

}  // namespace

void serve_socket(std::shared_ptr<TableEntry> entry, TlsStream stream, BeastRequest request,
                  SocketClient client, std::string peer) {
  ServerCore& core = entry->core();
  const ConnectionTable::Number number = entry->number();
  auto connection = std::make_shared<SocketConnection>(std::move(entry), std::move(stream),
                                                       std::move(client), std::move(peer));
  core.table.set(number, connection);
  connection->start(std::move(request));
}

}  // namespace roomwise::service
