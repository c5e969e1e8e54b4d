#include "roomwise/download/https_download.h"

#include <gmock/gmock.h>

#include <csignal>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/download/testing/test_server.h"

namespace roomwise::download {
namespace {

using ::testing::HasSubstr;
using testing::Reply;
using testing::Request;
using testing::TestServer;

std::string made_up_file(std::size_t size) {
  std::string file(size, '\0');
  for (std::size_t i = 0; i < size; ++i) file[i] = static_cast<char>(i * 2654435761U >> 13);
  return file;
}

std::string sha256_of(const std::string& text) {
  return sha256_hex(Bytes(text.begin(), text.end()));
}

std::string whole(const std::string& body, const std::string& more_headers = "") {
  return fmt::format("HTTP/1.1 200 OK\r\nContent-Length: {}\r\n{}Connection: close\r\n\r\n{}",
                     body.size(), more_headers, body);
}

// As a good server with ETags answers.
Reply serve(const Request& request, const std::string& file, const std::string& etag) {
  const std::string tag = "ETag: " + etag + "\r\n";
  const std::string range = request.value("Range");
  if (range.empty() || request.value("If-Range") != etag) return {whole(file, tag)};
  const std::size_t first = std::stoul(range.substr(range.find('=') + 1));
  if (first >= file.size()) {
    return {"HTTP/1.1 416 Range Not Satisfiable\r\nContent-Length: 0\r\n\r\n"};
  }
  return {fmt::format(
      "HTTP/1.1 206 Partial Content\r\nContent-Length: {}\r\n{}Content-Range: bytes "
      "{}-{}/{}\r\nConnection: close\r\n\r\n{}",
      file.size() - first, tag, first, file.size() - 1, file.size(), file.substr(first))};
}

class DownloadTest : public ::testing::Test {
 protected:
  void SetUp() override { std::signal(SIGPIPE, SIG_IGN); }
  Expected<FetchedFile> get(const TestServer& server, const std::string& path = "/net.onnx") {
    server.write_certificate(folder_ / "trusted.pem");
    options_.certificates = folder_ / "trusted.pem";
    return download(server.url(path), target_, expected_, progress_, options_);
  }
  [[nodiscard]] bool exists(const std::string& name) const {
    return std::filesystem::exists(folder_ / name);
  }

  ::roomwise::testing::ScratchFolder folder_;
  std::filesystem::path target_ = folder_ / "networks" / "net.onnx";
  std::string file_ = made_up_file(200'000);
  ExpectedFile expected_{200'000, sha256_of(file_)};
  DownloadOptions options_;
  SilentProgress progress_;
};

TEST_F(DownloadTest, FetchesAFile) {
  const TestServer server([&](const Request& request) { return serve(request, file_, "\"1\""); });
  const auto fetched = get(server);
  ASSERT_OK(fetched);
  EXPECT_EQ(fetched->bytes, 200'000u);
  EXPECT_EQ(fetched->sha256, sha256_of(file_));
  EXPECT_EQ(read_text_file(target_).value(), file_);
  EXPECT_EQ(server.requests().at(0).path(), "/net.onnx");
  EXPECT_FALSE(exists("networks/net.onnx.part"));
  EXPECT_FALSE(exists("networks/net.onnx.part.etag"));
}

TEST_F(DownloadTest, GoesOnAfterABrokenConnection) {
  std::atomic<int> tries = 0;
  const TestServer server([&](const Request& request) {
    Reply reply = serve(request, file_, "\"1\"");
    if (++tries == 1) reply.bytes.resize(reply.bytes.size() / 2);
    return reply;
  });
  EXPECT_ERROR(get(server), "try again");
  EXPECT_FALSE(exists("networks/net.onnx"));
  EXPECT_TRUE(exists("networks/net.onnx.part"));
  const auto fetched = get(server);
  ASSERT_OK(fetched);
  EXPECT_GT(fetched->resumed_from, 0u);
  EXPECT_LT(fetched->resumed_from, 200'000u);
  EXPECT_EQ(read_text_file(target_).value(), file_);
  EXPECT_EQ(server.requests().at(1).value("Range"),
            fmt::format("bytes={}-", fetched->resumed_from));
}

TEST_F(DownloadTest, BeginsAnewWhereTheFileHasChanged) {
  std::atomic<int> tries = 0;
  const std::string old(200'000, 'x');
  const TestServer server([&](const Request& request) {
    if (++tries > 1) return serve(request, file_, "\"2\"");
    Reply reply = serve(request, old, "\"1\"");
    reply.bytes.resize(100'000);
    return reply;
  });
  EXPECT_ERROR(get(server), "try again");
  const auto fetched = get(server);
  ASSERT_OK(fetched);
  EXPECT_EQ(fetched->resumed_from, 0u);
  EXPECT_EQ(read_text_file(target_).value(), file_);
}

TEST_F(DownloadTest, BeginsAnewWhereTheServerKnowsNoParts) {
  std::atomic<int> tries = 0;
  const TestServer server([&](const Request&) {
    Reply reply{whole(file_, "ETag: \"1\"\r\n")};
    if (++tries == 1) reply.bytes.resize(100'000);
    return reply;
  });
  EXPECT_ERROR(get(server), "try again");
  ASSERT_OK(get(server));
  EXPECT_EQ(read_text_file(target_).value(), file_);
}

TEST_F(DownloadTest, DoesNotGoOnWithoutAnEtag) {
  std::atomic<int> tries = 0;
  const TestServer server([&](const Request& request) {
    EXPECT_EQ(request.value("Range"), "");
    Reply reply{whole(file_, "ETag: W/\"weak\"\r\n")};
    if (++tries == 1) reply.bytes.resize(100'000);
    return reply;
  });
  EXPECT_ERROR(get(server), "try again");
  ASSERT_OK(get(server));
}

TEST_F(DownloadTest, RefusesAnotherPartThanItAskedFor) {
  std::atomic<int> tries = 0;
  const TestServer server([&](const Request& request) {
    Reply reply = serve(request, file_, "\"1\"");
    if (++tries == 1) reply.bytes.resize(100'000);
    if (tries == 2) reply.bytes.replace(reply.bytes.find("bytes ") + 6, 1, "1");
    return reply;
  });
  EXPECT_ERROR(get(server), "try again");
  EXPECT_ERROR(get(server), "another part of the file");
  ASSERT_OK(get(server));
  EXPECT_EQ(read_text_file(target_).value(), file_);
}

TEST_F(DownloadTest, AShorterAnswerThanTheRestIsNotTheWholeFile) {
  std::atomic<int> tries = 0;
  const TestServer server([&](const Request& request) {
    Reply reply = serve(request, file_, "\"1\"");
    ++tries;
    if (tries == 1) reply.bytes.resize(100'000);
    if (tries != 2) return reply;
    const std::size_t first = std::stoul(request.value("Range").substr(6));
    return Reply{
        fmt::format("HTTP/1.1 206 Partial Content\r\nContent-Length: 1000\r\nContent-Range: bytes "
                    "{}-{}/200000\r\nConnection: close\r\n\r\n{}",
                    first, first + 999, file_.substr(first, 1000))};
  });
  expected_ = {};  // nothing else would tell
  EXPECT_ERROR(get(server), "try again");
  const auto had = std::filesystem::file_size(folder_ / "networks/net.onnx.part");
  EXPECT_ERROR(get(server), fmt::format("first {} of 200000 bytes", had + 1000));
  EXPECT_FALSE(exists("networks/net.onnx"));
  const auto fetched = get(server);
  ASSERT_OK(fetched);
  EXPECT_EQ(fetched->resumed_from, had + 1000);
  EXPECT_EQ(read_text_file(target_).value(), file_);
}

TEST_F(DownloadTest, APartOfAFileOfUnknownLengthIsRefused) {
  std::atomic<int> tries = 0;
  const TestServer server([&](const Request& request) {
    Reply reply = serve(request, file_, "\"1\"");
    if (++tries == 1) reply.bytes.resize(100'000);
    if (tries == 2) reply.bytes.replace(reply.bytes.find("/200000"), 7, "/*");
    return reply;
  });
  EXPECT_ERROR(get(server), "try again");
  EXPECT_ERROR(get(server), "another part of the file");
  ASSERT_OK(get(server));
}

TEST_F(DownloadTest, TwoDoNotWriteTheSamePart) {
  std::string second;
  const TestServer server([&](const Request& request) {
    const auto fetched = download("https://127.0.0.1:9/", target_, expected_, progress_);
    if (!fetched) second = fetched.error().message;
    return serve(request, file_, "\"1\"");
  });
  ASSERT_OK(get(server));
  EXPECT_THAT(second, HasSubstr("another program is fetching it"));
  EXPECT_EQ(read_text_file(target_).value(), file_);
}

TEST_F(DownloadTest, BeginsAnewWhereNothingIsLeftToFetch) {
  std::atomic<int> tries = 0;
  const TestServer server([&](const Request& request) {
    const std::string longer = file_ + file_;
    ++tries;
    if (tries == 1) {
      Reply reply = serve(request, longer, "\"1\"");
      reply.bytes.resize(350'000);
      return reply;
    }
    return serve(request, file_, "\"1\"");  // a server whose ETag lies
  });
  expected_.bytes.reset();
  EXPECT_ERROR(get(server), "try again");
  ASSERT_OK(get(server));
  EXPECT_EQ(tries, 3);
  EXPECT_EQ(read_text_file(target_).value(), file_);
}

TEST_F(DownloadTest, WhatIsAllThereIsNotFetchedAgain) {
  const TestServer server([&](const Request& request) { return serve(request, file_, "\"1\""); });
  for (const bool knows_bytes : {true, false}) {
    SCOPED_TRACE(knows_bytes);
    if (!knows_bytes) expected_.bytes.reset();
    std::filesystem::remove(target_);
    options_.before_naming = [](const FetchedFile&) -> Expected<void> { return fail("no name"); };
    EXPECT_ERROR(get(server), "no name");
    options_.before_naming = {};
    const std::size_t requests = server.requests().size();
    const auto fetched = get(server);
    ASSERT_OK(fetched);
    EXPECT_EQ(fetched->resumed_from, 200'000u);
    EXPECT_EQ(read_text_file(target_).value(), file_);
    // Without the length the server has to be asked whether more is to come.
    EXPECT_EQ(server.requests().size(), requests + (knows_bytes ? 0 : 1));
  }
}

TEST_F(DownloadTest, WhatHasTheLengthAloneIsFetched) {
  const TestServer server([&](const Request& request) { return serve(request, file_, "\"1\""); });
  std::filesystem::create_directories(target_.parent_path());
  ASSERT_OK(write_file(target_.string() + ".part", std::string(200'000, 'x')));
  const auto fetched = get(server);
  ASSERT_OK(fetched);
  EXPECT_EQ(fetched->resumed_from, 0u);
  EXPECT_EQ(read_text_file(target_).value(), file_);
}

TEST_F(DownloadTest, KeepsNothingWrong) {
  std::string wrong = file_;
  wrong[77'777] ^= 1;
  const TestServer server([&](const Request& request) { return serve(request, wrong, "\"1\""); });
  EXPECT_ERROR(get(server), "expected " + sha256_of(file_));
  EXPECT_FALSE(exists("networks/net.onnx"));
  EXPECT_FALSE(exists("networks/net.onnx.part"));
  // The first digits of a digest, as torchvision's names carry them, tell as much.
  expected_.sha256_begin = sha256_of(file_).substr(0, 8);
  EXPECT_ERROR(get(server), "expected " + expected_.sha256_begin + "...");
  expected_.sha256_begin = sha256_of(wrong).substr(0, 8);
  EXPECT_OK(get(server));
}

TEST_F(DownloadTest, AFailedTryLeavesTheOldFile) {
  std::filesystem::create_directories(target_.parent_path());
  ASSERT_OK(write_file(target_, "old"));
  const TestServer server([&](const Request&) { return Reply{whole(std::string(200'000, 'x'))}; });
  EXPECT_ERROR(get(server), "SHA-256");
  EXPECT_EQ(read_text_file(target_).value(), "old");
}

TEST_F(DownloadTest, RefusesAnotherLength) {
  const TestServer shorter([&](const Request&) { return Reply{whole(file_.substr(1))}; });
  EXPECT_ERROR(get(shorter), "199999 bytes; expected 200000");
  const TestServer longer([&](const Request&) { return Reply{whole(file_ + "x")}; });
  EXPECT_ERROR(get(longer), "200001 bytes; expected 200000");
  // One that does not say how much it sends, and does not stop.
  const TestServer endless([&](const Request&) {
    return Reply{"HTTP/1.1 200 OK\r\nConnection: close\r\n\r\n" + file_ + file_};
  });
  EXPECT_ERROR(get(endless), "larger than 200000 bytes");
  EXPECT_FALSE(exists("networks/net.onnx.part"));
  expected_ = {};
  options_.max_bytes = 150'000;
  EXPECT_ERROR(get(endless), "larger than 150000 bytes");
  EXPECT_ERROR(get(shorter), "larger than 150000 bytes");
  // One that ends early and does not say so is found out by the digest.
  const TestServer silent([&](const Request&) {
    return Reply{"HTTP/1.1 200 OK\r\nConnection: close\r\n\r\n" + file_.substr(0, 1000)};
  });
  expected_ = {200'000, sha256_of(file_)};
  EXPECT_ERROR(get(silent), "expected 200000");
  EXPECT_FALSE(exists("networks/net.onnx"));
}

TEST_F(DownloadTest, KeepsNoPartOfAFileOfAnotherLength) {
  std::atomic<int> tries = 0;
  const TestServer server([&](const Request& request) {
    Reply reply = serve(request, file_, "\"1\"");
    if (++tries == 1) reply.bytes.resize(100'000);
    return reply;
  });
  EXPECT_ERROR(get(server), "try again");
  EXPECT_TRUE(exists("networks/net.onnx.part"));
  expected_.bytes = 150'000;
  EXPECT_ERROR(get(server), "200000 bytes; expected 150000");
  EXPECT_FALSE(exists("networks/net.onnx.part"));
  EXPECT_FALSE(exists("networks/net.onnx.part.etag"));
}

TEST_F(DownloadTest, FollowsToHttpsOnly) {
  const auto to = [](const std::string& address) {
    return Reply{"HTTP/1.1 302 Found\r\nLocation: " + address +
                 "\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"};
  };
  const TestServer server([&](const Request& request) {
    if (request.path() == "/moved") return to("/net.onnx");
    if (request.path() == "/plain") return to("http://127.0.0.1:9/net.onnx");
    if (request.path() == "/disk") return to("file:///etc/hostname");
    if (request.path() == "/circle") return to("/circle");
    return serve(request, file_, "\"1\"");
  });
  EXPECT_ERROR(get(server, "/plain"), "not https");
  EXPECT_ERROR(get(server, "/disk"), "not https");
  EXPECT_ERROR(get(server, "/circle"), "redirects");
  EXPECT_OK(get(server, "/moved"));
  EXPECT_ERROR(download("http://127.0.0.1/net.onnx", target_, {}, progress_),
               "not an https address");
}

TEST_F(DownloadTest, GivesUpWhereNothingComes) {
  const TestServer server([&](const Request& request) {
    Reply reply = serve(request, file_, "\"1\"");
    reply.bytes.resize(1000);
    reply.stall_after = true;
    return reply;
  });
  options_.stall_timeout_s = 1;
  EXPECT_ERROR(get(server), "stalled");
}

TEST_F(DownloadTest, TrustsNoUnknownCertificate) {
  const TestServer server([&](const Request& request) { return serve(request, file_, "\"1\""); });
  const TestServer other([&](const Request& request) { return serve(request, file_, "\"1\""); });
  other.write_certificate(folder_ / "other.pem");
  options_.certificates = folder_ / "other.pem";
  EXPECT_ERROR(download(server.url("/"), target_, expected_, progress_, options_), "certificate");
  EXPECT_TRUE(server.requests().empty());
}

TEST_F(DownloadTest, SaysWhatTheServerAnswers) {
  const TestServer server([](const Request&) {
    return Reply{"HTTP/1.1 404 Not Found\r\nContent-Length: 2\r\nConnection: close\r\n\r\nno"};
  });
  EXPECT_ERROR(get(server), "404");
  EXPECT_FALSE(exists("networks/net.onnx.part"));
}

TEST_F(DownloadTest, CanBeInterrupted) {
  class Stop final : public Progress {
   public:
    void begin(std::string_view, std::optional<std::uint64_t>) override {}
    void advance(std::uint64_t, std::string_view) override {}
    void end() override {}
    [[nodiscard]] bool interrupted() const override { return true; }
  } stop;
  const TestServer server([&](const Request& request) { return serve(request, file_, "\"1\""); });
  server.write_certificate(folder_ / "trusted.pem");
  options_.certificates = folder_ / "trusted.pem";
  EXPECT_ERROR(download(server.url("/"), target_, expected_, stop, options_), "interrupted");
  EXPECT_FALSE(exists("networks/net.onnx"));
}

TEST_F(DownloadTest, TakesAFileOfThisMachineTheSameWay) {
  ASSERT_OK(write_file(folder_ / "here.onnx", file_));
  const auto copied = copy_checked(folder_ / "here.onnx", target_, expected_);
  ASSERT_OK(copied);
  EXPECT_EQ(read_text_file(target_).value(), file_);
  ASSERT_OK(write_file(folder_ / "here.onnx", "something else"));
  EXPECT_ERROR(copy_checked(folder_ / "here.onnx", target_, expected_), "14 bytes");
  EXPECT_EQ(read_text_file(target_).value(), file_);
}

TEST_F(DownloadTest, KnowsDigests) {
  EXPECT_TRUE(is_digest_begin(sha256_of("a")));
  EXPECT_TRUE(is_digest_begin("0cc3c7bd"));
  EXPECT_FALSE(is_digest_begin("0CC3"));
  EXPECT_FALSE(is_digest_begin(sha256_of("a") + "0"));
  options_.stall_timeout_s = 0;
  EXPECT_ERROR(options_.validate(), "stall_timeout_s");
}

}  // namespace
}  // namespace roomwise::download
