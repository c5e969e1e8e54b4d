#include "laboratory/simulation/render/corner_light.h"

#include <algorithm>

#include "laboratory/simulation/scene/color_math.h"

namespace roomwise::simulation {
namespace {

constexpr int kDirectRounds = 2;
constexpr float kDirectTolerance = 0.1F, kBouncedTolerance = 0.2F;

// About exp(-squared), without its tail.
float closeness(float squared) {
  const float left = std::max(0.0F, 1 - squared / 4);
  return (left * left) * (left * left);
}

}  // namespace

CornerLight::CornerLight(const CornerPoints& points, std::span<const Flux> direct,
                         std::span<const Flux> bounced)
    : points_(points) {
  const std::size_t count = points.points().size();
  for (auto& lights : direct_) lights.resize(count);
  for (auto& lights : bounced_) lights.resize(count);
  is_dark_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    direct_[0][i] = light_of(direct[i]);
    bounced_[0][i] = light_of(bounced[i]);
    is_dark_[i] = direct[i].isZero(0) && bounced[i].isZero(0);
  }
  neighborhoods_.resize((count + kChunk - 1) / kChunk);
}

CornerLight::Light CornerLight::light_of(const Flux& flux) {
  Light light;
  for (const Eigen::Index axis : {0, 1, 2}) {
    const Eigen::Vector3f color = flux.row(axis);
    for (const Eigen::Index channel : {0, 1, 2}) light(channel, axis) = color[channel];
    light(3, axis) = luminance(color);
  }
  return light;
}

Eigen::Vector4f CornerLight::met_by(const Light& light, const Eigen::Vector3f& normal) {
  return light.col(0) * normal.x() + light.col(1) * normal.y() + light.col(2) * normal.z();
}

// Points that no light reaches, inside of shut furniture, stay dark and tell the others nothing:
// no light is within the tolerance of none.
CornerLight::Neighborhood CornerLight::neighborhood_of(std::size_t from, std::size_t to) const {
  Neighborhood result;
  std::vector<LightPointIndex::Neighbor> found;
  for (std::size_t i = from; i < to; ++i) {
    found.clear();
    if (!is_dark_[i]) points_.find_neighbors(i, found);
    std::ranges::copy_if(found, std::back_inserter(result.neighbors), [&](const auto& neighbor) {
      return neighbor.weight > 0 && !is_dark_[neighbor.point];
    });
    result.first[i - from + 1] = static_cast<std::uint32_t>(result.neighbors.size());
  }
  result.neighbors.shrink_to_fit();
  return result;
}

void CornerLight::smooth(int round, std::size_t from, std::size_t to) {
  Neighborhood& nearby = neighborhoods_[from / kChunk];
  if (round == 0) nearby = neighborhood_of(from, to);
  const std::size_t source = round % 2 == 0 ? 0 : 1;
  for (std::size_t i = from; i < to; ++i) {
    const std::uint32_t first = nearby.first[i - from], end = nearby.first[i - from + 1];
    const auto neighbors = std::span(nearby.neighbors).subspan(first, end - first);
    bounced_[1 - source][i] = smoothed(bounced_[source], i, neighbors, kBouncedTolerance);
    if (round < kDirectRounds) {
      direct_[1 - source][i] = smoothed(direct_[source], i, neighbors, kDirectTolerance);
    }
  }
}

// A point's light averaged over the neighbors whose light differs little.
CornerLight::Light CornerLight::smoothed(const std::vector<Light>& lights, std::size_t point,
                                         std::span<const LightPointIndex::Neighbor> neighbors,
                                         float tolerance) const {
  const Eigen::Vector3f& normal = points_.points()[point].normal;
  const auto brightness = [&](const Light& light) {
    return std::max(0.0F,
                    light(3, 0) * normal.x() + light(3, 1) * normal.y() + light(3, 2) * normal.z());
  };
  const float here = brightness(lights[point]);
  Light sum = 1e-6F * lights[point];
  float weights = 1e-6F;
  for (const LightPointIndex::Neighbor& neighbor : neighbors) {
    const Light& light = lights[neighbor.point];
    const float there = brightness(light);
    const float difference = (there - here) / (tolerance * (here + there) + 1e-6F);
    const float alike = neighbor.weight * closeness(difference * difference);
    if (alike <= 0) continue;
    sum += alike * light;
    weights += alike;
  }
  return sum / weights;
}

void CornerLight::blend(std::size_t from, std::size_t to,
                        std::array<std::vector<Eigen::Vector3f>, 2>& light) const {
  constexpr float kMinWeight = 1e-5F;
  const std::vector<Light>& direct = direct_[kDirectRounds % 2];
  const std::vector<Light>& bounced = bounced_[kRounds % 2];
  const auto illuminance = [&](std::uint32_t point, const Eigen::Vector3f& normal) {
    return met_by(direct[point] + bounced[point], normal).cwiseMax(0.0F).eval();
  };
  CornerPoints::CornerSources sources;
  for (std::size_t i = from; i < to; ++i) {
    for (auto& side : light) side[i].setZero();
    if (!points_.find_sources(static_cast<std::uint32_t>(i), sources)) continue;
    const std::array<Eigen::Vector3f, 2> normals{sources.normal, -sources.normal};
    std::array<Eigen::Vector4f, 2> sums{Eigen::Vector4f::Zero(), Eigen::Vector4f::Zero()};
    std::array<float, 2> weights{};
    for (const LightPointIndex::Neighbor& neighbor : sources.neighbors) {
      const std::size_t side = neighbor.weight > 0 ? 0 : 1;
      const float weight = std::abs(neighbor.weight);
      sums[side] += weight * illuminance(neighbor.point, normals[side]);
      weights[side] += weight;
    }
    for (const std::size_t side : {std::size_t{0}, std::size_t{1}}) {
      if (weights[side] > kMinWeight) {
        light[side][i] = sums[side].head<3>() / weights[side];
      } else if (sources.own_point[side] != CornerPoints::kNone) {
        light[side][i] = illuminance(sources.own_point[side], normals[side]).head<3>();
      }
    }
  }
}

}  // namespace roomwise::simulation
