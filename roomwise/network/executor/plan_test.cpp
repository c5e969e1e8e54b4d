#include <gtest/gtest.h>

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

}  // namespace
}  // namespace roomwise::network
