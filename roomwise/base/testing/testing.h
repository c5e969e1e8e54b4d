#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

// What tests share. Not part of the product.
namespace roomwise::testing {

// A folder of the test's own that is gone at its end.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string pattern =
        (std::filesystem::temp_directory_path() / "roomwise-test-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) std::abort();
    path_ = pattern;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::filesystem::path& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

// A real recording or photo folder NAME under ROOMWISE_DATA, a network NAME under ROOMWISE_MODELS;
// absent where the machine has none (the caller then skips with ROOMWISE_REQUIRE_FILE's message).
inline std::optional<std::filesystem::path> find_in(const char* variable, const std::string& name) {
  const char* root = std::getenv(variable);
  if (root == nullptr) return std::nullopt;
  std::filesystem::path path = std::filesystem::path(root) / name;
  if (!std::filesystem::exists(path)) return std::nullopt;
  return path;
}
inline auto find_data(const std::string& name) {
  return find_in("ROOMWISE_DATA", name);
}
inline auto find_model(const std::string& name) {
  return find_in("ROOMWISE_MODELS", name);
}

}  // namespace roomwise::testing

// const auto recording = ...find_data("office_walk"); ROOMWISE_REQUIRE_FILE(recording);
#define ROOMWISE_REQUIRE_FILE(path) \
  if (!(path))                      \
  GTEST_SKIP() << "set ROOMWISE_DATA and ROOMWISE_MODELS to the folders of real data and networks"

// ASSERT that an Expected holds a value, printing its error otherwise.
#define ASSERT_OK(expected) ASSERT_TRUE((expected).has_value()) << (expected).error().message
#define EXPECT_OK(expected) EXPECT_TRUE((expected).has_value()) << (expected).error().message
// EXPECT that an Expected holds an error whose message contains `text`.
#define EXPECT_ERROR(expected, text)                                   \
  do {                                                                 \
    const auto& checked_ = (expected);                                 \
    ASSERT_FALSE(checked_.has_value()) << "expected an error";         \
    EXPECT_THAT(checked_.error().message, ::testing::HasSubstr(text)); \
  } while (false)
