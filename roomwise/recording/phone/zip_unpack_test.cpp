#include "roomwise/recording/phone/zip_unpack.h"

#include <gmock/gmock.h>
#include <sys/resource.h>
#include <zip.h>

#include <csignal>
#include <deque>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::recording {
namespace {

class ZipUnpackFolder : public ::testing::Test {
 protected:
  // Writes an archive; a name that ends with '@' becomes a link.
  void pack(const std::vector<std::pair<std::string, std::string>>& files) const {
    int code = 0;
    zip_t* archive = zip_open(archive_.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &code);
    ASSERT_NE(archive, nullptr);
    for (auto [name, content] : files) {
      const bool is_link = name.ends_with('@');
      if (is_link) name.pop_back();
      contents_.push_back(content);
      zip_source_t* source =
          zip_source_buffer(archive, contents_.back().data(), contents_.back().size(), 0);
      const zip_int64_t index = zip_file_add(archive, name.c_str(), source, ZIP_FL_ENC_UTF_8);
      ASSERT_GE(index, 0) << zip_strerror(archive);
      if (is_link) {
        zip_file_set_external_attributes(archive, static_cast<zip_uint64_t>(index), 0,
                                         ZIP_OPSYS_UNIX, 0120777U << 16U);
      }
    }
    ASSERT_EQ(zip_close(archive), 0);
  }
  [[nodiscard]] Expected<void> unpack(const UnpackLimits& limits = {}) const {
    SilentProgress progress;
    return unpack_zip(archive_, out_, limits, progress);
  }
  // The archive's own bytes, with `from` put in the place of every `to`.
  void replace_in_archive(const std::string& from, const std::string& to) const {
    std::string bytes = read_text_file(archive_).value();
    for (std::size_t at = 0; (at = bytes.find(from, at)) != std::string::npos; at += to.size()) {
      bytes.replace(at, from.size(), to);
    }
    ASSERT_OK(write_file(archive_, bytes));
  }

  roomwise::testing::ScratchFolder folder_;
  std::filesystem::path archive_ = folder_ / "export.zip";
  std::filesystem::path out_ = folder_ / "out";
  mutable std::deque<std::string> contents_;
};

TEST_F(ZipUnpackFolder, FilesComeOutAsTheyWent) {
  pack({{"scan/frame_00000.json", "{}"}, {"scan/depth/0.png", std::string(3'000'000, 'd')}});
  EXPECT_TRUE(is_zip_file(archive_));
  ASSERT_OK(unpack({.max_ratio = 2000}));
  EXPECT_EQ(read_text_file(out_ / "scan/frame_00000.json").value(), "{}");
  EXPECT_EQ(read_text_file(out_ / "scan/depth/0.png")->size(), 3'000'000U);
  EXPECT_ERROR(unpack({.max_ratio = 2000}), "there already");
}

TEST_F(ZipUnpackFolder, WhatTheSystemAddedIsLeftOut) {
  pack({{"a/x.txt", "x"}, {"__MACOSX/a/._x.txt", "junk"}, {"a/.DS_Store", "junk"}});
  ASSERT_OK(unpack());
  EXPECT_TRUE(std::filesystem::exists(out_ / "a/x.txt"));
  EXPECT_FALSE(std::filesystem::exists(out_ / "__MACOSX"));
  EXPECT_FALSE(std::filesystem::exists(out_ / "a/.DS_Store"));
}

// Nothing is written of an archive that has one such name.
TEST_F(ZipUnpackFolder, NamesThatLeadOutAndLinksAreRefused) {
  for (const std::string name : {"../evil", "a/../../evil", "/etc/evil", "a\\..\\evil"}) {
    pack({{"good.txt", "x"}, {name, "evil"}});
    EXPECT_ERROR(unpack(), "outside of the archive's folder");
    EXPECT_FALSE(std::filesystem::exists(out_)) << name;
  }
  pack({{"link@", "/etc/passwd"}});
  EXPECT_ERROR(unpack(), "'link' is a link");
  pack({{"one.txt", "x"}, {"two.txt", "y"}});
  replace_in_archive("two.txt", "one.txt");
  EXPECT_ERROR(unpack(), "twice");
  EXPECT_EQ(unpack().error().code, ErrorCode::kRefused) << "nobody mends it";
}

TEST_F(ZipUnpackFolder, NamesOfManyFoldersAreRefused) {
  std::string deep;
  for (int i = 0; i < 31; ++i) deep += "a/";
  pack({{deep + "0.png", "x"}});
  EXPECT_OK(unpack());
  for (const std::string& name : {deep + "a/0.png", std::string(513, 'a')}) {
    pack({{name, "x"}});
    std::filesystem::remove_all(out_);
    EXPECT_ERROR(unpack(), "not safe");
    EXPECT_FALSE(std::filesystem::exists(out_));
  }
}

TEST_F(ZipUnpackFolder, AnArchiveThatWouldFillTheDiskIsRefusedBeforeItIsUnpacked) {
  pack({{"zeros", std::string(5'000'000, '\0')}});
  EXPECT_ERROR(unpack(), "times as large");
  const auto too_large = unpack({.max_bytes = 4'000'000, .max_ratio = 1e9});
  EXPECT_ERROR(too_large, "room for");
  EXPECT_EQ(too_large.error().code, ErrorCode::kDiskFull);
  pack({{"a", "1"}, {"b", "2"}});
  EXPECT_ERROR(unpack({.max_files = 1}), "holds 2 files");
  EXPECT_FALSE(std::filesystem::exists(out_));
}

// Its directory says 10 bytes, and more come out.
TEST_F(ZipUnpackFolder, AnArchiveThatLiesAboutASizeIsRefused) {
  pack({{"zeros", std::string(100'000, 'z')}});
  const std::string size{'\xA0', '\x86', '\x01', '\0'};  // 100,000
  replace_in_archive(size, std::string{'\x0A', '\0', '\0', '\0'});
  EXPECT_FALSE(unpack());
}

// At whatever byte.
TEST_F(ZipUnpackFolder, AnArchiveThatWasCutShortIsRefused) {
  pack({{"a.txt", "some text"}, {"b.txt", "some more"}});
  const std::string whole = read_text_file(archive_).value();
  for (std::size_t bytes = 0; bytes < whole.size(); ++bytes) {
    ASSERT_OK(write_file(archive_, whole.substr(0, bytes)));
    EXPECT_FALSE(unpack()) << bytes;
    std::filesystem::remove_all(out_);
  }
}

TEST_F(ZipUnpackFolder, AFullDiskIsToldWithItsMend) {
  pack({{"a.bin", std::string(10'000, 'a')}});
  struct rlimit before {};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit full{500, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &full), 0);
  const auto unpacked = unpack({.max_ratio = 1e9});
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);
  EXPECT_ERROR(unpacked, "free some space");
}

TEST_F(ZipUnpackFolder, CanBeStopped) {
  class Stopped final : public Progress {
   public:
    [[nodiscard]] bool interrupted() const override { return true; }
    void begin(std::string_view, std::optional<std::uint64_t>) override {}
    void advance(std::uint64_t, std::string_view) override {}
    void end() override {}
  } stopped;
  pack({{"a", "1"}});
  const auto unpacked = unpack_zip(archive_, out_, {}, stopped);
  ASSERT_FALSE(unpacked);
  EXPECT_EQ(unpacked.error().code, ErrorCode::kInterrupted);
}

}  // namespace
}  // namespace roomwise::recording
