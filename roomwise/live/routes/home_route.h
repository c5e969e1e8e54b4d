#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "roomwise/live/home/live_home.h"
#include "roomwise/service/server/router.h"

namespace roomwise::live {

// A route of a home that need not be open yet: as service::Route, but for what its handler is
// given.
struct HomeRoute {
  std::string method;
  std::string pattern;
  std::optional<service::Role> role;
  std::function<service::HttpAnswer(LiveHome&, const service::HttpRequest&,
                                    const service::Placeholders&)>
      handler;
  std::size_t max_body_bytes = service::Route{}.max_body_bytes;
  bool is_audited = true;
};

}  // namespace roomwise::live
