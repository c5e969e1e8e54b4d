#pragma once

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "roomwise/base/expected.h"

// JSON that came from outside, read without trust: nothing here throws. For source files only.
namespace roomwise::service {

using OrderedJson = nlohmann::ordered_json;

constexpr double kMaxTime_ms = 9e12;                      // 300 years
constexpr double kMaxValidUntil_ms = kMaxTime_ms + 60e3;  // no prompt holds longer
// What a double holds, as JavaScript has it.
constexpr std::int64_t kMaxInteger = std::int64_t{1} << 53U;
constexpr std::size_t kMaxWordBytes = 200;                // of a name, a thing, a room
constexpr std::size_t kMaxKeyBytes = kMaxWordBytes + 50;  // of a prompt: it holds a name
constexpr std::size_t kMaxSentenceBytes = 2'000;

// What a value is called in a message.
template <typename T>
struct Word {
  std::string_view word;
  T value;
};
template <typename Words, typename T>
[[nodiscard]] constexpr std::string_view word_of(const Words& words, T value) {
  for (const auto& one : words) {
    if (one.value == value) return one.word;
  }
  return {};
}

// Reads the members of a JSON object. The first one that is wrong is remembered, by name; what is
// read after it means nothing.
class Members {
 public:
  explicit Members(const OrderedJson& object) : object_(object) {}

  [[nodiscard]] bool has(const char* name) const {
    const auto found = object_.find(name);
    return found != object_.end() && !found->is_null();
  }
  std::string text(const char* name, std::size_t max_bytes = kMaxWordBytes) {
    const OrderedJson* value = member(name);
    if (value == nullptr) return {};
    if (!value->is_string()) return wrong(name, "a text"), std::string();
    auto text = value->get<std::string>();
    if (text.size() > max_bytes) {
      return wrong(name, fmt::format("a text of at most {} bytes", max_bytes)), std::string();
    }
    return text;
  }
  double number(const char* name, double least, double most) {
    const OrderedJson* value = member(name);
    if (value == nullptr) return 0;
    const double number = value->is_number() ? value->get<double>() : std::nan("");
    if (!(number >= least && number <= most)) {
      return wrong(name, fmt::format("a number from {:g} to {:g}", least, most)), 0;
    }
    return number;
  }
  std::int64_t integer(const char* name, std::int64_t least, std::int64_t most) {
    const OrderedJson* value = member(name);
    if (value == nullptr) return 0;
    // JSON does not tell 1000.0 from 1000, and some that write it do not either.
    if (value->is_number_float()) {
      const double number = value->get<double>();
      const bool is_whole = number == std::floor(number) && number >= static_cast<double>(least) &&
                            number <= static_cast<double>(most);
      if (is_whole) return static_cast<std::int64_t>(number);
    }
    const bool fits = value->is_number_unsigned()
                          ? value->get<std::uint64_t>() <= static_cast<std::uint64_t>(most)
                          : value->is_number_integer() && value->get<std::int64_t>() <= most;
    if (!fits || value->get<std::int64_t>() < least) {
      return wrong(name, fmt::format("a whole number from {} to {}", least, most)), 0;
    }
    return value->get<std::int64_t>();
  }
  bool boolean(const char* name) {
    const OrderedJson* value = member(name);
    if (value == nullptr) return false;
    if (!value->is_boolean()) return wrong(name, "true or false"), false;
    return value->get<bool>();
  }
  template <typename T, std::size_t N>
  T one_of(const char* name, const std::array<Word<T>, N>& words) {
    const std::string text = this->text(name);
    if (error_) return {};
    std::string known;
    for (const auto& one : words) {
      if (one.word == text) return one.value;
      known += fmt::format("{}'{}'", known.empty() ? "" : ", ", one.word);
    }
    wrong(name, "one of " + known);
    return {};
  }
  std::vector<std::string> texts(const char* name) {
    std::vector<std::string> all;
    const OrderedJson* value = member(name);
    if (value == nullptr) return all;
    if (!value->is_array()) return wrong(name, "a list of texts"), all;
    for (const OrderedJson& one : *value) {
      if (!one.is_string()) return wrong(name, "a list of texts"), all;
      all.push_back(one.get<std::string>());
    }
    return all;
  }
  // So many numbers, each within the bounds.
  std::vector<double> numbers(const char* name, std::size_t count, double least, double most) {
    const OrderedJson* value = member(name);
    if (value == nullptr) return {};
    std::vector<double> all;
    const bool is_list = value->is_array() && value->size() == count;
    for (std::size_t i = 0; is_list && i < count; ++i) {
      const OrderedJson& one = (*value)[i];
      const double number = one.is_number() ? one.get<double>() : std::nan("");
      if (number >= least && number <= most) all.push_back(number);
    }
    if (all.size() == count) return all;
    wrong(name, fmt::format("a list of {} numbers from {:g} to {:g}", count, least, most));
    return {};
  }
  // An object; nullptr where it is wrong.
  const OrderedJson* object(const char* name) {
    const OrderedJson* value = member(name);
    if (value != nullptr && !value->is_object()) return wrong(name, "an object"), nullptr;
    return value;
  }
  void wrong(const char* name, const std::string& expected) {
    if (!error_) error_ = Error{fmt::format("'{}' must be {}", name, expected)};
  }
  template <typename T>
  [[nodiscard]] Expected<T> finish(T value) {
    if (error_) return Unexpected(std::move(*error_));
    return value;
  }
  [[nodiscard]] const std::optional<Error>& error() const { return error_; }

 private:
  const OrderedJson* member(const char* name) {
    if (error_) return nullptr;
    const auto found = object_.find(name);
    if (found == object_.end()) {
      error_ = Error{fmt::format("'{}' is missing", name)};
      return nullptr;
    }
    return &*found;
  }

  const OrderedJson& object_;
  std::optional<Error> error_;
};

[[nodiscard]] inline Expected<OrderedJson> parse_object(std::string_view text,
                                                        std::size_t max_bytes) {
  if (text.size() > max_bytes) {
    return fail("the message has {} bytes; at most {} are read", text.size(), max_bytes);
  }
  OrderedJson json = OrderedJson::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return fail("the message is no JSON object");
  return json;
}

// JSON of texts that came from outside: bytes that are no UTF-8 become U+FFFD and never an
// exception.
[[nodiscard]] inline std::string dump(const OrderedJson& json) {
  return json.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
}

template <typename T>
[[nodiscard]] OrderedJson or_null(const std::optional<T>& value) {
  return value ? OrderedJson(*value) : OrderedJson(nullptr);
}

}  // namespace roomwise::service
