#include "roomwise/network/formats/weights_file.h"

#include <gmock/gmock.h>

#include "roomwise/base/random.h"
#include "roomwise/network/formats/onnx_writer.h"
#include "roomwise/network/formats/pickle.h"
#include "roomwise/network/formats/safetensors.h"
#include "roomwise/network/formats/torch_checkpoint_reader.h"
#include "roomwise/network/graph/inception_v3.h"
#include "roomwise/network/testing/more_layers.h"
#include "roomwise/network/testing/tiny_runs.h"
#include "roomwise/network/testing/torch_checkpoint.h"

namespace roomwise::network {
namespace {

using namespace testing;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Two views of one storage (one turned round), halves, brain floats, doubles and a count.
Bytes varied_checkpoint() {
  const std::string pickle =
      whole_pickle(state_dict({{"a.weight", {{2, 3}, {3, 1}, "0", "FloatStorage", 6, 0}},
                               {"a.turned", {{3, 1}, {1, 3}, "0", "FloatStorage", 6, 3}},
                               {"a.transposed", {{3, 2}, {1, 3}, "0", "FloatStorage", 6, 0}},
                               {"half", {{2}, {1}, "1", "HalfStorage", 2, 0}},
                               {"brain", {{1, 2}, {2, 1}, "2", "BFloat16Storage", 2, 0}},
                               {"double", {{}, {}, "3", "DoubleStorage", 1, 0}},
                               {"bn.num_batches_tracked", {{}, {}, "4", "LongStorage", 1, 0}}}));
  return checkpoint(pickle, {{"0", raw<float>({1, 2, 3, 4, 5, 6})},
                             {"1", raw<std::uint16_t>({0x3C00, 0xC100})},
                             {"2", raw<std::uint16_t>({0x3F80, 0xC040})},
                             {"3", raw<double>({0.5})},
                             {"4", raw<std::int64_t>({7})}});
}

TEST(TorchCheckpoint, IsReadWhole) {
  const auto weights = read_weights(varied_checkpoint());
  ASSERT_OK(weights);
  ASSERT_EQ(weights->size(), 7u);
  const auto floats = [&](const char* name) { return weights->at(name)->floats; };
  EXPECT_EQ(weights->at("a.weight")->shape, (Shape{2, 3}));
  EXPECT_THAT(floats("a.weight"), ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_THAT(floats("a.turned"), ElementsAre(4, 5, 6));
  EXPECT_THAT(floats("a.transposed"), ElementsAre(1, 4, 2, 5, 3, 6));
  EXPECT_THAT(floats("half"), ElementsAre(1, -2.5F));
  EXPECT_THAT(floats("brain"), ElementsAre(1, -3));
  EXPECT_THAT(floats("double"), ElementsAre(0.5F));
  EXPECT_TRUE(weights->at("bn.num_batches_tracked")->is_integer);
  EXPECT_THAT(weights->at("bn.num_batches_tracked")->integers, ElementsAre(7));
}

const SavedTensor kOne{{1}, {1}, "0", "FloatStorage", 1, 0};
Bytes checkpoint_of(const SavedTensor& tensor) {
  return checkpoint(whole_pickle(state_dict({{"w", tensor}})), {{"0", raw<float>({2})}});
}

TEST(TorchCheckpoint, FindsTheStateDictOfATrainingRun) {
  const std::string pickle = whole_pickle("}(" + pickled("epoch") + pickled(3) +
                                          pickled("state_dict") + state_dict({{"w", kOne}}) + "u");
  const auto weights = read_weights(checkpoint(pickle, {{"0", raw<float>({2})}}));
  ASSERT_OK(weights);
  EXPECT_THAT(weights->at("w")->floats, ElementsAre(2));
}

TEST(TorchCheckpoint, OfCppIsReadToo) {
  const std::string dictionary = "}(" + pickled("w") + pickled(kOne) + "u";
  const std::string pickle = whole_pickle(global("torch.jit._pickle", "restore_type_tag") +
                                          dictionary + pickled("Dict[str, Tensor]") + "\x86R");
  const auto weights = read_weights(checkpoint(pickle, {{"0", raw<float>({2})}}));
  ASSERT_OK(weights);
  EXPECT_THAT(weights->at("w")->floats, ElementsAre(2));
}

TEST(TorchCheckpoint, RunsNothing) {
  for (const std::string& asked :
       {global("os", "system"), global("posix", "system"), global("builtins", "eval"),
        global("torch._utils", "_rebuild_tensor_v2.__globals__")}) {
    const Bytes evil =
        checkpoint(whole_pickle(asked + "(" + pickled("touch /tmp/evil") + "tR"), {});
    EXPECT_ERROR(read_weights(evil), "nothing was run");
  }
  EXPECT_ERROR(read_weights(checkpoint(whole_pickle("(" + pickled("x") + "ios\nsystem\n"), {})),
               "opcode 0x69: a dictionary of tensors does not need it");
}

TEST(TorchCheckpoint, RefusesTensorsThatLie) {
  SavedTensor tensor = kOne;
  EXPECT_OK(read_weights(checkpoint_of(tensor)));
  tensor.shape = {2};
  EXPECT_ERROR(read_weights(checkpoint_of(tensor)),
               "tensor \"w\": it ends at the number 1 of a storage of 1");
  tensor.shape = {1 << 29};
  tensor.strides = {0};
  EXPECT_ERROR(read_weights(checkpoint_of(tensor)), "\"w\": it is larger than the file can hold");
  tensor = kOne;
  tensor.numbers = 2;
  EXPECT_ERROR(read_weights(checkpoint_of(tensor)), "\"w\": its storage \"0\" has 1 numbers");
  tensor = kOne;
  tensor.offset = 1;
  EXPECT_ERROR(read_weights(checkpoint_of(tensor)), "ends at the number 1");
  tensor = kOne;
  tensor.storage = "9";
  EXPECT_ERROR(read_weights(checkpoint_of(tensor)), "lacks \"archive/data/9\"");
  tensor = kOne;
  tensor.strides = {1, 1};
  EXPECT_ERROR(read_weights(checkpoint_of(tensor)), "its shape 1 is impossible");
  tensor = kOne;
  tensor.type = "ByteStorage";
  EXPECT_ERROR(read_weights(checkpoint_of(tensor)), "torch.ByteStorage");
}

TEST(TorchCheckpoint, RefusesOtherArchives) {
  EXPECT_ERROR(read_weights(zip_archive({{"picture.png", "x"}})), "without data.pkl");
  EXPECT_ERROR(read_weights(zip_archive({{"a/data.pkl", "x"}, {"b/data.pkl", "x"}})),
               "more than one data.pkl");
  EXPECT_ERROR(read_weights(checkpoint(std::string(5000, 'N'), {}, true)), "packed");
  const std::string old("\x80\x02\x8a\x0a\x6c\xfc\x9c\x46\xf9\x20\x6a\xa8\x50\x19.", 15);
  EXPECT_ERROR(read_weights(testing::bytes_of(old)), "before PyTorch 1.6");
  EXPECT_ERROR(read_weights(checkpoint(whole_pickle(pickled(5)), {})), "holds no state dict");
}

TEST(Pickle, NeverTakesMuchMoreThanItHas) {
  const std::string many = "\x80\x02" + std::string(std::size_t{3} << 20, ')') + ".";
  EXPECT_ERROR(read_pickle(testing::bytes_of(many), {}), "too many objects");
  for (const char* text :
       {"\x80\x02X\xff\xff\xff\xff", "\x80\x02(", "\x80\x02R.", "\x80\x02h\x01.", "\x80\x02t.",
        "\x80\x02NN.", "\x80\x02(\x85.", "\x80\x02}(Nu.", "N", ""}) {
    EXPECT_FALSE(read_pickle(testing::bytes_of(std::string(text)), {}).has_value()) << text;
  }
}

// Whatever the bytes say, there are weights or an error, but no crash and no endless memory.
void expect_survives_damage(const Bytes& whole) {
  RandomStream random(3);
  int refused = 0;
  for (int round = 0; round < 3000; ++round) {
    Bytes damaged = whole;
    for (std::uint64_t i = 0; i <= random.index(4); ++i)
      damaged[random.index(damaged.size())] = static_cast<std::uint8_t>(random.index(256));
    refused += read_weights(damaged) ? 0 : 1;
  }
  EXPECT_GT(refused, 300);
  for (std::size_t kept = 0; kept < whole.size(); ++kept)
    EXPECT_FALSE(read_weights(std::span(whole).first(kept)).has_value()) << kept;
}

TEST(TorchCheckpoint, SurvivesDamage) {
  expect_survives_damage(varied_checkpoint());
}

// The zip's check sums hide the pickle from the damage above.
TEST(Pickle, SurvivesDamage) {
  const std::string whole = whole_pickle(state_dict({{"w", kOne}, {"v", kOne}}));
  constexpr std::array<std::string_view, 2> kGlobals{"torch._utils._rebuild_tensor_v2",
                                                     "torch.FloatStorage"};
  ASSERT_OK(read_pickle(testing::bytes_of(whole), kGlobals));
  RandomStream random(5);
  int survived = 0;
  for (int round = 0; round < 20000; ++round) {
    std::string damaged = whole;
    for (std::uint64_t i = 0; i <= random.index(4); ++i)
      damaged[random.index(damaged.size())] = static_cast<char>(random.index(256));
    const auto pickle = read_pickle(testing::bytes_of(damaged), kGlobals);
    survived += pickle ? 1 : 0;
    // What was read names only what is there.
    for (std::size_t i = 0; pickle && i < pickle->values.size(); ++i) {
      for (const std::size_t item : pickle->values[i].items) ASSERT_LT(item, pickle->values.size());
    }
  }
  EXPECT_GT(survived, 100);
  EXPECT_LT(survived, 19000);
}

Weights some_weights() {
  const auto constant = [](Shape shape, std::vector<float> floats) {
    Constant made;
    made.shape = std::move(shape);
    made.floats = std::move(floats);
    return std::make_shared<const Constant>(std::move(made));
  };
  Constant count;
  count.is_integer = true;
  count.integers = {-3};
  return {{"b", constant({2, 2}, {1, 2, 3, -0.0F})},
          {"a\"\\ name", constant({3}, {1e-20F, 5, 6})},
          {"count", std::make_shared<const Constant>(std::move(count))}};
}

TEST(Safetensors, AreReadBackToTheBit) {
  const Weights weights = some_weights();
  const Bytes bytes = write_safetensors(weights);
  const auto read = read_weights(bytes);
  ASSERT_OK(read);
  ASSERT_EQ(read->size(), weights.size());
  for (const auto& [name, constant] : weights) {
    EXPECT_EQ(read->at(name)->shape, constant->shape) << name;
    EXPECT_EQ(read->at(name)->floats, constant->floats) << name;
    EXPECT_EQ(read->at(name)->integers, constant->integers) << name;
  }
  EXPECT_EQ(write_safetensors(*read), bytes);
}

Bytes safetensors_of(const std::string& header, const std::string& data) {
  const std::string text = little(header.size(), 8) + header + data;
  return {text.begin(), text.end()};
}

TEST(Safetensors, OfOtherNumbersAreReadToo) {
  const auto weights = read_weights(safetensors_of(
      R"({"__metadata__":{"format":"pt"},"h":{"dtype":"F16","shape":[1],"data_offsets":[0,2]},)"
      R"("f":{"dtype":"BF16","shape":[1,1],"data_offsets":[2,4]}})",
      raw<std::uint16_t>({0x3C00, 0x4000})));
  ASSERT_OK(weights);
  EXPECT_THAT(weights->at("h")->floats, ElementsAre(1));
  EXPECT_THAT(weights->at("f")->floats, ElementsAre(2));
}

TEST(Safetensors, RefusesTensorsThatLie) {
  const auto read = [](const std::string& tensors) {
    return read_weights(safetensors_of(tensors, std::string(8, 'x')));
  };
  EXPECT_OK(read(R"({"w":{"dtype":"F32","shape":[2],"data_offsets":[0,8]}})"));
  EXPECT_ERROR(read(R"({"w":{"dtype":"F32","shape":[3],"data_offsets":[0,12]}})"),
               "tensor \"w\" lies from byte 0 to 12 of 8");
  EXPECT_ERROR(read(R"({"w":{"dtype":"F32","shape":[3],"data_offsets":[0,8]}})"),
               "\"w\" has 8 bytes, not those of F32 of the shape 3");
  EXPECT_ERROR(
      read(R"({"w":{"dtype":"F32","shape":[4611686018427387904,4],"data_offsets":[0,8]}})"),
      "\"w\" has 8 bytes");
  EXPECT_ERROR(read(R"({"w":{"dtype":"F32","shape":[-2],"data_offsets":[0,8]}})"), "\"w\" lacks");
  EXPECT_ERROR(read(R"({"w":{"dtype":"F8","shape":[8],"data_offsets":[0,8]}})"), "of the type F8");
  EXPECT_ERROR(read(R"({"w":7})"), "\"w\" lacks its dtype");
  EXPECT_ERROR(read(R"({"v":{"dtype":"F32","shape":[2],"data_offsets":[0,8]},)"
                    R"("w":{"dtype":"F32","shape":[2],"data_offsets":[0,8]}})"),
               "\"v\" and \"w\" overlap");
  EXPECT_ERROR(read(R"({"w":)"), "whose header is no JSON");
  EXPECT_ERROR(read_weights(testing::bytes_of(little(1000, 8) + "{}")), "cut off");
}

TEST(Safetensors, SurvivesDamage) {
  expect_survives_damage(write_safetensors(some_weights()));
}

OnnxGraph tiny_graph() {
  GraphBuilder builder;
  auto x = builder.input("picture", {1, 3, 8, 8});
  x = builder.batch_norm(builder.convolution(x, "c", {4, {3, 3}}), "bn");
  x = builder.flatten(builder.global_average_pool(testing::relu6(builder, x, "r"), "pool"), "flat");
  builder.output(builder.linear(builder.dropout(x, "drop"), "fc", 2));
  return builder.take();
}

TEST(Weights, AreTakenFromEveryKindOfFile) {
  const OnnxGraph source = tiny_graph();
  Weights weights;
  for (const std::string& name : parameters_of(source)) weights[name] = source.constants.at(name);
  OnnxGraph graph = tiny_graph();
  for (const std::string& name : parameters_of(graph)) {
    Constant zeros = *graph.constants.at(name);
    std::ranges::fill(zeros.floats, 0.0F);
    graph.constants[name] = std::make_shared<const Constant>(std::move(zeros));
  }
  const auto read = read_weights(write_safetensors(weights));
  ASSERT_OK(read);
  ASSERT_OK(apply_weights(graph, *read));
  for (const auto& [name, constant] : source.constants)
    EXPECT_EQ(graph.constants.at(name)->floats, constant->floats) << name;
  // An ONNX file's limits and rates are no weights; those of the graph stay.
  const auto file = write_onnx_graph(source);
  ASSERT_OK(file);
  const auto initializers = read_weights(*file);
  ASSERT_OK(initializers);
  EXPECT_OK(apply_weights(graph, *initializers));
}

TEST(Weights, ThatDoNotFitAreAllNamed) {
  OnnxGraph graph = tiny_graph();
  Weights weights;
  for (const std::string& name : parameters_of(graph)) weights[name] = graph.constants.at(name);
  weights["bn.num_batches_tracked"] = some_weights().at("count");
  weights["AuxLogits.fc.bias"] = some_weights().at("b");
  EXPECT_OK(apply_weights(graph, weights));
  const auto before = graph.constants.at("fc.weight");
  weights["fc.weight"] = some_weights().at("b");
  weights.erase("bn.running_var");
  weights["surplus"] = some_weights().at("b");
  EXPECT_ERROR(apply_weights(graph, weights),
               "\"bn.running_var\" is missing; \"fc.weight\" is 2x2 instead of 2x4; "
               "\"surplus\" has no place in the network");
  EXPECT_EQ(graph.constants.at("fc.weight"), before);
}

}  // namespace
}  // namespace roomwise::network
