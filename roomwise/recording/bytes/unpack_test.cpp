#include "roomwise/recording/bytes/unpack.h"

#include <bzlib.h>
#include <gmock/gmock.h>
#include <lz4frame.h>
#include <zlib.h>
#include <zstd.h>

#include "roomwise/base/testing/testing.h"

namespace roomwise::recording {
namespace {

constexpr std::array kPackings{Packing::kLz4, Packing::kZstd, Packing::kBz2, Packing::kZlib};

Bytes plain_bytes() {
  Bytes bytes(200'000);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i * i / 700);
  return bytes;
}

Bytes pack(Packing packing, Bytes plain) {
  plain.reserve(1);  // bzlib wants an address also for nothing
  Bytes packed(2 * plain.size() + 1000);
  const auto size = static_cast<unsigned>(plain.size());
  auto packed_size = static_cast<unsigned>(packed.size());
  auto zlib_size = static_cast<uLongf>(packed.size());
  switch (packing) {
    case Packing::kNone:
      return plain;
    case Packing::kLz4:
      packed_size = static_cast<unsigned>(
          LZ4F_compressFrame(packed.data(), packed.size(), plain.data(), size, nullptr));
      break;
    case Packing::kZstd:
      packed_size =
          static_cast<unsigned>(ZSTD_compress(packed.data(), packed.size(), plain.data(), size, 1));
      break;
    case Packing::kBz2:
      BZ2_bzBuffToBuffCompress(reinterpret_cast<char*>(packed.data()), &packed_size,
                               reinterpret_cast<char*>(plain.data()), size, 1, 0, 0);
      break;
    case Packing::kZlib:
      compress(packed.data(), &zlib_size, plain.data(), size);
      packed_size = static_cast<unsigned>(zlib_size);
      break;
  }
  packed.resize(packed_size);
  return packed;
}

TEST(Unpack, GivesBackWhatWasPacked) {
  for (const Packing packing : kPackings) {
    const auto bytes = unpack(packing, pack(packing, plain_bytes()), 200'000);
    ASSERT_OK(bytes);
    EXPECT_EQ(*bytes, plain_bytes());
    EXPECT_OK(unpack(packing, pack(packing, {}), 0));
  }
  EXPECT_OK(unpack(Packing::kNone, plain_bytes(), 200'000));
}

TEST(Unpack, RefusesAnotherSize) {
  for (const Packing packing : kPackings) {
    const Bytes packed = pack(packing, plain_bytes());
    EXPECT_ERROR(unpack(packing, packed, 199'999), "more than the 199999 bytes");
    EXPECT_ERROR(unpack(packing, packed, 200'001), "200000 bytes instead of 200001");
    // The size is a lie: what comes out takes memory, not what is claimed.
    EXPECT_ERROR(unpack(packing, packed, std::uint64_t{1} << 60), "200000 bytes instead of");
  }
  EXPECT_ERROR(unpack(Packing::kNone, plain_bytes(), 3), "instead of 3");
}

TEST(Unpack, RefusesWhatIsCutOffOrIsNotPacked) {
  for (const Packing packing : kPackings) {
    const Bytes packed = pack(packing, plain_bytes());
    for (const std::size_t size :
         {std::size_t{0}, std::size_t{3}, packed.size() / 2, packed.size() - 1}) {
      EXPECT_FALSE(unpack(packing, std::span(packed).first(size), 200'000));
    }
    EXPECT_ERROR(unpack(packing, plain_bytes(), 200'000), "damaged");
  }
}

TEST(Unpack, KnowsThePackingsByName) {
  EXPECT_EQ(packing_named("lz4").value(), Packing::kLz4);
  EXPECT_EQ(packing_named("zstd").value(), Packing::kZstd);
  EXPECT_EQ(packing_named("bz2").value(), Packing::kBz2);
  EXPECT_EQ(packing_named("").value(), Packing::kNone);
  EXPECT_EQ(packing_named("none").value(), Packing::kNone);
  EXPECT_ERROR(packing_named("br"), "compressed by 'br'");
}

}  // namespace
}  // namespace roomwise::recording
