#include "roomwise/evaluation/statistics/resampling.h"

#include <vector>

#include "roomwise/base/random.h"
#include "roomwise/evaluation/statistics/quantile.h"

namespace roomwise::evaluation {

Proportion BlockedProportion::total() const {
  Proportion total;
  for (const auto& [block, proportion] : blocks_) {
    total.successes += proportion.successes;
    total.n += proportion.n;
  }
  return total;
}

Interval BlockedProportion::resampled_interval(std::uint64_t seed, int resamples) const {
  if (blocks_.size() < 2) return {0, 1};
  std::vector<Proportion> blocks;
  for (const auto& [block, proportion] : blocks_) blocks.push_back(proportion);
  std::vector<double> values;
  for (int i = 0; i < resamples; ++i) {
    RandomStream random(seed, {static_cast<std::uint64_t>(i)});
    Proportion drawn;
    for (std::size_t k = 0; k < blocks.size(); ++k) {
      const Proportion& block = blocks[random.index(blocks.size())];
      drawn.successes += block.successes;
      drawn.n += block.n;
    }
    values.push_back(drawn.value());
  }
  return {quantile(values, 0.025), quantile(values, 0.975)};
}

}  // namespace roomwise::evaluation
