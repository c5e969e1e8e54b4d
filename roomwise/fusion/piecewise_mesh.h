#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/base/scratch_file.h"
#include "roomwise/fusion/triangle_mesh.h"
#include "roomwise/geometry/rigid_transform.h"

namespace roomwise::fusion {

// A part of a surface: vertices of its own, then those of earlier pieces that its triangles use.
// Triangles count the piece's vertices.
struct MeshPiece {
  TriangleMesh mesh;
  std::size_t own = 0;                    // vertices: the first ones
  std::uint32_t first = 0;                // number of the first of them in the whole surface
  std::vector<std::uint32_t> borrowed;    // numbers of the other vertices
  std::vector<std::uint32_t> components;  // of the vertices, while the surface is extracted

  [[nodiscard]] std::span<const Eigen::Vector3f> own_vertices() const {
    return std::span(mesh.vertices).first(own);
  }
  // Of a vertex in the whole surface.
  [[nodiscard]] std::uint32_t number_of(std::size_t vertex) const {
    return vertex < own ? first + static_cast<std::uint32_t>(vertex) : borrowed[vertex - own];
  }
};

// Pieces in their order: the first ones in memory, those beyond the working set in a scratch file.
class MeshPieces {
 public:
  explicit MeshPieces(WorkingSet working_set = {}) : working_set_(std::move(working_set)) {}

  [[nodiscard]] Expected<void> add(MeshPiece piece);
  [[nodiscard]] std::size_t size() const { return entries_.size(); }
  // The piece, or, where it lies in the file, a copy of it in `room`.
  [[nodiscard]] Expected<const MeshPiece*> get(std::size_t index, MeshPiece& room) const;
  // Gives the memory of a piece back that is not needed any more.
  void drop(std::size_t index);

 private:
  struct Entry {
    MeshPiece piece;
    std::uint64_t offset = 0;
    std::size_t disk_bytes = 0;  // 0: in memory
  };
  WorkingSet working_set_;
  std::vector<Entry> entries_;
  std::size_t bytes_ = 0;  // in memory
  std::optional<ScratchFile> scratch_;
};

// A surface, which may be too large for memory. Own vertices and triangles of one piece after the
// other are those of the whole, in their order; where it was cut says nothing. What is read fails
// where the scratch file cannot be read.
class PiecewiseMesh {
 public:
  PiecewiseMesh() = default;
  PiecewiseMesh(TriangleMesh mesh);  // NOLINT(google-explicit-constructor): a mesh is one
  PiecewiseMesh(MeshPieces pieces, std::size_t vertices, std::size_t triangles);

  [[nodiscard]] std::size_t vertex_count() const { return vertices_; }
  [[nodiscard]] std::size_t triangle_count() const { return triangles_; }
  [[nodiscard]] Expected<void> for_each(const std::function<void(const MeshPiece&)>& visit) const;
  // All of it in memory.
  [[nodiscard]] Expected<TriangleMesh> whole() const;

  // In another frame. What it shows is shared, not copied.
  [[nodiscard]] PiecewiseMesh moved(const geometry::RigidTransform& to_from_mesh) const;

 private:
  std::shared_ptr<const MeshPieces> pieces_;
  std::vector<geometry::RigidTransform> moves_;  // one after the other
  std::size_t vertices_ = 0, triangles_ = 0;
};

// The mesh in another frame.
[[nodiscard]] inline PiecewiseMesh transformed(const geometry::RigidTransform& to_from_mesh,
                                               const PiecewiseMesh& mesh) {
  return mesh.moved(to_from_mesh);
}

}  // namespace roomwise::fusion
