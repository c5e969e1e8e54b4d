#include "roomwise/service/server/server_events.h"

#include <fmt/format.h>

namespace roomwise::service {

void write_metrics(const ServerCounts& counts, MetricsText& text) {
  const auto counter = [&](const char* name, const char* help, std::uint64_t value) {
    text.single(name, "counter", help, value);
  };
  counter("connections_total", "Connections that were taken.", counts.connections);
  counter("sockets_total", "WebSockets that were opened.", counts.sockets);
  text.single("connections_open", "gauge", "Connections that are open.",
              std::uint64_t{counts.open_connections});
  text.single("sockets_open", "gauge", "WebSockets that are open.",
              std::uint64_t{counts.open_sockets});
  counter("messages_received_total", "Messages of WebSockets that came.", counts.messages_in);
  counter("received_bytes_total", "Bytes of these.", counts.message_bytes_in);
  counter("messages_sent_total", "Messages of WebSockets that went.", counts.messages_out);
  counter("messages_dropped_total", "Messages to clients that did not read.",
          counts.messages_dropped);
  text.family("answers_total", "counter", "Answers to requests, by their status.");
  for (const auto& [status, count] : counts.answers) {
    text.sample({{"status", fmt::format("{}", status)}}, count);
  }
  text.family("refusals_total", "counter", "Connections and requests that were refused, and why.");
  for (const auto& [reason, count] : counts.refusals) text.sample({{"reason", reason}}, count);
}

void ServerEvents::opened_connection() {
  const std::scoped_lock lock(mutex_);
  ++counts_.connections;
}

void ServerEvents::opened_socket() {
  const std::scoped_lock lock(mutex_);
  ++counts_.sockets;
}

void ServerEvents::refused(const std::string& reason, const std::string& peer, double now_s) {
  {
    const std::scoped_lock lock(mutex_);
    ++counts_.refusals[reason];
  }
  say_sometimes(reason, fmt::format("{}: refused: {}", peer, reason), now_s);
}

void ServerEvents::answered(int status, const std::string& method, std::string_view where,
                            const std::string& peer, double now_s) {
  {
    const std::scoped_lock lock(mutex_);
    ++counts_.answers[status];
  }
  if (method == "GET" && status < 400) return;
  say_sometimes(fmt::format("{}", status),
                fmt::format("{}: {} {}: {}", peer, method, where, status), now_s);
}

void ServerEvents::message_in(std::size_t bytes) {
  const std::scoped_lock lock(mutex_);
  ++counts_.messages_in;
  counts_.message_bytes_in += bytes;
}

void ServerEvents::message_out() {
  const std::scoped_lock lock(mutex_);
  ++counts_.messages_out;
}

void ServerEvents::message_dropped() {
  const std::scoped_lock lock(mutex_);
  ++counts_.messages_dropped;
}

void ServerEvents::say(const std::string& line) {
  const std::scoped_lock lock(log_mutex_);
  log_(line);
}

ServerCounts ServerEvents::counts() const {
  const std::scoped_lock lock(mutex_);
  return counts_;
}

void ServerEvents::say_sometimes(const std::string& kind, const std::string& line, double now_s) {
  {
    const std::scoped_lock lock(mutex_);
    if (!lines_.take(kind, now_s)) return;
  }
  say(line);
}

}  // namespace roomwise::service
