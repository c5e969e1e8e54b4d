#pragma once

#include <cstdint>
#include <map>

#include "roomwise/evaluation/statistics/proportion.h"

namespace roomwise::evaluation {

// How often something succeeded, counted apart in blocks whose trials hang together: whole walks,
// or visits of a room. Neighbouring frames of a walk are right or wrong together, so that frames
// taken as independent make an interval too narrow.
class BlockedProportion {
 public:
  void add(std::uint64_t block, bool success) { blocks_[block].add(success); }

  [[nodiscard]] Proportion total() const;
  [[nodiscard]] std::size_t blocks() const { return blocks_.size(); }
  // The middle 95 % of the proportion over resamples of whole blocks, drawn with replacement
  // (Efron's percentile bootstrap). 0 to 1 with fewer than two blocks, which say nothing of how
  // blocks differ. The same seed gives the same interval.
  [[nodiscard]] Interval resampled_interval(std::uint64_t seed = 1, int resamples = 2000) const;

 private:
  std::map<std::uint64_t, Proportion> blocks_;
};

}  // namespace roomwise::evaluation
