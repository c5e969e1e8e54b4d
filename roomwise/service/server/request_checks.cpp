#include "roomwise/service/server/request_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

namespace roomwise::service {
namespace {

bool same_text(std::string_view a, std::string_view b) {
  return std::ranges::equal(
      a, b, [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

}  // namespace

bool is_host(std::string_view text) {
  return !text.empty() && text.size() <= 255 && std::ranges::all_of(text, [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '.' || c == '-' || c == '_' || c == ':' || c == '[' ||
           c == ']';
  });
}

std::optional<HttpAnswer> refuse_foreign(const HttpRequest& request) {
  const std::string_view host = request.header("host");
  if (!is_host(host)) return error_answer(400, "the header Host is missing or no host");
  // Browsers say from which page a request comes.
  const auto origin = request.headers.find("origin");
  if (origin != request.headers.end() &&
      !same_text(origin->second, fmt::format("https://{}", host))) {
    return error_answer(403, "requests from pages of other sites are refused");
  }
  // A link that is followed shows what it leads to to nobody but the person.
  const std::string_view site = request.header("sec-fetch-site");
  const bool link = request.header("sec-fetch-mode") == "navigate" && request.method == "GET";
  if ((site == "cross-site" || site == "same-site") && !link) {
    return error_answer(403, "requests from pages of other sites are refused");
  }
  return std::nullopt;
}

std::optional<std::string> token_of(const HttpRequest& request) {
  const std::string_view given = request.header("authorization");
  constexpr std::string_view kBearer = "bearer ";
  if (given.size() > kBearer.size() && same_text(given.substr(0, kBearer.size()), kBearer)) {
    return std::string(given.substr(kBearer.size()));
  }
  return cookie_of(request.header("cookie"), "roomwise");
}

std::vector<std::pair<std::string, std::string>> security_headers(const HttpRequest& request) {
  // Older browsers do not take wss: for 'self'.
  const std::string_view host = request.header("host");
  const std::string sockets = is_host(host) ? fmt::format(" wss://{}", host) : "";
  std::vector<std::pair<std::string, std::string>> headers{
      {"Content-Security-Policy",
       fmt::format("default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: "
                   "data:; media-src 'self' blob:; connect-src 'self'{}; manifest-src 'self'; "
                   "worker-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
                   sockets)},
      {"X-Content-Type-Options", "nosniff"},
      {"X-Frame-Options", "DENY"},
      {"Referrer-Policy", "no-referrer"},
      {"Permissions-Policy",
       "camera=(self), xr-spatial-tracking=(self), microphone=(self), "
       "on-device-speech-recognition=(self), geolocation=()"},
      {"Cross-Origin-Opener-Policy", "same-origin"},
      {"Cross-Origin-Resource-Policy", "same-origin"}};
  return headers;
}

}  // namespace roomwise::service
