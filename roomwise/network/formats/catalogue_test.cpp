#include "roomwise/network/formats/catalogue.h"

#include <gmock/gmock.h>

#include "roomwise/base/testing/testing.h"

namespace roomwise::network {
namespace {

std::string entry(const std::string& more = "", const std::string& address = "https://a.b/n.onnx",
                  const std::string& file = "n.onnx") {
  return fmt::format(
      R"([{{"name": "n", "file": "{}", "address": "{}", "license": "MIT", "about": "x"{}}}])", file,
      address, more);
}

TEST(Catalogue, ThatIsBuiltInCanBeRead) {
  EXPECT_GE(catalogue().size(), 5u);
  for (const CatalogueEntry& published : catalogue()) {
    // torchvision puts the digest's beginning into the name.
    if (!published.file.ends_with(".pth")) continue;
    EXPECT_NE(published.file.find("-" + published.sha256_begin + ".pth"), std::string::npos);
  }
}

TEST(Catalogue, ReadsAnEntry) {
  const auto read = parse_catalogue(
      entry(R"(, "bytes": 12, "sha256_begin": "0123abcd", "digest_from": "the name")"), "c.json");
  ASSERT_OK(read);
  EXPECT_EQ(read->front().bytes, 12u);
  EXPECT_EQ(read->front().sha256_begin, "0123abcd");
  EXPECT_EQ(parse_catalogue(entry(), "c.json")->front().bytes, std::nullopt);
}

TEST(Catalogue, NamesWhatIsWrong) {
  const auto error = [](const std::string& json) { return parse_catalogue(json, "c.json"); };
  EXPECT_ERROR(error("{}"), "c.json: is not a JSON list");
  EXPECT_ERROR(error("[3]"), "c.json: entry 1: expected {");
  EXPECT_ERROR(error(entry(R"(, "size": 3)")), "entry 1.size: unknown field");
  EXPECT_ERROR(error(entry(R"(, "bytes": -3)")), "entry 1.bytes: expected a whole number");
  EXPECT_ERROR(error(entry(R"(, "sha256_begin": "0123")")), "8 to 64");
  EXPECT_ERROR(error(entry(R"(, "sha256_begin": "0123ABCD")")), "8 to 64");
  EXPECT_ERROR(error(entry(R"(, "digest_from": "me")")), "without the other");
  EXPECT_ERROR(error(entry("", "http://a.b/n.onnx")), "expected an https address");
  EXPECT_ERROR(error(entry("", "https://a.b", "../n.onnx")), "no file's name");
  EXPECT_ERROR(error(R"([{"name": "n"}])"), "entry 1.file: expected a text");
  std::string twice = entry();
  twice.insert(twice.size() - 1, ", " + twice.substr(1, twice.size() - 2));
  EXPECT_ERROR(error(twice), "entry 2: n (n.onnx) stands there twice");
}

}  // namespace
}  // namespace roomwise::network
