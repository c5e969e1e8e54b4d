#include "roomwise/download/part_file.h"

#include <gmock/gmock.h>
#include <sys/resource.h>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::download {
namespace {

class PartFileTest : public ::testing::Test {
 protected:
  [[nodiscard]] bool exists(const std::string& name) const {
    return std::filesystem::exists(folder_ / name);
  }
  static std::string sha256_of(const std::string& text) {
    return sha256_hex(Bytes(text.begin(), text.end()));
  }
  // An open part that holds "abc".
  PartFile abc() {
    auto part = PartFile::open(target_);
    EXPECT_OK(part);
    const Bytes bytes{'a', 'b', 'c'};
    EXPECT_OK(part->append(bytes));
    return std::move(*part);
  }

  ::roomwise::testing::ScratchFolder folder_;
  std::filesystem::path target_ = folder_ / "net.onnx";
};

TEST_F(PartFileTest, OnlyOneAtATime) {
  {
    const PartFile first = abc();
    EXPECT_ERROR(PartFile::open(target_), "another program is fetching it");
  }
  const auto second = PartFile::open(target_);
  ASSERT_OK(second);
  EXPECT_EQ(second->bytes().value(), 3u);
}

TEST_F(PartFileTest, NothingIsLeftOfNothing) {
  EXPECT_OK(PartFile::open(target_));
  EXPECT_FALSE(exists("net.onnx.part"));
}

TEST_F(PartFileTest, WhatMustBeThereBeforeTheFileIs) {
  PartFile part = abc();
  EXPECT_ERROR(part.accept({}, [](const FetchedFile&) { return fail("the disk is full"); }),
               "the disk is full");
  EXPECT_TRUE(exists("net.onnx.part"));
  std::string recorded;
  ASSERT_OK(part.accept({3, sha256_of("abc")}, [&](const FetchedFile& file) -> Expected<void> {
    EXPECT_FALSE(exists("net.onnx"));
    recorded = file.sha256;
    return {};
  }));
  EXPECT_EQ(recorded, sha256_of("abc"));
  EXPECT_EQ(read_text_file(target_).value(), "abc");
}

TEST_F(PartFileTest, OnlyWhatIsWrongIsDeleted) {
  PartFile part = abc();
  // What cannot be read, as a folder in its place cannot, may yet be right.
  std::filesystem::rename(part.path(), folder_ / "aside");
  std::filesystem::create_directory(part.path());
  EXPECT_ERROR(part.accept({}, {}), "cannot be read");
  EXPECT_TRUE(exists("net.onnx.part"));
  std::filesystem::remove(part.path());
  std::filesystem::rename(folder_ / "aside", part.path());
  EXPECT_ERROR(part.accept({4, ""}, {}), "has 3 bytes; expected 4");
  EXPECT_FALSE(exists("net.onnx.part"));
}

TEST_F(PartFileTest, ALargeFileIsNotHeldInMemory) {
  ASSERT_OK(write_file(target_, ""));
  std::filesystem::resize_file(target_, std::uintmax_t{256} << 20U);  // without blocks on the disk
  const auto max_kb = [] {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss;
  };
  const long before_kb = max_kb();
  const auto checked = check_file(target_, {});
  ASSERT_OK(checked);
  EXPECT_EQ(checked->sha256, "a6d72ac7690f53be6ae46ba88506bd97302a093f7108472bd9efc3cefda06484");
  EXPECT_LT(max_kb() - before_kb, 64 * 1024);
}

}  // namespace
}  // namespace roomwise::download
