#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "roomwise/service/credentials/identity.h"

namespace roomwise::service {

// An open connection, as the server sees it from outside. Called on the network thread alone.
class Connection {
 public:
  virtual ~Connection() = default;
  // Ends it in an orderly way: what is being answered is answered.
  virtual void end(const std::string& reason) = 0;
  // Ends it at once.
  virtual void cut() = 0;
};

struct ConnectionLimits {
  std::size_t connections = 64;  // one more takes the place of the oldest without a token
  // That have not shown a token: one more takes the place of the address's oldest. So a client that
  // holds them open keeps out nobody who shares its address.
  std::size_t unknown_per_peer = 8;
  std::size_t connections_per_device = 16;
  std::size_t sockets_per_device = 2;  // the newest stay
};

// A device of a home. Homes number their devices each for itself.
struct DeviceOfHome {
  std::string home = {};  // empty where the server has one home
  std::int64_t device = 0;

  bool operator==(const DeviceOfHome&) const = default;
};

// Which connections are open, and whether there may be one more. Thread-safe.
class ConnectionTable {
 public:
  using Number = std::uint64_t;

  // `proxies`: addresses from which many clients' connections come, so that their number tells
  // nothing.
  explicit ConnectionTable(const ConnectionLimits& limits, std::set<std::string> proxies = {})
      : limits_(limits), proxies_(std::move(proxies)) {}

  // Why a new connection from there is refused; empty: it is not. Where the table is full, or the
  // address has enough of them, the oldest connection without a token is named in `cut` and no
  // longer counted.
  struct Verdict {
    std::string refused;
    std::shared_ptr<Connection> cut;
  };
  [[nodiscard]] Verdict ask(const std::string& peer);

  Number add(const std::string& peer);
  void set(Number number, std::weak_ptr<Connection> connection);
  void remove(Number number);

  // Whose connection it is; false where the device has too many.
  [[nodiscard]] bool identify(Number number, const DeviceOfHome& device, Role role = Role::kDevice);
  // That a socket was opened; gives the device's older ones that are too many. These are among its
  // connections until they are gone, so that nobody has more by not letting go of them.
  [[nodiscard]] std::vector<std::shared_ptr<Connection>> open_socket(Number number);

  [[nodiscard]] std::vector<std::shared_ptr<Connection>> all() const;
  [[nodiscard]] std::vector<std::shared_ptr<Connection>> of(const DeviceOfHome& device) const;
  // The devices of the home that have a socket.
  [[nodiscard]] std::set<std::int64_t> online(const std::string& home = {}) const;
  // The same with the role in which each socket was opened.
  [[nodiscard]] std::set<std::pair<std::int64_t, Role>> roles_online(
      const std::string& home = {}) const;
  [[nodiscard]] std::size_t size() const;
  [[nodiscard]] std::size_t sockets() const;

  // Whether all are gone before the time is over.
  [[nodiscard]] bool wait_until_empty(std::chrono::milliseconds most) const;
  void wait_until_empty() const;

 private:
  struct Entry {
    std::string peer;  // see peer_key
    std::weak_ptr<Connection> connection;
    std::optional<DeviceOfHome> device;
    Role role = Role::kDevice;  // of the device
    bool socket = false;
    bool leaving = false;  // was cut off and counts no more
  };
  using Choice = std::function<bool(const Entry&)>;
  [[nodiscard]] std::size_t count(const Choice& chosen) const;
  [[nodiscard]] Verdict make_room(const Choice& chosen);  // by the oldest of these
  [[nodiscard]] std::vector<std::shared_ptr<Connection>> choose(const Choice& chosen) const;

  ConnectionLimits limits_;
  std::set<std::string> proxies_;
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::map<Number, Entry> entries_;  // the oldest first
  Number next_ = 1;
};

}  // namespace roomwise::service
