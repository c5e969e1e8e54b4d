#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "roomwise/service/protocol/http.h"

namespace roomwise::service {

// "roomwise.local:8443": a host name or address with a port or none, and nothing else.
[[nodiscard]] bool is_host(std::string_view text);

// Why a request is refused whatever it asks for: no proper Host, or a page of another origin sent
// it.
[[nodiscard]] std::optional<HttpAnswer> refuse_foreign(const HttpRequest& request);

// What the request shows to say who it is from: the bearer token, else the cookie "roomwise".
[[nodiscard]] std::optional<std::string> token_of(const HttpRequest& request);

// The headers that every answer has: what a page may load, that nobody guesses types, frames it or
// keeps what /api answers. Not Strict-Transport-Security: with a certificate that no authority
// signed it would lock people out.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> security_headers(
    const HttpRequest& request);

}  // namespace roomwise::service
