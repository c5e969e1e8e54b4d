#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "roomwise/service/protocol/http.h"

namespace roomwise::service {

// The values of a route's placeholders, decoded: {"id", "12"} of "/api/things/{id}".
using Placeholders = std::map<std::string, std::string>;

struct Route {
  std::string method;  // HEAD is asked for as "GET" (HttpConnection)
  // Pieces between slashes; a piece in braces stands for any one that is not empty:
  // "/api/recordings/{id}/rooms".
  std::string pattern;
  std::optional<Role> role;  // who may; nothing: everyone
  // Called on any of several threads at once.
  std::function<HttpAnswer(const HttpRequest&, const Placeholders&)> handler;
  std::size_t max_body_bytes = std::size_t{64} << 10U;
  // Whether it goes into the operator's log of what was done: not each piece of a file.
  bool is_audited = true;
};

// A route that was found for a request, with what its placeholders stand for.
struct RouteMatch {
  const Route* route = nullptr;
  Placeholders placeholders;
};

// Which handler a request goes to, and who may: the only place where that is decided.
class Router {
 public:
  // `log` is told, a line each, of handlers that throw; on any thread.
  explicit Router(
      std::vector<Route> routes,
      std::function<void(std::string_view)> log = [](std::string_view) {});

  // The route for this method and path, or the answer why there is none: 401 where the
  // request must say who it is from, 403 where it may not, 404 where there is no such path, 405
  // with Allow where the method is another. Looks at the method, path and who of a request alone,
  // so that a body that is not wanted need not be read.
  [[nodiscard]] std::variant<RouteMatch, HttpAnswer> find(const HttpRequest& request) const;

  // Whether any method has a route for that path.
  [[nodiscard]] bool knows(std::string_view path) const;

  // find(), then the handler. A handler that throws is answered by 500.
  [[nodiscard]] HttpAnswer answer(const HttpRequest& request) const;

  [[nodiscard]] const std::vector<Route>& routes() const { return routes_; }

 private:
  std::vector<Route> routes_;
  std::function<void(std::string_view)> log_;
  std::vector<std::vector<std::string>> pieces_;  // of each route's pattern
};

}  // namespace roomwise::service
