#include "roomwise/network/graph/inception_v3.h"

namespace roomwise::network {
namespace {

using GraphValue = GraphBuilder::Value;
using Sides = std::array<std::int64_t, 2>;

constexpr PoolingShape kHalving{{3, 3}, {2, 2}, {0, 0}};

// One block of the network: its branches are named after it.
class Block {
 public:
  Block(GraphBuilder& builder, std::string name) : builder_(builder), name_(std::move(name)) {}

  // A convolution of the kernel, batch norm and ReLU; the size stays the same.
  GraphValue same(const GraphValue& from, const char* branch, std::int64_t outputs, Sides kernel) {
    return convolve(from, branch, {outputs, kernel, {1, 1}, {kernel[0] / 2, kernel[1] / 2}});
  }
  // The same without padding, which halves the size at a stride of 2.
  GraphValue inside(const GraphValue& from, const char* branch, std::int64_t outputs, Sides kernel,
                    std::int64_t stride) {
    return convolve(from, branch, {outputs, kernel, {stride, stride}, {0, 0}});
  }
  // The mean around each place, then a 1x1 convolution.
  GraphValue mean_branch(const GraphValue& from, std::int64_t outputs) {
    const GraphValue mean =
        builder_.average_pool(from, name_ + ".avg_pool", {{3, 3}, {1, 1}, {1, 1}});
    return same(mean, "branch_pool", outputs, {1, 1});
  }
  GraphValue halved(const GraphValue& from) {
    return builder_.max_pool(from, name_ + ".max_pool", kHalving);
  }
  GraphValue join(std::initializer_list<GraphValue> branches, const char* name = nullptr) {
    return builder_.concat({branches.begin(), branches.size()},
                           name == nullptr ? name_ : name_ + "." + name);
  }

 private:
  GraphValue convolve(const GraphValue& from, const char* branch, const ConvolutionShape& shape) {
    constexpr float kEpsilon = 0.001F;
    const std::string name = (name_.empty() ? "" : name_ + ".") + branch;
    const GraphValue sums = builder_.convolution(from, name + ".conv", shape);
    return builder_.relu(builder_.batch_norm(sums, name + ".bn", kEpsilon), name);
  }

  GraphBuilder& builder_;
  std::string name_;
};

// The three kinds of blocks that keep the size (figures 5, 6 and 7 of the paper) and the two that
// halve it (figure 10); the letters are torchvision's.
GraphValue block_a(GraphBuilder& builder, const GraphValue& from, const char* name,
                   std::int64_t of_mean) {
  Block block(builder, name);
  const GraphValue wide = block.same(from, "branch5x5_1", 48, {1, 1});
  const GraphValue first = block.same(from, "branch3x3dbl_1", 64, {1, 1});
  const GraphValue second = block.same(first, "branch3x3dbl_2", 96, {3, 3});
  return block.join(
      {block.same(from, "branch1x1", 64, {1, 1}), block.same(wide, "branch5x5_2", 64, {5, 5}),
       block.same(second, "branch3x3dbl_3", 96, {3, 3}), block.mean_branch(from, of_mean)});
}

GraphValue block_b(GraphBuilder& builder, const GraphValue& from, const char* name) {
  Block block(builder, name);
  const GraphValue first = block.same(from, "branch3x3dbl_1", 64, {1, 1});
  const GraphValue second = block.same(first, "branch3x3dbl_2", 96, {3, 3});
  return block.join({block.inside(from, "branch3x3", 384, {3, 3}, 2),
                     block.inside(second, "branch3x3dbl_3", 96, {3, 3}, 2), block.halved(from)});
}

GraphValue block_c(GraphBuilder& builder, const GraphValue& from, const char* name,
                   std::int64_t narrow) {
  Block block(builder, name);
  GraphValue once = block.same(from, "branch7x7_1", narrow, {1, 1});
  once = block.same(once, "branch7x7_2", narrow, {1, 7});
  once = block.same(once, "branch7x7_3", 192, {7, 1});
  GraphValue twice = block.same(from, "branch7x7dbl_1", narrow, {1, 1});
  twice = block.same(twice, "branch7x7dbl_2", narrow, {7, 1});
  twice = block.same(twice, "branch7x7dbl_3", narrow, {1, 7});
  twice = block.same(twice, "branch7x7dbl_4", narrow, {7, 1});
  twice = block.same(twice, "branch7x7dbl_5", 192, {1, 7});
  return block.join(
      {block.same(from, "branch1x1", 192, {1, 1}), once, twice, block.mean_branch(from, 192)});
}

GraphValue block_d(GraphBuilder& builder, const GraphValue& from, const char* name) {
  Block block(builder, name);
  const GraphValue narrow = block.same(from, "branch3x3_1", 192, {1, 1});
  GraphValue long_way = block.same(from, "branch7x7x3_1", 192, {1, 1});
  long_way = block.same(long_way, "branch7x7x3_2", 192, {1, 7});
  long_way = block.same(long_way, "branch7x7x3_3", 192, {7, 1});
  return block.join({block.inside(narrow, "branch3x3_2", 320, {3, 3}, 2),
                     block.inside(long_way, "branch7x7x3_4", 192, {3, 3}, 2), block.halved(from)});
}

GraphValue block_e(GraphBuilder& builder, const GraphValue& from, const char* name) {
  Block block(builder, name);
  const GraphValue narrow = block.same(from, "branch3x3_1", 384, {1, 1});
  const GraphValue split = block.join({block.same(narrow, "branch3x3_2a", 384, {1, 3}),
                                       block.same(narrow, "branch3x3_2b", 384, {3, 1})},
                                      "branch3x3");
  const GraphValue first = block.same(from, "branch3x3dbl_1", 448, {1, 1});
  const GraphValue second = block.same(first, "branch3x3dbl_2", 384, {3, 3});
  const GraphValue split_twice = block.join({block.same(second, "branch3x3dbl_3a", 384, {1, 3}),
                                             block.same(second, "branch3x3dbl_3b", 384, {3, 1})},
                                            "branch3x3dbl");
  return block.join({block.same(from, "branch1x1", 320, {1, 1}), split, split_twice,
                     block.mean_branch(from, 192)});
}

GraphValue stem(GraphBuilder& builder, const GraphValue& picture) {
  Block block(builder, "");
  GraphValue value = block.inside(picture, "Conv2d_1a_3x3", 32, {3, 3}, 2);
  value = block.inside(value, "Conv2d_2a_3x3", 32, {3, 3}, 1);
  value = block.same(value, "Conv2d_2b_3x3", 64, {3, 3});
  value = builder.max_pool(value, "maxpool1", kHalving);
  value = block.inside(value, "Conv2d_3b_1x1", 80, {1, 1}, 1);
  value = block.inside(value, "Conv2d_4a_3x3", 192, {3, 3}, 1);
  return builder.max_pool(value, "maxpool2", kHalving);
}

GraphValue auxiliary_head(GraphBuilder& builder, const GraphValue& from, std::int64_t classes) {
  Block block(builder, "AuxLogits");
  const GraphValue mean =
      builder.average_pool(from, "AuxLogits.avg_pool", {{5, 5}, {3, 3}, {0, 0}});
  const GraphValue narrow = block.same(mean, "conv0", 128, {1, 1});
  const GraphValue wide = block.inside(narrow, "conv1", 768, {5, 5}, 1);
  const GraphValue pooled = builder.global_average_pool(wide, "AuxLogits.pool");
  return builder.linear(builder.flatten(pooled, "AuxLogits.features"), "AuxLogits.fc", classes);
}

}  // namespace

OnnxGraph inception_v3(const InceptionOptions& options) {
  GraphBuilder builder(options.weights);
  GraphValue value =
      stem(builder, builder.input("picture", {options.batch, 3, options.side_px, options.side_px}));
  value = block_a(builder, value, "Mixed_5b", 32);
  value = block_a(builder, value, "Mixed_5c", 64);
  value = block_a(builder, value, "Mixed_5d", 64);
  value = block_b(builder, value, "Mixed_6a");
  value = block_c(builder, value, "Mixed_6b", 128);
  value = block_c(builder, value, "Mixed_6c", 160);
  value = block_c(builder, value, "Mixed_6d", 160);
  const GraphValue middle = block_c(builder, value, "Mixed_6e", 192);
  value = block_d(builder, middle, "Mixed_7a");
  value = block_e(builder, value, "Mixed_7b");
  value = block_e(builder, value, "Mixed_7c");
  value = builder.flatten(builder.global_average_pool(value, "avgpool"), "features");
  builder.output(builder.linear(builder.dropout(value, "dropout"), "fc", options.classes));
  if (options.has_auxiliary_head) builder.output(auxiliary_head(builder, middle, options.classes));
  return builder.take();
}

}  // namespace roomwise::network
