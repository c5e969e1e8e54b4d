#pragma once

#include <cstddef>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>

#include "roomwise/service/access/rate_limit.h"
#include "roomwise/service/server/metrics_text.h"
#include "roomwise/service/server/server.h"

namespace roomwise::service {

// The counts as figures for Prometheus.
void write_metrics(const ServerCounts& counts, MetricsText& text);

// Counts what happens in a server, and says it in its log. Thread-safe.
class ServerEvents {
 public:
  explicit ServerEvents(std::function<void(std::string_view)> log) : log_(std::move(log)) {}

  void opened_connection();
  void opened_socket();
  void refused(const std::string& reason, const std::string& peer, double now_s);
  // `where`: the pattern of a route and not what was asked for, which may hold anything.
  void answered(int status, const std::string& method, std::string_view where,
                const std::string& peer, double now_s);
  void message_in(std::size_t bytes);
  void message_out();
  void message_dropped();
  void say(const std::string& line);

  [[nodiscard]] ServerCounts counts() const;

 private:
  // One who floods the server must not flood its log: a few lines of a kind at once, then one a
  // second.
  void say_sometimes(const std::string& kind, const std::string& line, double now_s);

  mutable std::mutex mutex_;
  std::mutex log_mutex_;
  ServerCounts counts_;
  RateLimit lines_{20, 1};
  std::function<void(std::string_view)> log_;
};

}  // namespace roomwise::service
