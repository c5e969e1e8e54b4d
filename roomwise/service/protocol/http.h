#pragma once

#include <charconv>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/base/file.h"
#include "roomwise/service/credentials/identity.h"

// Requests and answers as plain values: what handles them needs to know nothing of sockets.
namespace roomwise::service {

struct HttpRequest {
  std::string method;  // "GET"; a HEAD request is handed on as GET
  // As it came, without the query: begins with '/', may hold percent signs ("/api/rooms/a%20b"),
  // all of which can be decoded.
  std::string path;
  // What stood before `path`, where one port serves many homes: "/homes/flat-7"; else empty.
  std::string base = {};
  std::map<std::string, std::string> query;    // decoded
  std::map<std::string, std::string> headers;  // names in small letters
  Bytes body;
  std::string peer;             // address that it comes from, without the port: "192.168.1.7"
  std::optional<Identity> who;  // of a token that is known

  // The header's value (name in small letters), or nothing.
  [[nodiscard]] std::string_view header(const std::string& name) const;
};

struct HttpAnswer {
  int status = 200;
  std::string content_type;  // empty: there is no body
  Bytes body;
  std::vector<std::pair<std::string, std::string>> headers;  // beside those that every answer has
};

[[nodiscard]] HttpAnswer json_answer(const nlohmann::json& json, int status = 200);
[[nodiscard]] HttpAnswer text_answer(std::string_view text, int status = 200);
// {"error": "what is wrong and how to mend it"}; `key`: by which pages have their own words for it.
[[nodiscard]] HttpAnswer error_answer(int status, std::string_view what, std::string_view key = {});
[[nodiscard]] HttpAnswer refusal_answer(const Refusal& refusal);
// To a request that a fault of the program's own broke off.
[[nodiscard]] HttpAnswer internal_error_answer();

// The body as a JSON object, or why it is none.
[[nodiscard]] Expected<nlohmann::json> json_of(const HttpRequest& request);
// Its text of that name; empty where it is missing or no text.
[[nodiscard]] std::string text_member(const nlohmann::json& json, const char* name);

// "a%20b" to "a b"; nothing where a percent sign is not followed by two hexadecimal digits, or
// where a zero byte would come of it.
[[nodiscard]] std::optional<std::string> percent_decoded(std::string_view text);

// The members of "a=1&b=x%20y"; nothing where one of them cannot be decoded.
[[nodiscard]] std::optional<std::map<std::string, std::string>> parse_query(std::string_view text);

// The whole text as a number; nothing where it is none.
template <typename T>
[[nodiscard]] std::optional<T> number_of(std::string_view text) {
  T number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

// The cookie of that name in a Cookie header; nothing where there is none.
[[nodiscard]] std::optional<std::string> cookie_of(std::string_view header, std::string_view name);

}  // namespace roomwise::service
