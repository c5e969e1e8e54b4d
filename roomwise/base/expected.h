#pragma once

#include <fmt/format.h>

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace roomwise {

// What a program decides by where something failed. Words are for people: no program reads them.
enum class ErrorCode {
  kFailed,       // nothing in particular
  kInterrupted,  // the user asked to stop; what was done till then is kept where the work says so
  kRefused,      // the other side does not let this one in: trying the same again is no use
  kDiskFull,     // there is no room to write; what was written before is kept
  kDamaged,      // what was stored is not what was written
};

// Why something that can fail in normal use failed. The message is one line that names the file,
// line, frame or field that is wrong and how to mend it: "fr1/rgb.txt:3: 'abc' is not a time stamp;
// expected seconds, for example 1305031229.528748".
struct Error {
  std::string message;
  ErrorCode code = ErrorCode::kFailed;

  // The same error seen from further out: "CONTEXT: message".
  Error with_context(std::string_view context) && {
    return Error{fmt::format("{}: {}", context, message), code};
  }
};

// A value, or the Error that says why there is none. (tl::expected has the interface of C++23's
// std::expected, which Debian 12's clang, and with it clang-tidy and libFuzzer, cannot compile.)
template <typename T>
using Expected = tl::expected<T, Error>;
using Unexpected = tl::unexpected<Error>;

// return fail("{}: no such file", path);
template <typename... Args>
[[nodiscard]] Unexpected fail(fmt::format_string<Args...> format, Args&&... args) {
  return Unexpected(Error{fmt::format(format, std::forward<Args>(args)...)});
}

// return fail_with(ErrorCode::kRefused, "{} does not know this device", server);
template <typename... Args>
[[nodiscard]] Unexpected fail_with(ErrorCode code, fmt::format_string<Args...> format,
                                   Args&&... args) {
  return Unexpected(Error{fmt::format(format, std::forward<Args>(args)...), code});
}

}  // namespace roomwise

#define ROOMWISE_CONCAT_(a, b) a##b
#define ROOMWISE_CONCAT(a, b) ROOMWISE_CONCAT_(a, b)

// ROOMWISE_TRY(auto image, decode(bytes));  declares image, or returns decode's error to the
// caller.
#define ROOMWISE_TRY(declaration, expression) \
  ROOMWISE_TRY_(ROOMWISE_CONCAT(expected_, __LINE__), declaration, expression)
#define ROOMWISE_TRY_(temporary, declaration, expression)                      \
  auto temporary = (expression);                                               \
  if (!temporary) return ::roomwise::Unexpected(std::move(temporary).error()); \
  declaration = std::move(*temporary)

// ROOMWISE_RETURN_IF_ERROR(file.write(bytes));  returns the error of an Expected<void> to the
// caller.
#define ROOMWISE_RETURN_IF_ERROR(expression) \
  ROOMWISE_CHECK_OK_(ROOMWISE_CONCAT(status_, __LINE__), expression)
#define ROOMWISE_CHECK_OK_(temporary, expression)                  \
  do {                                                             \
    if (auto temporary = (expression); !temporary)                 \
      return ::roomwise::Unexpected(std::move(temporary).error()); \
  } while (false)
