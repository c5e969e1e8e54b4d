#include "laboratory/simulation/render/light_filter.h"

#include <algorithm>
#include <cmath>

#include "laboratory/simulation/scene/color_math.h"

namespace roomwise::simulation {
namespace {

// Blends over a patch once, with neighbours `step` texels apart.
class PatchFilter {
 public:
  PatchFilter(const Patch& patch, const std::vector<Eigen::Vector3f>& from,
              std::vector<Eigen::Vector3f>& to)
      : patch_(patch), from_(from), to_(to) {
    for (int row = 0; row < patch.rows; ++row) {
      for (int column = 0; column < patch.columns; ++column) {
        guide_.push_back(smooth_luminance(column, row));
      }
    }
  }

  void run(int step, float tolerance) {
    for (int row = 0; row < patch_.rows; ++row) {
      for (int column = 0; column < patch_.columns; ++column) {
        if (!patch_.is_hole[local(column, row)]) blend(column, row, step, tolerance);
      }
    }
  }

 private:
  [[nodiscard]] std::size_t local(int column, int row) const {
    return static_cast<std::size_t>(row * patch_.columns + column);
  }
  [[nodiscard]] const Eigen::Vector3f& value(int column, int row) const {
    return from_[patch_.first_texel + local(column, row)];
  }
  [[nodiscard]] bool is_there(int column, int row) const {
    return column >= 0 && row >= 0 && column < patch_.columns && row < patch_.rows &&
           !patch_.is_hole[local(column, row)];
  }
  // The mean of the nine texels about one: less noisy than the texel itself, to compare by.
  [[nodiscard]] float smooth_luminance(int column, int row) const {
    float sum = 0, count = 0;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if (!is_there(column + dx, row + dy)) continue;
        sum += luminance(value(column + dx, row + dy));
        count += 1;
      }
    }
    return count > 0 ? sum / count : 0;
  }

  void blend(int column, int row, int step, float tolerance) {
    const float here = guide_[local(column, row)];
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    float weights = 0;
    for (int dy = -2; dy <= 2; ++dy) {
      for (int dx = -2; dx <= 2; ++dx) {
        const int x = column + dx * step, y = row + dy * step;
        if (!is_there(x, y)) continue;
        const float there = guide_[local(x, y)];
        const float difference = std::abs(there - here) / (tolerance * (here + there) + 1e-6F);
        const float weight = std::exp(-0.35F * static_cast<float>(dx * dx + dy * dy)) *
                             std::exp(-difference * difference);
        sum += weight * value(x, y);
        weights += weight;
      }
    }
    to_[patch_.first_texel + local(column, row)] = sum / weights;
  }

  const Patch& patch_;
  const std::vector<Eigen::Vector3f>& from_;
  std::vector<Eigen::Vector3f>& to_;
  std::vector<float> guide_;  // smooth_luminance of every texel
};

}  // namespace

void fill_buried_texels(const Scene& scene, std::vector<std::uint8_t> is_buried,
                        std::vector<Eigen::Vector3f>& texels) {
  constexpr int kRounds = 2;  // a texel further in each
  for (int round = 0; round < kRounds; ++round) {
    std::vector<std::uint8_t> still_buried = is_buried;
    for (const Patch& patch : scene.patches()) {
      for (int row = 0; row < patch.rows; ++row) {
        for (int column = 0; column < patch.columns; ++column) {
          const std::size_t here = patch.texel_index(column, row);
          if (is_buried[here] == 0) continue;
          Eigen::Vector3f sum = Eigen::Vector3f::Zero();
          float count = 0;
          for (const auto& [x, y] : {std::pair{column - 1, row},
                                     {column + 1, row},
                                     {column, row - 1},
                                     {column, row + 1}}) {
            if (x < 0 || y < 0 || x >= patch.columns || y >= patch.rows) continue;
            const std::size_t there = patch.texel_index(x, y);
            if (is_buried[there] != 0 || patch.is_hole[there - patch.first_texel]) continue;
            sum += texels[there];
            count += 1;
          }
          if (count <= 0) continue;
          texels[here] = sum / count;
          still_buried[here] = 0;
        }
      }
    }
    is_buried = std::move(still_buried);
  }
}

void filter_texels(const Scene& scene, Smoothness smoothness, ThreadPool& pool,
                   std::vector<Eigen::Vector3f>& texels) {
  const auto blend_all = [&](int step, float tolerance) {
    std::vector<Eigen::Vector3f> smoothed = texels;
    pool.parallel_for(scene.patches().size(), [&](std::size_t i) {
      PatchFilter(scene.patches()[i], texels, smoothed).run(step, tolerance);
    });
    texels = std::move(smoothed);
  };
  const bool is_bounced = smoothness == Smoothness::kBounced;
  blend_all(1, is_bounced ? 0.25F : 0.12F);
  blend_all(2, is_bounced ? 0.12F : 0.05F);
  if (is_bounced) blend_all(3, 0.06F);
}

}  // namespace roomwise::simulation
