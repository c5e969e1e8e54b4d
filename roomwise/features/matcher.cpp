#include "roomwise/features/matcher.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

namespace roomwise::features {
namespace {

// Closeness orders neighbours: more is nearer. It is the scalar product of real descriptors of unit
// length, and minus the Hamming distance of binary ones.
constexpr float kFar = -std::numeric_limits<float>::infinity();

struct Nearest {
  float closeness = kFar;
  float second_closeness = kFar;
  std::uint32_t train = 0;
};

// The nearest neighbours in both directions, built a row of closenesses (one query against all
// train) at a time. Of equally near ones the first counts as nearest.
class NeighbourTable {
 public:
  NeighbourTable(std::size_t queries, std::size_t trains)
      : nearest_(queries), train_closeness_(trains, kFar), train_nearest_(trains, 0) {}

  [[gnu::always_inline]] inline void add_row(std::uint32_t query, const float* closeness) {
    const std::size_t count = train_closeness_.size();
    Nearest nearest;
    for (std::size_t t = 0; t < count; ++t) {
      if (closeness[t] <= nearest.second_closeness) continue;
      if (closeness[t] > nearest.closeness) {
        nearest.second_closeness = nearest.closeness;
        nearest.closeness = closeness[t];
        nearest.train = static_cast<std::uint32_t>(t);
      } else {
        nearest.second_closeness = closeness[t];
      }
    }
    nearest_[query] = nearest;
    float* __restrict best = train_closeness_.data();
    std::uint32_t* __restrict best_query = train_nearest_.data();
    for (std::size_t t = 0; t < count; ++t) {
      const bool nearer = closeness[t] > best[t];
      best[t] = nearer ? closeness[t] : best[t];
      best_query[t] = nearer ? query : best_query[t];
    }
  }

  [[nodiscard]] const Nearest& nearest(std::uint32_t query) const { return nearest_[query]; }
  [[nodiscard]] bool is_mutual(std::uint32_t query) const {
    return train_nearest_[nearest_[query].train] == query;
  }
  [[nodiscard]] std::uint32_t queries() const {
    return static_cast<std::uint32_t>(nearest_.size());
  }

 private:
  std::vector<Nearest> nearest_;
  std::vector<float> train_closeness_;
  std::vector<std::uint32_t> train_nearest_;
};

NeighbourTable compare(const RealDescriptors& query, const RealDescriptors& train) {
  constexpr Eigen::Index kBlock = 64;  // queries at a time; the products stay in the cache
  NeighbourTable table(static_cast<std::size_t>(query.rows()),
                       static_cast<std::size_t>(train.rows()));
  RealDescriptors products(kBlock, train.rows());
  for (Eigen::Index first = 0; first < query.rows(); first += kBlock) {
    const Eigen::Index count = std::min(kBlock, query.rows() - first);
    products.topRows(count).noalias() = query.middleRows(first, count) * train.transpose();
    for (Eigen::Index i = 0; i < count; ++i) {
      table.add_row(static_cast<std::uint32_t>(first + i), products.row(i).data());
    }
  }
  return table;
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

[[gnu::always_inline]] inline void compare_words(const Words& query, const Words& train,
                                                 NeighbourTable& table) {
  std::vector<float> closeness(static_cast<std::size_t>(train.rows()));
  for (Eigen::Index q = 0; q < query.rows(); ++q) {
    const std::uint64_t* a = query.data() + q * query.cols();
    for (Eigen::Index t = 0; t < train.rows(); ++t) {
      const std::uint64_t* b = train.data() + t * train.cols();
      int distance = 0;
      for (Eigen::Index w = 0; w < query.cols(); ++w) distance += std::popcount(a[w] ^ b[w]);
      closeness[static_cast<std::size_t>(t)] = static_cast<float>(-distance);
    }
    table.add_row(static_cast<std::uint32_t>(q), closeness.data());
  }
}

#if defined(__x86_64__)
// The same code where the processor counts bits by an instruction.
__attribute__((target("popcnt"))) void compare_words_popcnt(const Words& query, const Words& train,
                                                            NeighbourTable& table) {
  compare_words(query, train, table);
}
#endif

NeighbourTable compare(const BinaryDescriptors& query, const BinaryDescriptors& train) {
  NeighbourTable table(static_cast<std::size_t>(query.rows()),
                       static_cast<std::size_t>(train.rows()));
#if defined(__x86_64__)
  if (__builtin_cpu_supports("popcnt")) {
    compare_words_popcnt(to_words(query), to_words(train), table);
    return table;
  }
#endif
  compare_words(to_words(query), to_words(train), table);
  return table;
}

float distance_of(float closeness, const RealDescriptors&) {
  return std::sqrt(std::max(0.0F, 2 - 2 * closeness));
}
float distance_of(float closeness, const BinaryDescriptors&) {
  return -closeness;
}

template <typename Descriptors>
std::vector<Match> match_descriptors(const Descriptors& query, const Descriptors& train,
                                     const MatchOptions& options) {
  if (query.rows() == 0 || train.rows() == 0) return {};
  if (query.cols() != train.cols()) {
    throw std::invalid_argument("match_features: descriptors of different length");
  }
  const NeighbourTable table = compare(query, train);
  const auto ratio = static_cast<float>(options.most_distance_ratio);
  std::vector<Match> matches;
  for (std::uint32_t q = 0; q < table.queries(); ++q) {
    const Nearest& nearest = table.nearest(q);
    const float distance = distance_of(nearest.closeness, query);
    if (ratio < 1) {
      if (nearest.second_closeness == kFar) continue;
      if (!(distance < ratio * distance_of(nearest.second_closeness, query))) continue;
    }
    if (options.mutual && !table.is_mutual(q)) continue;
    matches.push_back({q, nearest.train, distance});
  }
  return matches;
}

// The key-points of one polarity, and where they stand among all.
struct Polarity {
  std::vector<std::uint32_t> indices;
  RealDescriptors descriptors;
};

Polarity take_polarity(const Features& features, bool bright) {
  const auto& all = std::get<RealDescriptors>(features.descriptors);
  Polarity part;
  for (std::uint32_t i = 0; i < features.size(); ++i) {
    if (features.keypoints[i].bright == bright) part.indices.push_back(i);
  }
  part.descriptors.resize(static_cast<Eigen::Index>(part.indices.size()), all.cols());
  for (std::size_t i = 0; i < part.indices.size(); ++i) {
    part.descriptors.row(static_cast<Eigen::Index>(i)) = all.row(part.indices[i]);
  }
  return part;
}

// Light and dark blobs apart: half the comparisons or less, and no wrong match between them.
std::vector<Match> match_real(const Features& query, const Features& train,
                              const MatchOptions& options) {
  std::vector<Match> matches;
  for (const bool bright : {false, true}) {
    const Polarity queries = take_polarity(query, bright);
    const Polarity trains = take_polarity(train, bright);
    for (const Match& match : match_descriptors(queries.descriptors, trains.descriptors, options)) {
      matches.push_back(
          {queries.indices[match.query], trains.indices[match.train], match.distance});
    }
  }
  std::sort(matches.begin(), matches.end(),
            [](const Match& a, const Match& b) { return a.query < b.query; });
  return matches;
}

}  // namespace

Expected<void> MatchOptions::validate() const {
  if (!(most_distance_ratio > 0 && most_distance_ratio <= 1)) {
    return fail("most_distance_ratio is {}; it must be above 0 and at most 1 (1 tests nothing)",
                most_distance_ratio);
  }
  return {};
}

std::vector<Match> match_features(const Features& query, const Features& train,
                                  const MatchOptions& options) {
  if (const auto valid = options.validate(); !valid) {
    throw std::invalid_argument(valid.error().message);
  }
  if (query.descriptors.index() != train.descriptors.index()) {
    throw std::invalid_argument("match_features: real against binary descriptors");
  }
  if (std::holds_alternative<RealDescriptors>(query.descriptors)) {
    return match_real(query, train, options);
  }
  return match_descriptors(std::get<BinaryDescriptors>(query.descriptors),
                           std::get<BinaryDescriptors>(train.descriptors), options);
}

}  // namespace roomwise::features
