#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "roomwise/base/plain_bytes.h"
#include "roomwise/features/feature_extractor.h"
#include "roomwise/mapping/frontend/keyframe.h"

namespace roomwise::mapping {

struct AppearanceIndexOptions {
  std::size_t features = 400;  // the strongest of each key-frame are indexed
  // Tables of hashes; a feature finds another where they agree in all bits of one table's hash.
  std::size_t tables = 4;
  int bits = 20;  // at most 32
  // A hash that more features share tells nothing and is passed over; so what a question costs does
  // not grow with the map.
  std::size_t max_in_bucket = 40;

  [[nodiscard]] Expected<void> validate() const;
};

// Which key-frames look like a picture: features that hash alike vote for the key-frames they are
// in. The hash of a real descriptor is the signs of random projections (Charikar, "Similarity
// estimation techniques from rounding algorithms", STOC 2002), that of a binary one a random choice
// of its bits. It needs no vocabulary learned elsewhere. All features must be of one kind.
class AppearanceIndex {
 public:
  // Indices of one seed hash alike, so one can go on from the other.
  static constexpr std::uint64_t kUsualSeed = 1;
  explicit AppearanceIndex(std::uint64_t seed, const AppearanceIndexOptions& options = {});

  struct Hit {
    KeyframeId id = 0;
    double votes = 0;  // each weighs less the more features share its hash
  };
  // The `most` key-frames with the most votes among those added with id from `first` to below
  // `before`, best first; of equals the earlier.
  // Those in `left_out`, by id, are as if they were not there, but that their features fill
  // buckets.
  [[nodiscard]] std::vector<Hit> find(const features::Features& features, KeyframeId first,
                                      KeyframeId before, std::size_t most,
                                      const std::vector<bool>& left_out = {}) const;
  // Ids grow.
  void add(KeyframeId id, const features::Features& features);

  // The index of some of its key-frames, ascending, which are numbered 0, 1, 2, ... from now on.
  void keep_only(std::span<const KeyframeId> kept);

  // Of the key-frames that were 0, 1, 2, ... these are the numbers now, ascending.
  void renumber(std::span<const KeyframeId> numbers);

  // The index as plain bytes and back; seed and options must be those that it was made with. Of
  // bytes that are none of an index `reader` is not whole afterwards, or nothing is found.
  void write(PlainWriter& writer) const;
  [[nodiscard]] std::size_t written_bytes() const;
  void read(PlainReader& reader);

 private:
  // One row a feature, one column a table.
  using Hashes = Eigen::Matrix<std::uint32_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  [[nodiscard]] Hashes hash(const features::Features& features) const;

  AppearanceIndexOptions options_;
  std::uint64_t seed_;
  Eigen::RowVectorXf center_;   // of the first key-frame's real descriptors
  Eigen::MatrixXf directions_;  // on which they are projected, a column a bit
  struct Entry {
    std::uint32_t hash = 0;
    std::uint32_t id = 0;
    friend auto operator<=>(const Entry&, const Entry&) = default;
  };
  // Most entries lie in one sorted row, eight bytes each; those of the newest key-frames wait
  // beside it until they are worth merging.
  struct Table {
    std::vector<Entry> sorted;
    std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> recent;
  };
  // Calls take(id, weight) for those in a bucket, unless it is too full.
  template <typename Take>
  void for_each_in_bucket(const Table& table, std::uint32_t hash, const Take& take) const;
  // All of a table, sorted.
  [[nodiscard]] std::vector<Entry> merged(const Table& table) const;
  void set_directions(Eigen::Index descriptor_size);

  std::vector<Table> tables_;
  std::size_t recent_keyframes_ = 0;
};

}  // namespace roomwise::mapping
