#include "roomwise/pipeline/stored/network_files.h"

#include <gmock/gmock.h>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/network/formats/eight_bit_file.h"
#include "roomwise/network/formats/network_file.h"
#include "roomwise/network/testing/tiny_network.h"

namespace roomwise::pipeline {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class NetworkFilesTest : public ::testing::Test {
 protected:
  NetworkFilesTest() {
    write("tiny.card.json", R"({"input": {"width": 6, "height": 4}})");
    write("tiny.onnx", network_);
  }
  void write(const std::string& name, std::string_view text) {
    EXPECT_OK(write_file(folder_ / name, text));
  }
  [[nodiscard]] std::vector<NeededNetwork> all() const {
    return check_network_files(home_, {folder_ / "tiny.onnx", folder_ / "finder.onnx",
                                       folder_ / "tiny-8bit.eightbits"})
        .value();
  }
  [[nodiscard]] NeededNetwork only() const {
    const auto found = all();
    EXPECT_EQ(found.size(), 1U);
    return found.empty() ? NeededNetwork() : found.front();
  }
  [[nodiscard]] static std::string sha256_of(const std::string& text) {
    return sha256_hex(Bytes(text.begin(), text.end()));
  }
  void store_rooms(const std::string& name, const std::string& fingerprint) {
    ASSERT_OK(home_.put_room_classifier({name, fingerprint, {1}, "{}"}));
  }
  [[nodiscard]] std::string with_a_byte_flipped() const {
    std::string bytes = network_;
    char& of_a_name = bytes.at(bytes.find("pooled_node"));  // still a network
    of_a_name = static_cast<char>(of_a_name ^ 1);
    return bytes;
  }

  ::roomwise::testing::ScratchFolder folder_;
  home::Home home_ = home::Home::create(folder_ / "a.home").value();
  const std::string network_ = ::roomwise::testing::mean_color_network();
  const std::string sha256_ = sha256_of(network_);
};

TEST_F(NetworkFilesTest, ANewHomeNeedsNone) {
  EXPECT_THAT(all(), IsEmpty());
}

TEST_F(NetworkFilesTest, TheSameBytesAreRight) {
  store_rooms("tiny", sha256_);
  EXPECT_EQ(only().state, NetworkFileState::kRight);
  EXPECT_EQ(only().file, folder_ / "tiny.onnx");
}

TEST_F(NetworkFilesTest, TheSameBytesWithAnotherCardAreOther) {
  store_rooms("tiny", network::read_network_in_floats(folder_ / "tiny.onnx").value().fingerprint);
  EXPECT_EQ(only().state, NetworkFileState::kRight);
  write("tiny.card.json", R"({"input": {"width": 6, "height": 4}, "scale": [2, 2, 2]})");
  EXPECT_EQ(only().state, NetworkFileState::kOther);
}

TEST_F(NetworkFilesTest, OfFilesWithTheBytesTheOneOfTheNameIsLookedAtFirst) {
  write("finder.onnx", network_);
  store_rooms("finder", sha256_);
  EXPECT_EQ(only().state, NetworkFileState::kRight);
  EXPECT_EQ(only().file, folder_ / "finder.onnx");
  write("finder.onnx", "something else");
  EXPECT_EQ(only().state, NetworkFileState::kRight);
  EXPECT_EQ(only().file, folder_ / "tiny.onnx");
}

TEST_F(NetworkFilesTest, OneFlippedByteIsDamageWhereItsCardHasTheDigest) {
  store_rooms("tiny", sha256_);
  write("tiny.card.json",
        fmt::format(R"({{"input": {{"width": 6, "height": 4}}, "sha256": "{}"}})", sha256_));
  EXPECT_EQ(only().state, NetworkFileState::kRight);
  write("tiny.onnx", with_a_byte_flipped());
  ASSERT_EQ(only().state, NetworkFileState::kDamaged);
  EXPECT_THAT(in_words(only()),
              AllOf(HasSubstr((folder_ / "tiny.onnx").string() + ": the network tiny, with which "),
                    HasSubstr("put a copy of it there")));
}

TEST_F(NetworkFilesTest, OneFlippedByteIsDamageWhereItWasFetchedWithTheDigest) {
  store_rooms("tiny", sha256_);
  write("tiny.onnx.sha256", sha256_ + "  tiny.onnx\n");
  write("tiny.onnx", with_a_byte_flipped());
  EXPECT_EQ(only().state, NetworkFileState::kDamaged);
}

TEST_F(NetworkFilesTest, WhatIsNoNetworkIsDamaged) {
  store_rooms("tiny", sha256_);
  write("tiny.onnx", network_.substr(0, network_.size() / 2));
  EXPECT_EQ(only().state, NetworkFileState::kDamaged);
}

TEST_F(NetworkFilesTest, AnotherNetworkOfTheNameIsTold) {
  store_rooms("tiny", std::string(64, 'a'));
  ASSERT_EQ(only().state, NetworkFileState::kOther);
  EXPECT_THAT(in_words(only()), HasSubstr(fmt::format("is not the network tiny, with which its "
                                                      "rooms were learned (now {}, then aaaa",
                                                      sha256_.substr(0, 12))));
}

TEST_F(NetworkFilesTest, AMissingOneIsNamedAndWhereItCanBeFetched) {
  store_rooms("inception-v3-torchvision", "0cc3c7bd" + std::string(56, 'a'));
  ASSERT_EQ(only().state, NetworkFileState::kMissing);
  EXPECT_THAT(in_words(only()), HasSubstr("roomwise networks pull inception-v3-torchvision"));
}

TEST_F(NetworkFilesTest, OfOneNameTheLastCountsAndTheRoomsComeFirst) {
  ASSERT_OK(home_.add_network({"tiny", "older", {}, 3}));
  ASSERT_OK(home_.add_network({"tiny", sha256_, {}, 3}));
  ASSERT_OK(home_.add_region_finder({"finder", std::string(64, 'b'), {"bed"}}));
  ASSERT_OK(home_.add_region_finder({"region proposals", "x proposals 2", {"bed"}}));
  store_rooms("learned", std::string(64, 'c'));
  const auto found = all();
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(found[0].name, "learned");
  EXPECT_EQ(found[1].name, "tiny");
  EXPECT_EQ(found[1].state, NetworkFileState::kRight);
  EXPECT_EQ(found[2].name, "finder");
  EXPECT_EQ(found[2].state, NetworkFileState::kMissing);
}

TEST_F(NetworkFilesTest, OfOneInEightBitsItsWeightsAreLookedAt) {
  const network::EightBitFile way{
      .network = "tiny.onnx",
      .sha256 = sha256_,
      .preprocessing = "as it comes",
      .ranges = {.input = {1, 3, 4, 6}, .min_channels = 1, .of_layers = {}},
      .checked = "near enough"};
  write("tiny-8bit.eightbits", network::text_of(way).value());
  store_rooms("tiny (8 bits)", way.fingerprint());
  EXPECT_EQ(only().state, NetworkFileState::kRight);
  write("tiny.onnx", network_.substr(0, network_.size() / 2));
  EXPECT_EQ(only().state, NetworkFileState::kDamaged);
}

}  // namespace
}  // namespace roomwise::pipeline
