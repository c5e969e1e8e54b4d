#include "roomwise/recording/bytes/lzfse.h"

#include <gmock/gmock.h>

#include <array>

#include "roomwise/base/testing/testing.h"
#include "roomwise/recording/bytes/testing/lzfse_vectors.h"

namespace roomwise::recording {
namespace {

using namespace recording::testing;

// Numbers of four bytes that repeat here and there, as depths do.
Bytes walls(std::size_t size) {
  Bytes bytes;
  for (std::size_t i = 0; bytes.size() < size; ++i) {
    const std::size_t value = i % 7 * (i / 64);
    for (unsigned k = 0; k < 4; ++k) bytes.push_back(static_cast<std::uint8_t>(value >> 8 * k));
  }
  bytes.resize(size);
  return bytes;
}

template <typename Number>
void put(Bytes& bytes, Number number) {
  for (std::size_t k = 0; k < sizeof(Number); ++k) {
    bytes.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(number) >> 8 * k));
  }
}

// A block with its frequencies unpacked (bvx1): each symbol has all states, so that no bit is
// needed to say four times 'a', and eight bytes again from one back.
Bytes block_with_plain_tables() {
  Bytes block{'b', 'v', 'x', '1'};
  for (const std::uint32_t field : {12U, 16U, 4U, 1U, 8U, 8U, 0U}) put(block, field);
  for (int i = 0; i < 4; ++i) put(block, std::uint16_t{0});
  put(block, std::uint32_t{0});
  for (int i = 0; i < 3; ++i) put(block, std::uint16_t{0});
  std::array<std::uint16_t, 20 + 20 + 64 + 256> frequencies{};
  frequencies[4] = 64;        // four literals
  frequencies[20 + 8] = 64;   // eight bytes again
  frequencies[40 + 1] = 256;  // from one back
  frequencies[104 + 'a'] = 1024;
  for (const std::uint16_t frequency : frequencies) put(block, frequency);
  put(block, std::uint16_t{0});
  block.resize(block.size() + 16);  // payloads, of which no bit is read
  for (const char c : {'b', 'v', 'x', '$'}) block.push_back(static_cast<std::uint8_t>(c));
  return block;
}

TEST(Lzfse, DecodesWhatApplesEncoderWrote) {
  for (const auto& [hex, size] :
       {std::pair{kLzfseBlock, 4200}, {kLzvnBlock, 400}, {kPlainBlock, 5}, {kNoBlock, 0}}) {
    const auto bytes = decode_lzfse(from_hex(hex), 5000);
    ASSERT_OK(bytes);
    EXPECT_EQ(*bytes, walls(static_cast<std::size_t>(size)));
  }
}

TEST(Lzfse, DecodesABlockWithPlainTables) {
  const auto bytes = decode_lzfse(block_with_plain_tables(), 12);
  ASSERT_OK(bytes);
  EXPECT_EQ(*bytes, Bytes(12, 'a'));
}

TEST(Lzfse, JoinsBlocksOfAllKinds) {
  Bytes packed = block_with_plain_tables();
  packed.resize(packed.size() - 4);
  const Bytes more = from_hex(kLzvnBlock);
  packed.insert(packed.end(), more.begin(), more.end());
  const auto bytes = decode_lzfse(packed, 412);
  ASSERT_OK(bytes);
  Bytes expected(12, 'a');
  const Bytes end = walls(400);
  expected.insert(expected.end(), end.begin(), end.end());
  EXPECT_EQ(*bytes, expected);
}

TEST(Lzfse, RefusesMoreThanItMayGive) {
  EXPECT_ERROR(decode_lzfse(from_hex(kLzfseBlock), 4199), "damaged LZFSE data");
  EXPECT_ERROR(decode_lzfse(from_hex(kLzvnBlock), 399), "damaged LZFSE data");
  EXPECT_ERROR(decode_lzfse(from_hex(kPlainBlock), 4), "larger than it should be");
}

TEST(Lzfse, RefusesWhatIsCutOffAnywhere) {
  for (const std::string_view hex : {kLzfseBlock, kLzvnBlock, kPlainBlock, kNoBlock}) {
    const Bytes packed = from_hex(hex);
    for (std::size_t size = 0; size < packed.size(); ++size) {
      EXPECT_ERROR(decode_lzfse(std::span(packed).first(size), 5000), "damaged LZFSE data");
    }
  }
}

TEST(Lzfse, SurvivesEveryFlippedBit) {
  for (const std::string_view hex : {kLzfseBlock, kLzvnBlock}) {
    const Bytes whole = from_hex(hex);
    for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
      Bytes packed = whole;
      packed[bit / 8] = static_cast<std::uint8_t>(packed[bit / 8] ^ 1U << bit % 8);
      const auto bytes = decode_lzfse(packed, 5000);
      if (bytes) {
        EXPECT_LE(bytes->size(), 5000U);
      }
    }
  }
}

TEST(Lzfse, KnowsItsFirstBytes) {
  EXPECT_TRUE(is_lzfse(from_hex(kLzvnBlock)));
  EXPECT_FALSE(is_lzfse(from_hex("0102")));
  EXPECT_FALSE(is_lzfse(from_hex("01020304")));
}

}  // namespace
}  // namespace roomwise::recording
