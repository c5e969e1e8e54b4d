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
  if (const auto* real = std::get_if<features::FloatDescriptors>(&features.descriptors)) {
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
                                                        std::size_t most,
                                                        const std::vector<bool>& left_out) const {
  const auto is_left_out = [&](KeyframeId id) { return id < left_out.size() && left_out[id]; };
  if (std::ranges::all_of(tables_, [](const Table& table) {
        return table.sorted.empty() && table.recent.empty();
      })) {
    return {};
  }
  std::map<KeyframeId, double> votes;
  const Hashes hashes = hash(features);
  for (Eigen::Index row = 0; row < hashes.rows(); ++row) {
    for (std::size_t table = 0; table < tables_.size(); ++table) {
      for_each_in_bucket(tables_[table], hashes(row, static_cast<Eigen::Index>(table)),
                         [&](KeyframeId id, double weight) {
                           if (id >= first && id < before && !is_left_out(id)) votes[id] += weight;
                         });
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
    if (const auto* real = std::get_if<features::FloatDescriptors>(&features.descriptors)) {
      center_ = real->colwise().mean();
      set_directions(real->cols());
    }
  }
  const Hashes hashes = hash(features);
  for (Eigen::Index row = 0; row < hashes.rows(); ++row) {
    for (std::size_t table = 0; table < tables_.size(); ++table) {
      tables_[table].recent[hashes(row, static_cast<Eigen::Index>(table))].push_back(
          static_cast<std::uint32_t>(id));
    }
  }
  // Merging moves all entries: it is done the more seldom, the more there are.
  constexpr std::size_t kMinRecent = 64;
  if (++recent_keyframes_ < kMinRecent + id / 64) return;
  recent_keyframes_ = 0;
  for (Table& table : tables_) {
    table.sorted = merged(table);
    table.recent.clear();
  }
}

template <typename Take>
void AppearanceIndex::for_each_in_bucket(const Table& table, std::uint32_t hash,
                                         const Take& take) const {
  const auto old = std::ranges::equal_range(table.sorted, hash, {}, &Entry::hash);
  const auto recent = table.recent.find(hash);
  const std::size_t count = old.size() + (recent == table.recent.end() ? 0 : recent->second.size());
  if (count == 0 || count > options_.max_in_bucket) return;
  const double weight = 1 / static_cast<double>(count);
  for (const Entry& entry : old) take(entry.id, weight);
  if (recent == table.recent.end()) return;
  for (const std::uint32_t id : recent->second) take(id, weight);
}

std::vector<AppearanceIndex::Entry> AppearanceIndex::merged(const Table& table) const {
  std::vector<Entry> recent;
  for (const auto& [hash, ids] : table.recent)
    for (const std::uint32_t id : ids) recent.push_back({hash, id});
  std::ranges::sort(recent);
  std::vector<Entry> all(table.sorted.size() + recent.size());
  std::ranges::merge(table.sorted, recent, all.begin());
  return all;
}

void AppearanceIndex::keep_only(std::span<const KeyframeId> kept) {
  for (Table& table : tables_) {
    std::vector<Entry> entries;
    for (const Entry& entry : merged(table)) {
      const auto place = std::ranges::lower_bound(kept, KeyframeId{entry.id});
      if (place != kept.end() && *place == entry.id)
        entries.push_back({entry.hash, static_cast<std::uint32_t>(place - kept.begin())});
    }
    table.sorted = std::move(entries);
    table.recent.clear();
  }
  recent_keyframes_ = 0;
}

void AppearanceIndex::renumber(std::span<const KeyframeId> numbers) {
  for (Table& table : tables_) {
    table.sorted = merged(table);
    table.recent.clear();
    for (Entry& entry : table.sorted) entry.id = static_cast<std::uint32_t>(numbers[entry.id]);
  }
  recent_keyframes_ = 0;
}

void AppearanceIndex::set_directions(Eigen::Index descriptor_size) {
  RandomStream random(seed_, {kStream});
  directions_ = Eigen::MatrixXf::NullaryExpr(
      descriptor_size, static_cast<Eigen::Index>(options_.tables) * options_.bits,
      [&](Eigen::Index, Eigen::Index) { return static_cast<float>(random.normal()); });
}

void AppearanceIndex::write(PlainWriter& writer) const {
  writer.put(static_cast<std::uint64_t>(center_.size()));
  writer.put(center_.data(), static_cast<std::size_t>(center_.size()));
  for (const Table& table : tables_) {
    const std::vector<Entry> all = merged(table);
    writer.put(static_cast<std::uint64_t>(all.size()));
    writer.put(all.data(), all.size());
  }
}

std::size_t AppearanceIndex::written_bytes() const {
  std::size_t bytes =
      sizeof(std::uint64_t) + static_cast<std::size_t>(center_.size()) * sizeof(float);
  for (const Table& table : tables_) {
    std::size_t entries = table.sorted.size();
    for (const auto& [hash, ids] : table.recent) entries += ids.size();
    bytes += sizeof(std::uint64_t) + entries * sizeof(Entry);
  }
  return bytes;
}

void AppearanceIndex::read(PlainReader& reader) {
  center_.resize(static_cast<Eigen::Index>(reader.get_count(sizeof(float))));
  reader.get(center_.data(), static_cast<std::size_t>(center_.size()));
  if (center_.size() > 0) set_directions(center_.size());
  recent_keyframes_ = 0;
  for (Table& table : tables_) {
    table.recent.clear();
    table.sorted.resize(reader.get_count(sizeof(Entry)));
    reader.get(table.sorted.data(), table.sorted.size());
  }
}

}  // namespace roomwise::mapping
