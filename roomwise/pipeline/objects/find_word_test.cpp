#include "roomwise/pipeline/objects/find_word.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "roomwise/base/file.h"
#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/fusion/testing/test_scenes.h"
#include "roomwise/image/codec.h"
#include "roomwise/network/testing/word_networks.h"

namespace roomwise::pipeline {
namespace {

// A home of light pictures, one of which shows something red in its lower right quarter.
class FindWord : public ::testing::Test {
 protected:
  static constexpr std::size_t kPictures = 12, kRed = 7;

  void SetUp() override {
    ASSERT_OK(network::testing::write_word_networks(folder_.path()));
    networks_ = network::OpenVocabulary::load(folder_ / "words.onnx").value();
    const geometry::PinholeCamera camera = fusion::testing::small_camera();
    home::MapCommit step;
    step.recording = home_.add_recording({"walk", "", camera, kPictures}).value();
    step.next_frame_index = kPictures;
    RandomStream random(1);
    for (std::size_t i = 0; i < kPictures; ++i) {
      const auto light = [&] { return static_cast<std::uint8_t>(200 + random.index(56)); };
      image::ColorImage color(camera.width, camera.height, Rgb8{light(), light(), light()});
      for (int y = camera.height / 2; i == kRed && y < camera.height; ++y) {
        for (int x = camera.width / 2; x < camera.width; ++x) color.at(x, y) = {255, 0, 0};
      }
      const auto time_ns = static_cast<TimestampNs>((i + 1) * 1'000'000'000);
      const image::DepthImage depth(camera.width, camera.height);
      step.keyframes.push_back(
          {{i, i, time_ns}, {}, {image::encode_png(color), image::encode_png(depth)}, {}, {}});
      step.frames.push_back({i, time_ns, home::FramePlace{i, {}}, ""});
    }
    ASSERT_OK(home_.commit(step));
  }
  Expected<WordPlaces> look(RunContext& run) {
    return word_places(home_, *networks_, run, [&](const WordPlaces& so_far) {
      EXPECT_OK(keep_word_places(home_, *networks_, so_far));
    });
  }
  WordPlaces places() { return look(run_).value(); }
  FoundWord find(std::string_view word) {
    return find_word(places(), networks_->embed(word).value());
  }

  roomwise::testing::ScratchFolder folder_;
  home::Home home_ = home::Home::create(folder_ / "a.home").value();
  std::unique_ptr<network::OpenVocabulary> networks_;
  SilentProgress silent_;
  OwnRunContext run_{2, silent_};
};

TEST_F(FindWord, FindsWhatAPictureShowsAndWhere) {
  const FoundWord red = find("red");
  EXPECT_TRUE(red.is_found);
  EXPECT_LE(red.false_alarms, kWordFalseAlarms);
  EXPECT_EQ(red.place.keyframe, kRed);
  const geometry::PinholeCamera camera = fusion::testing::small_camera();
  const auto width = static_cast<float>(camera.width), height = static_cast<float>(camera.height);
  EXPECT_EQ(red.place.box, (network::PixelBox{width / 2, height / 2, width, height}));
  EXPECT_FALSE(find("green").is_found);
  EXPECT_FALSE(find("blue").is_found);
}

// Words that mean something by chance, as those of absent things do here.
TEST_F(FindWord, WordsOfAbsentThingsAreFoundAboutAsSeldomAsSaid) {
  const WordPlaces looked_at = places();
  RandomStream random(2);
  int found = 0;
  constexpr int kWords = 300;
  for (int i = 0; i < kWords; ++i) {
    std::string word;
    for (std::size_t letters = 4 + random.index(8); letters > 0; --letters)
      word += static_cast<char>('a' + random.index(26));
    found += find_word(looked_at, networks_->embed(word).value()).is_found ? 1 : 0;
  }
  // With the seed of the words, and the 150 that they are compared with, all the same each time.
  EXPECT_LE(found, 2 * kWordFalseAlarms * kWords);
  EXPECT_FALSE(find(absent_things().front()).is_found);
}

TEST_F(FindWord, WhatWasSeenIsKeptUntilTheNetworksAreOthers) {
  const WordPlaces first = places();
  EXPECT_EQ(first.places.size(), 10 * kPictures);
  EXPECT_EQ(first.absent.size(), absent_things().size());
  const auto kept = home_.derived_data("word_places").value();
  ASSERT_TRUE(kept.has_value());
  const WordPlaces again = places();
  EXPECT_EQ(again.places, first.places);
  EXPECT_EQ(again.embeddings, first.embeddings);
  EXPECT_EQ(again.absent, first.absent);
  // Damaged bytes are made anew.
  home::DerivedData damaged = *kept;
  damaged.data.resize(damaged.data.size() / 2);
  ASSERT_OK(home_.put_derived_data(damaged));
  EXPECT_EQ(places().embeddings, first.embeddings);
  EXPECT_EQ(home_.derived_data("word_places").value(), kept);
  // So are those of key-frames that the home does not have, and what is no number.
  const auto replaced = [&](const auto& change) {
    home::DerivedData changed = *kept;
    nlohmann::json json = nlohmann::json::from_cbor(changed.data);
    change(json);
    changed.data = nlohmann::json::to_cbor(json);
    return home_.put_derived_data(changed);
  };
  ASSERT_OK(replaced([](nlohmann::json& json) { json["places"][3][0] = 999'999; }));
  EXPECT_EQ(places().places, first.places);
  ASSERT_OK(replaced([](nlohmann::json& json) {
    auto& bytes = json["embeddings"].get_binary();
    std::fill_n(bytes.begin(), 4, std::uint8_t{0xff});
  }));
  EXPECT_EQ(places().embeddings, first.embeddings);
  std::string card = network::testing::kWordCard;
  ASSERT_OK(write_file(folder_ / "words.card.json", card.replace(card.find("{}\"]"), 2, "a {}")));
  networks_ = network::OpenVocabulary::load(folder_ / "words.onnx").value();
  EXPECT_NE(places().absent, first.absent);
  EXPECT_NE(home_.derived_data("word_places").value()->made_from, kept->made_from);
}

// Counts the pictures that are looked at, and stops after so many.
class CountPictures final : public Progress {
 public:
  explicit CountPictures(std::uint64_t most = 1000) : most_(most) {}
  void begin(std::string_view work, std::optional<std::uint64_t>) override {
    is_of_pictures_ = work == "looking at the pictures for words";
    reads_words_ = reads_words_ || !is_of_pictures_;
  }
  void advance(std::uint64_t done, std::string_view) override {
    if (is_of_pictures_) looked_at_ = done;
  }
  void end() override {}
  [[nodiscard]] bool interrupted() const override { return looked_at_ >= most_; }
  [[nodiscard]] std::uint64_t looked_at() const { return looked_at_; }
  [[nodiscard]] bool reads_words() const { return reads_words_; }

 private:
  std::uint64_t most_, looked_at_ = 0;
  bool is_of_pictures_ = false, reads_words_ = false;
};

TEST_F(FindWord, WhatWasSeenBeforeItWasInterruptedIsKept) {
  CountPictures first(4);
  OwnRunContext run(2, first);
  EXPECT_ERROR(look(run), "interrupted");
  ASSERT_EQ(first.looked_at(), 4U);
  CountPictures second;
  OwnRunContext rest(2, second);
  const home::Home reader = home::Home::open_read_only(home_.file()).value();
  const WordPlaces all = word_places(reader, *networks_, rest).value();
  EXPECT_EQ(second.looked_at(), kPictures - 4);
  EXPECT_FALSE(second.reads_words());
  ASSERT_OK(home_.put_derived_data({"word_places", "other", {}}));
  EXPECT_EQ(all.places, places().places);
  EXPECT_EQ(all.embeddings, places().embeddings);
}

// Where two programs look at once, or the home changes meanwhile.
TEST_F(FindWord, WhatIsOfOtherKeyframesIsNotKept) {
  WordPlaces seen = word_places(home_, *networks_, run_).value();
  EXPECT_FALSE(home_.derived_data("word_places").value().has_value()) << "nobody asked for it";
  seen.places.resize(10);  // of the first picture, whose number stays
  seen.embeddings.resize(10);
  home::KeyframeCulling culling;
  culling.places.push_back({1, kRed, home::FramePlace{0, {}}});
  culling.culled.push_back(kRed);
  ASSERT_OK(home_.cull_keyframes(culling));
  ASSERT_OK(keep_word_places(home_, *networks_, seen));
  EXPECT_FALSE(home_.derived_data("word_places").value().has_value());
}

TEST_F(FindWord, OfKeyframesThatAreTakenOutNothingIsKept) {
  (void)places();
  home::KeyframeCulling culling;
  culling.places.push_back({1, kRed, home::FramePlace{0, {}}});
  culling.culled.push_back(kRed);
  ASSERT_OK(home_.cull_keyframes(culling));
  EXPECT_FALSE(home_.derived_data("word_places").value().has_value());
  EXPECT_EQ(places().places.size(), 10 * (kPictures - 1));
  EXPECT_FALSE(find("red").is_found);
}

// Without its passphrase nobody shall ask what its pictures show.
TEST_F(FindWord, OfAProtectedHomeNothingIsKept) {
  const WordPlaces first = places();
  const auto secret = home::Passphrase::from("open sesame");
  ASSERT_OK(secret);
  ASSERT_OK(home_.protect(*secret, {.passes = 1, .memory_bytes = 8192}));
  EXPECT_FALSE(home_.derived_data("word_places").value().has_value());
  EXPECT_EQ(places().embeddings, first.embeddings);
  EXPECT_FALSE(home_.derived_data("word_places").value().has_value());
  const home::Home locked = home::Home::open_read_only(home_.file()).value();
  EXPECT_TRUE(locked.is_locked());
}

TEST_F(FindWord, AHomeWithoutPicturesHasNone) {
  home::Home empty = home::Home::create(folder_ / "empty.home").value();
  EXPECT_ERROR(word_places(empty, *networks_, run_), "no pictures of a walk");
}

}  // namespace
}  // namespace roomwise::pipeline
