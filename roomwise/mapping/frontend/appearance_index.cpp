#include "roomwise/mapping/frontend/appearance_index.h"

#include <algorithm>
#include <map>

#include "roomwise/base/random.h"

namespace roomwise::mapping {
namespace {

constexpr std::uint64_t kStream = 0x696e646578;  // of random numbers, the index's own

}  // namespace

Expected<void> AppearanceIndexOptions::validate() const {
  if (features < 1 || tables < 1 || max_in_bucket < 1) {
    return fail("features = {}, tables = {} and max_in_bucket = {} must be at least 1", features,
                tables, max_in_bucket);
  }
  if (bits < 1 || bits > 32) return fail("bits = {} must be from 1 to 32", bits);
  return {};
}

AppearanceIndex::AppearanceIndex(std::uint64_t seed, const AppearanceIndexOptions& options)
    : options_(options), seed_(seed), tables_(options.tables) {}

AppearanceIndex::Hashes AppearanceIndex::hash(const features::Features& features) const {
  const auto rows =
      static_cast<Eigen::Index>(std::min<std::size_t>(options_.features, features.size()));
  const auto tables = static_cast<Eigen::Index>(options_.tables);
  Hashes hashes = Hashes::Zero(rows, tables);
  if (rows == 0) return hashes;
  if (const auto* real = std::get_if<features::RealDescriptors>(&features.descriptors)) {
    const Eigen::MatrixXf signs = (real->topRows(rows).rowwise() - center_) * directions_;
    for (Eigen::Index row = 0; row < rows; ++row) {
      for (Eigen::Index bit = 0; bit < signs.cols(); ++bit) {
        std::uint32_t& value = hashes(row, bit / options_.bits);
        value = (value << 1U) | (signs(row, bit) > 0 ? 1U : 0U);
      }
    }
  } else {
    RandomStream random(seed_, {kStream});
    const auto& binary = std::get<features::BinaryDescriptors>(features.descriptors);
    for (Eigen::Index bit = 0; bit < tables * options_.bits; ++bit) {
      const auto place =
          static_cast<Eigen::Index>(random.index(static_cast<std::uint64_t>(8 * binary.cols())));
      for (Eigen::Index row = 0; row < rows; ++row) {
        std::uint32_t& value = hashes(row, bit / options_.bits);
        value = (value << 1U) | ((binary(row, place / 8) >> (place % 8)) & 1U);
      }
    }
  }
  return hashes;
}

std::vector<AppearanceIndex::Hit> AppearanceIndex::find(const features::Features& features,
                                                        KeyframeId first, KeyframeId before,
                                                        std::size_t most) const {
  if (std::ranges::all_of(tables_, [](const auto& table) { return table.empty(); })) return {};
  std::map<KeyframeId, double> votes;
  const Hashes hashes = hash(features);
  for (Eigen::Index row = 0; row < hashes.rows(); ++row) {
    for (std::size_t table = 0; table < tables_.size(); ++table) {
      const auto bucket = tables_[table].find(hashes(row, static_cast<Eigen::Index>(table)));
      if (bucket == tables_[table].end() || bucket->second.size() > options_.max_in_bucket)
        continue;
      const double weight = 1 / static_cast<double>(bucket->second.size());
      for (const KeyframeId id : bucket->second) {
        if (id >= first && id < before) votes[id] += weight;
      }
    }
  }
  std::vector<Hit> hits;
  for (const auto& [id, count] : votes) hits.push_back({id, count});
  std::ranges::stable_sort(hits, std::ranges::greater(), &Hit::votes);
  hits.resize(std::min(hits.size(), most));
  return hits;
}

void AppearanceIndex::add(KeyframeId id, const features::Features& features) {
  if (center_.size() == 0 && features.size() > 0) {
    if (const auto* real = std::get_if<features::RealDescriptors>(&features.descriptors)) {
      center_ = real->colwise().mean();
      RandomStream random(seed_, {kStream});
      directions_ = Eigen::MatrixXf::NullaryExpr(
          real->cols(), static_cast<Eigen::Index>(options_.tables) * options_.bits,
          [&](Eigen::Index, Eigen::Index) { return static_cast<float>(random.normal()); });
    }
  }
  const Hashes hashes = hash(features);
  for (Eigen::Index row = 0; row < hashes.rows(); ++row) {
    for (std::size_t table = 0; table < tables_.size(); ++table) {
      auto& bucket = tables_[table][hashes(row, static_cast<Eigen::Index>(table))];
      // One more than is ever looked at marks a bucket as full.
      if (bucket.size() <= options_.max_in_bucket) bucket.push_back(id);
    }
  }
}

}  // namespace roomwise::mapping
