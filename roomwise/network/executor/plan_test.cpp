#include <gtest/gtest.h>
#include <malloc.h>

#include "roomwise/network/executor/plan_builder.h"

namespace roomwise::network {
namespace {

TEST(Plan, BlocksAreAsWideAsRegisters) {
  using dnnl::cpu_isa;
  for (const cpu_isa narrow : {cpu_isa::sse41, cpu_isa::avx, cpu_isa::avx2, cpu_isa::avx2_vnni}) {
    EXPECT_EQ(channels_in_block(narrow), 8u) << static_cast<unsigned>(narrow);
  }
  for (const cpu_isa wide : {cpu_isa::avx512_core, cpu_isa::avx512_core_vnni,
                             cpu_isa::avx512_core_bf16, cpu_isa::avx512_core_amx}) {
    EXPECT_EQ(channels_in_block(wide), 16u) << static_cast<unsigned>(wide);
  }
}

// A plan's memory is counted by its tensors.
TEST(Plan, SelectionsKeepNoTables) {
  const auto held = [] {
    const struct mallinfo2 heap = mallinfo2();
    return heap.uordblks + heap.hblkhd;
  };
  const std::size_t before = held();
  const Kernel kernel = selection_kernel({1024, 1}, {1, 1024}, {}, {1024, 1024});
  EXPECT_LT(held(), before + (1 << 16));
}

}  // namespace
}  // namespace roomwise::network
