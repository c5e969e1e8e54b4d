#include "roomwise/service/server_events.h"

#include <fmt/format.h>

namespace roomwise::service {

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
