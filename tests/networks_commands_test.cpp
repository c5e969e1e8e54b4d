// Networks, command by command, fetched from a server of the test's own.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "roomwise/base/file.h"
#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/download/testing/test_server.h"
#include "roomwise/image/codec.h"
#include "roomwise/network/testing/tiny_network.h"
#include "roomwise/network/testing/word_networks.h"
#include "run_program.h"

namespace roomwise {
namespace {

using download::testing::Reply;
using download::testing::Request;
using download::testing::TestServer;
using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::ProgramResult;
using testing::result_of;
using testing::run_roomwise;

namespace fs = std::filesystem;

std::string sha256_of(const std::string& text) {
  return sha256_hex(Bytes(text.begin(), text.end()));
}

class NetworksCommandsTest : public ::testing::Test {
 protected:
  NetworksCommandsTest() { server_.write_certificate(path("trusted.pem")); }
  [[nodiscard]] std::string path(const std::string& name) const { return folder_ / name; }
  // With the user's own networks in this test's folder.
  json ask(const std::vector<std::string>& arguments) {
    return result_of(arguments, folder_.path());
  }
  ProgramResult run(const std::vector<std::string>& arguments) {
    return run_roomwise(arguments, folder_.path());
  }
  // `pull` from the test's server as a mirror.
  std::vector<std::string> pull(const std::string& name, std::vector<std::string> more = {}) {
    std::vector<std::string> words{"networks",         "pull",           name,
                                   "--from",           server_.url("/"), "--certificates",
                                   path("trusted.pem")};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }

  testing::ScratchFolder folder_;
  const std::string network_ = testing::mean_color_network();
  TestServer server_{[this](const Request&) {
    return Reply{fmt::format("HTTP/1.1 200 OK\r\nContent-Length: {}\r\nConnection: close\r\n\r\n{}",
                             network_.size(), network_)};
  }};
  // Of the catalogue, without a published digest.
  const std::string file_ = path("roomwise/networks/resnet50-v1-12.onnx");
};

TEST_F(NetworksCommandsTest, APublishedNetworkIsFetchedAndFound) {
  const json pulled = ask(pull("resnet50-v1-onnx"));
  EXPECT_EQ(pulled["file"], file_);
  EXPECT_EQ(pulled["sha256"], sha256_of(network_));
  EXPECT_EQ(pulled["digits_checked"], 0);
  EXPECT_EQ(read_text_file(file_).value(), network_);
  EXPECT_EQ(server_.requests().back().path(), "/resnet50-v1-12.onnx");
  EXPECT_TRUE(ask(pull("resnet50-v1-onnx"))["was_here"]);
  EXPECT_EQ(server_.requests().size(), 1u);

  EXPECT_EQ(ask({"networks", "verify"})[0]["digits_checked"], 64) << "as it was recorded";
  const json listed = ask({"networks", "list"});
  for (const json& known : listed["known"]) {
    EXPECT_EQ(known["installed"].is_null(), known["name"] != "resnet50-v1-onnx");
  }
  // Without a card it cannot be used; with one, commands take it by default.
  EXPECT_FALSE(ask({"networks", "list"})["here"][0]["used_by_default"]);
  ASSERT_OK(write_file(path("roomwise/networks/resnet50-v1-12.card.json"),
                       R"({"input": {"width": 6, "height": 4}})"));
  EXPECT_TRUE(ask({"networks", "list"})["here"][0]["used_by_default"]);
  const json info = ask({"networks", "info", "resnet50-v1-onnx"});
  EXPECT_EQ(info["inputs"][0]["shape"], "1x3x4x6");
  EXPECT_EQ(info["layers"]["GlobalAveragePool"], 1);
  EXPECT_EQ(info["parameters"], 0);
  EXPECT_GT(ask({"networks", "bench", "resnet50-v1-onnx", "--runs", "3"})["memory_mb"], 0);

  ASSERT_OK(write_file(file_, network_ + "x"));
  EXPECT_THAT(run({"networks", "verify"}).errors, HasSubstr("is not the file"));
}

TEST_F(NetworksCommandsTest, APairThatComparesPicturesWithWordsIsListed) {
  const std::string folder = path("roomwise/networks");
  fs::create_directories(folder);
  ASSERT_OK(network::testing::write_word_networks(folder));
  const json here = ask({"networks", "list"})["here"];
  EXPECT_EQ(here[0]["file"], folder + "/words-text.onnx");
  EXPECT_EQ(here[0]["for"], "reads words");
  EXPECT_FALSE(here[0]["used_by_default"]);
  EXPECT_EQ(here[1]["for"], "compares with words");
  EXPECT_TRUE(here[1]["used_by_default"]);
  EXPECT_GT(ask({"networks", "bench", "words", "--runs", "2"})["memory_mb"], -1);
  EXPECT_EQ(ask({"info", folder + "/words.onnx"})["features"], 8);
  EXPECT_THAT(run({"networks", "quantize", "words", "--pictures", folder}).errors,
              HasSubstr("8 bits are for networks that look at whole ones"));
}

// Two convolutions, of random weights.
std::string convolving_network(std::uint64_t seed) {
  using testing::layer;
  const auto weights = [seed](const std::string& name, std::int64_t outputs, std::int64_t inputs) {
    RandomStream random(seed);
    std::vector<float> values(static_cast<std::size_t>(outputs * inputs * 9));
    for (float& value : values) value = static_cast<float>(random.normal());
    return testing::tensor(name, {outputs, inputs, 3, 3}, values);
  };
  return testing::onnx(testing::TinyGraph{
      {layer("Conv", {"picture", "w1"}, {"c1"}, {}), layer("Relu", {"c1"}, {"r1"}, {}),
       layer("Conv", {"r1", "w2"}, {"c2"}, {}), layer("Relu", {"c2"}, {"r2"}, {}),
       layer("GlobalAveragePool", {"r2"}, {"pooled"}, {}),
       layer("Flatten", {"pooled"}, {"features"}, {})},
      {weights("w1", 12, 3), weights("w2", 16, 12)},
      {1, 3, 18, 20},
      {{"features", {1, 16}}}});
}

// Of detectors that know the same one looks, the largest, but for the kind that objects were fitted
// with; one that knows other things looks beside it.
TEST_F(NetworksCommandsTest, OfDetectorsWithTheSameLabelsOneIsUsed) {
  const std::string folder = "roomwise/networks/";
  fs::create_directories(path(folder));
  const auto put = [&](const std::string& name, const std::string& network, const std::string& task,
                       const std::string& labels) {
    ASSERT_OK(write_file(path(folder + name + ".onnx"), network));
    ASSERT_OK(write_file(path(folder + name + ".card.json"),
                         R"({"task": ")" + task +
                             R"(", "input": {"width": 6, "height": 4}, "labels": ")" + labels +
                             R"("})"));
  };
  const auto used = [&] {
    std::vector<std::string> names;
    const json listed = ask({"networks", "list"});
    for (const json& one : listed["here"]) {
      if (one["for"] == "finds things" && one["used_by_default"])
        names.push_back(fs::path(one["file"].get<std::string>()).stem());
    }
    return names;
  };
  const std::string remark = "\x32\x04more";  // ModelProto.doc_string
  put("a", network_, "yolox", "coco-labels-80.txt");
  put("b", network_ + remark, "yolox", "coco-labels-80.txt");
  ASSERT_OK(write_file(path(folder + "aids.txt"), "walker\n"));
  put("c", network_, "yolox", "aids.txt");
  EXPECT_THAT(used(), ElementsAre("b", "c"));
  put("d", network_, "nanodet-plus", "coco-labels-80.txt");
  EXPECT_THAT(used(), ElementsAre("c", "d"));
}

TEST_F(NetworksCommandsTest, ANetworkIsMadeToRunInEightBits) {
  for (const char* folder : {"roomwise/networks", "photos/red", "photos/noise", "few"})
    std::filesystem::create_directories(path(folder));
  ASSERT_OK(write_file(path("roomwise/networks/tiny.onnx"), convolving_network(1)));
  ASSERT_OK(write_file(path("roomwise/networks/tiny.card.json"),
                       R"({"input": {"width": 20, "height": 18}})"));
  RandomStream random(1);
  const auto write_pictures = [&](const std::string& folder, int count) {
    for (int i = 0; i < count; ++i) {
      image::ColorImage picture(30, 20);
      for (Rgb8& pixel : picture.pixels()) pixel.r = static_cast<std::uint8_t>(random.next());
      ASSERT_OK(write_file(path(fmt::format("{}/{}.png", folder, i)), image::encode_png(picture)));
    }
  };
  write_pictures("photos/red", 40);
  write_pictures("photos/noise", 40);
  const std::vector<std::string> quantize{"networks", "quantize", "tiny", "--pictures",
                                          path("photos")};
  const json made = ask(quantize);
  const std::string file = path("roomwise/networks/tiny-8bit.eightbits");
  EXPECT_EQ(made["file"], file);
  EXPECT_EQ(made["measured_on"], 20);
  EXPECT_EQ(made["checked_on"], 60);
  EXPECT_GT(made["mean_cosine"][0], 0.99);
  EXPECT_EQ(ask({"networks", "info", "tiny-8bit"})["eight_bits"]["network"], "tiny.onnx");
  EXPECT_GT(ask({"networks", "bench", "tiny-8bit", "--runs", "2"})["cpu_ms"], 0);
  EXPECT_EQ(ask({"info", file})["features"], 16);
  const json listed = ask({"networks", "list"});
  for (const json& here : listed["here"]) {
    if (here["file"] != file) continue;
    EXPECT_EQ(here["for"], "features, 8 bits");
    EXPECT_FALSE(here["used_by_default"]);
  }

  // Rooms are learned with it and recognised with it, and by no other.
  const std::string home = path("photos.home");
  ask({"rooms", "learn", "--photos", path("photos"), "--network", file, "--home", home});
  const std::string picture = path("photos/red/0.png");
  EXPECT_TRUE(ask({"rooms", "recognize", "--home", home, "--network", file, picture}).is_object());
  EXPECT_THAT(run({"rooms", "recognize", "--home", home, "--network",
                   path("roomwise/networks/tiny.onnx"), picture})
                  .errors,
              HasSubstr("learned with the network tiny (8 bits)"));

  // Without it a home checks 8 bits on its own pictures, once, and is asked as it was learned.
  const std::string own = path("own.home"), floats = path("floats.home");
  const auto learn = [&](const std::string& into, const std::string& precision) {
    return run({"rooms", "learn", "--photos", path("photos"), "--home", into, "--network-precision",
                precision});
  };
  EXPECT_THAT(learn(own, "auto").errors, HasSubstr("tiny looks at this home in 8 bits: measured"));
  EXPECT_THAT(learn(own, "auto").errors, Not(HasSubstr("looks at this home")));
  EXPECT_EQ(ask({"info", own})["rooms_learned_with"], "tiny (8 bits)");
  EXPECT_TRUE(ask({"rooms", "recognize", "--home", own, picture}).is_object());
  EXPECT_THAT(
      run({"rooms", "recognize", "--home", own, "--network-precision", "float", picture}).errors,
      HasSubstr("learned with the network tiny (8 bits)"));
  EXPECT_EQ(learn(floats, "float").exit_code, 0);
  EXPECT_EQ(ask({"info", floats})["rooms_learned_with"], "tiny");
  EXPECT_TRUE(ask({"rooms", "recognize", "--home", floats, picture}).is_object());
  EXPECT_THAT(
      run({"rooms", "recognize", "--home", floats, "--network-precision", "eight-bits", picture})
          .errors,
      HasSubstr("tiny cannot look at it in 8 bits"));

  // Measured again on the same pictures it is the same; on others it is another one.
  EXPECT_EQ(ask(quantize)["mean_cosine"], made["mean_cosine"]);
  write_pictures("photos/red", 40);
  EXPECT_THAT(run(quantize).errors, HasSubstr("would have to be learned anew"));
  std::vector<std::string> replaced = quantize;
  replaced.emplace_back("--replace");
  EXPECT_EQ(ask(replaced)["file"], file);

  // A link is named as the link, beside which the card lies.
  std::filesystem::create_directories(path("store"));
  std::filesystem::rename(path("roomwise/networks/tiny.onnx"), path("store/blob"));
  std::filesystem::create_symlink(path("store/blob"), path("roomwise/networks/tiny.onnx"));
  const std::string elsewhere = path("store/linked.eightbits");
  std::vector<std::string> linked = quantize;
  linked.insert(linked.end(), {"--out", elsewhere});
  ask(linked);
  EXPECT_EQ(ask({"networks", "info", elsewhere})["eight_bits"]["network"],
            "../roomwise/networks/tiny.onnx");
  EXPECT_GT(ask({"networks", "bench", elsewhere, "--runs", "2"})["cpu_ms"], 0);
  std::filesystem::remove(path("roomwise/networks/tiny.onnx"));

  ASSERT_OK(write_file(path("roomwise/networks/tiny.onnx"), convolving_network(1)));
  EXPECT_THAT(run({"networks", "quantize", "tiny"}).errors, HasSubstr("--home or --pictures"));
  EXPECT_THAT(run({"networks", "quantize", "tiny-8bit", "--pictures", path("photos")}).errors,
              HasSubstr("give the network's own file"));
  EXPECT_THAT(run({"networks", "quantize", "tiny", "--pictures", path("photos"), "--out",
                   path("tiny.json")})
                  .errors,
              HasSubstr("ends in .eightbits"));
  write_pictures("few", 3);
  EXPECT_THAT(run({"networks", "quantize", "tiny", "--pictures", path("few")}).errors,
              HasSubstr("at least 80 pictures"));
  ASSERT_OK(write_file(path("roomwise/networks/tiny.onnx"), convolving_network(2)));
  EXPECT_THAT(run({"networks", "bench", "tiny-8bit"}).errors,
              HasSubstr("was measured of another file"));

  // What a home was made with is compared with what is here.
  const ProgramResult other = run({"check", own});
  EXPECT_EQ(other.exit_code, 0);
  EXPECT_THAT(other.output, HasSubstr("tiny.onnx: is not the network tiny, with which its rooms"));
  ASSERT_OK(write_file(path("roomwise/networks/tiny.onnx"), std::string_view("no network")));
  const ProgramResult damaged = run({"check", own});
  EXPECT_EQ(damaged.exit_code, 1);
  EXPECT_THAT(damaged.output, HasSubstr("tiny.onnx: the network tiny, with which its rooms were "
                                        "learned, is damaged: delete the file"));
  ASSERT_OK(write_file(path("roomwise/networks/tiny.onnx"), convolving_network(1)));
  EXPECT_EQ(ask({"check", own})["networks"][0]["state"], "right");
}

TEST_F(NetworksCommandsTest, OursIsUsedWhereThereIsNoOther) {
  const auto is_default = [this](const std::string& file) {
    const json listed = ask({"networks", "list"});
    for (const json& here : listed["here"]) {
      if (here["file"].get<std::string>().ends_with(file))
        return here["used_by_default"].get<bool>();
    }
    ADD_FAILURE() << file << " is not listed";
    return false;
  };
  EXPECT_TRUE(is_default("share/roomwise/networks/roomwise-compact-2.onnx"));
  const json info = ask({"networks", "info", "roomwise-compact-2"});
  EXPECT_LE(info["parameter_bytes"], 4'000'000);
  EXPECT_GT(info["card"]["notes"].size(), 0);

  std::filesystem::create_directories(path("roomwise/networks"));
  ASSERT_OK(write_file(path("roomwise/networks/mine.onnx"), network_));
  ASSERT_OK(write_file(path("roomwise/networks/mine.card.json"),
                       R"({"input": {"width": 6, "height": 4}})"));
  EXPECT_TRUE(is_default("mine.onnx"));
  EXPECT_FALSE(is_default("roomwise-compact-2.onnx"));
}

TEST_F(NetworksCommandsTest, WhatIsNotAsPublishedIsRefused) {
  const ProgramResult other = run(pull("yolox-nano"));
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_THAT(other.errors, HasSubstr("expected 3659407; it is another file"));
  const std::string digest = sha256_of("another file");
  EXPECT_THAT(run(pull("resnet50-v1-onnx", {"--sha256", digest})).errors,
              HasSubstr("expected " + digest));
  EXPECT_THAT(run(pull("resnet18-torchvision")).errors, HasSubstr("expected f37072fd..."));
  EXPECT_THAT(run(pull("resnet50-v1-onnx", {"--sha256", "12"})).errors, HasSubstr("64 lower-case"));
  EXPECT_FALSE(std::filesystem::exists(file_));
  EXPECT_EQ(ask(pull("resnet50-v1-onnx", {"--sha256", sha256_of(network_)}))["digits_checked"], 64);
}

TEST_F(NetworksCommandsTest, WhatTheUserVouchedForStaysRight) {
  // The catalogue has other digits of one, and another length of the other.
  for (const std::string name : {"resnet18-torchvision", "yolox-nano"}) {
    const json pulled = ask(pull(name, {"--sha256", sha256_of(network_)}));
    const json verified = ask({"networks", "verify", name})[0];
    EXPECT_TRUE(verified["right"]);
    EXPECT_EQ(verified["digits_checked"], 64);
    EXPECT_EQ(verified["vouched"], "given by the user");
    ASSERT_OK(write_file(pulled["file"].get<std::string>(), network_ + "x"));
    EXPECT_THAT(run({"networks", "verify", name}).errors, HasSubstr("is not the file"));
  }
  // One that was put there by hand is vouched for later.
  const std::string by_hand = path("roomwise/networks/yolox_nano.onnx");
  ASSERT_OK(write_file(by_hand, network_));
  std::filesystem::remove(by_hand + ".sha256");
  EXPECT_THAT(run({"networks", "verify", "yolox-nano"}).errors, HasSubstr("expected 3659407"));
  EXPECT_TRUE(ask(pull("yolox-nano", {"--sha256", sha256_of(network_)}))["was_here"]);
  EXPECT_TRUE(ask({"networks", "verify", "yolox-nano"})[0]["right"]);
}

TEST_F(NetworksCommandsTest, AFileOrAFolderServesToo) {
  ASSERT_OK(write_file(path("resnet50-v1-12.onnx"), network_));
  for (const std::string& from : {path("resnet50-v1-12.onnx"), folder_.path().string()}) {
    const std::string to = path("to" + std::to_string(from.size()));
    ask({"networks", "pull", "resnet50-v1-onnx", "--from", from, "--to", to});
    EXPECT_EQ(read_text_file(to + "/resnet50-v1-12.onnx").value(), network_);
  }
  EXPECT_TRUE(server_.requests().empty());
  EXPECT_THAT(run({"networks", "pull", "resnet50-v1-onnx", "--from", "http://localhost/"}).errors,
              HasSubstr("not an https address"));
}

TEST_F(NetworksCommandsTest, InfoTellsTheFilesDigestAndWhatHomesKnowItBy) {
  ASSERT_OK(write_file(path("tiny.onnx"), network_));
  ASSERT_OK(write_file(path("tiny.card.json"),
                       std::string_view(R"({"input": {"width": 6, "height": 4}})")));
  const json told = ask({"info", path("tiny.onnx")});
  EXPECT_EQ(told.at("sha256"), sha256_of(network_));
  EXPECT_EQ(told.at("fingerprint").get<std::string>().size(), 64U);
  EXPECT_NE(told.at("fingerprint"), told.at("sha256"));
}

TEST_F(NetworksCommandsTest, NamesThatMeanNothingAreSaidSo) {
  EXPECT_THAT(run({"networks", "pull", "inception"}).errors, HasSubstr("not in the catalogue"));
  EXPECT_THAT(run({"networks", "info", "inception"}).errors, HasSubstr("no such network"));
  EXPECT_THAT(run({"networks", "bench", "yolox-nano"}).errors,
              HasSubstr("networks pull yolox-nano"));
  EXPECT_FALSE(ask({"networks", "info", "yolox-nano"})["installed"]);
  EXPECT_THAT(run({"networks", "verify"}).errors, HasSubstr("no network of the catalogue is here"));
}

}  // namespace
}  // namespace roomwise
