#include "roomwise/fusion/surface_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <span>
#include <unordered_map>
#include <utility>

#include "roomwise/base/disjoint_sets.h"
#include "roomwise/fusion/marching_cubes.h"

namespace roomwise::fusion {
namespace {

using Eigen::Vector3f;
using Eigen::Vector3i;

// The voxels of a block with those around it: two more on the far sides for the cubes at the
// block's end and their gradients, one more on the near sides.
constexpr int kBefore = 1;
constexpr int kSide = kBefore + kBlockSide + 2;
constexpr float kNoDistance = std::numeric_limits<float>::quiet_NaN();

struct Neighbourhood {
  std::array<float, static_cast<std::size_t>(kSide* kSide* kSide)> distance_m;
  std::array<const VoxelBlock*, 27> blocks;

  static std::size_t index(const Vector3i& voxel) {
    const Vector3i v = voxel.array() + kBefore;
    return static_cast<std::size_t>((v.z() * kSide + v.y()) * kSide + v.x());
  }
  // Of a voxel counted from the block's first.
  [[nodiscard]] float at(const Vector3i& voxel) const { return distance_m[index(voxel)]; }
};

// The block (of the 27) along an axis, and the voxel in it.
int block_along(int voxel) {
  return (voxel >> 3) + 1;
}
std::size_t block_slot(const Vector3i& voxel) {
  return static_cast<std::size_t>((block_along(voxel.z()) * 3 + block_along(voxel.y())) * 3 +
                                  block_along(voxel.x()));
}
std::size_t voxel_slot(const Vector3i& voxel) {
  return TsdfVolume::offset_of(voxel.unaryExpr([](int v) { return v & (kBlockSide - 1); }));
}

void fill(Neighbourhood& around, const TsdfVolume& field, const Vector3i& block,
          std::uint32_t min_weight) {
  for (int i = 0; i < 27; ++i) {
    const Vector3i offset(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    around.blocks[static_cast<std::size_t>(i)] = field.find(block + offset);
  }
  for (int z = -kBefore; z < kSide - kBefore; ++z) {
    for (int y = -kBefore; y < kSide - kBefore; ++y) {
      for (int x = -kBefore; x < kSide - kBefore; ++x) {
        const Vector3i voxel(x, y, z);
        const VoxelBlock* there = around.blocks[block_slot(voxel)];
        float& distance_m = around.distance_m[Neighbourhood::index(voxel)];
        distance_m = kNoDistance;
        if (there == nullptr) continue;
        const Voxel& content = there->voxels[voxel_slot(voxel)];
        if (content.weight < min_weight) continue;
        distance_m = static_cast<float>(field.sample(content).distance_m);
      }
    }
  }
}

// The slope of the distance along an axis, from both neighbours or from the one that is known.
float slope(const Neighbourhood& around, const Vector3i& voxel, int axis) {
  const Vector3i step = Vector3i::Unit(axis);
  const float here = around.at(voxel);
  const float ahead = around.at(voxel + step) - here;
  const float behind = here - around.at(voxel - step);
  if (std::isnan(ahead)) return std::isnan(behind) ? 0.0F : behind;
  return std::isnan(behind) ? ahead : 0.5F * (ahead + behind);
}

Vector3f gradient(const Neighbourhood& around, const Vector3i& voxel) {
  return {slope(around, voxel, 0), slope(around, voxel, 1), slope(around, voxel, 2)};
}

// The mean colour at a voxel, and whether there is one.
std::pair<Vector3f, bool> color_at(const Neighbourhood& around, const Vector3i& voxel) {
  const VoxelBlock* block = around.blocks[block_slot(voxel)];
  if (block->colors == nullptr) return {Vector3f::Zero(), false};
  const ColorSum& sum = (*block->colors)[voxel_slot(voxel)];
  if (sum.weight == 0) return {Vector3f::Zero(), false};
  const auto channel = [&](std::uint32_t value) {
    return static_cast<float>(static_cast<double>(value) / sum.weight);
  };
  return {{channel(sum.r), channel(sum.g), channel(sum.b)}, true};
}

Rgb8 rounded(const Vector3f& color) {
  const auto channel = [](float value) {
    return static_cast<std::uint8_t>(std::clamp(value + 0.5F, 0.0F, 255.0F));
  };
  return {channel(color.x()), channel(color.y()), channel(color.z())};
}

// Names a vertex in the whole field: the voxel at the lower end of its edge, and the edge's axis.
struct EdgeKey {
  TsdfVolume::Key block = 0;
  std::uint32_t edge = 0;  // 3 * offset of the voxel + axis

  friend bool operator==(const EdgeKey&, const EdgeKey&) = default;
};
struct EdgeKeyHash {
  std::size_t operator()(const EdgeKey& key) const {
    std::uint64_t mixed = key.block * 0x9E3779B97F4A7C15U + key.edge;
    mixed ^= mixed >> 32;
    return static_cast<std::size_t>(mixed * 0xD6E8FEB86659FD93U);
  }
};

double area_m2(const TriangleMesh& mesh, const std::array<std::uint32_t, 3>& triangle) {
  const Eigen::Vector3d a = mesh.vertices[triangle[0]].cast<double>();
  const Eigen::Vector3d b = mesh.vertices[triangle[1]].cast<double>();
  const Eigen::Vector3d c = mesh.vertices[triangle[2]].cast<double>();
  return 0.5 * (b - a).cross(c - a).norm();
}

// The surface in one block's cubes; triangles count its own vertices.
struct BlockMesh {
  TriangleMesh mesh;
  std::vector<EdgeKey> keys;  // of the vertices
  // What hangs together within the block: for each vertex the lowest that does, and of that one the
  // area.
  std::vector<std::uint32_t> components;
  std::vector<double> areas_m2;

  void find_components() {
    DisjointSets sets(mesh.vertices.size());
    for (const auto& [a, b, c] : mesh.triangles) {
      sets.join(a, b);
      sets.join(a, c);
    }
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
      components.push_back(static_cast<std::uint32_t>(sets.find(i)));
    areas_m2.resize(mesh.vertices.size());
    for (const auto& triangle : mesh.triangles)
      areas_m2[components[triangle[0]]] += area_m2(mesh, triangle);
  }
};

class BlockMesher {
 public:
  BlockMesher(const TsdfVolume& field, std::uint32_t min_weight)
      : field_(field), min_weight_(min_weight) {}

  [[nodiscard]] BlockMesh mesh(const Vector3i& block) {
    block_ = block;
    result_ = {};
    vertex_at_.fill(kNoVertex);
    fill(around_, field_, block, min_weight_);
    for (int z = 0; z < kBlockSide; ++z) {
      for (int y = 0; y < kBlockSide; ++y) {
        for (int x = 0; x < kBlockSide; ++x) add_cube({x, y, z});
      }
    }
    result_.find_components();
    return std::move(result_);
  }

 private:
  static constexpr std::uint32_t kNoVertex = std::numeric_limits<std::uint32_t>::max();
  static constexpr int kCorners = kBlockSide + 1;  // a side

  static Vector3i corner(const Vector3i& cube, int i) {
    return cube + Vector3i(i & 1, i >> 1 & 1, i >> 2 & 1);
  }

  void add_cube(const Vector3i& cube) {
    unsigned inside = 0;
    for (int i = 0; i < kCubeCorners; ++i) {
      const float distance_m = around_.at(corner(cube, i));
      if (std::isnan(distance_m)) return;
      if (distance_m < 0) inside |= 1U << i;
    }
    for (const auto& triangle : cube_triangles()[inside]) {
      std::array<std::uint32_t, 3> corners{};
      for (std::size_t i = 0; i < 3; ++i) corners[i] = vertex(cube, cube_edges()[triangle[i]]);
      result_.mesh.triangles.push_back(corners);
    }
  }

  std::uint32_t vertex(const Vector3i& cube, const CubeEdge& edge) {
    const Vector3i from = corner(cube, edge.from), to = corner(cube, edge.to);
    const int place = (from.z() * kCorners + from.y()) * kCorners + from.x();
    std::uint32_t& known = vertex_at_[static_cast<std::size_t>(3 * place + edge.axis)];
    if (known != kNoVertex) return known;
    known = static_cast<std::uint32_t>(result_.mesh.vertices.size());

    const float a = around_.at(from), b = around_.at(to);
    const float share = a / (a - b);  // of the way from `from` to `to`; their signs differ
    const Vector3f voxel =
        (kBlockSide * block_ + from).cast<float>() + share * (to - from).cast<float>();
    result_.mesh.vertices.emplace_back(static_cast<float>(field_.voxel_size_m()) * voxel);
    const Vector3f normal = (1 - share) * gradient(around_, from) + share * gradient(around_, to);
    result_.mesh.normals.push_back(
        normal.norm() > 0 ? Vector3f(normal.normalized())
                          : Vector3f((a < b ? 1.0F : -1.0F) * (to - from).cast<float>()));
    const auto [color_a, has_a] = color_at(around_, from);
    const auto [color_b, has_b] = color_at(around_, to);
    const float share_b = !has_a ? 1.0F : !has_b ? 0.0F : share;
    result_.mesh.colors.push_back(rounded((1 - share_b) * color_a + share_b * color_b));

    const Vector3i block_offset = from.unaryExpr([](int v) { return v >> 3; });
    result_.keys.push_back(
        {TsdfVolume::key_of(block_ + block_offset),
         static_cast<std::uint32_t>(3 * voxel_slot(from)) + static_cast<std::uint32_t>(edge.axis)});
    return known;
  }

  const TsdfVolume& field_;
  std::uint32_t min_weight_;
  Vector3i block_ = Vector3i::Zero();
  Neighbourhood around_;
  std::array<std::uint32_t, static_cast<std::size_t>(3 * kCorners * kCorners * kCorners)>
      vertex_at_{};
  BlockMesh result_;
};

// Joins the blocks' surfaces: a vertex that two of them have becomes one. Blocks come in the order
// of their keys, layer by layer.
class MeshJoiner {
 public:
  explicit MeshJoiner(const WorkingSet& working_set)
      : working_set_(working_set), pieces_(working_set) {}

  void add(const Vector3i& place, const BlockMesh& block) {
    // A vertex belongs to its block or to one behind: those of lower layers are not met again.
    vertices_of_.erase(vertices_of_.begin(), vertices_of_.lower_bound(place.z()));
    const std::vector<std::uint32_t> components = join_components(block);
    std::vector<std::uint32_t> joined;
    joined.reserve(block.keys.size());
    for (std::size_t i = 0; i < block.keys.size(); ++i) {
      const Vertex next{piece_.first + static_cast<std::uint32_t>(piece_.mesh.vertices.size()),
                        components[i]};
      const auto [found, is_new] = layer_of(block.keys[i]).try_emplace(block.keys[i], next);
      const std::uint32_t number = found->second.number;
      if (is_new) append(block.mesh, i, components[i], piece_.mesh, piece_.components);
      joined.push_back(number >= piece_.first ? number - piece_.first
                                              : borrow(number, block.mesh, i, components[i]));
    }
    for (const auto& [a, b, c] : block.mesh.triangles)
      piece_.mesh.triangles.push_back({joined[a], joined[b], joined[c]});
  }

  // What was added since becomes a piece.
  [[nodiscard]] Expected<void> end_piece() {
    piece_.own = piece_.mesh.vertices.size();
    const auto own = static_cast<std::uint32_t>(piece_.own);
    for (auto& triangle : piece_.mesh.triangles) {
      for (std::uint32_t& corner : triangle) {
        if ((corner & kBorrowed) != 0) corner = own + (corner & ~kBorrowed);
      }
    }
    for (std::size_t i = 0; i < borrowed_.vertices.size(); ++i)
      append(borrowed_, i, borrowed_components_[i], piece_.mesh, piece_.components);
    MeshPiece next;
    next.first = piece_.first + own;
    ROOMWISE_RETURN_IF_ERROR(pieces_.add(std::exchange(piece_, std::move(next))));
    borrowed_ = {};
    borrowed_components_.clear();
    borrowed_at_.clear();
    return {};
  }

  // Without what hangs together and has less area.
  [[nodiscard]] Expected<PiecewiseMesh> finish(double min_component_m2) {
    vertices_of_.clear();
    std::vector<double> area_m2(areas_m2_.size(), 0.0);
    for (std::size_t i = 0; i < areas_m2_.size(); ++i) area_m2[components_.find(i)] += areas_m2_[i];
    std::vector<bool> stays(areas_m2_.size());
    for (std::size_t i = 0; i < areas_m2_.size(); ++i)
      stays[i] = area_m2[components_.find(i)] >= min_component_m2;

    MeshPieces kept(working_set_);
    std::vector<std::uint32_t> gone;  // numbers of vertices, rising
    std::size_t vertices = 0, triangles = 0;
    MeshPiece room;
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      ROOMWISE_TRY(const MeshPiece* const piece, pieces_.get(i, room));
      MeshPiece rest = without(*piece, stays, gone);
      vertices += rest.own;
      triangles += rest.mesh.triangles.size();
      pieces_.drop(i);
      ROOMWISE_RETURN_IF_ERROR(kept.add(std::move(rest)));
    }
    return PiecewiseMesh(std::move(kept), vertices, triangles);
  }

 private:
  static constexpr std::uint32_t kBorrowed = 1U << 31U;  // a mark of corners while a piece grows
  struct Vertex {
    std::uint32_t number = 0, component = 0;
  };
  using Layer = std::unordered_map<EdgeKey, Vertex, EdgeKeyHash>;

  Layer& layer_of(const EdgeKey& key) { return vertices_of_[TsdfVolume::block_of(key.block).z()]; }

  static void append(const TriangleMesh& from, std::size_t vertex, std::uint32_t component,
                     TriangleMesh& mesh, std::vector<std::uint32_t>& components) {
    mesh.vertices.push_back(from.vertices[vertex]);
    mesh.normals.push_back(from.normals[vertex]);
    mesh.colors.push_back(from.colors[vertex]);
    components.push_back(component);
  }

  // A vertex of an earlier piece, which is the same to the bit in each block that has it.
  std::uint32_t borrow(std::uint32_t number, const TriangleMesh& mesh, std::size_t vertex,
                       std::uint32_t component) {
    const auto next = static_cast<std::uint32_t>(borrowed_.vertices.size());
    const auto [found, is_new] = borrowed_at_.try_emplace(number, next);
    if (is_new) {
      append(mesh, vertex, component, borrowed_, borrowed_components_);
      piece_.borrowed.push_back(number);
    }
    return found->second | kBorrowed;
  }

  // What hangs together in a block hangs together with what has the same vertices. By vertex.
  std::vector<std::uint32_t> join_components(const BlockMesh& block) {
    constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> of_lowest(block.keys.size(), kNone), components;
    for (std::size_t i = 0; i < block.keys.size(); ++i) {
      std::uint32_t& component = of_lowest[block.components[i]];
      const Layer& layer = layer_of(block.keys[i]);
      const auto known = layer.find(block.keys[i]);
      if (known == layer.end()) continue;
      if (component == kNone) {
        component = known->second.component;
      } else {
        components_.join(component, known->second.component);
      }
    }
    for (std::size_t i = 0; i < block.keys.size(); ++i) {
      std::uint32_t& component = of_lowest[block.components[i]];
      if (component == kNone) {
        component = static_cast<std::uint32_t>(components_.add());
        areas_m2_.push_back(0);
      }
      if (block.components[i] == i) areas_m2_[component] += block.areas_m2[i];
      components.push_back(component);
    }
    return components;
  }

  static MeshPiece without(const MeshPiece& piece, const std::vector<bool>& stays,
                           std::vector<std::uint32_t>& gone) {
    MeshPiece rest;
    rest.first = piece.first - static_cast<std::uint32_t>(gone.size());
    std::vector<std::uint32_t> place(piece.mesh.vertices.size());
    std::vector<std::uint32_t> unused;
    for (std::size_t i = 0; i < piece.mesh.vertices.size(); ++i) {
      place[i] = static_cast<std::uint32_t>(rest.mesh.vertices.size());
      if (stays[piece.components[i]]) {
        append(piece.mesh, i, 0, rest.mesh, unused);
        if (i < piece.own) continue;
        const auto before = std::ranges::lower_bound(gone, piece.number_of(i)) - gone.begin();
        rest.borrowed.push_back(piece.number_of(i) - static_cast<std::uint32_t>(before));
      } else if (i < piece.own) {
        gone.push_back(piece.number_of(i));
      }
    }
    rest.own = rest.mesh.vertices.size() - rest.borrowed.size();
    for (const auto& [a, b, c] : piece.mesh.triangles) {
      if (stays[piece.components[a]]) rest.mesh.triangles.push_back({place[a], place[b], place[c]});
    }
    return rest;
  }

  WorkingSet working_set_;
  MeshPieces pieces_;
  MeshPiece piece_;  // that grows; `borrowed_` will follow its own vertices
  TriangleMesh borrowed_;
  std::vector<std::uint32_t> borrowed_components_;
  std::unordered_map<std::uint32_t, std::uint32_t> borrowed_at_;  // by number
  std::map<int, Layer> vertices_of_;                              // by layer
  DisjointSets components_{0};
  std::vector<double> areas_m2_;  // by component, before they are joined
};

}  // namespace

Expected<void> MeshOptions::validate() const {
  if (min_weight < 1) return fail("min_weight is {}; expected 1 or more", min_weight);
  if (!(min_component_m2 >= 0)) {
    return fail("min_component_m2 is {}; expected 0 or more", min_component_m2);
  }
  return {};
}

Expected<PiecewiseMesh> extract_mesh(TsdfVolume& field, const MeshOptions& options,
                                     ThreadPool& pool) {
  const std::vector<Vector3i> blocks = field.blocks();
  MeshJoiner joiner(field.working_set());
  // Blocks' surfaces wait to be joined in the order of the blocks, not all at once.
  constexpr std::size_t kBlocksATask = 128;
  constexpr std::size_t kMostTasks = 8;  // at once: all their blocks are in memory
  const std::size_t blocks_a_round =
      kBlocksATask * 4 * std::min<std::size_t>(pool.size(), kMostTasks);
  for (std::size_t first = 0; first < blocks.size(); first += blocks_a_round) {
    const std::size_t count = std::min(blocks_a_round, blocks.size() - first);
    ROOMWISE_RETURN_IF_ERROR(field.bring_around(std::span(blocks).subspan(first, count)));
    std::vector<BlockMesh> meshes(count);
    pool.parallel_for((count + kBlocksATask - 1) / kBlocksATask, [&](std::size_t task) {
      BlockMesher mesher(field, options.min_weight);
      const std::size_t end = std::min(count, (task + 1) * kBlocksATask);
      for (std::size_t i = task * kBlocksATask; i < end; ++i) {
        meshes[i] = mesher.mesh(blocks[first + i]);
      }
    });
    for (std::size_t i = 0; i < count; ++i) joiner.add(blocks[first + i], meshes[i]);
    ROOMWISE_RETURN_IF_ERROR(joiner.end_piece());
  }
  return joiner.finish(options.min_component_m2);
}

}  // namespace roomwise::fusion
