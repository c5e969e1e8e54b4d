#include "roomwise/service/server/router.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>

namespace roomwise::service {
namespace {

bool is_placeholder(std::string_view piece) {
  return piece.size() > 2 && piece.front() == '{' && piece.back() == '}';
}

// The pieces between slashes, decoded each for itself: "%2F" is no slash. HttpConnection has
// refused paths that cannot be decoded.
std::vector<std::string> split(std::string_view path) {
  std::vector<std::string> pieces;
  while (!path.empty()) {
    path.remove_prefix(1);  // the slash
    const std::size_t end = std::min(path.find('/'), path.size());
    pieces.push_back(percent_decoded(path.substr(0, end)).value_or(""));
    path.remove_prefix(end);
  }
  return pieces;
}

// What the placeholders stand for where `path` fits `pattern`.
std::optional<Placeholders> matched(const std::vector<std::string>& pattern,
                                    const std::vector<std::string>& path) {
  if (pattern.size() != path.size()) return std::nullopt;
  Placeholders values;
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    if (is_placeholder(pattern[i]) && !path[i].empty()) {
      values[pattern[i].substr(1, pattern[i].size() - 2)] = path[i];
    } else if (pattern[i] != path[i]) {
      return std::nullopt;
    }
  }
  return values;
}

HttpAnswer not_allowed(const std::string& method, const std::string& allowed) {
  HttpAnswer answer =
      error_answer(405, fmt::format("{} is not possible here; possible: {}", method, allowed));
  answer.headers.emplace_back("Allow", allowed);
  return answer;
}

HttpAnswer refused(const HttpRequest& request, Role role) {
  if (!request.who) {
    HttpAnswer answer =
        error_answer(401, "this needs a paired device: pair it with a code first", "not_paired");
    answer.headers.emplace_back("WWW-Authenticate", "Bearer");
    return answer;
  }
  return error_answer(403,
                      fmt::format("this needs the role '{}', and '{}' has the role '{}'",
                                  to_string(role), request.who->name, to_string(request.who->role)),
                      "not_for_role");
}

}  // namespace

Router::Router(std::vector<Route> routes, std::function<void(std::string_view)> log)
    : routes_(std::move(routes)), log_(std::move(log)) {
  for (const Route& route : routes_) pieces_.push_back(split(route.pattern));
}

std::variant<RouteMatch, HttpAnswer> Router::find(const HttpRequest& request) const {
  const std::vector<std::string> path = split(request.path);
  std::string allowed;
  for (std::size_t i = 0; i < routes_.size(); ++i) {
    std::optional<Placeholders> placeholders = matched(pieces_[i], path);
    if (!placeholders) continue;
    const Route& route = routes_[i];
    if (route.method != request.method) {
      allowed += (allowed.empty() ? "" : ", ") + route.method;
      if (route.method == "GET") allowed += ", HEAD";
      continue;
    }
    if (!may(request.who, route.role)) return refused(request, *route.role);
    return RouteMatch{&route, *std::move(placeholders)};
  }
  if (!allowed.empty()) return not_allowed(request.method, allowed);
  return error_answer(404, "there is nothing under this address");
}

bool Router::knows(std::string_view path) const {
  const std::vector<std::string> pieces = split(path);
  return std::ranges::any_of(
      pieces_, [&](const auto& pattern) { return matched(pattern, pieces).has_value(); });
}

HttpAnswer Router::answer(const HttpRequest& request) const {
  std::variant<RouteMatch, HttpAnswer> found = find(request);
  if (auto* answer = std::get_if<HttpAnswer>(&found)) return std::move(*answer);
  const auto& match = std::get<RouteMatch>(found);
  try {
    return match.route->handler(request, match.placeholders);
  } catch (const std::exception& fault) {
    // What went wrong may name files or other people's things: it is not for whoever asks.
    log_(fmt::format("{} {} went wrong: {}", request.method, match.route->pattern, fault.what()));
    return internal_error_answer();
  }
}

}  // namespace roomwise::service
