#include "laboratory/studies/known_digests.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::studies {
namespace {

namespace fs = std::filesystem;
using roomwise::testing::ScratchFolder;

TEST(KnownDigests, AreNotWorkedOutAgainWhereTheFileIsAsItWas) {
  const ScratchFolder folder;
  const fs::path file = folder / "network.onnx", kept = folder / "digests.json";
  ASSERT_OK(write_file(file, "first"));
  const auto changed = fs::last_write_time(file);
  KnownDigests begun;
  const auto first = begun.of(file);
  ASSERT_OK(first);
  const Bytes content = read_file(file).value();
  EXPECT_EQ(*first, sha256_hex(content));
  ASSERT_OK(begun.write(kept));

  // As long and as old as before: who reads it all the same finds other bytes.
  ASSERT_OK(write_file(file, "other"));
  fs::last_write_time(file, changed);
  EXPECT_EQ(KnownDigests::read(kept).of(file).value(), *first);

  fs::last_write_time(file, changed + std::chrono::seconds(1));
  const std::string newer = KnownDigests::read(kept).of(file).value();
  EXPECT_NE(newer, *first) << "it is newer";
  ASSERT_OK(write_file(file, "longer than it was"));
  fs::last_write_time(file, changed);
  EXPECT_NE(KnownDigests::read(kept).of(file).value(), *first) << "it is longer";
}

TEST(KnownDigests, AreWorkedOutWhereWhatWasKeptIsDamagedAndFailWhereThereIsNoFile) {
  const ScratchFolder folder;
  const fs::path file = folder / "network.onnx", kept = folder / "digests.json";
  ASSERT_OK(write_file(file, "first"));
  ASSERT_OK(write_file(kept, R"({"network.onnx": {"bytes": "many"}})"));
  EXPECT_EQ(KnownDigests::read(kept).of(file).value(), KnownDigests().of(file).value());
  EXPECT_ERROR(KnownDigests().of(folder / "none.onnx"), "none.onnx");
}

}  // namespace
}  // namespace roomwise::studies
