#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "roomwise/service/access/account_store.h"
#include "roomwise/service/server/router.h"

namespace roomwise::service {

struct StaffRoutesContext {
  std::function<Now()> clock = Now::read;
  std::function<std::vector<std::string>()> homes;  // that are there, by name
  // Somebody signed out, or may do less: their WebSockets end. On a worker.
  std::function<void(std::int64_t account)> on_signed_out = [](std::int64_t) {};
  std::function<void(std::string_view line)> log = [](std::string_view) {};
};

// POST /api/staff/sign-in and /api/staff/sign-out, GET /api/staff/me: for the staff of who keeps
// many homes, as docs/protocol.md describes them. `accounts` must outlive them.
[[nodiscard]] std::vector<Route> staff_routes(AccountStore& accounts, StaffRoutesContext context);

// Who somebody of the staff is in that home, by the cookie of their session: a device by
// Identity::device_of_account(). Nothing where they may not open it.
[[nodiscard]] Expected<std::optional<Identity>> staff_in_home(AccountStore& accounts,
                                                              const HttpRequest& request,
                                                              const std::string& home,
                                                              const Now& now);

}  // namespace roomwise::service
