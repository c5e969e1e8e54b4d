#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "roomwise/base/simd.h"
#include "roomwise/features/feature_extractor.h"

namespace roomwise::features {

// Real descriptors in whole numbers, so that their squared distances are exact: the same with
// every processor's instructions, in whatever order they add. Rounding moves a descriptor of unit
// length by some 2e-4 of it, far less than noise does.
class QuantizedDescriptors {
 public:
  static constexpr int kUnit = 1 << 14;     // stands for 1
  static constexpr std::size_t kBlock = 8;  // descriptors that stand side by side

  // The descriptors of these rows. Values outside [-1, 1], which a descriptor of unit length has
  // not, become the nearest inside.
  QuantizedDescriptors(const FloatDescriptors& descriptors, std::span<const std::uint32_t> rows);

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::size_t blocks() const { return (size_ + kBlock - 1) / kBlock; }
  // Values come in pairs; an odd last one is paired with a zero.
  [[nodiscard]] std::size_t pairs() const { return pairs_; }
  // Pair p of the block's descriptor d is at 2 (p kBlock + d); what fills up the last block is
  // zero.
  [[nodiscard]] const std::int16_t* block(std::size_t index) const {
    return values_.data() + index * kBlock * 2 * pairs_;
  }
  // kUnit^2 for a descriptor of unit length; zero for what fills up the last block.
  [[nodiscard]] const std::int32_t* squared_lengths() const { return squared_lengths_.data(); }

 private:
  std::size_t size_, pairs_;
  std::vector<std::int16_t> values_;
  std::vector<std::int32_t> squared_lengths_;
};

// The scalar products of all descriptors of two blocks: products[i stride + j] becomes that of a's
// descriptor i and b's descriptor j, in kUnit^2.
using BlockProducts = void (*)(const std::int16_t* a, const std::int16_t* b, std::size_t pairs,
                               std::int32_t* products, std::size_t stride);
[[nodiscard]] BlockProducts block_products(Simd simd);

}  // namespace roomwise::features
