#include "roomwise/pipeline/stored/network_precision.h"

#include <gmock/gmock.h>

#include "roomwise/base/file.h"
#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/network/formats/onnx_writer.h"
#include "roomwise/network/graph/graph_builder.h"
#include "roomwise/pipeline/rooms/room_learning.h"

namespace roomwise::pipeline {
namespace {

using network::NetworkFile;
using ::testing::HasSubstr;

constexpr int kWidthOfNoise_px = 20, kHeightOfNoise_px = 18;
constexpr const char* kCard = R"({"input": {"width": 20, "height": 18},
  "mean": [127.5, 127.5, 127.5], "scale": [0.008, 0.008, 0.008]})";

image::ColorImage noisy_picture(std::size_t seed) {
  RandomStream random(seed);
  image::ColorImage picture(kWidthOfNoise_px, kHeightOfNoise_px);
  for (Rgb8& pixel : picture.pixels()) {
    const auto bits = static_cast<std::uint32_t>(random.next());
    pixel = {static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(bits >> 8),
             static_cast<std::uint8_t>(bits >> 16)};
  }
  return picture;
}

class NetworkPrecisionTest : public ::testing::Test {
 protected:
  NetworkPrecisionTest() { write_network({16, 24, 40}); }

  // Convolutions, one after the other, of so many channels.
  void write_network(const std::vector<std::int64_t>& channels) {
    network::GraphBuilder builder({5, false});
    auto x = builder.input("picture", {1, 3, kHeightOfNoise_px, kWidthOfNoise_px});
    for (const std::int64_t count : channels) {
      const std::string name = fmt::format("of{}", count);
      x = builder.relu(builder.convolution(x, name, {count, {3, 3}, {1, 1}, {1, 1}}),
                       name + ".relu");
    }
    builder.output(builder.flatten(builder.global_average_pool(x, "pool"), "features"));
    EXPECT_OK(write_file(weights(), *network::write_onnx_graph(builder.take())));
    write("tiny.card.json", kCard);
  }
  void write(const std::string& name, std::string_view text) {
    EXPECT_OK(write_file(folder_ / name, text));
  }
  [[nodiscard]] std::filesystem::path weights() const { return folder_ / "tiny.onnx"; }
  [[nodiscard]] NetworkFile file() const {
    return network::read_network_in_floats(weights()).value();
  }
  PrecisionCheck check(std::size_t pictures, std::size_t threads = 1) {
    return check_precision(home_, weights(), pictures, noisy_picture, threads).value();
  }
  [[nodiscard]] bool needs_check(NetworkPrecision precision = NetworkPrecision::kAuto) const {
    return needs_precision_check(home_, file(), precision).value();
  }
  [[nodiscard]] bool looks_in_eight_bits(
      NetworkPrecision precision = NetworkPrecision::kAuto) const {
    return in_precision(home_, file(), precision).value().eight_bits.has_value();
  }

  roomwise::testing::ScratchFolder folder_;
  home::Home home_ = create_home(folder_ / "a.home").value();
};

TEST_F(NetworkPrecisionTest, IsThatOfTheCheckThatTheHomeKeeps) {
  EXPECT_TRUE(needs_check());
  EXPECT_FALSE(needs_check(NetworkPrecision::kFloat));
  EXPECT_FALSE(looks_in_eight_bits());

  const PrecisionCheck made = check(200);
  ASSERT_TRUE(made.eight_bits) << made.why;
  EXPECT_THAT(made.why, HasSubstr("measured on 20 pictures, checked on 60 others"));
  EXPECT_FALSE(needs_check());
  EXPECT_TRUE(looks_in_eight_bits());
  EXPECT_TRUE(looks_in_eight_bits(NetworkPrecision::kEightBits));
  EXPECT_FALSE(looks_in_eight_bits(NetworkPrecision::kFloat));

  const auto looking = in_precision(home_, file(), NetworkPrecision::kAuto);
  EXPECT_EQ(looking->card.name, "tiny (8 bits)");
  EXPECT_EQ(looking->fingerprint, made.eight_bits->fingerprint());
  EXPECT_EQ(check(200, 3).eight_bits->fingerprint(), looking->fingerprint) << "by three threads";
}

TEST_F(NetworkPrecisionTest, AHomeThatKnowsANetworkByItsWeightsAloneGoesOnSo) {
  const auto known = [&](const std::string& name) {
    return known_as_before(home_, file(), name).value().fingerprint;
  };
  const std::string own = file().fingerprint;
  ASSERT_NE(own, file().sha256);
  EXPECT_EQ(known("tiny.onnx"), own) << "it is new";
  ASSERT_OK(home_.put_room_classifier({"tiny", file().sha256, {1}, "{}"}));
  EXPECT_EQ(known("tiny.onnx"), file().sha256);
  EXPECT_EQ(known("roomwise-compact-2.onnx"), own) << "it may have looked by the card that comes";
  ASSERT_OK(home_.add_network({"tiny", own, {}, 40}));
  EXPECT_EQ(known("tiny.onnx"), own);
}

TEST_F(NetworkPrecisionTest, IsFloatsWherePicturesAreFew) {
  const PrecisionCheck made = check(79);
  EXPECT_FALSE(made.eight_bits);
  EXPECT_THAT(made.why, HasSubstr("need 80 pictures of the home to be checked on, not 79"));
  EXPECT_FALSE(looks_in_eight_bits());
  EXPECT_ERROR(in_precision(home_, file(), NetworkPrecision::kEightBits), "not checked yet");
}

// One convolution, that looks at the picture: nothing can be held in 8 bits.
TEST_F(NetworkPrecisionTest, IsFloatsWhereTheCheckFails) {
  write_network({16});
  EXPECT_FALSE(check(80).eight_bits);
  EXPECT_FALSE(needs_check());
  EXPECT_FALSE(looks_in_eight_bits());
  EXPECT_ERROR(in_precision(home_, file(), NetworkPrecision::kEightBits),
               "tiny cannot look at it in 8 bits: nothing in it can be held in 8 bits");
}

TEST_F(NetworkPrecisionTest, IsThatOfTheCardThatWasChecked) {
  ASSERT_TRUE(check(80).eight_bits);
  write("tiny.card.json", R"({"input": {"width": 20, "height": 18}})");
  EXPECT_FALSE(looks_in_eight_bits());
  EXPECT_TRUE(needs_check());
}

TEST_F(NetworkPrecisionTest, IsFloatsWhereTheHomeWasLookedAtInFloats) {
  ASSERT_OK(home_.add_network({"tiny", file().fingerprint, {}, 40}));
  EXPECT_FALSE(needs_check());
  EXPECT_TRUE(needs_check(NetworkPrecision::kEightBits)) << "unless it is asked for";
}

TEST_F(NetworkPrecisionTest, IsThatByWhichRoomsWereLearned) {
  ASSERT_OK(home_.put_room_classifier({"tiny", file().fingerprint, {}, "{}"}));
  EXPECT_FALSE(needs_check());
  const PrecisionCheck made = check(80);
  EXPECT_FALSE(looks_in_eight_bits());
  EXPECT_TRUE(looks_in_eight_bits(NetworkPrecision::kEightBits));
  ASSERT_OK(home_.put_room_classifier({"tiny (8 bits)", made.eight_bits->fingerprint(), {}, "{}"}));
  EXPECT_TRUE(looks_in_eight_bits());
}

TEST_F(NetworkPrecisionTest, OfANetworkThatNamesThingsIsFloats) {
  write("names.txt", "chair\ntable\n");
  const auto naming = network::read_network_in_floats(weights(), folder_ / "names.txt");
  EXPECT_FALSE(*needs_precision_check(home_, *naming, NetworkPrecision::kEightBits));
  EXPECT_FALSE(in_precision(home_, *naming, NetworkPrecision::kEightBits)->eight_bits);
}

TEST_F(NetworkPrecisionTest, HasThreeNames) {
  EXPECT_EQ(parse_network_precision("eight-bits").value(), NetworkPrecision::kEightBits);
  EXPECT_ERROR(parse_network_precision("half"), "expected auto, float or eight-bits");
}

}  // namespace
}  // namespace roomwise::pipeline
