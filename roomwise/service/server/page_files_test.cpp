#include "roomwise/service/server/page_files.h"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "roomwise/base/testing/testing.h"
#include "roomwise/service/access/rate_limit.h"
#include "roomwise/service/server/request_checks.h"

namespace roomwise::service {
namespace {

class PageFilesTest : public ::testing::Test {
 protected:
  PageFilesTest() {
    std::filesystem::create_directories(folder_ / "pages" / "device");
    for (const char* name : {"index.html", "pair.html", "device/index.html", "app.js", ".hidden"}) {
      EXPECT_OK(write_file(folder_ / "pages" / name, std::string("this is ") + name));
    }
    EXPECT_OK(write_file(folder_ / "secret", "the key"));
    std::filesystem::create_symlink(folder_ / "secret", folder_ / "pages" / "link");
    pages_ = PageFiles::open(folder_ / "pages").value();
  }
  [[nodiscard]] HttpAnswer get(const std::string& path, const std::string& tag = "") const {
    HttpRequest request;
    request.method = "GET";
    request.path = path;
    if (!tag.empty()) request.headers["if-none-match"] = tag;
    return pages_.answer(request);
  }
  [[nodiscard]] std::string text(const std::string& path) const {
    const HttpAnswer answer = get(path);
    return answer.status == 200 ? std::string(answer.body.begin(), answer.body.end()) : "";
  }

  roomwise::testing::ScratchFolder folder_;
  PageFiles pages_ = PageFiles::open("").value();
};

TEST_F(PageFilesTest, AreFoundByShortNames) {
  EXPECT_EQ(text("/"), "this is index.html");
  EXPECT_EQ(text("/pair"), "this is pair.html");
  EXPECT_EQ(text("/device/"), "this is device/index.html");
  EXPECT_EQ(text("/app%2Ejs"), "this is app.js");
  EXPECT_EQ(get("/app.js").content_type, "text/javascript; charset=utf-8");
  EXPECT_EQ(get("/pair").content_type, "text/html; charset=utf-8");
}

TEST_F(PageFilesTest, LieInAFolderWhoseAddressEndsWithASlash) {
  const HttpAnswer answer = get("/device");
  EXPECT_EQ(answer.status, 308);
  ASSERT_EQ(answer.headers.size(), 1U);
  EXPECT_EQ(answer.headers[0], (std::pair<std::string, std::string>("Location", "/device/")));
  EXPECT_EQ(text("/device/index.html"), "this is device/index.html");
}

TEST_F(PageFilesTest, AreAllThatIsRead) {
  for (const char* path :
       {"/../secret",   "/..%2fsecret",   "/%2e%2e/secret",  "/device/../../secret",
        "/./../secret", "//../secret",    "/..\\secret",     "/..%5csecret",
        "/link",        "/.hidden",       "/%2ehidden",      "/device/../index.html",
        "//etc/passwd", "/%2Fetc/passwd", "/app.js%00.html", "/C:/x",
        "/app.js/x",    "/nothing",       "nothing",         ""}) {
    EXPECT_EQ(get(path).status, 404) << path;
  }
}

TEST_F(PageFilesTest, AreSentOnce) {
  const HttpAnswer first = get("/app.js");
  ASSERT_EQ(first.headers[0].first, "ETag");
  EXPECT_EQ(first.headers[1], (std::pair<std::string, std::string>("Cache-Control", "no-cache")));
  const HttpAnswer again = get("/app.js", first.headers[0].second);
  EXPECT_EQ(again.status, 304);
  EXPECT_TRUE(again.body.empty());
  EXPECT_EQ(get("/pair", first.headers[0].second).status, 200);
}

TEST(RateLimitTest, LetsThroughWhatItSays) {
  RateLimit limit(2, 0.5);
  EXPECT_TRUE(limit.take("a", 0));
  EXPECT_TRUE(limit.take("a", 0));
  EXPECT_FALSE(limit.take("a", 0));
  EXPECT_TRUE(limit.take("b", 0));
  EXPECT_FALSE(limit.take("a", 1.9));
  EXPECT_TRUE(limit.take("a", 4));
  EXPECT_TRUE(limit.take("a", 4));
  EXPECT_FALSE(limit.take("a", 3));  // a clock that goes back gives nothing
}

TEST(RateLimitTest, HoldsSoManyKeys) {
  RateLimit limit(2, 1);
  for (int i = 0; i < 10'000; ++i) (void)limit.take(std::to_string(i), 0);
  EXPECT_LE(limit.keys(), 4096u);
  EXPECT_FALSE(limit.take("one more", 0));
  EXPECT_TRUE(limit.take("one more", 10));
}

// A computer may have any address of its network of IPv6.
TEST(RateLimitTest, AnIpv6NetworkCountsAsOneAddress) {
  EXPECT_EQ(peer_key("2001:db8:1:2::7"), "2001:db8:1:2::/64");
  EXPECT_EQ(peer_key("2001:DB8:1:2:ffff:eeee:dddd:1"), "2001:db8:1:2::/64");
  EXPECT_EQ(peer_key("fe80::1%eth0"), "fe80::/64");
  EXPECT_EQ(peer_key("2001:db8:1:3::7"), "2001:db8:1:3::/64");
  EXPECT_EQ(peer_key("10.0.0.7"), "10.0.0.7");
  EXPECT_EQ(peer_key("::ffff:10.0.0.7"), "10.0.0.7");
  EXPECT_EQ(peer_key("2001:db8:1:2::/64"), "2001:db8:1:2::/64");
  EXPECT_EQ(peer_key("nobody"), "nobody");
}

TEST(HttpTextTest, IsDecoded) {
  EXPECT_EQ(percent_decoded("a%20b%C3%A4"), "a bä");
  EXPECT_FALSE(percent_decoded("%"));
  EXPECT_FALSE(percent_decoded("%4"));
  EXPECT_FALSE(percent_decoded("%+4"));
  EXPECT_FALSE(percent_decoded("a%00"));
  EXPECT_EQ(parse_query("a=1&b=x%26y&c")->at("b"), "x&y");
  EXPECT_EQ(cookie_of("a=b; roomwise=x=y; c", "roomwise"), "x=y");
  EXPECT_FALSE(cookie_of("notroomwise=1", "roomwise"));
  HttpRequest request;
  const auto json = [&](std::string text) {
    request.body = Bytes(text.begin(), text.end());
    return json_of(request);
  };
  EXPECT_OK(json("{\"a\": 1}"));
  EXPECT_ERROR(json("{"), "not JSON");
  EXPECT_ERROR(json("[1]"), "JSON object");
  EXPECT_ERROR(json("{\"a\":" + std::string(10'000, '[')), "too deeply");
  request.headers["authorization"] = "bearer abc";
  request.headers["cookie"] = "roomwise=def";
  EXPECT_EQ(token_of(request), "abc");
}

}  // namespace
}  // namespace roomwise::service
