#include "laboratory/simulation/render/frame_renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <span>

#include "laboratory/simulation/scene/color_math.h"
#include "laboratory/simulation/scene/sampling.h"

namespace roomwise::simulation {
namespace {

constexpr int kTile = 32;  // px

// A block's rays go about the same way and are traced together.
constexpr int kBlock = 4;  // px
static_assert(kTile % kBlock == 0 && kBlock * kBlock <= RayCaster::kBundle);

// The pixels of a block, row after row; fewer at the image's edges.
struct Block {
  std::array<Eigen::Vector2i, RayCaster::kBundle> pixels;
  std::size_t count = 0;
};

void for_all_blocks(int width, int height, ThreadPool& pool,
                    const std::function<void(const Block& block)>& visit) {
  const int columns = (width + kTile - 1) / kTile, rows = (height + kTile - 1) / kTile;
  const auto block_at = [&](int left, int top) {
    Block block;
    for (int y = top; y < std::min(top + kBlock, height); ++y) {
      for (int x = left; x < std::min(left + kBlock, width); ++x) {
        block.pixels[block.count++] = {x, y};
      }
    }
    return block;
  };
  pool.parallel_for(static_cast<std::size_t>(columns * rows), [&](std::size_t tile) {
    const int left = static_cast<int>(tile) % columns * kTile;
    const int top = static_cast<int>(tile) / columns * kTile;
    for (int y = top; y < std::min(top + kTile, height); y += kBlock) {
      for (int x = left; x < std::min(left + kTile, width); x += kBlock) visit(block_at(x, y));
    }
  });
}

}  // namespace

ViewDirections::ViewDirections(const geometry::PinholeCamera& camera)
    : camera_(camera), centers_(camera.width + 2, camera.height + 2, Eigen::Vector2f::Zero()) {
  for (int y = -1; y <= camera.height; ++y) {
    for (int x = -1; x <= camera.width; ++x) {
      const Eigen::Vector2d ideal = camera.undistort({x, y});
      centers_.at(x + 1, y + 1) = {static_cast<float>((ideal.x() - camera.cx) / camera.fx),
                                   static_cast<float>((ideal.y() - camera.cy) / camera.fy)};
    }
  }
}

Eigen::Vector3f ViewDirections::at(int x, int y, const Eigen::Vector2f& beside_px) const {
  const Eigen::Vector2f right = (center(x + 1, y) - center(x - 1, y)) / 2;
  const Eigen::Vector2f down = (center(x, y + 1) - center(x, y - 1)) / 2;
  const Eigen::Vector2f place = center(x, y) + beside_px.x() * right + beside_px.y() * down;
  return {place.x(), place.y(), 1};
}

FrameRenderer::FrameRenderer(const Scene& scene, const Shading& shading,
                             const ViewDirections& directions,
                             const geometry::RigidTransform& world_from_camera,
                             int samples_per_pixel)
    : scene_(scene),
      shading_(shading),
      directions_(directions),
      rotation_(world_from_camera.rotation_matrix().cast<float>()),
      origin_(world_from_camera.translation.cast<float>()),
      samples_(samples_per_pixel),
      pixel_width_(
          static_cast<float>(1 / std::min(directions.camera().fx, directions.camera().fy))),
      centers_(directions.camera().width, directions.camera().height) {}

// The first sample of a pixel is its centre.
ViewRay FrameRenderer::ray_of(int x, int y, int sample) const {
  const auto pixel = static_cast<std::uint32_t>(y * centers_.width() + x);
  Eigen::Vector2f beside = Eigen::Vector2f::Zero();
  if (sample > 0) {
    beside = EvenPoints(pixel * 2654435761U).at(sample) - Eigen::Vector2f::Constant(0.5F);
  }
  return {origin_, rotation_ * directions_.at(x, y, beside), pixel_width_,
          pixel * 256U + static_cast<std::uint32_t>(sample), std::nullopt};
}

RenderedFrame FrameRenderer::render(ThreadPool& pool) {
  const int width = centers_.width(), height = centers_.height();
  RenderedFrame frame{image::Image<Eigen::Vector3f>(width, height, Eigen::Vector3f::Zero()),
                      image::Image<float>(width, height), image::Image<float>(width, height),
                      image::Image<float>(width, height),
                      image::Image<std::uint16_t>(width, height)};
  for_all_blocks(width, height, pool, [&](const Block& block) {
    const auto hits = first_hits(std::span(block.pixels).first(block.count), 0);
    for (std::size_t i = 0; i < block.count; ++i) {
      look_through_center(block.pixels[i].x(), block.pixels[i].y(), hits[i], frame);
    }
  });
  for_all_blocks(width, height, pool, [&](const Block& block) {
    shade(std::span(block.pixels).first(block.count), frame);
  });
  return frame;
}

// What the rays of one sample of some pixels meet.
FrameRenderer::Hits FrameRenderer::first_hits(std::span<const Eigen::Vector2i> pixels,
                                              int sample) const {
  RayCaster::Bundle bundle;
  for (const Eigen::Vector2i& pixel : pixels) {
    bundle.add(ray_of(pixel.x(), pixel.y(), sample).direction, kFarthestDrawn);
  }
  return scene_.rays().first_hits(origin_, bundle);
}

// What the depth camera and the truth need, of the first thing that is not looked through.
void FrameRenderer::look_through_center(int x, int y, std::optional<RayHit> hit,
                                        RenderedFrame& frame) {
  const ViewRay ray = ray_of(x, y, 0);
  Center& center = centers_.at(x, y);
  center.hit = hit;
  while (hit) {
    note_surface(ray, *hit, x, y, frame);
    const SceneTriangle& triangle = scene_.triangles()[hit->triangle];
    if (scene_.appearances()[triangle.appearance].opacity() > 0.5F) break;
    hit = scene_.rays().first_hit(ray.origin, ray.direction, hit->distance * (1 + 1e-5F) + 1e-5F,
                                  kFarthestDrawn, RayCaster::Meets::kEverything);
  }
  if (hit) {
    frame.depth_m.at(x, y) = hit->distance;
    frame.object.at(x, y) = scene_.triangles()[hit->triangle].object;
    center.in_sun = shading_.is_in_sun(ray, *hit);
  } else {
    frame.albedo.at(x, y) = 0;
  }
}

void FrameRenderer::note_surface(const ViewRay& ray, const RayHit& hit, int x, int y,
                                 RenderedFrame& frame) const {
  const Eigen::Vector3f point = ray.origin + hit.distance * ray.direction;
  const SurfaceLook look = scene_.look_at(hit, point, ray.spread * hit.distance);
  frame.specularity.at(x, y) = std::max(frame.specularity.at(x, y), look.specular);
  frame.albedo.at(x, y) = look.albedo.mean();
}

// Whether the surface at one pixel goes on at another: alike, in one plane, in the same light.
bool FrameRenderer::continues(int x, int y, int other_x, int other_y) const {
  if (!centers_.contains(other_x, other_y)) return true;
  const Center& here = centers_.at(x, y);
  const Center& there = centers_.at(other_x, other_y);
  if (!there.hit || here.in_sun != there.in_sun) return false;
  const SceneTriangle& a = scene_.triangles()[here.hit->triangle];
  const SceneTriangle& b = scene_.triangles()[there.hit->triangle];
  if (&a == &b) return true;
  if (a.patch >= 0 || b.patch >= 0) return a.patch == b.patch;
  if (a.object != b.object || a.appearance != b.appearance) return false;
  constexpr float kAlike = 0.97F;
  if (std::abs(a.normal.dot(b.normal)) < kAlike) return false;
  const Eigen::Vector3f step = there.hit->distance * ray_of(other_x, other_y, 0).direction -
                               here.hit->distance * ray_of(x, y, 0).direction;
  return std::abs(a.normal.dot(step)) < 0.3F * step.norm();
}

bool FrameRenderer::is_even(int x, int y) const {
  const Center& here = centers_.at(x, y);
  if (!here.hit || here.hit->triangle >= scene_.opaque_count()) return false;
  if (scene_.appearances()[scene_.triangles()[here.hit->triangle].appearance].is_detailed()) {
    return false;
  }
  return continues(x, y, x - 1, y) && continues(x, y, x + 1, y) && continues(x, y, x, y - 1) &&
         continues(x, y, x, y + 1);
}

void FrameRenderer::shade(std::span<const Eigen::Vector2i> pixels, RenderedFrame& frame) const {
  // Glaring samples count for less: a picture that is too bright for its edge with one part of a
  // pixel is so with the whole, and edges of windows and sunlight would be jagged.
  constexpr float kGlaring = 60;  // cd/m^2
  struct Mean {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    float weights = 0;

    void add(const Eigen::Vector3f& sample) {
      const float weight = 1 / (1 + luminance(sample) / kGlaring);
      sum += weight * sample;
      weights += weight;
    }
  };
  std::array<Mean, RayCaster::kBundle> means;
  std::array<Eigen::Vector2i, RayCaster::kBundle> uneven;
  std::size_t count = 0;
  for (const Eigen::Vector2i& pixel : pixels) {
    const Center& center = centers_.at(pixel.x(), pixel.y());
    ViewRay middle = ray_of(pixel.x(), pixel.y(), 0);
    if (samples_ == 1 || is_even(pixel.x(), pixel.y())) {
      middle.in_sun = center.in_sun;
      frame.radiance.at(pixel.x(), pixel.y()) = shading_.radiance(middle, center.hit);
    } else {
      means[count].add(shading_.radiance(middle, center.hit));
      uneven[count++] = pixel;
    }
  }
  if (count == 0) return;
  const auto several = std::span(uneven).first(count);
  for (int sample = 1; sample < samples_; ++sample) {
    const Hits hits = first_hits(several, sample);
    for (std::size_t i = 0; i < count; ++i) {
      ViewRay ray = ray_of(several[i].x(), several[i].y(), sample);
      ray.faintest_mirror = 0.1F;  // along edges nobody misses the mirror image in a tile
      means[i].add(shading_.radiance(ray, hits[i]));
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    frame.radiance.at(several[i].x(), several[i].y()) = means[i].sum / means[i].weights;
  }
}

}  // namespace roomwise::simulation
