#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "roomwise/base/color.h"
#include "roomwise/base/expected.h"
#include "roomwise/base/scratch_file.h"

namespace roomwise::fusion {

struct TsdfOptions {
  double voxel_size_m = 0.02;
  double truncation_voxels = 4;  // farther before a surface all distances are the same
  bool keeps_colors = true;      // they take up to two thirds of the memory

  [[nodiscard]] Expected<void> validate() const;
  [[nodiscard]] double truncation_m() const { return voxel_size_m * truncation_voxels; }
};

// Distances are summed in steps of truncation / kStepsPerTruncation.
constexpr int kStepsPerTruncation = 1024;
constexpr int kBlockSide = 8;  // voxels
constexpr int kBlockVoxels = kBlockSide * kBlockSide * kBlockSide;

// Sums of whole numbers, so that what was added can be taken away again to the bit, in any order.
struct Voxel {
  std::int32_t distance_sum = 0;  // weight times distance
  std::uint32_t weight = 0;

  friend bool operator==(const Voxel&, const Voxel&) = default;
};
struct ColorSum {
  std::uint32_t r = 0, g = 0, b = 0;  // weight times colour
  std::uint32_t weight = 0;

  friend bool operator==(const ColorSum&, const ColorSum&) = default;
};

// 8 x 8 x 8 voxels, x fastest, then y. Colours are kept only where a surface is near.
struct VoxelBlock {
  std::array<Voxel, kBlockVoxels> voxels{};
  std::unique_ptr<std::array<ColorSum, kBlockVoxels>> colors;

  [[nodiscard]] bool is_empty() const;
  void drop_empty_colors();
};

// What is known at one voxel.
struct TsdfSample {
  double distance_m = 0;  // to the nearest surface: positive in the open, negative inside
  std::uint32_t weight = 0;
};

// A truncated signed distance field (Curless and Levoy, "A Volumetric Method for Building Complex
// Models from Range Images", 1996) in blocks that exist only where something was seen, found by a
// hash of their place (Niessner et al., "Real-time 3D Reconstruction at Scale using Voxel Hashing",
// 2013). Voxel (i, j, k) is the point voxel_size * (i, j, k) of the field's frame; block (a, b, c)
// holds the voxels 8 (a, b, c) to 8 (a, b, c) + 7. A block takes 4 KiB, and 8 KiB more where a
// surface is near.
//
// Blocks beyond the working set, those that were asked for longest ago, lie in a scratch file, from
// where they come back to the bit: bring them into memory before they are looked at. What is asked
// for at once stays in memory, however much it is.
class TsdfVolume {
 public:
  using Key = std::uint64_t;  // of a block

  explicit TsdfVolume(const TsdfOptions& options, WorkingSet working_set = {})
      : options_(options), working_set_(std::move(working_set)) {}

  [[nodiscard]] const TsdfOptions& options() const { return options_; }
  [[nodiscard]] const WorkingSet& working_set() const { return working_set_; }
  [[nodiscard]] double voxel_size_m() const { return options_.voxel_size_m; }
  // In memory and in the scratch file.
  [[nodiscard]] std::size_t block_count() const;
  // Of the blocks in memory and of the tables that find all; given back when the field goes.
  [[nodiscard]] std::size_t memory_bytes() const;

  // Blocks as far as 2^20 blocks from the origin have a key; the key orders by z, then y, then x.
  [[nodiscard]] static bool has_key(const Eigen::Vector3i& block);
  [[nodiscard]] static Key key_of(const Eigen::Vector3i& block);
  [[nodiscard]] static Eigen::Vector3i block_of(Key key);
  [[nodiscard]] static std::size_t offset_of(const Eigen::Vector3i& voxel_in_block) {
    return static_cast<std::size_t>(
        (voxel_in_block.z() * kBlockSide + voxel_in_block.y()) * kBlockSide + voxel_in_block.x());
  }

  // The places of all blocks, in the order of their keys.
  [[nodiscard]] std::vector<Eigen::Vector3i> blocks() const;

  // Those of these blocks that exist are in memory until the next call: to be read, the second with
  // those around each, or to be changed. Errors are those of the scratch file: no block is lost or
  // changed then.
  [[nodiscard]] Expected<void> bring(std::span<const Eigen::Vector3i> blocks);
  [[nodiscard]] Expected<void> bring_around(std::span<const Eigen::Vector3i> blocks);
  [[nodiscard]] Expected<void> bring_to_change(std::span<const Eigen::Vector3i> blocks);
  // Null where there is none in memory.
  [[nodiscard]] const VoxelBlock* find(const Eigen::Vector3i& block) const;
  [[nodiscard]] VoxelBlock* find(const Eigen::Vector3i& block);
  // Only of what was brought to be changed.
  void insert(const Eigen::Vector3i& block, std::unique_ptr<VoxelBlock> content);
  void erase(const Eigen::Vector3i& block);

  [[nodiscard]] TsdfSample sample(const Voxel& voxel) const {
    return {distance_step_m() * voxel.distance_sum / voxel.weight, voxel.weight};
  }

  // The same blocks with the same sums, wherever they lie. False where the scratch file cannot be
  // read.
  friend bool operator==(const TsdfVolume& a, const TsdfVolume& b);

 private:
  // Blocks move between memory and disk by tiles of 8 x 8 x 1: whoever goes through all blocks in
  // the order of their keys has few of them at once.
  static constexpr int kTileSide = 8;
  using TileBlocks = std::array<std::unique_ptr<VoxelBlock>, std::size_t{kTileSide} * kTileSide>;
  struct Tile {
    std::uint64_t present = 0;           // a bit for each block
    std::unique_ptr<TileBlocks> blocks;  // null: on the disk
    std::size_t memory_bytes = 0;        // when it was looked at last
    std::uint64_t offset = 0;            // in the scratch file
    std::uint32_t disk_bytes = 0, disk_room = 0;
    bool is_changed = true;  // since it was written
    bool is_asked = false;
    std::list<Tile*>::iterator use;  // of those in memory
  };
  [[nodiscard]] static Key tile_of(const Eigen::Vector3i& block);
  [[nodiscard]] static std::size_t slot_of(const Eigen::Vector3i& block);
  [[nodiscard]] static Bytes to_bytes(const Tile& tile);
  [[nodiscard]] Expected<std::unique_ptr<TileBlocks>> read(const Tile& tile) const;
  [[nodiscard]] Expected<void> bring(std::span<const Eigen::Vector3i> blocks, bool to_change);
  [[nodiscard]] Expected<void> ask(Key key, bool to_change);
  void begin_asking();
  [[nodiscard]] Expected<void> make_room();
  [[nodiscard]] Expected<void> push_out(Tile& tile);
  [[nodiscard]] double distance_step_m() const {
    return options_.truncation_m() / kStepsPerTruncation;
  }

  TsdfOptions options_;
  WorkingSet working_set_;
  std::unordered_map<Key, Tile> tiles_;
  std::list<Tile*> used_;     // those in memory, the one asked for last first
  std::vector<Tile*> asked_;  // since begin_asking()
  std::size_t bytes_ = 0;     // of tiles in memory
  std::optional<ScratchFile> scratch_;
};

}  // namespace roomwise::fusion
