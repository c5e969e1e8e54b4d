#include "roomwise/service/server/connection_table.h"

#include <algorithm>
#include <utility>

#include "roomwise/service/access/rate_limit.h"

namespace roomwise::service {

ConnectionTable::Verdict ConnectionTable::ask(const std::string& peer) {
  const std::string key = peer_key(peer);
  const std::scoped_lock lock(mutex_);
  const auto unknown = [](const Entry& entry) { return !entry.device; };
  const auto unknown_there = [&](const Entry& entry) {
    return unknown(entry) && entry.peer == key;
  };
  if (!proxies_.contains(peer) && count(unknown_there) >= limits_.unknown_per_peer) {
    return make_room(unknown_there);
  }
  if (count([](const Entry&) { return true; }) < limits_.connections) return {};
  return make_room(unknown);
}

ConnectionTable::Verdict ConnectionTable::make_room(const Choice& chosen) {
  const auto oldest = std::ranges::find_if(entries_, [&](const auto& numbered) {
    return !numbered.second.leaving && chosen(numbered.second);
  });
  if (oldest == entries_.end()) return {"too many connections", nullptr};
  oldest->second.leaving = true;
  return {"", oldest->second.connection.lock()};
}

ConnectionTable::Number ConnectionTable::add(const std::string& peer) {
  const std::scoped_lock lock(mutex_);
  entries_[next_].peer = peer_key(peer);
  return next_++;
}

void ConnectionTable::set(Number number, std::weak_ptr<Connection> connection) {
  const std::scoped_lock lock(mutex_);
  entries_.at(number).connection = std::move(connection);
}

void ConnectionTable::remove(Number number) {
  const std::scoped_lock lock(mutex_);
  entries_.erase(number);
  changed_.notify_all();
}

bool ConnectionTable::identify(Number number, const DeviceOfHome& device, Role role) {
  const std::scoped_lock lock(mutex_);
  Entry& entry = entries_.at(number);
  const auto before = std::exchange(entry.device, device);
  const bool may = count([&](const Entry& other) { return other.device == device; }) <=
                   limits_.connections_per_device;
  // One too many makes room like a connection without a token.
  if (may) {
    entry.role = role;
  } else {
    entry.device = before;
  }
  return may;
}

std::vector<std::shared_ptr<Connection>> ConnectionTable::open_socket(Number number) {
  const std::scoped_lock lock(mutex_);
  Entry& opened = entries_.at(number);
  opened.socket = true;
  std::vector<Entry*> sockets;
  for (auto& [other, entry] : entries_) {
    if (entry.socket && entry.device == opened.device) sockets.push_back(&entry);
  }
  std::vector<std::shared_ptr<Connection>> gone;
  for (std::size_t i = 0; i + limits_.sockets_per_device < sockets.size(); ++i) {
    sockets[i]->socket = false;
    if (auto connection = sockets[i]->connection.lock()) gone.push_back(std::move(connection));
  }
  return gone;
}

std::vector<std::shared_ptr<Connection>> ConnectionTable::all() const {
  return choose([](const Entry&) { return true; });
}

std::vector<std::shared_ptr<Connection>> ConnectionTable::of(const DeviceOfHome& device) const {
  return choose([&](const Entry& entry) { return entry.device == device; });
}

std::set<std::int64_t> ConnectionTable::online(const std::string& home) const {
  std::set<std::int64_t> devices;
  for (const auto& [device, role] : roles_online(home)) devices.insert(device);
  return devices;
}

std::set<std::pair<std::int64_t, Role>> ConnectionTable::roles_online(
    const std::string& home) const {
  const std::scoped_lock lock(mutex_);
  std::set<std::pair<std::int64_t, Role>> devices;
  for (const auto& [number, entry] : entries_) {
    if (entry.socket && entry.device && entry.device->home == home) {
      devices.emplace(entry.device->device, entry.role);
    }
  }
  return devices;
}

std::size_t ConnectionTable::size() const {
  const std::scoped_lock lock(mutex_);
  return entries_.size();
}

std::size_t ConnectionTable::sockets() const {
  const std::scoped_lock lock(mutex_);
  return static_cast<std::size_t>(
      std::ranges::count_if(entries_, [](const auto& entry) { return entry.second.socket; }));
}

bool ConnectionTable::wait_until_empty(std::chrono::milliseconds most) const {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, most, [&] { return entries_.empty(); });
}

void ConnectionTable::wait_until_empty() const {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return entries_.empty(); });
}

std::size_t ConnectionTable::count(const Choice& chosen) const {
  return static_cast<std::size_t>(std::ranges::count_if(entries_, [&](const auto& numbered) {
    return !numbered.second.leaving && chosen(numbered.second);
  }));
}

std::vector<std::shared_ptr<Connection>> ConnectionTable::choose(const Choice& chosen) const {
  const std::scoped_lock lock(mutex_);
  std::vector<std::shared_ptr<Connection>> connections;
  for (const auto& [number, entry] : entries_) {
    if (!chosen(entry)) continue;
    if (auto connection = entry.connection.lock()) connections.push_back(std::move(connection));
  }
  return connections;
}

}  // namespace roomwise::service
