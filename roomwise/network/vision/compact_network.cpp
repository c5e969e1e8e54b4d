#include "roomwise/network/vision/compact_network.h"

namespace roomwise::network {
namespace {

using GraphValue = GraphBuilder::Value;

constexpr std::int64_t kSide_px = 128;

class Layers {
 public:
  explicit Layers(GraphBuilder& builder) : builder_(builder) {}

  GraphValue convolved(const GraphValue& from, const std::string& name, std::int64_t outputs,
                       std::int64_t stride) {
    const GraphValue sums =
        builder_.convolution(from, name + ".conv", {outputs, {3, 3}, {stride, stride}, {1, 1}});
    return builder_.batch_norm(sums, name + ".bn");
  }
  GraphValue layer(const GraphValue& from, const std::string& name, std::int64_t outputs,
                   std::int64_t stride) {
    return builder_.relu(convolved(from, name, outputs, stride), name);
  }
  // Half as large, then a pair of convolutions and the sum past them.
  GraphValue stage(const GraphValue& from, const std::string& name, std::int64_t outputs) {
    const GraphValue halved = layer(from, name + ".halved", outputs, 2);
    const GraphValue first = layer(halved, name + ".first", outputs, 1);
    const GraphValue second = convolved(first, name + ".second", outputs, 1);
    return builder_.relu(builder_.add(halved, second, name + ".sum"), name);
  }

 private:
  GraphBuilder& builder_;
};

}  // namespace

OnnxGraph compact_network(const CompactOptions& options) {
  GraphBuilder builder(options.weights);
  Layers layers(builder);
  const GraphValue picture = builder.input("picture", {options.batch, 3, kSide_px, kSide_px});
  const GraphValue stem = layers.layer(picture, "stem", 16, 2);
  const GraphValue quarter = layers.layer(stem, "quarter", 32, 2);
  const GraphValue eighth = layers.stage(quarter, "eighth", 64);
  const GraphValue sixteenth = layers.stage(eighth, "sixteenth", 128);
  const GraphValue last = layers.layer(sixteenth, "last", 256, 2);
  const GraphValue pooled = builder.global_average_pool(last, "pool");
  const GraphValue features = builder.flatten(pooled, "features");
  builder.output(builder.linear(features, "logits", options.classes));
  return builder.take();
}

ModelCard compact_card() {
  constexpr float kMiddle = 127.5F;
  ModelCard card;
  card.name = "roomwise-compact";
  card.input_width_px = card.input_height_px = static_cast<int>(kSide_px);
  card.mean = {kMiddle, kMiddle, kMiddle};
  card.scale = {1 / kMiddle, 1 / kMiddle, 1 / kMiddle};
  card.features_outputs = {"features"};
  card.scores_output = "logits";
  card.scores_need_softmax = true;
  return card;
}

}  // namespace roomwise::network
