#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "roomwise/base/color.h"
#include "roomwise/base/expected.h"

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
class TsdfVolume {
 public:
  using Key = std::uint64_t;  // of a block

  explicit TsdfVolume(const TsdfOptions& options) : options_(options) {}

  [[nodiscard]] const TsdfOptions& options() const { return options_; }
  [[nodiscard]] double voxel_size_m() const { return options_.voxel_size_m; }
  [[nodiscard]] std::size_t block_count() const { return blocks_.size(); }
  // Of the blocks and of the table that finds them; given back when the field goes.
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
  [[nodiscard]] const VoxelBlock* find(const Eigen::Vector3i& block) const;
  [[nodiscard]] VoxelBlock* find(const Eigen::Vector3i& block);
  void insert(const Eigen::Vector3i& block, std::unique_ptr<VoxelBlock> content);
  void erase(const Eigen::Vector3i& block);

  // Nothing where nothing was seen.
  [[nodiscard]] std::optional<TsdfSample> at(const Eigen::Vector3i& voxel) const;
  // At the voxel nearest to a point of the field's frame.
  [[nodiscard]] std::optional<TsdfSample> near(const Eigen::Vector3d& point) const;
  [[nodiscard]] TsdfSample sample(const Voxel& voxel) const {
    return {distance_step_m() * voxel.distance_sum / voxel.weight, voxel.weight};
  }

  // The same blocks with the same sums.
  friend bool operator==(const TsdfVolume& a, const TsdfVolume& b);

 private:
  [[nodiscard]] double distance_step_m() const {
    return options_.truncation_m() / kStepsPerTruncation;
  }

  TsdfOptions options_;
  std::unordered_map<Key, std::unique_ptr<VoxelBlock>> blocks_;
};

}  // namespace roomwise::fusion
