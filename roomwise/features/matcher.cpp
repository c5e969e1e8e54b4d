#include "roomwise/features/matcher.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "roomwise/features/quantized_descriptors.h"

#if defined(__aarch64__)
#include <arm_neon.h>
#endif

namespace roomwise::features {
namespace {

// Closeness orders neighbours: more is nearer. It is minus the squared distance of real
// descriptors, in units of WholeDescriptors, and minus the Hamming distance of binary ones.
constexpr std::int32_t kFar = std::numeric_limits<std::int32_t>::min();
constexpr std::size_t kLanes = 8;  // the most that are worked on at a time

[[gnu::always_inline]] inline void iota_lanes(Int8& lanes) {
  lanes = Int8{0, 1, 2, 3, 4, 5, 6, 7};
}
[[gnu::always_inline]] inline void iota_lanes(Int4& lanes) {
  lanes = Int4{0, 1, 2, 3};
}

constexpr std::size_t to_whole_lanes(std::size_t count) {
  return (count + kLanes - 1) / kLanes * kLanes;
}

struct Nearest {
  std::int32_t closeness = kFar;
  std::int32_t second_closeness = kFar;
  std::uint32_t train = 0;
};

// The nearest neighbours in both directions, built a row of closenesses (one query against all
// train) at a time. Of equally near ones the first counts as nearest.
class NeighbourTable {
 public:
  NeighbourTable(std::size_t queries, std::size_t trains)
      : nearest_(queries),
        train_closeness_(to_whole_lanes(trains), kFar),
        train_nearest_(to_whole_lanes(trains), 0) {}

  // What fills a row up to whole lanes must be kFar.
  template <Simd simd>
  [[gnu::always_inline]] inline void add_row(std::uint32_t query, const std::int32_t* closeness) {
    using Int = typename Lanes<simd>::Int;
    constexpr int kCount = Lanes<simd>::kCount;
    const auto here = static_cast<std::int32_t>(query);
    Int first = Int{} + kFar, second = first, where{}, train;
    iota_lanes(train);
    for (std::size_t t = 0; t < train_closeness_.size(); t += kCount, train += kCount) {
      Int now, best, best_query;
      load(closeness + t, now);
      const Int lower = now > first ? first : now;
      second = lower > second ? lower : second;
      where = now > first ? train : where;
      first = now > first ? now : first;
      load(train_closeness_.data() + t, best);
      load(train_nearest_.data() + t, best_query);
      store(now > best ? Int{} + here : best_query, train_nearest_.data() + t);
      store(now > best ? now : best, train_closeness_.data() + t);
    }
    Nearest& nearest = nearest_[query];
    for (int lane = 0; lane < kCount; ++lane) {
      const auto at = static_cast<std::uint32_t>(where[lane]);
      nearest.second_closeness = std::max(
          {nearest.second_closeness, second[lane], std::min(first[lane], nearest.closeness)});
      if (first[lane] > nearest.closeness ||
          (first[lane] == nearest.closeness && at < nearest.train)) {
        nearest.closeness = first[lane];
        nearest.train = at;
      }
    }
  }

  [[nodiscard]] const Nearest& nearest(std::uint32_t query) const { return nearest_[query]; }
  [[nodiscard]] bool is_mutual(std::uint32_t query) const {
    return train_nearest_[nearest_[query].train] == static_cast<std::int32_t>(query);
  }
  [[nodiscard]] std::uint32_t queries() const {
    return static_cast<std::uint32_t>(nearest_.size());
  }

 private:
  std::vector<Nearest> nearest_;
  std::vector<std::int32_t> train_closeness_;
  std::vector<std::int32_t> train_nearest_;
};

template <Simd simd>
[[gnu::always_inline]] inline void compare_blocks(const QuantizedDescriptors& query,
                                                  const QuantizedDescriptors& train,
                                                  NeighbourTable& table) {
  const BlockProducts multiply = block_products(simd);
  constexpr std::size_t kBlock = QuantizedDescriptors::kBlock;
  static_assert(kBlock % kLanes == 0);
  const std::size_t stride = train.blocks() * kBlock;
  std::vector<std::int32_t> rows(kBlock * stride);  // products, then closenesses
  for (std::size_t first = 0; first < query.size(); first += kBlock) {
    for (std::size_t t = 0; t < train.blocks(); ++t) {
      multiply(query.block(first / kBlock), train.block(t), query.pairs(), rows.data() + t * kBlock,
               stride);
    }
    for (std::size_t q = first; q < std::min(first + kBlock, query.size()); ++q) {
      std::int32_t* row = rows.data() + (q - first) * stride;
      const std::int32_t squared_length = query.squared_lengths()[q];
      for (std::size_t t = 0; t < stride; ++t)
        row[t] = 2 * row[t] - squared_length - train.squared_lengths()[t];
      std::fill(row + train.size(), row + stride, kFar);
      table.add_row<simd>(static_cast<std::uint32_t>(q), row);
    }
  }
}

#if defined(__x86_64__)
__attribute__((target("avx2"))) void compare_blocks_avx2(const QuantizedDescriptors& query,
                                                         const QuantizedDescriptors& train,
                                                         NeighbourTable& table) {
  compare_blocks<Simd::kAvx2>(query, train, table);
}
#endif

NeighbourTable compare(const QuantizedDescriptors& query, const QuantizedDescriptors& train,
                       [[maybe_unused]] Simd simd) {
  NeighbourTable table(query.size(), train.size());
#if defined(__x86_64__)
  if (simd == Simd::kAvx2) {
    compare_blocks_avx2(query, train, table);
    return table;
  }
#elif defined(__aarch64__)
  if (simd == Simd::kNeon) {
    compare_blocks<Simd::kNeon>(query, train, table);
    return table;
  }
#endif
  compare_blocks<Simd::kPortable>(query, train, table);
  return table;
}

float distance_of_real(std::int32_t closeness) {
  return std::sqrt(-static_cast<float>(closeness)) / QuantizedDescriptors::kUnit;
}

using Words = Eigen::Matrix<std::uint64_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Rows filled up with zeros to whole words, which adds nothing to their distances.
Words to_words(const BinaryDescriptors& descriptors) {
  constexpr Eigen::Index kWordBytes = sizeof(std::uint64_t);
  Words words = Words::Zero(descriptors.rows(), (descriptors.cols() + kWordBytes - 1) / kWordBytes);
  for (Eigen::Index i = 0; i < descriptors.rows(); ++i) {
    std::memcpy(words.row(i).data(), descriptors.row(i).data(),
                static_cast<std::size_t>(descriptors.cols()));
  }
  return words;
}

// Bits that differ.
template <Simd simd>
[[gnu::always_inline]] inline int distance_of_words(const std::uint64_t* a, const std::uint64_t* b,
                                                    Eigen::Index count) {
  int distance = 0;
  Eigen::Index w = 0;
#if defined(__aarch64__)
  if constexpr (simd == Simd::kNeon) {
    for (; w + 2 <= count; w += 2) {
      const uint64x2_t differing = veorq_u64(vld1q_u64(a + w), vld1q_u64(b + w));
      distance += vaddlvq_u8(vcntq_u8(vreinterpretq_u8_u64(differing)));
    }
  }
#endif
  for (; w < count; ++w) distance += std::popcount(a[w] ^ b[w]);
  return distance;
}

template <Simd simd>
[[gnu::always_inline]] inline void compare_words(const Words& query, const Words& train,
                                                 NeighbourTable& table) {
  std::vector<std::int32_t> closeness(to_whole_lanes(static_cast<std::size_t>(train.rows())), kFar);
  for (Eigen::Index q = 0; q < query.rows(); ++q) {
    const std::uint64_t* a = query.data() + q * query.cols();
    for (Eigen::Index t = 0; t < train.rows(); ++t) {
      const std::uint64_t* b = train.data() + t * train.cols();
      closeness[static_cast<std::size_t>(t)] = -distance_of_words<simd>(a, b, query.cols());
    }
    table.add_row<simd>(static_cast<std::uint32_t>(q), closeness.data());
  }
}

#if defined(__x86_64__)
// The same code where the processor counts bits by an instruction, as all with AVX2 do.
__attribute__((target("avx2,popcnt"))) void compare_words_avx2(const Words& query,
                                                               const Words& train,
                                                               NeighbourTable& table) {
  compare_words<Simd::kAvx2>(query, train, table);
}
#endif

NeighbourTable compare(const Words& query, const Words& train, [[maybe_unused]] Simd simd) {
  NeighbourTable table(static_cast<std::size_t>(query.rows()),
                       static_cast<std::size_t>(train.rows()));
#if defined(__x86_64__)
  if (simd == Simd::kAvx2) {
    compare_words_avx2(query, train, table);
    return table;
  }
#elif defined(__aarch64__)
  if (simd == Simd::kNeon) {
    compare_words<Simd::kNeon>(query, train, table);
    return table;
  }
#endif
  compare_words<Simd::kPortable>(query, train, table);
  return table;
}

float distance_of_binary(std::int32_t closeness) {
  return -static_cast<float>(closeness);
}

// The pairs that pass the tests, in the order of query.
std::vector<Match> take_matches(const NeighbourTable& table, const MatchOptions& options,
                                float (*distance_of)(std::int32_t)) {
  const auto ratio = static_cast<float>(options.max_distance_ratio);
  std::vector<Match> matches;
  for (std::uint32_t q = 0; q < table.queries(); ++q) {
    const Nearest& nearest = table.nearest(q);
    const float distance = distance_of(nearest.closeness);
    if (ratio < 1) {
      if (nearest.second_closeness == kFar) continue;
      if (!(distance < ratio * distance_of(nearest.second_closeness))) continue;
    }
    if (options.mutual && !table.is_mutual(q)) continue;
    matches.push_back({q, nearest.train, distance});
  }
  return matches;
}

std::vector<std::uint32_t> of_polarity(const Features& features, bool bright) {
  std::vector<std::uint32_t> indices;
  for (std::uint32_t i = 0; i < features.size(); ++i) {
    if (features.keypoints[i].bright == bright) indices.push_back(i);
  }
  return indices;
}

// Light and dark blobs apart: half the comparisons or less, and no wrong match between them.
std::vector<Match> match_real(const Features& query, const Features& train,
                              const MatchOptions& options, Simd simd) {
  std::vector<Match> matches;
  for (const bool bright : {false, true}) {
    const auto queries = of_polarity(query, bright), trains = of_polarity(train, bright);
    if (queries.empty() || trains.empty()) continue;
    const NeighbourTable table =
        compare(QuantizedDescriptors(std::get<FloatDescriptors>(query.descriptors), queries),
                QuantizedDescriptors(std::get<FloatDescriptors>(train.descriptors), trains), simd);
    for (const Match& match : take_matches(table, options, distance_of_real))
      matches.push_back({queries[match.query], trains[match.train], match.distance});
  }
  std::ranges::sort(matches, {}, &Match::query);
  return matches;
}

Eigen::Index descriptor_length(const Features& features) {
  return std::visit([](const auto& rows) { return rows.cols(); }, features.descriptors);
}

}  // namespace

Expected<void> MatchOptions::validate() const {
  if (!(max_distance_ratio > 0 && max_distance_ratio <= 1)) {
    return fail("max_distance_ratio is {}; it must be above 0 and at most 1 (1 tests nothing)",
                max_distance_ratio);
  }
  return {};
}

std::vector<Match> match_features(const Features& query, const Features& train,
                                  const MatchOptions& options, Simd simd) {
  if (const auto valid = options.validate(); !valid) {
    throw std::invalid_argument(valid.error().message);
  }
  if (query.descriptors.index() != train.descriptors.index()) {
    throw std::invalid_argument("match_features: real against binary descriptors");
  }
  if (query.size() == 0 || train.size() == 0) return {};
  if (descriptor_length(query) != descriptor_length(train)) {
    throw std::invalid_argument("match_features: descriptors of different length");
  }
  if (std::holds_alternative<FloatDescriptors>(query.descriptors)) {
    return match_real(query, train, options, simd);
  }
  return take_matches(compare(to_words(std::get<BinaryDescriptors>(query.descriptors)),
                              to_words(std::get<BinaryDescriptors>(train.descriptors)), simd),
                      options, distance_of_binary);
}

}  // namespace roomwise::features
