#pragma once

#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "roomwise/base/expected.h"
#include "roomwise/service/access/access.h"
#include "roomwise/service/server/router.h"

namespace roomwise::service {

class SocketHandler;

// A home as a server sees it. It stays open as long as somebody holds it.
class ServedHome {
 public:
  virtual ~ServedHome() = default;
  // By which its address and its lines in the log are told apart; empty: the server has no other.
  [[nodiscard]] virtual const std::string& name() const = 0;
  // Who may what, and what answers.
  [[nodiscard]] virtual const Router& router() const = 0;
  // Who that request is from now: nobody where there is no such device any more, say. Asked again
  // right before what the request is for is done. On any thread.
  [[nodiscard]] virtual Expected<std::optional<Identity>> identify(const HttpRequest& /*request*/,
                                                                   const Now& /*now*/) {
    return std::nullopt;  // nobody is known there
  }
  // Where its WebSockets go. Called before each is opened, on a worker: it may take a while, and
  // fails in words for people.
  [[nodiscard]] virtual Expected<SocketHandler*> sockets() = 0;
  // Told of what was done for who is known: of all requests but GET. On a worker.
  virtual void note_done(const HttpRequest& /*request*/, const Route& /*route*/, int /*status*/) {}
};

// A request that found its home.
struct ResolvedRequest {
  std::shared_ptr<ServedHome> home;
  std::string base = {};  // of the request's path: "/homes/flat-7"
  std::optional<Identity> who = {};
};

// The homes behind a port.
class HomesAtPort {
 public:
  virtual ~HomesAtPort() = default;
  // Whose home a request is for and whom it is from, or why that cannot be told. `request` has no
  // body yet.
  [[nodiscard]] virtual std::variant<ResolvedRequest, HttpAnswer> resolve(
      const HttpRequest& request, const Now& now) = 0;
  // Whether resolve() waits for nothing, so that it can be called on the network's thread.
  [[nodiscard]] virtual bool resolves_at_once() const { return false; }
};

// GET /api/socket, which a router needs so that WebSockets can be opened.
[[nodiscard]] Route socket_route();

// A server's only home. What it is given must outlive it.
[[nodiscard]] std::unique_ptr<HomesAtPort> only_home(Router router, AccessRegister& access,
                                                     SocketHandler& sockets);

}  // namespace roomwise::service
