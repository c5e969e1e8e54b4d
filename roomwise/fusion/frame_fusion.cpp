#include "roomwise/fusion/frame_fusion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace roomwise::fusion {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using Eigen::Vector3i;
using geometry::RigidTransform;

constexpr double kNearest_m = 0.1;  // from the camera
constexpr int kTile_px = 16;

// How far a frame sees, in tiles of pixels.
class MaxDepthTiles {
 public:
  explicit MaxDepthTiles(const FrameSurface& frame)
      : farthest_m_((frame.camera.width + kTile_px - 1) / kTile_px,
                    (frame.camera.height + kTile_px - 1) / kTile_px) {
    for (int y = 0; y < frame.camera.height; ++y) {
      for (int x = 0; x < frame.camera.width; ++x) {
        const SurfacePixel& pixel = pixel_at_undistorted(frame, x, y);
        // The plane may lead farther than the pixel: a tile's neighbours are asked too.
        float& farthest_m = farthest_m_.at(x / kTile_px, y / kTile_px);
        farthest_m = std::max(farthest_m, depth_m(frame, pixel, x, y));
      }
    }
  }

  // Within a square about an ideal pixel; 0 where nothing is seen or it lies outside.
  [[nodiscard]] float within(double x_px, double y_px, double reach_px) const {
    const auto tile = [](double px, int count) {
      return static_cast<int>(std::clamp(std::floor(px / kTile_px), -1.0, 1.0 * count));
    };
    const int right = std::min(farthest_m_.width() - 1, tile(x_px + reach_px, farthest_m_.width()));
    const int below =
        std::min(farthest_m_.height() - 1, tile(y_px + reach_px, farthest_m_.height()));
    float farthest_m = 0;
    for (int y = std::max(0, tile(y_px - reach_px, farthest_m_.height())); y <= below; ++y) {
      for (int x = std::max(0, tile(x_px - reach_px, farthest_m_.width())); x <= right; ++x) {
        farthest_m = std::max(farthest_m, farthest_m_.at(x, y));
      }
    }
    return farthest_m;
  }

  // What the ideal camera sees there; without any depth where the lens shows nothing of it.
  [[nodiscard]] static const SurfacePixel& pixel_at_undistorted(const FrameSurface& frame, int x,
                                                                int y) {
    static const SurfacePixel kNothing;
    if (frame.distorted_index_of_undistorted->empty()) return frame.pixels.at(x, y);
    const std::int32_t real =
        (*frame.distorted_index_of_undistorted)[static_cast<std::size_t>(y) *
                                                    static_cast<std::size_t>(frame.camera.width) +
                                                static_cast<std::size_t>(x)];
    return real < 0 ? kNothing : frame.pixels.pixels()[static_cast<std::size_t>(real)];
  }

 private:
  static float depth_m(const FrameSurface& frame, const SurfacePixel& pixel, int x, int y) {
    if (!pixel.has_surface()) return pixel.free_depth_m;
    const Vector3f ray = frame.camera.unproject_undistorted({x, y}, 1.0).cast<float>();
    return std::max(pixel.free_depth_m, pixel.offset_m / pixel.normal.dot(ray));
  }

  image::Image<float> farthest_m_;
};

// The blocks that may hold voxels which the frame sees, in the order of their keys.
std::vector<Vector3i> blocks_in_view(const TsdfOptions& field, const FrameSurface& frame,
                                     const RigidTransform& field_from_camera) {
  const MaxDepthTiles farthest(frame);
  const geometry::PinholeCamera& camera = frame.camera;
  const double reach_m = frame.options.farthest_m + field.truncation_m();
  Eigen::AlignedBox3d bounds(field_from_camera.translation);
  for (const double x : {-0.5, camera.width - 0.5}) {
    for (const double y : {-0.5, camera.height - 0.5}) {
      bounds.extend(field_from_camera * camera.unproject_undistorted({x, y}, reach_m));
    }
  }
  const double block_m = kBlockSide * field.voxel_size_m;
  const double radius_m = std::sqrt(3.0) / 2 * (kBlockSide - 1) * field.voxel_size_m;
  const Vector3i low = ((bounds.min().array() - field.voxel_size_m) / block_m).floor().cast<int>();
  const Vector3i high = ((bounds.max().array() + field.voxel_size_m) / block_m).floor().cast<int>();
  const RigidTransform camera_from_field = field_from_camera.inverse();
  const double focal_px = std::max(camera.fx, camera.fy);

  std::vector<Vector3i> blocks;
  for (int z = low.z(); z <= high.z(); ++z) {
    for (int y = low.y(); y <= high.y(); ++y) {
      for (int x = low.x(); x <= high.x(); ++x) {
        const Vector3i block(x, y, z);
        if (!TsdfVolume::has_key(block)) continue;
        const Vector3d middle_field =
            field.voxel_size_m *
            (kBlockSide * block.cast<double>() + Vector3d::Constant(0.5 * (kBlockSide - 1)));
        const Vector3d middle = camera_from_field * middle_field;
        const double nearest_m = middle.z() - radius_m;
        if (nearest_m > reach_m || middle.z() + radius_m < kNearest_m) continue;
        double farthest_m = reach_m;  // about the camera itself everything is in view
        if (nearest_m > kNearest_m) {
          const Eigen::Vector2d pixel = camera.project_undistorted(middle);
          // The farther a ray is from the axis the more the sphere about the block is drawn out.
          const double slant = 1 + middle.head<2>().norm() / middle.z();
          farthest_m =
              farthest.within(pixel.x(), pixel.y(), slant * focal_px * radius_m / nearest_m + 1);
          if (farthest_m == 0) continue;
        }
        if (nearest_m < farthest_m + field.truncation_m()) blocks.push_back(block);
      }
    }
  }
  return blocks;
}

// What one frame says of one voxel.
struct Observation {
  std::int32_t distance = 0;  // steps
  std::uint32_t weight = 0;   // 0: nothing
  const SurfacePixel* color = nullptr;
};

// Looks voxels up in one frame.
class FrameView {
 public:
  FrameView(const TsdfOptions& field, const FrameSurface& frame,
            const RigidTransform& field_from_camera)
      : frame_(frame),
        camera_from_field_(field_from_camera.inverse()),
        rotation_(camera_from_field_.rotation_matrix().cast<float>()),
        fx_(static_cast<float>(frame.camera.fx)),
        fy_(static_cast<float>(frame.camera.fy)),
        cx_(static_cast<float>(frame.camera.cx)),
        cy_(static_cast<float>(frame.camera.cy)),
        width_(frame.camera.width),
        height_(frame.camera.height),
        voxel_m_(static_cast<float>(field.voxel_size_m)),
        truncation_m_(static_cast<float>(field.truncation_m())),
        noise_at_1m_m_(static_cast<float>(frame.options.depth_noise_at_1m_m)),
        keeps_colors_(field.keeps_colors && frame.has_colors) {}

  // The camera coordinates of a block's first voxel, and the steps to its neighbours.
  [[nodiscard]] Vector3f first_voxel(const Vector3i& block) const {
    const Vector3d point_field =
        static_cast<double>(kBlockSide) * block.cast<double>() * static_cast<double>(voxel_m_);
    return (camera_from_field_ * point_field).cast<float>();
  }
  [[nodiscard]] Vector3f step(int axis) const { return voxel_m_ * rotation_.col(axis); }

  [[nodiscard]] Observation observe(const Vector3f& point) const {
    if (!(point.z() > static_cast<float>(kNearest_m))) return {};
    const float px = fx_ * point.x() / point.z() + cx_ + 0.5F;
    const float py = fy_ * point.y() / point.z() + cy_ + 0.5F;
    if (!(px >= 0 && py >= 0 && px < static_cast<float>(width_) &&
          py < static_cast<float>(height_))) {
      return {};
    }
    const SurfacePixel& pixel =
        MaxDepthTiles::pixel_at_undistorted(frame_, static_cast<int>(px), static_cast<int>(py));
    if (pixel.has_surface()) return observe_surface(pixel, point);
    if (point.z() + truncation_m_ < pixel.free_depth_m) {
      return {kStepsPerTruncation, pixel.weight, nullptr};
    }
    return {};
  }

 private:
  [[nodiscard]] Observation observe_surface(const SurfacePixel& pixel,
                                            const Vector3f& point) const {
    const float distance_m = pixel.distance_m(point);
    if (distance_m >= truncation_m_) return {kStepsPerTruncation, pixel.weight, nullptr};
    // Behind a surface nothing is seen. A little is believed, so that there is a crossing from
    // before to behind; more would spoil the other side of a door.
    const float noise_m = noise_at_1m_m_ * point.z() * point.z();
    const float behind_m = std::min(std::max(2 * voxel_m_, 3 * noise_m), truncation_m_);
    if (distance_m <= -behind_m) return {};
    std::uint32_t weight = pixel.weight;
    if (distance_m < -voxel_m_) {
      const float fading = (behind_m + distance_m) / (behind_m - voxel_m_);
      weight = static_cast<std::uint32_t>(std::max(1.0F, fading * static_cast<float>(weight)));
    }
    const float steps = distance_m / truncation_m_ * kStepsPerTruncation;
    // The cast cuts off, and the sum is positive: this rounds.
    const int rounded = static_cast<int>(steps + kStepsPerTruncation + 0.5F) - kStepsPerTruncation;
    const bool is_near = std::abs(distance_m) < 2 * voxel_m_;
    return {rounded, weight, keeps_colors_ && is_near ? &pixel : nullptr};
  }

  const FrameSurface& frame_;
  RigidTransform camera_from_field_;
  Eigen::Matrix3f rotation_;
  float fx_, fy_, cx_, cy_;
  int width_, height_;
  float voxel_m_, truncation_m_, noise_at_1m_m_;
  bool keeps_colors_;
};

// Sums of unsigned numbers wrap around: taking away is adding the negative.
void accumulate(VoxelBlock& block, std::size_t offset, const Observation& seen, int sign) {
  const auto factor = static_cast<std::uint32_t>(sign) * seen.weight;
  Voxel& voxel = block.voxels[offset];
  voxel.weight += factor;
  voxel.distance_sum += sign * static_cast<std::int32_t>(seen.weight) * seen.distance;
  if (seen.color == nullptr) return;
  if (block.colors == nullptr) {
    block.colors = std::make_unique<std::array<ColorSum, kBlockVoxels>>();
  }
  ColorSum& color = (*block.colors)[offset];
  color.r += factor * seen.color->color.r;
  color.g += factor * seen.color->color.g;
  color.b += factor * seen.color->color.b;
  color.weight += factor;
}

// Every voxel of a block that the frame sees; makes the block where it is missing and something is
// seen.
void accumulate_block(std::unique_ptr<VoxelBlock>& made, VoxelBlock* block, const FrameView& view,
                      const Vector3i& place, int sign) {
  const Vector3f first = view.first_voxel(place);
  const Vector3f dx = view.step(0), dy = view.step(1), dz = view.step(2);
  std::size_t offset = 0;
  for (int z = 0; z < kBlockSide; ++z) {
    for (int y = 0; y < kBlockSide; ++y) {
      const Vector3f row = first + static_cast<float>(z) * dz + static_cast<float>(y) * dy;
      for (int x = 0; x < kBlockSide; ++x, ++offset) {
        const Observation seen = view.observe(row + static_cast<float>(x) * dx);
        if (seen.weight == 0) continue;
        if (block == nullptr) {
          made = std::make_unique<VoxelBlock>();
          block = made.get();
        }
        accumulate(*block, offset, seen, sign);
      }
    }
  }
}

Expected<void> accumulate_frame(TsdfVolume& field, const FrameSurface& frame,
                                const RigidTransform& field_from_camera, int sign,
                                ThreadPool& pool) {
  const std::vector<Vector3i> blocks = blocks_in_view(field.options(), frame, field_from_camera);
  ROOMWISE_RETURN_IF_ERROR(field.bring_to_change(blocks));
  const FrameView view(field.options(), frame, field_from_camera);
  std::vector<std::unique_ptr<VoxelBlock>> made(blocks.size());
  std::vector<VoxelBlock*> there(blocks.size());
  constexpr std::size_t kBlocksATask = 256;
  pool.parallel_for((blocks.size() + kBlocksATask - 1) / kBlocksATask, [&](std::size_t task) {
    const std::size_t end = std::min(blocks.size(), (task + 1) * kBlocksATask);
    for (std::size_t i = task * kBlocksATask; i < end; ++i) {
      there[i] = field.find(blocks[i]);
      accumulate_block(made[i], there[i], view, blocks[i], sign);
    }
  });
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (made[i] != nullptr) field.insert(blocks[i], std::move(made[i]));
    if (sign > 0 || there[i] == nullptr) continue;
    there[i]->drop_empty_colors();
    if (there[i]->is_empty()) field.erase(blocks[i]);
  }
  return {};
}

}  // namespace

Expected<void> integrate_frame(TsdfVolume& field, const FrameSurface& frame,
                               const RigidTransform& field_from_camera, ThreadPool& pool) {
  return accumulate_frame(field, frame, field_from_camera, 1, pool);
}

Expected<void> deintegrate_frame(TsdfVolume& field, const FrameSurface& frame,
                                 const RigidTransform& field_from_camera, ThreadPool& pool) {
  return accumulate_frame(field, frame, field_from_camera, -1, pool);
}

}  // namespace roomwise::fusion
