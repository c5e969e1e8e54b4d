#include "roomwise/service/protocol/http.h"

#include <charconv>
#include <nlohmann/json.hpp>

namespace roomwise::service {
namespace {

std::optional<char> hex_byte(std::string_view two_digits) {
  unsigned value = 0;
  const char* end = two_digits.data() + two_digits.size();
  const auto read = std::from_chars(two_digits.data(), end, value, 16);
  if (two_digits.size() != 2 || read.ec != std::errc() || read.ptr != end) return std::nullopt;
  return static_cast<char>(value);
}

// Cuts what comes before the first separator off `text`.
std::string_view cut(std::string_view& text, char separator) {
  const std::size_t end = text.find(separator);
  const std::string_view piece = text.substr(0, end);
  text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
  return piece;
}

}  // namespace

std::string_view HttpRequest::header(const std::string& name) const {
  const auto found = headers.find(name);
  return found == headers.end() ? std::string_view() : found->second;
}

HttpAnswer json_answer(const nlohmann::json& json, int status) {
  // Text from elsewhere that is no UTF-8 is shown with replacement characters, not thrown about.
  const std::string text = json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  return {status, "application/json", Bytes(text.begin(), text.end()), {}};
}

HttpAnswer text_answer(std::string_view text, int status) {
  return {status, "text/plain; charset=utf-8", Bytes(text.begin(), text.end()), {}};
}

HttpAnswer error_answer(int status, std::string_view what, std::string_view key) {
  nlohmann::json json{{"error", what}};
  if (!key.empty()) json["message"] = key;
  return json_answer(json, status);
}

HttpAnswer refusal_answer(const Refusal& refusal) {
  HttpAnswer answer = error_answer(refusal.status, refusal.message, refusal.key);
  if (refusal.wait_s > 0) {
    answer.headers.emplace_back("Retry-After", fmt::format("{}", refusal.wait_s));
  }
  return answer;
}

HttpAnswer internal_error_answer() {
  return error_answer(500, "the computer made a mistake with this request; it goes on", "fault");
}

Expected<nlohmann::json> json_of(const HttpRequest& request) {
  // Deep nesting would overflow the stack where the value is destroyed.
  constexpr int kDeepest = 32;
  bool too_deep = false;
  const auto watch = [&](int depth, nlohmann::json::parse_event_t, nlohmann::json&) {
    too_deep = too_deep || depth > kDeepest;
    return !too_deep;
  };
  nlohmann::json json =
      nlohmann::json::parse(request.body.begin(), request.body.end(), watch, false);
  if (too_deep) return fail("the JSON is nested too deeply");
  if (json.is_discarded()) return fail("the body is not JSON");
  if (!json.is_object()) return fail("the body must be a JSON object, {{...}}");
  return json;
}

std::string text_member(const nlohmann::json& json, const char* name) {
  const auto found = json.find(name);
  return found != json.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::optional<std::string> percent_decoded(std::string_view text) {
  std::string decoded;
  decoded.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    char c = text[i];
    if (c == '%') {
      const std::optional<char> byte = hex_byte(text.substr(i + 1, 2));
      if (!byte) return std::nullopt;
      c = *byte;
      i += 2;
    }
    if (c == '\0') return std::nullopt;
    decoded += c;
  }
  return decoded;
}

std::optional<std::map<std::string, std::string>> parse_query(std::string_view text) {
  std::map<std::string, std::string> members;
  while (!text.empty()) {
    std::string_view value = cut(text, '&');
    const std::optional<std::string> name = percent_decoded(cut(value, '='));
    const std::optional<std::string> decoded = percent_decoded(value);
    if (!name || !decoded) return std::nullopt;
    if (!name->empty()) members[*name] = *decoded;
  }
  return members;
}

std::optional<std::string> cookie_of(std::string_view header, std::string_view name) {
  while (!header.empty()) {
    std::string_view value = cut(header, ';');
    while (value.starts_with(' ')) value.remove_prefix(1);
    if (cut(value, '=') == name) return std::string(value);
  }
  return std::nullopt;
}

}  // namespace roomwise::service
