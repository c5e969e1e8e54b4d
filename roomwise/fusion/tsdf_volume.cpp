#include "roomwise/fusion/tsdf_volume.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace roomwise::fusion {
namespace {

constexpr int kBitsPerAxis = 21;
constexpr int kHalfRange = 1 << (kBitsPerAxis - 1);
constexpr std::uint64_t kAxisMask = (std::uint64_t{1} << kBitsPerAxis) - 1;

// ---- a tile as bytes: small numbers take few ----

// Most voxels are empty space (their distance is always the truncation) or were not seen at all.
constexpr std::size_t kMaxVarint = 5;

class Writer {
 public:
  explicit Writer(std::size_t most) : bytes_(most) {}
  void put(std::uint64_t number) {
    for (; number >= 0x80; number >>= 7) bytes_[size_++] = static_cast<std::uint8_t>(number | 0x80);
    bytes_[size_++] = static_cast<std::uint8_t>(number);
  }
  [[nodiscard]] Bytes finish() {
    bytes_.resize(size_);
    return std::move(bytes_);
  }

 private:
  Bytes bytes_;
  std::size_t size_ = 0;
};

class Reader {
 public:
  explicit Reader(const Bytes& bytes) : bytes_(bytes) {}
  [[nodiscard]] std::uint64_t take() {
    std::uint64_t number = 0;
    for (int shift = 0; at_ < bytes_.size() && shift < 64; shift += 7) {
      const std::uint64_t byte = bytes_[at_++];
      number |= (byte & 0x7F) << shift;
      if (byte < 0x80) return number;
    }
    is_whole_ = false;
    return 0;
  }
  [[nodiscard]] bool is_whole() const { return is_whole_ && at_ == bytes_.size(); }

 private:
  const Bytes& bytes_;
  std::size_t at_ = 0;
  bool is_whole_ = true;
};

void put(Writer& writer, const VoxelBlock& block) {
  writer.put(block.colors == nullptr ? 0 : 1);
  for (const Voxel& voxel : block.voxels) {
    const std::int64_t distance = voxel.distance_sum;
    const bool is_free = distance == std::int64_t{kStepsPerTruncation} * voxel.weight;
    writer.put(std::uint64_t{voxel.weight} << 1U | (is_free ? 0 : 1));
    if (is_free) continue;
    writer.put(static_cast<std::uint64_t>(distance < 0 ? -2 * distance - 1 : 2 * distance));
  }
  if (block.colors == nullptr) return;
  for (const ColorSum& color : *block.colors) {
    for (const std::uint32_t sum : {color.weight, color.r, color.g, color.b}) writer.put(sum);
  }
}

std::unique_ptr<VoxelBlock> take_block(Reader& reader) {
  auto block = std::make_unique<VoxelBlock>();
  const bool has_colors = reader.take() != 0;
  for (Voxel& voxel : block->voxels) {
    const std::uint64_t code = reader.take();
    voxel.weight = static_cast<std::uint32_t>(code >> 1U);
    if ((code & 1U) == 0) {
      voxel.distance_sum = static_cast<std::int32_t>(kStepsPerTruncation * voxel.weight);
      continue;
    }
    const std::uint64_t folded = reader.take();
    const auto half = static_cast<std::int32_t>(folded >> 1U);
    voxel.distance_sum = (folded & 1U) != 0 ? -half - 1 : half;
  }
  if (!has_colors) return block;
  block->colors = std::make_unique<std::array<ColorSum, kBlockVoxels>>();
  for (ColorSum& color : *block->colors) {
    for (std::uint32_t* sum : {&color.weight, &color.r, &color.g, &color.b})
      *sum = static_cast<std::uint32_t>(reader.take());
  }
  return block;
}

std::size_t bytes_of(const VoxelBlock& block) {
  return sizeof(VoxelBlock) + (block.colors == nullptr ? 0 : sizeof(*block.colors));
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

std::size_t TsdfVolume::block_count() const {
  std::size_t count = 0;
  for (const auto& [key, tile] : tiles_)
    count += static_cast<std::size_t>(std::popcount(tile.present));
  return count;
}

std::size_t TsdfVolume::memory_bytes() const {
  std::size_t bytes =
      tiles_.bucket_count() * sizeof(void*) + tiles_.size() * (sizeof(void*) + sizeof(Key));
  for (const auto& [key, tile] : tiles_) {
    bytes += sizeof(Tile);
    if (tile.blocks == nullptr) continue;
    bytes += sizeof(TileBlocks);
    for (const auto& block : *tile.blocks) bytes += block == nullptr ? 0 : bytes_of(*block);
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

TsdfVolume::Key TsdfVolume::tile_of(const Eigen::Vector3i& block) {
  // Arithmetic shifts round down.
  static_assert(kTileSide == 1 << 3);
  return key_of({block.x() >> 3, block.y() >> 3, block.z()});
}

std::size_t TsdfVolume::slot_of(const Eigen::Vector3i& block) {
  return static_cast<std::size_t>((block.y() & (kTileSide - 1)) * kTileSide +
                                  (block.x() & (kTileSide - 1)));
}

std::vector<Eigen::Vector3i> TsdfVolume::blocks() const {
  std::vector<Key> keys;
  keys.reserve(block_count());
  for (const auto& [key, tile] : tiles_) {
    const Eigen::Vector3i corner =
        block_of(key).cwiseProduct(Eigen::Vector3i(kTileSide, kTileSide, 1));
    for (std::uint64_t left = tile.present; left != 0; left &= left - 1) {
      const int slot = std::countr_zero(left);
      keys.push_back(key_of(corner + Eigen::Vector3i(slot % kTileSide, slot / kTileSide, 0)));
    }
  }
  std::ranges::sort(keys);
  std::vector<Eigen::Vector3i> places;
  places.reserve(keys.size());
  for (const Key key : keys) places.push_back(block_of(key));
  return places;
}

// ---- what is in memory ----

Expected<void> TsdfVolume::bring_around(std::span<const Eigen::Vector3i> blocks) {
  begin_asking();
  std::array<Key, 3> last{};  // by layer; 0 is no tile's key: its place is too far
  for (const Eigen::Vector3i& block : blocks) {
    for (int layer = 0; layer < 3; ++layer) {
      for (const int y : {block.y() - 1, block.y() + 1}) {
        for (const int x : {block.x() - 1, block.x() + 1}) {
          const Key key = tile_of({x, y, block.z() + layer - 1});
          if (key == std::exchange(last[static_cast<std::size_t>(layer)], key)) continue;
          ROOMWISE_RETURN_IF_ERROR(ask(key, /*to_change=*/false));
        }
      }
    }
  }
  return make_room();
}

Expected<void> TsdfVolume::bring(std::span<const Eigen::Vector3i> blocks) {
  return bring(blocks, /*to_change=*/false);
}

Expected<void> TsdfVolume::bring_to_change(std::span<const Eigen::Vector3i> blocks) {
  return bring(blocks, /*to_change=*/true);
}

Expected<void> TsdfVolume::bring(std::span<const Eigen::Vector3i> blocks, bool to_change) {
  begin_asking();
  Key last = 0;
  for (const Eigen::Vector3i& block : blocks) {
    const Key key = tile_of(block);
    if (key == std::exchange(last, key)) continue;
    ROOMWISE_RETURN_IF_ERROR(ask(key, to_change));
  }
  return make_room();
}

void TsdfVolume::begin_asking() {
  for (Tile* tile : asked_) {
    tile->is_asked = false;
    bytes_ -= tile->memory_bytes;
    tile->memory_bytes = sizeof(TileBlocks);
    for (const auto& block : *tile->blocks)
      tile->memory_bytes += block == nullptr ? 0 : bytes_of(*block);
    bytes_ += tile->memory_bytes;
  }
  asked_.clear();
}

Expected<void> TsdfVolume::ask(Key key, bool to_change) {
  const auto found = tiles_.find(key);
  if (found == tiles_.end() || found->second.is_asked) return {};
  Tile& tile = found->second;
  if (tile.blocks == nullptr) {
    ROOMWISE_TRY(tile.blocks, read(tile));
    tile.memory_bytes = 0;
    tile.is_changed = false;
    used_.push_front(&tile);
    tile.use = used_.begin();
  } else {
    used_.splice(used_.begin(), used_, tile.use);
  }
  tile.is_changed = tile.is_changed || to_change;
  tile.is_asked = true;
  asked_.push_back(&tile);
  return {};
}

Expected<void> TsdfVolume::make_room() {
  if (working_set_.scratch_folder.empty()) return {};
  while (bytes_ > working_set_.max_bytes && !used_.empty() && !used_.back()->is_asked)
    ROOMWISE_RETURN_IF_ERROR(push_out(*used_.back()));
  return {};
}

Expected<void> TsdfVolume::push_out(Tile& tile) {
  if (tile.is_changed) {
    if (!scratch_) {
      ROOMWISE_TRY(ScratchFile scratch, ScratchFile::create(working_set_.scratch_folder));
      scratch_.emplace(std::move(scratch));
    }
    Bytes bytes = to_bytes(tile);
    const auto size = static_cast<std::uint32_t>(bytes.size());
    if (size <= tile.disk_room) {
      ROOMWISE_RETURN_IF_ERROR(scratch_->overwrite(tile.offset, bytes));
    } else {
      bytes.resize(size + size / 4);  // sums grow when it is seen again
      ROOMWISE_TRY(tile.offset, scratch_->append(bytes));
      tile.disk_room = static_cast<std::uint32_t>(bytes.size());
    }
    tile.disk_bytes = size;
  }
  used_.erase(tile.use);
  tile.blocks.reset();
  bytes_ -= tile.memory_bytes;
  return {};
}

Bytes TsdfVolume::to_bytes(const Tile& tile) {
  std::size_t most = 0;
  for (const auto& block : *tile.blocks) {
    if (block != nullptr)
      most += 1 + kMaxVarint * kBlockVoxels * (block->colors == nullptr ? 2 : 6);
  }
  Writer writer(most);
  for (const auto& block : *tile.blocks) {
    if (block != nullptr) put(writer, *block);
  }
  return writer.finish();
}

Expected<std::unique_ptr<TsdfVolume::TileBlocks>> TsdfVolume::read(const Tile& tile) const {
  ROOMWISE_TRY(const Bytes bytes, scratch_->read(tile.offset, tile.disk_bytes));
  auto blocks = std::make_unique<TileBlocks>();
  Reader reader(bytes);
  for (std::uint64_t left = tile.present; left != 0; left &= left - 1)
    (*blocks)[static_cast<std::size_t>(std::countr_zero(left))] = take_block(reader);
  if (!reader.is_whole()) {
    return fail(
        "{}: the scratch file there does not give back what was written; is that disk sound?",
        working_set_.scratch_folder.string());
  }
  return blocks;
}

// ---- blocks in memory ----

const VoxelBlock* TsdfVolume::find(const Eigen::Vector3i& block) const {
  const auto found = tiles_.find(tile_of(block));
  if (found == tiles_.end() || found->second.blocks == nullptr) return nullptr;
  return (*found->second.blocks)[slot_of(block)].get();
}

VoxelBlock* TsdfVolume::find(const Eigen::Vector3i& block) {
  return const_cast<VoxelBlock*>(std::as_const(*this).find(block));
}

void TsdfVolume::insert(const Eigen::Vector3i& block, std::unique_ptr<VoxelBlock> content) {
  Tile& tile = tiles_[tile_of(block)];
  if (tile.blocks == nullptr) {
    tile.blocks = std::make_unique<TileBlocks>();
    used_.push_front(&tile);
    tile.use = used_.begin();
    tile.is_asked = true;
    asked_.push_back(&tile);
  }
  (*tile.blocks)[slot_of(block)] = std::move(content);
  tile.present |= std::uint64_t{1} << slot_of(block);
}

void TsdfVolume::erase(const Eigen::Vector3i& block) {
  const auto found = tiles_.find(tile_of(block));
  if (found == tiles_.end()) return;
  (*found->second.blocks)[slot_of(block)] = nullptr;
  found->second.present &= ~(std::uint64_t{1} << slot_of(block));
}

bool operator==(const TsdfVolume& a, const TsdfVolume& b) {
  const auto bytes_of_tile = [](const TsdfVolume& field, const TsdfVolume::Tile& tile) {
    if (tile.blocks != nullptr) return Expected<Bytes>(TsdfVolume::to_bytes(tile));
    return field.scratch_->read(tile.offset, tile.disk_bytes);
  };
  return a.block_count() == b.block_count() &&
         std::ranges::all_of(a.tiles_, [&](const auto& entry) {
           const auto& [key, tile] = entry;
           if (tile.present == 0) return true;
           const auto found = b.tiles_.find(key);
           if (found == b.tiles_.end() || found->second.present != tile.present) return false;
           const auto here = bytes_of_tile(a, tile), there = bytes_of_tile(b, found->second);
           return here && there && *here == *there;
         });
}

}  // namespace roomwise::fusion
