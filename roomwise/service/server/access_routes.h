#pragma once

#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "roomwise/service/access/access.h"
#include "roomwise/service/credentials/certificate.h"
#include "roomwise/service/server/router.h"

namespace roomwise::service {

// What the routes below need from around them. All are called on worker threads.
struct AccessRoutesContext {
  std::function<Now()> clock = Now::read;
  std::function<std::set<std::int64_t>()> online;  // devices with an open WebSocket
  std::function<void(std::int64_t device)> disconnect;
  // Of the page that a code is typed into, to be shown as text and QR code:
  // "https://HOST:PORT/pair".
  std::function<std::string()> pair_address;
  std::function<std::optional<Authority>()> authority;  // nothing where the home has none
  // The rows of modules ("1011...") of a QR code of a text.
  std::function<std::vector<std::string>(const std::string& text)> qr;
  std::function<void(std::int64_t device, const std::string& name)> renamed =
      [](std::int64_t, const std::string&) {};
};

// GET /api/authority and /authority.crt: what to install so that browsers do not warn.
[[nodiscard]] std::vector<Route> authority_routes(
    std::function<std::optional<Authority>()> authority);

// POST /api/pair, by what lets somebody in.
using RedeemCode = std::function<tl::expected<Pairing, Refusal>(const HttpRequest& request,
                                                                const PairingAttempt&)>;
[[nodiscard]] Route pairing_route(RedeemCode redeem);

// pairing_route(), GET /api/me, POST /api/leave, GET /api/devices, DELETE /api/devices/{device},
// POST /api/codes: who may connect; and authority_routes(); as docs/protocol.md describes them.
[[nodiscard]] std::vector<Route> access_routes(AccessRegister& access, AccessRoutesContext context);

}  // namespace roomwise::service
