#include "roomwise/fusion/tsdf_volume.h"

#include <algorithm>
#include <cmath>

namespace roomwise::fusion {
namespace {

constexpr int kBitsPerAxis = 21;
constexpr int kHalfRange = 1 << (kBitsPerAxis - 1);
constexpr std::uint64_t kAxisMask = (std::uint64_t{1} << kBitsPerAxis) - 1;

// The block of a voxel, and the voxel in it.
int block_of_voxel(int voxel) {
  return voxel >> 3;  // arithmetic: rounds down
}
static_assert(kBlockSide == 1 << 3);

bool same(const VoxelBlock& a, const VoxelBlock& b) {
  if (a.voxels != b.voxels || (a.colors == nullptr) != (b.colors == nullptr)) return false;
  return a.colors == nullptr || *a.colors == *b.colors;
}

}  // namespace

Expected<void> TsdfOptions::validate() const {
  if (!(voxel_size_m >= 0.001 && voxel_size_m <= 1)) {
    return fail("voxel_size_m is {}; expected 0.001 to 1", voxel_size_m);
  }
  if (!(truncation_voxels >= 2 && truncation_voxels <= 20)) {
    return fail("truncation_voxels is {}; expected 2 to 20", truncation_voxels);
  }
  return {};
}

bool VoxelBlock::is_empty() const {
  return std::ranges::all_of(voxels, [](const Voxel& voxel) { return voxel.weight == 0; });
}

void VoxelBlock::drop_empty_colors() {
  if (colors == nullptr) return;
  if (std::ranges::all_of(*colors, [](const ColorSum& color) { return color.weight == 0; })) {
    colors.reset();
  }
}

std::size_t TsdfVolume::memory_bytes() const {
  constexpr std::size_t kNode = sizeof(void*) + sizeof(Key) + sizeof(std::unique_ptr<VoxelBlock>);
  std::size_t bytes = blocks_.bucket_count() * sizeof(void*) + blocks_.size() * kNode;
  for (const auto& [key, block] : blocks_) {
    bytes += sizeof(VoxelBlock) + (block->colors == nullptr ? 0 : sizeof(*block->colors));
  }
  return bytes;
}

bool TsdfVolume::has_key(const Eigen::Vector3i& block) {
  return (block.array() >= -kHalfRange).all() && (block.array() < kHalfRange).all();
}

TsdfVolume::Key TsdfVolume::key_of(const Eigen::Vector3i& block) {
  const auto bits = [](int coordinate) { return static_cast<Key>(coordinate + kHalfRange); };
  return (bits(block.z()) << (2 * kBitsPerAxis)) | (bits(block.y()) << kBitsPerAxis) |
         bits(block.x());
}

Eigen::Vector3i TsdfVolume::block_of(Key key) {
  const auto axis = [&](int shift) {
    return static_cast<int>((key >> shift) & kAxisMask) - kHalfRange;
  };
  return {axis(0), axis(kBitsPerAxis), axis(2 * kBitsPerAxis)};
}

std::vector<Eigen::Vector3i> TsdfVolume::blocks() const {
  std::vector<Key> keys;
  keys.reserve(blocks_.size());
  for (const auto& [key, block] : blocks_) keys.push_back(key);
  std::ranges::sort(keys);
  std::vector<Eigen::Vector3i> places;
  places.reserve(keys.size());
  for (const Key key : keys) places.push_back(block_of(key));
  return places;
}

const VoxelBlock* TsdfVolume::find(const Eigen::Vector3i& block) const {
  const auto found = blocks_.find(key_of(block));
  return found == blocks_.end() ? nullptr : found->second.get();
}

VoxelBlock* TsdfVolume::find(const Eigen::Vector3i& block) {
  const auto found = blocks_.find(key_of(block));
  return found == blocks_.end() ? nullptr : found->second.get();
}

void TsdfVolume::insert(const Eigen::Vector3i& block, std::unique_ptr<VoxelBlock> content) {
  blocks_[key_of(block)] = std::move(content);
}

void TsdfVolume::erase(const Eigen::Vector3i& block) {
  blocks_.erase(key_of(block));
}

std::optional<TsdfSample> TsdfVolume::at(const Eigen::Vector3i& voxel) const {
  const Eigen::Vector3i place = voxel.unaryExpr(&block_of_voxel);
  const VoxelBlock* block = find(place);
  if (block == nullptr) return std::nullopt;
  const Voxel& found = block->voxels[offset_of(voxel - kBlockSide * place)];
  if (found.weight == 0) return std::nullopt;
  return sample(found);
}

std::optional<TsdfSample> TsdfVolume::near(const Eigen::Vector3d& point) const {
  const Eigen::Array3d voxel = (point.array() / options_.voxel_size_m).round();
  if (!(voxel.abs() < static_cast<double>(kHalfRange)).all()) return std::nullopt;
  return at(voxel.matrix().cast<int>());
}

bool operator==(const TsdfVolume& a, const TsdfVolume& b) {
  return a.blocks_.size() == b.blocks_.size() &&
         std::ranges::all_of(a.blocks_, [&](const auto& entry) {
           const auto found = b.blocks_.find(entry.first);
           return found != b.blocks_.end() && same(*entry.second, *found->second);
         });
}

}  // namespace roomwise::fusion
