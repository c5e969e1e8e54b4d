#include "roomwise/recording/bytes/lzfse.h"

#include <gmock/gmock.h>

#include <array>
#include <string_view>

#include "roomwise/base/testing/testing.h"

namespace roomwise::recording {
namespace {

// Packed by Apple's published encoder: the bytes of walls(4200) as one block of LZFSE (bvx2), of
// walls(400) as one of LZVN, of walls(5) as a plain one.
constexpr std::string_view kLzfse =
    "6276783268100000bc00d0040031007040ca79cb79560070a600000024c8b00307af00b2810d142c0814de010000"
    "38e743380100d6e27d801300801700b8e69a1316000000000000009fe5bab939bcb959373737eb70dd1cde70c35a"
    "8b9bb5d6e2909bc5ba81b5b861ddc062b1586b010b586b018b050b160b58002c0016000000000000000000000000"
    "000000000000000000000000000000000000000000000000000000003f1eefdf3d08a48fa287141feda09759cec8"
    "1e8cc86206dfd1e196971aebf1767d8fb90dbf5c99ce4d41286fcd2f3ed709957aee8e9e4d98935b0be5458792f9"
    "a0132ea9e09e5832560fcb01780000000000000000000053000611f0ac503c06047a5d1cf49bb5518035511bcb01"
    "60a0f52a1f604524013cd8f61a4c8840592c9c350cadaf64c0ac61804903560f185532f06af887c8aa902001cc6b"
    "1019865901f99862767824";
constexpr std::string_view kLzvn =
    "6276786e9001000025000000680100f0e7400401460246034604460598010600381cf056e4010000000600000000"
    "00000062767824";
constexpr std::string_view kPlain = "6276782d05000000000000000062767824";
constexpr std::string_view kNothing = "6276782d0000000062767824";

Bytes from_hex(std::string_view hex) {
  const auto digit = [](char c) { return c <= '9' ? c - '0' : c - 'a' + 10; };
  Bytes bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    bytes.push_back(static_cast<std::uint8_t>(16 * digit(hex[i]) + digit(hex[i + 1])));
  }
  return bytes;
}

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
       {std::pair{kLzfse, 4200}, {kLzvn, 400}, {kPlain, 5}, {kNothing, 0}}) {
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
  const Bytes more = from_hex(kLzvn);
  packed.insert(packed.end(), more.begin(), more.end());
  const auto bytes = decode_lzfse(packed, 412);
  ASSERT_OK(bytes);
  Bytes expected(12, 'a');
  const Bytes end = walls(400);
  expected.insert(expected.end(), end.begin(), end.end());
  EXPECT_EQ(*bytes, expected);
}

TEST(Lzfse, RefusesMoreThanItMayGive) {
  EXPECT_ERROR(decode_lzfse(from_hex(kLzfse), 4199), "damaged LZFSE data");
  EXPECT_ERROR(decode_lzfse(from_hex(kLzvn), 399), "damaged LZFSE data");
  EXPECT_ERROR(decode_lzfse(from_hex(kPlain), 4), "larger than it should be");
}

TEST(Lzfse, RefusesWhatIsCutOffAnywhere) {
  for (const std::string_view hex : {kLzfse, kLzvn, kPlain, kNothing}) {
    const Bytes packed = from_hex(hex);
    for (std::size_t size = 0; size < packed.size(); ++size) {
      EXPECT_ERROR(decode_lzfse(std::span(packed).first(size), 5000), "damaged LZFSE data");
    }
  }
}

TEST(Lzfse, SurvivesEveryFlippedBit) {
  for (const std::string_view hex : {kLzfse, kLzvn}) {
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
  EXPECT_TRUE(is_lzfse(from_hex(kLzvn)));
  EXPECT_FALSE(is_lzfse(from_hex("0102")));
  EXPECT_FALSE(is_lzfse(from_hex("01020304")));
}

}  // namespace
}  // namespace roomwise::recording
