#include "roomwise/fusion/piecewise_mesh.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace roomwise::fusion {
namespace {

// Visits the arrays of a piece, in one order.
template <typename Piece, typename Visit>
void visit_arrays(Piece& piece, const Visit& visit) {
  visit(piece.mesh.vertices);
  visit(piece.mesh.normals);
  visit(piece.mesh.colors);
  visit(piece.mesh.triangles);
  visit(piece.borrowed);
  visit(piece.components);
}

std::size_t bytes_in(const MeshPiece& piece) {
  std::size_t bytes = 0;
  visit_arrays(piece, [&](const auto& array) { bytes += array.size() * sizeof(array[0]); });
  return bytes;
}

Bytes to_bytes(const MeshPiece& piece) {
  Bytes bytes;
  bytes.reserve(bytes_in(piece) + 8 * sizeof(std::size_t));
  const auto put = [&](const void* data, std::size_t size) {
    const auto* begin = static_cast<const std::uint8_t*>(data);
    bytes.insert(bytes.end(), begin, begin + size);
  };
  const std::size_t first = piece.first;
  put(&piece.own, sizeof(piece.own));
  put(&first, sizeof(first));
  visit_arrays(piece, [&](const auto& array) {
    const std::size_t size = array.size() * sizeof(array[0]);
    put(&size, sizeof(size));
    put(array.data(), size);
  });
  return bytes;
}

// Of bytes that to_bytes() gave.
void from_bytes(const Bytes& bytes, MeshPiece& piece) {
  std::size_t place = 0;
  const auto take = [&](void* data, std::size_t size) {
    if (size > 0) std::memcpy(data, bytes.data() + place, size);
    place += size;
  };
  std::size_t first = 0;
  take(&piece.own, sizeof(piece.own));
  take(&first, sizeof(first));
  piece.first = static_cast<std::uint32_t>(first);
  visit_arrays(piece, [&](auto& array) {
    std::size_t size = 0;
    take(&size, sizeof(size));
    array.resize(size / sizeof(array[0]));
    take(array.data(), size);
  });
}

void move(TriangleMesh& mesh, const geometry::RigidTransform& to_from_mesh) {
  for (Eigen::Vector3f& vertex : mesh.vertices)
    vertex = (to_from_mesh * Eigen::Vector3d(vertex.cast<double>())).cast<float>();
  for (Eigen::Vector3f& normal : mesh.normals)
    normal = (to_from_mesh.rotation * normal.cast<double>()).cast<float>();
}

}  // namespace

Expected<void> MeshPieces::add(MeshPiece piece) {
  const std::size_t bytes = bytes_in(piece);
  if (working_set_.scratch_folder.empty() || bytes_ + bytes <= working_set_.max_bytes) {
    bytes_ += bytes;
    entries_.push_back({std::move(piece)});
    return {};
  }
  if (!scratch_) {
    ROOMWISE_TRY(ScratchFile scratch, ScratchFile::create(working_set_.scratch_folder));
    scratch_.emplace(std::move(scratch));
  }
  const Bytes written = to_bytes(piece);
  ROOMWISE_TRY(const std::uint64_t offset, scratch_->append(written));
  entries_.push_back({{}, offset, written.size()});
  return {};
}

Expected<const MeshPiece*> MeshPieces::get(std::size_t index, MeshPiece& room) const {
  const Entry& entry = entries_[index];
  if (entry.disk_bytes == 0) return &entry.piece;
  ROOMWISE_TRY(const Bytes bytes, scratch_->read(entry.offset, entry.disk_bytes));
  from_bytes(bytes, room);
  return &room;
}

void MeshPieces::drop(std::size_t index) {
  bytes_ -= bytes_in(entries_[index].piece);
  entries_[index].piece = {};
}

PiecewiseMesh::PiecewiseMesh(TriangleMesh mesh)
    : vertices_(mesh.vertices.size()), triangles_(mesh.triangles.size()) {
  MeshPiece piece;
  piece.own = vertices_;
  piece.mesh = std::move(mesh);
  MeshPieces pieces;
  // In memory nothing can fail.
  (void)pieces.add(std::move(piece));
  pieces_ = std::make_shared<const MeshPieces>(std::move(pieces));
}

PiecewiseMesh::PiecewiseMesh(MeshPieces pieces, std::size_t vertices, std::size_t triangles)
    : pieces_(std::make_shared<const MeshPieces>(std::move(pieces))),
      vertices_(vertices),
      triangles_(triangles) {}

Expected<void> PiecewiseMesh::for_each(const std::function<void(const MeshPiece&)>& visit) const {
  MeshPiece room;
  for (std::size_t i = 0; pieces_ != nullptr && i < pieces_->size(); ++i) {
    ROOMWISE_TRY(const MeshPiece* piece, pieces_->get(i, room));
    if (!moves_.empty()) {
      if (piece != &room) room = *piece;
      for (const geometry::RigidTransform& to_from : moves_) move(room.mesh, to_from);
      piece = &room;
    }
    visit(*piece);
  }
  return {};
}

Expected<TriangleMesh> PiecewiseMesh::whole() const {
  TriangleMesh mesh;
  mesh.vertices.reserve(vertices_);
  mesh.normals.reserve(vertices_);
  mesh.colors.reserve(vertices_);
  mesh.triangles.reserve(triangles_);
  ROOMWISE_RETURN_IF_ERROR(for_each([&](const MeshPiece& piece) {
    const auto add_own = [&](auto& all, const auto& some) {
      const auto end = static_cast<std::ptrdiff_t>(std::min(piece.own, some.size()));
      all.insert(all.end(), some.begin(), some.begin() + end);
    };
    add_own(mesh.vertices, piece.mesh.vertices);
    add_own(mesh.normals, piece.mesh.normals);
    add_own(mesh.colors, piece.mesh.colors);
    for (const auto& [a, b, c] : piece.mesh.triangles)
      mesh.triangles.push_back({piece.number_of(a), piece.number_of(b), piece.number_of(c)});
  }));
  return mesh;
}

PiecewiseMesh PiecewiseMesh::moved(const geometry::RigidTransform& to_from_mesh) const {
  PiecewiseMesh mesh = *this;
  mesh.moves_.push_back(to_from_mesh);
  return mesh;
}

}  // namespace roomwise::fusion
