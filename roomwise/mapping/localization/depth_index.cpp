#include "roomwise/mapping/localization/depth_index.h"

#include <algorithm>
#include <cmath>

namespace roomwise::mapping {
namespace {

constexpr int kStep = 2;  // pixels of the coarsest level a pixel of the thumbnail

using Thumbnail = Eigen::Array<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct Shift {
  int x = 0, y = 0;  // pixels of the thumbnail
};

// The mean difference of the depths that overlap, each cut off at 1: one that is a seventh of the
// distance counts fully, since the camera need not stand where it stood.
double unlike(const Thumbnail& asked, const Thumbnail& indexed, const Shift& shift) {
  constexpr float kShare = 0.15F, kMin_m = 0.1F, kUnknown = 0.5F;
  constexpr int kMinPixels = 60;
  float sum = 0;
  int count = 0;
  for (Eigen::Index y = 0; y < asked.rows(); ++y) {
    const Eigen::Index row = y + shift.y;
    if (row < 0 || row >= indexed.rows()) continue;
    for (Eigen::Index x = 0; x < asked.cols(); ++x) {
      const Eigen::Index column = x + shift.x;
      if (column < 0 || column >= indexed.cols()) continue;
      const float a = asked(y, x), b = indexed(row, column);
      if (a <= 0 && b <= 0) continue;
      ++count;
      sum += a <= 0 || b <= 0
                 ? kUnknown
                 : std::min(1.0F, std::abs(a - b) / (kShare * std::min(a, b) + kMin_m));
    }
  }
  return count < kMinPixels ? 1.0 : static_cast<double>(sum / static_cast<float>(count));
}

}  // namespace

DepthIndex::Thumbnail DepthIndex::shrink(const motion::PyramidLevel& level) {
  Thumbnail thumbnail(level.depth.height() / kStep, level.depth.width() / kStep);
  const auto units = static_cast<float>(level.camera.depth_units_per_metre);
  for (Eigen::Index y = 0; y < thumbnail.rows(); ++y) {
    for (Eigen::Index x = 0; x < thumbnail.cols(); ++x) {
      thumbnail(y, x) = level.depth.at(static_cast<int>(x) * kStep + kStep / 2,
                                       static_cast<int>(y) * kStep + kStep / 2) /
                        units;
    }
  }
  return thumbnail;
}

void DepthIndex::add(const motion::RgbdPyramid& view) {
  thumbnails_.push_back(shrink(view.levels.back()));
}

void DepthIndex::keep_only(std::span<const std::size_t> kept) {
  std::vector<Thumbnail> thumbnails;
  for (const std::size_t index : kept) thumbnails.push_back(std::move(thumbnails_[index]));
  thumbnails_ = std::move(thumbnails);
}

void DepthIndex::write(PlainWriter& writer) const {
  writer.put(static_cast<std::uint64_t>(thumbnails_.size()));
  for (const Thumbnail& thumbnail : thumbnails_) {
    writer.put(static_cast<std::uint64_t>(thumbnail.rows()));
    writer.put(static_cast<std::uint64_t>(thumbnail.cols()));
    writer.put(thumbnail.data(), static_cast<std::size_t>(thumbnail.size()));
  }
}

std::size_t DepthIndex::written_bytes() const {
  std::size_t bytes = sizeof(std::uint64_t);
  for (const Thumbnail& thumbnail : thumbnails_) {
    bytes += 2 * sizeof(std::uint64_t) + static_cast<std::size_t>(thumbnail.size()) * sizeof(float);
  }
  return bytes;
}

void DepthIndex::read(PlainReader& reader) {
  thumbnails_.resize(reader.get_count(2 * sizeof(std::uint64_t)));
  for (Thumbnail& thumbnail : thumbnails_) {
    const std::size_t rows = reader.get_count(1);
    const std::size_t columns = reader.get_columns(rows, sizeof(float));
    thumbnail.resize(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(columns));
    reader.get(thumbnail.data(), static_cast<std::size_t>(thumbnail.size()));
  }
}

std::vector<DepthIndex::Hit> DepthIndex::find(const motion::RgbdPyramid& view, std::size_t most,
                                              const std::vector<bool>& left_out) const {
  // Of two that fit alike the less turned one.
  constexpr double kPerPixel = 0.006;
  constexpr int kMaxAside = 6, kMaxUp = 2, kBetween = 2;
  const geometry::PinholeCamera& camera = view.levels.back().camera;
  const Thumbnail asked = shrink(view.levels.back());
  std::vector<Hit> hits;
  for (std::size_t i = 0; i < thumbnails_.size(); ++i) {
    if (i < left_out.size() && left_out[i]) continue;
    Hit best{i, 2, {}};
    Shift best_shift;
    for (int x = -kMaxAside; x <= kMaxAside; x += kBetween) {
      for (int y = -kMaxUp; y <= kMaxUp; y += kBetween) {
        const double value =
            unlike(asked, thumbnails_[i], {x, y}) + kPerPixel * (std::abs(x) + std::abs(y));
        if (value >= best.unlike) continue;
        best.unlike = value;
        best_shift = {x, y};
      }
    }
    const Eigen::Vector3d turned(kStep * best_shift.x / camera.fx, kStep * best_shift.y / camera.fy,
                                 1);
    best.indexed_from_query.rotation =
        Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), turned);
    hits.push_back(best);
  }
  std::ranges::stable_sort(hits, {}, &Hit::unlike);
  hits.resize(std::min(hits.size(), most));
  return hits;
}

}  // namespace roomwise::mapping
