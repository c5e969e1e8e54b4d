// Writes the seeds of the fuzz targets: small files of every kind, made here.

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>

#include "memory_folder.h"
#include "roomwise/base/file.h"
#include "roomwise/image/testing/exif_writer.h"
#include "roomwise/network/formats/built_in_cards.h"
#include "roomwise/network/formats/eight_bit_file.h"
#include "roomwise/network/formats/safetensors.h"
#include "roomwise/network/testing/tiny_network.h"
#include "roomwise/network/testing/torch_checkpoint.h"
#include "roomwise/recording/bytes/testing/exr_writer.h"
#include "roomwise/recording/bytes/testing/lzfse_vectors.h"
#include "roomwise/recording/phone/testing/record3d_writer.h"
#include "roomwise/recording/phone/testing/video_writer.h"
#include "roomwise/recording/robot/testing/robot_log.h"
#include "roomwise/recording/sens/testing/sens_writer.h"
#include "roomwise/service/protocol/messages.h"

namespace {

namespace fs = std::filesystem;
using namespace roomwise::testing;
using Numbers = std::vector<std::int64_t>;
using Weights = std::vector<float>;
namespace saved = roomwise::network::testing;

struct Seed {
  std::string name;
  std::string bytes;
};

// A network of one layer and what it needs beside its picture.
Seed one_layer(const std::string& operation, const std::vector<std::string>& more_inputs,
               const std::vector<std::string>& attributes,
               const std::vector<std::string>& constants, std::uint64_t opset = 13) {
  std::vector<std::string> inputs{"picture"};
  inputs.insert(inputs.end(), more_inputs.begin(), more_inputs.end());
  return {operation + ".onnx", onnx(TinyGraph{{layer(operation, inputs, {"out"}, attributes)},
                                              constants,
                                              {1, 3, 4, 6},
                                              {{"out", {1}}},
                                              opset})};
}

std::vector<Seed> onnx_seeds() {
  const Weights weights(2 * 3 * 3 * 3, 0.1F);
  std::vector<Seed> seeds{
      {"mean.onnx", mean_color_network()},
      {"empty.onnx", onnx({}, {1, 3, 4, 6}, {{"picture", {1, 3, 4, 6}}})},
      one_layer("Conv", {"w", "b"},
                {attribute("kernel_shape", Numbers{3, 3}), attribute("pads", Numbers{1, 1, 1, 1}),
                 attribute("strides", Numbers{2, 1})},
                {tensor("w", {2, 3, 3, 3}, weights), tensor("b", {2}, Weights{1, 2})}),
      one_layer("BatchNormalization", {"s", "b", "m", "v"}, {attribute("epsilon", 1e-3F)},
                {tensor("s", {3}, Weights{1, 2, 3}), tensor("b", {3}, Weights{1, 2, 3}),
                 tensor("m", {3}, Weights{1, 2, 3}), tensor("v", {3}, Weights{1, 2, 3})}),
      one_layer("MaxPool", {},
                {attribute("kernel_shape", Numbers{2, 2}), attribute("strides", Numbers{2, 2}),
                 attribute("ceil_mode", 1)},
                {}),
      one_layer("AveragePool", {},
                {attribute("kernel_shape", Numbers{3, 3}), attribute("pads", Numbers{1, 1, 1, 1}),
                 attribute("count_include_pad", 1)},
                {}),
      one_layer("Transpose", {}, {attribute("perm", Numbers{0, 2, 3, 1})}, {}),
      one_layer("Softmax", {}, {attribute("axis", 1)}, {}),
      one_layer("Reshape", {"to"}, {}, {tensor("to", {3}, Numbers{0, -1, 6})}),
      one_layer("Slice", {"b", "e", "a", "s"}, {},
                {tensor("b", {1}, Numbers{3}), tensor("e", {1}, Numbers{-100}),
                 tensor("a", {1}, Numbers{2}), tensor("s", {1}, Numbers{-2})}),
      one_layer("Pad", {"p"}, {attribute("mode", "constant")},
                {tensor("p", {8}, Numbers{0, 0, 1, 2, 0, 0, 3, 0})}),
      one_layer("Resize", {"", "s"}, {attribute("mode", "nearest")},
                {tensor("s", {4}, Weights{1, 1, 2, 2})}),
      one_layer("MatMul", {"w"}, {}, {tensor("w", {6, 2}, Weights(12, 0.5F))}),
      one_layer("Concat", {"picture"}, {attribute("axis", 1)}, {}),
      one_layer("Unsqueeze", {"a"}, {}, {tensor("a", {1}, Numbers{0})}),
      one_layer("ReduceMean", {}, {attribute("axes", Numbers{2, 3}), attribute("keepdims", 0)}, {}),
      one_layer("Gather", {"i"}, {attribute("axis", 1)}, {tensor("i", {2}, Numbers{2, 0})}),
      one_layer("Clip", {"low", "high"}, {},
                {tensor("low", {}, Weights{0}), tensor("high", {}, Weights{6})})};
  for (const char* operation : {"Relu", "Sigmoid", "HardSwish", "Flatten", "Shape", "Identity"}) {
    seeds.push_back(one_layer(operation, {}, {}, {}));
  }
  for (const char* operation : {"Add", "Mul", "Div", "Sub"}) {
    seeds.push_back(one_layer(operation, {"c"}, {}, {tensor("c", {3, 1, 1}, Weights{1, 2, 3})}));
  }
  return seeds;
}

std::vector<Seed> card_seeds() {
  std::vector<Seed> seeds;
  for (const auto& card : roomwise::network::built_in_cards()) {
    seeds.push_back({std::string(card.name) + ".json", std::string(card.text)});
  }
  return seeds;
}

std::vector<Seed> eight_bits_seeds() {
  roomwise::network::EightBitFile file;
  file.network = "../networks/tiny.onnx";
  file.sha256 = std::string(64, 'a');
  file.preprocessing = "version 1; input 6x4";
  file.ranges.input = {1, 3, 4, 6};
  file.ranges.min_channels = 65;
  file.ranges.of_layers = {{"", {0, 1}}, {"first", {-2.5F, 3}}, {"first #2", {0, 0}}};
  file.checked = "on others";
  return {{"tiny.eightbits", *roomwise::network::text_of(file)}};
}

std::string text_of(const roomwise::Bytes& bytes) {
  return {bytes.begin(), bytes.end()};
}

std::vector<Seed> weights_seeds() {
  const saved::SavedTensor matrix{{2, 3}, {3, 1}, "0", "FloatStorage", 6};
  const saved::SavedTensor turned{{3, 2}, {1, 3}, "0", "FloatStorage", 6};
  const saved::SavedTensor halves{{4}, {1}, "1", "HalfStorage", 4};
  const saved::SavedTensor count{{}, {}, "2", "LongStorage", 1};
  const std::string pickle = saved::whole_pickle(saved::state_dict(
      {{"w", matrix}, {"w.turned", turned}, {"h", halves}, {"num_batches_tracked", count}}));
  const std::map<std::string, std::string> storages{{"0", saved::raw(Weights{1, 2, 3, 4, 5, 6})},
                                                    {"1", std::string(8, '\x3c')},
                                                    {"2", saved::raw(Numbers{7})}};
  roomwise::network::Constant constant;
  constant.shape = {2, 2};
  constant.floats = {1, 2, 3, 4};
  const roomwise::network::Weights tensors{
      {"a", std::make_shared<const roomwise::network::Constant>(constant)}};
  return {{"checkpoint.pth", text_of(saved::checkpoint(pickle, storages))},
          {"packed.pth", text_of(saved::checkpoint(pickle, storages, true))},
          {"some.safetensors", text_of(roomwise::network::write_safetensors(tensors))},
          {"none.safetensors", text_of(roomwise::network::write_safetensors({}))},
          {"mean.onnx", mean_color_network()}};
}

roomwise::Expected<void> write(const fs::path& folder, const std::vector<Seed>& seeds) {
  std::error_code error;
  fs::create_directories(folder, error);
  for (const Seed& seed : seeds) {
    ROOMWISE_RETURN_IF_ERROR(roomwise::write_file(folder / seed.name, seed.bytes));
  }
  std::printf("%zu files in %s\n", seeds.size(), folder.c_str());
  return {};
}

// Each begins with the kind that protocol_fuzz.cpp reads by its first byte.
std::vector<Seed> protocol_seeds() {
  using namespace roomwise::service;
  std::vector<Seed> seeds;
  const auto add = [&](const std::string& name, char kind, std::string_view message) {
    seeds.push_back({name, kind + std::string(message)});
  };
  Hello hello;
  hello.version = kProtocolVersion;
  hello.name = "belt";
  hello.camera = DeviceCamera{640, 480, *roomwise::geometry::camera_preset("fr1"), true};
  add("hello", 0, write(DeviceMessage(hello)));
  add("ask", 0, write(DeviceMessage(Ask{7, 12.5, Question::kWhereIs, "bed"})));
  add("settings", 0, write(DeviceMessage(SettingsChange{"de", Distances::kSteps, 0.6, true})));
  add("quiet", 0, write(DeviceMessage(Quiet{true})));
  const Seen seen{12.5, "room", "kitchen", 0.9, "it looks so", SeenPosition{1, 2, 1.3, 90, 0.1}};
  add("welcome", 1, write(HomeMessage(Welcome{"flat", "device", {"bath"}, {"bed"}, true, true})));
  add("arrived", 1, write(HomeMessage(FrameArrived{12.5, 3})));
  add("seen", 1, write(HomeMessage(seen)));
  add("aim", 1, write(HomeMessage(GoalBearing{12.5, -30, 0.75, 1012.5})));
  PromptMessage prompt;
  prompt.answer_to = 7;
  prompt.text = "You are in the kitchen.";
  add("prompt", 1, write(HomeMessage(prompt)));
  add("recording", 1, write(HomeMessage(RecordingState{7, "saved", "walk", 17, ""})));
  add("job", 1, write(HomeMessage(JobState{"map", "running", "mapping", 0.4, 70.0, ""})));
  add("device", 1, write(HomeMessage(DeviceSeen{3, "belt", true, seen})));
  add("error", 1, write(HomeMessage(ErrorMessage{"no", 4})));
  const roomwise::Bytes color{1, 2, 3}, depth{4, 5};
  const roomwise::Bytes frame = write(FrameMessage{12.5, color, depth});
  add("frame", 2, {reinterpret_cast<const char*>(frame.data()), frame.size()});
  return seeds;
}

// Small files of robots, and their messages: each of these begins with the type and the encoding
// that messages_fuzz.cpp reads by its first bytes.
namespace robots = roomwise::recording::testing;
using roomwise::recording::Encoding;

std::vector<Seed> mcap_seeds() {
  std::vector<Seed> seeds;
  for (const char* packing : {"", "lz4", "zstd"}) {
    auto plan = robots::small_robot(Encoding::kCdr).plan(packing);
    plan.has_sums = false;
    seeds.push_back(
        {std::string("robot") + packing + ".mcap", text_of(robots::McapWriter::write(plan))});
  }
  auto plan = robots::small_robot(Encoding::kRos1).plan("");
  plan.has_chunks = plan.has_index = false;
  seeds.push_back({"robot_flat.mcap", text_of(robots::McapWriter::write(plan))});
  return seeds;
}

std::vector<Seed> bag_seeds() {
  std::vector<Seed> seeds;
  for (const char* packing : {"", "lz4", "bz2"}) {
    auto plan = robots::small_robot(Encoding::kRos1).plan(packing);
    seeds.push_back(
        {std::string("robot") + packing + ".bag", text_of(robots::BagWriter::write(plan))});
    plan.has_index = false;
    seeds.push_back(
        {std::string("open") + packing + ".bag", text_of(robots::BagWriter::write(plan))});
  }
  return seeds;
}

std::vector<Seed> message_seeds() {
  std::vector<Seed> seeds;
  for (const Encoding encoding : {Encoding::kRos1, Encoding::kCdr}) {
    const auto plan = robots::small_robot(encoding).plan("");
    for (const auto& chunk : plan.chunks) {
      for (const auto& message : chunk) {
        const auto type = plan.channels[message.channel].type;
        seeds.push_back({fmt::format("{}_{}", robots::encoding_name(encoding), message.channel),
                         std::string{static_cast<char>(static_cast<int>(type) - 1),
                                     static_cast<char>(encoding)} +
                             text_of(message.data)});
      }
    }
  }
  const auto raw = robots::ProtoWriter()
                       .time(1, 5)
                       .fixed32(2, 1)
                       .fixed32(3, 1)
                       .text(4, "mono8")
                       .fixed32(5, 1)
                       .blob(6, roomwise::Bytes{7})
                       .text(7, "camera");
  seeds.push_back({"protobuf_image", std::string{0, 2} + text_of(raw.all())});
  seeds.push_back(
      {"json_image",
       std::string{1, 3} +
           R"({"timestamp":{"sec":5,"nsec":7},"frame_id":"c","data":"AQIDBA==","format":"jpeg"})"});
  seeds.push_back(
      {"json_camera",
       std::string{2, 3} +
           R"({"width":4,"height":3,"distortion_model":"","D":[],"K":[1,0,2,0,1,1,0,0,1],"P":[]})"});
  return seeds;
}

std::vector<Seed> sens_seeds() {
  robots::SensPlan plan;
  plan.color_width = 16;
  plan.color_height = 12;
  std::vector<Seed> seeds{{"zlib.sens", text_of(robots::sens_file(plan))}};
  plan.depth_packing = 0;
  seeds.push_back({"plain.sens", text_of(robots::sens_file(plan))});
  return seeds;
}

std::vector<Seed> record3d_seeds() {
  const fs::path path = fs::temp_directory_path() / "roomwise-seed.r3d";
  const bool is_written = robots::write_zip(path, robots::phone_files());
  const auto bytes = roomwise::read_file(path);
  std::error_code ignored;
  fs::remove(path, ignored);
  if (!is_written || !bytes) return {};
  return {{"two.r3d", text_of(*bytes)}};
}

// The files of a folder, as memory_folder.h reads them.
class FolderSeed {
 public:
  FolderSeed& add(const std::string& name, const std::string& content) {
    if (!bytes_.empty()) bytes_ += MemoryFolder::kBetween;
    bytes_ += name + "\n" + content;
    return *this;
  }
  FolderSeed& add(const std::string& name, const roomwise::Bytes& content) {
    return add(name, text_of(content));
  }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

roomwise::Bytes small_jpeg() {
  return roomwise::image::encode_jpeg(roomwise::image::ColorImage(16, 12, {90, 80, 70}), 90);
}
roomwise::Bytes small_png(int width, int height) {
  return roomwise::image::encode_png(roomwise::image::ColorImage(width, height, {90, 80, 70}));
}
roomwise::Bytes small_depth(int width, int height) {
  return roomwise::image::encode_png(roomwise::image::DepthImage(width, height, 1500));
}

std::vector<Seed> scanner_app_seeds() {
  FolderSeed folder;
  for (int i = 0; i < 3; ++i) {
    folder.add(fmt::format("frame_{:05}.json", i),
               fmt::format(R"({{"time": {}, "intrinsics": [14, 0, 8, 0, 14, 6, 0, 0, 1],)"
                           R"( "cameraPoseARFrame": [1,0,0,{},0,1,0,1.5,0,0,1,0,0,0,0,1]}})",
                           100 + 0.2 * i, 0.5 * i));
    folder.add(fmt::format("depth_{:05}.png", i), small_depth(8, 6));
    if (i != 1) folder.add(fmt::format("frame_{:05}.jpg", i), small_jpeg());
  }
  return {{"three", folder.bytes()}};
}

std::vector<Seed> polycam_seeds() {
  std::vector<Seed> seeds;
  for (const std::string which : {"", "corrected_"}) {
    FolderSeed folder;
    for (int i = 0; i < 2; ++i) {
      const std::string name = std::to_string(5'000'000 + 100'000 * i);
      folder.add("keyframes/" + which + "cameras/" + name + ".json",
                 fmt::format(R"({{"fx":14,"fy":14,"cx":8,"cy":6,"width":16,"height":12,)"
                             R"("t_00":1,"t_01":0,"t_02":0,"t_03":{},"t_10":0,"t_11":1,"t_12":0,)"
                             R"("t_13":0,"t_20":0,"t_21":0,"t_22":1,"t_23":0}})",
                             i));
      folder.add("keyframes/" + which + "images/" + name + ".jpg", small_jpeg());
      folder.add("keyframes/depth/" + name + ".png", small_depth(8, 6));
    }
    seeds.push_back({which + "two", folder.bytes()});
  }
  return seeds;
}

std::vector<Seed> arkitscenes_seeds() {
  std::vector<Seed> seeds;
  for (const std::string which : {"lowres_wide", "vga_wide"}) {
    FolderSeed folder;
    for (const std::string time : {"12.345", "12.445"}) {
      const std::string name = "/4242_" + time;
      folder.add(which + name + ".png", small_png(16, 12));
      folder.add("lowres_depth" + name + ".png", small_depth(8, 6));
      folder.add(which + "_intrinsics" + name + ".pincam", std::string("16 12 14 14 8 6\n"));
    }
    folder.add("lowres_wide.traj", std::string("12.3449 0 3.1415 0 1 2 3\n12.4449 0 0 0 1 2 3\n"));
    seeds.push_back({which, folder.bytes()});
  }
  return seeds;
}

std::vector<Seed> seven_scenes_seeds() {
  FolderSeed folder;
  for (int i = 0; i < 2; ++i) {
    const std::string name = fmt::format("frame-{:06}", i);
    folder.add(name + ".color.png", small_png(640, 480));
    folder.add(name + ".depth.png", small_depth(640, 480));
    folder.add(name + ".pose.txt", std::string("0 0 1 4\n0 1 0 5\n-1 0 0 6\n0 0 0 1\n"));
  }
  return {{"two", folder.bytes()}};
}

std::vector<Seed> stray_scanner_seeds() {
  const fs::path path = fs::temp_directory_path() / "roomwise-seed.mp4";
  const bool is_written = robots::write_grey_video(path, 3, AV_CODEC_ID_MPEG4, 2, 16, 16);
  const auto video = roomwise::read_file(path);
  std::error_code ignored;
  fs::remove(path, ignored);
  if (!is_written || !video) return {};
  const std::string header = "timestamp, frame, x, y, z, qx, qy, qz, qw";
  std::vector<Seed> seeds;
  for (const bool is_newer : {false, true}) {
    std::string table = header + (is_newer ? ", fx, fy, cx, cy\n" : "\n");
    FolderSeed folder;
    for (int i = 0; i < 3; ++i) {
      table += fmt::format("{:.3f}, {:06}, 0.1, 0, 1.5, 0, 1, 0, 0{}\n", 7 + 0.017 * i, i,
                           is_newer ? ", 14, 14, 8, 8" : "");
      folder.add(fmt::format("depth/{:06}.png", i), small_depth(8, 8));
    }
    folder.add("odometry.csv", table);
    folder.add("camera_matrix.csv", std::string("14, 0, 8\n0, 14, 8\n0, 0, 1\n"));
    folder.add("rgb.mp4", *video);
    seeds.push_back({is_newer ? "newer" : "older", folder.bytes()});
  }
  return seeds;
}

std::vector<Seed> record3d_exr_seeds() {
  const robots::ZipContents files = robots::phone_files();
  FolderSeed folder;
  folder.add("metadata.json", files.at("metadata"));
  for (const std::string number : {"0", "1"}) {
    folder.add("rgb/" + number + ".jpg", files.at("rgbd/" + number + ".jpg"));
    folder.add("depth/" + number + ".exr", robots::exr_file({}));
  }
  return {{"two", folder.bytes()}};
}

std::vector<Seed> exr_seeds() {
  std::vector<Seed> seeds;
  for (const int packing : {0, 2, 3}) {
    robots::ExrPlan plan;
    plan.height = 21;
    plan.packing = static_cast<std::uint8_t>(packing);
    seeds.push_back({fmt::format("half_{}.exr", packing), text_of(robots::exr_file(plan))});
    plan.is_half = false;
    plan.channels = {"A", "R"};
    seeds.push_back({fmt::format("float_{}.exr", packing), text_of(robots::exr_file(plan))});
  }
  return seeds;
}

std::vector<Seed> exif_seeds() {
  using namespace roomwise::image::testing;
  return {{"phone", text_of(ExifWriter(true).write(kPhoneExif))},
          {"phone_little", text_of(ExifWriter(false).write(kPhoneExif))}};
}

std::vector<Seed> question_seeds() {
  return {{"english", "Where did I leave my keys?"},
          {"german", "Bring mich bitte zum Klo"},
          {"spanish", "¿Qué hay encima de la mesa?"},
          {"french", "Où est l'armoire ?"},
          {"no_utf8", "take me to the \xFF\xC3kichen"}};
}

std::vector<Seed> lzfse_seeds() {
  return {{"lzfse", text_of(robots::from_hex(robots::kLzfseBlock))},
          {"lzvn", text_of(robots::from_hex(robots::kLzvnBlock))},
          {"plain", text_of(robots::lzfse(roomwise::Bytes(20, 'a')))}};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s FOLDER\n", argv[0]);
    return 2;
  }
  const fs::path corpus = argv[1];
  const std::vector<Seed> list{
      {"catalogue.json", std::string(roomwise::network::built_in_catalogue())}};
  for (const auto& written : {write(corpus / "onnx", onnx_seeds()),
                              write(corpus / "model_card", card_seeds()),
                              write(corpus / "eight_bits", eight_bits_seeds()),
                              write(corpus / "catalogue", list),
                              write(corpus / "weights", weights_seeds()),
                              write(corpus / "protocol", protocol_seeds()),
                              write(corpus / "question", question_seeds()),
                              write(corpus / "mcap", mcap_seeds()),
                              write(corpus / "ros1_bag", bag_seeds()),
                              write(corpus / "messages", message_seeds()),
                              write(corpus / "sens", sens_seeds()),
                              write(corpus / "record3d", record3d_seeds()),
                              write(corpus / "lzfse", lzfse_seeds()),
                              write(corpus / "exr", exr_seeds()),
                              write(corpus / "record3d_exr", record3d_exr_seeds()),
                              write(corpus / "exif", exif_seeds()),
                              write(corpus / "scanner_app", scanner_app_seeds()),
                              write(corpus / "polycam", polycam_seeds()),
                              write(corpus / "arkitscenes", arkitscenes_seeds()),
                              write(corpus / "seven_scenes", seven_scenes_seeds()),
                              write(corpus / "stray_scanner", stray_scanner_seeds())}) {
    if (written) continue;
    std::fprintf(stderr, "%s\n", written.error().message.c_str());
    return 1;
  }
  return 0;
}
