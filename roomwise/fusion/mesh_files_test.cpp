#include "roomwise/fusion/mesh_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::fusion {
namespace {

using nlohmann::json;
using roomwise::testing::ScratchFolder;
using ::testing::HasSubstr;

// Two triangles, one of them standing up.
TriangleMesh small_mesh() {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}};
  mesh.normals = {{0, 0, 1}, {0, 0, 1}, {0, 1, 0}, {1, 0, 0}};
  mesh.colors = {{255, 0, 128}, {0, 255, 0}, {10, 20, 30}, {1, 2, 3}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

template <typename Number>
Number number_at(const std::string& bytes, std::size_t place) {
  Number number;
  std::memcpy(&number, bytes.data() + place, sizeof(number));
  return number;
}

TEST(MeshPly, HoldsVerticesAndTriangles) {
  const ScratchFolder folder;
  ASSERT_OK(write_ply(folder / "a.ply", small_mesh()));
  const std::string content = read_text_file(folder / "a.ply").value();
  const std::string end = "end_header\n";
  const std::size_t body = content.find(end) + end.size();
  EXPECT_THAT(content.substr(0, body), HasSubstr("element vertex 4\n"));
  EXPECT_THAT(content.substr(0, body),
              HasSubstr("element face 2\nproperty list uchar int vertex_indices\n"));
  ASSERT_EQ(content.size(), body + 4 * 27 + 2 * 13);
  EXPECT_EQ(number_at<float>(content, body + 3 * 27 + 8), 3.0F);
  EXPECT_EQ(number_at<float>(content, body + 3 * 27 + 12), 1.0F);
  EXPECT_EQ(content.substr(body + 24, 3), std::string("\xff\x00\x80", 3));
  const std::size_t faces = body + 4 * 27;
  EXPECT_EQ(content[faces + 13], 3);
  EXPECT_EQ(number_at<std::int32_t>(content, faces + 13 + 9), 3);
  EXPECT_ERROR(write_ply(folder / "missing" / "a.ply", small_mesh()), "a.ply");
}

// The parts of a .glb file, checked as they are taken apart.
struct Glb {
  json description;
  std::string binary;
};
Glb parse_glb(const std::string& file) {
  EXPECT_EQ(file.substr(0, 4), "glTF");
  EXPECT_EQ(number_at<std::uint32_t>(file, 4), 2U);
  EXPECT_EQ(number_at<std::uint32_t>(file, 8), file.size());
  const std::size_t json_size = number_at<std::uint32_t>(file, 12);
  EXPECT_EQ(json_size % 4, 0U);
  EXPECT_EQ(file.substr(16, 4), "JSON");
  const std::size_t second = 20 + json_size;
  const std::size_t binary_size = number_at<std::uint32_t>(file, second);
  EXPECT_EQ(binary_size % 4, 0U);
  EXPECT_EQ(file.substr(second + 4, 4), std::string("BIN\0", 4));
  EXPECT_EQ(second + 8 + binary_size, file.size());
  return {json::parse(file.substr(20, json_size)), file.substr(second + 8)};
}

class GlbTest : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_OK(write_glb(folder_ / "a.glb", small_mesh()));
    glb_ = parse_glb(read_text_file(folder_ / "a.glb").value());
    primitive_ = glb_.description.at("meshes").at(0).at("primitives").at(0);
  }
  static std::size_t index(const json& number) { return number.get<std::size_t>(); }
  const json& view_of(const json& accessor) const {
    return glb_.description.at("bufferViews").at(index(accessor.at("bufferView")));
  }
  json accessor(const std::string& attribute) const {
    return glb_.description.at("accessors").at(index(primitive_.at("attributes").at(attribute)));
  }
  std::size_t offset(const json& accessor) const {
    return index(view_of(accessor).at("byteOffset"));
  }

  ScratchFolder folder_;
  Glb glb_;
  json primitive_;
};

TEST_F(GlbTest, ItsViewsFillTheBufferAndAreAligned) {
  EXPECT_EQ(glb_.description.at("asset").at("version"), "2.0");
  ASSERT_EQ(glb_.description.at("buffers").size(), 1U);
  EXPECT_EQ(glb_.description.at("buffers").at(0).at("byteLength"), glb_.binary.size());
  std::size_t place = 0;
  for (const json& view : glb_.description.at("bufferViews")) {
    EXPECT_EQ(view.at("byteOffset"), place);
    EXPECT_EQ(place % 4, 0U);
    place += index(view.at("byteLength"));
  }
  EXPECT_EQ(place, glb_.binary.size());
  const std::map<std::string, std::size_t> components{{"SCALAR", 1}, {"VEC3", 3}, {"VEC4", 4}};
  const std::map<int, std::size_t> bytes{{5123, 2}, {5125, 4}, {5126, 4}};
  for (const json& accessor : glb_.description.at("accessors")) {
    EXPECT_EQ(index(view_of(accessor).at("byteLength")),
              accessor.at("count").get<std::size_t>() * components.at(accessor.at("type")) *
                  bytes.at(accessor.at("componentType")));
  }
}

TEST_F(GlbTest, HasYUpAndSaysItsBounds) {
  const json positions = accessor("POSITION");
  EXPECT_EQ(positions.at("count"), 4);
  EXPECT_EQ(positions.at("min"), json({0.0, 0.0, -2.0}));
  EXPECT_EQ(positions.at("max"), json({1.0, 3.0, 0.0}));
  const std::size_t standing = offset(positions) + 3 * 12;
  EXPECT_EQ(number_at<float>(glb_.binary, standing + 4), 3.0F) << "what was z";
  const std::size_t up = offset(accessor("NORMAL"));
  EXPECT_EQ(number_at<float>(glb_.binary, up + 4), 1.0F);
}

TEST_F(GlbTest, HasLinearColorsAndTheTriangles) {
  const json colors = accessor("COLOR_0");
  EXPECT_EQ(colors.at("normalized"), true);
  const std::size_t first = offset(colors);
  EXPECT_EQ(number_at<std::uint16_t>(glb_.binary, first), 65535);
  EXPECT_EQ(number_at<std::uint16_t>(glb_.binary, first + 2), 0);
  // sRGB 128 is 21.586 % of the light.
  EXPECT_NEAR(number_at<std::uint16_t>(glb_.binary, first + 4), 0.21586 * 65535, 1.0);
  EXPECT_EQ(number_at<std::uint16_t>(glb_.binary, first + 6), 65535);
  const json indices = glb_.description.at("accessors").at(index(primitive_.at("indices")));
  EXPECT_EQ(indices.at("count"), 6);
  for (const auto& [place, index] : {std::pair(2, 2U), {4, 2U}, {5, 3U}}) {
    EXPECT_EQ(number_at<std::uint32_t>(glb_.binary,
                                       offset(indices) + 4 * static_cast<std::size_t>(place)),
              index);
  }
}

TEST(Glb, CannotHoldAnEmptyMesh) {
  const ScratchFolder folder;
  EXPECT_ERROR(write_glb(folder / "a.glb", {}), "no surface");
  EXPECT_FALSE(std::filesystem::exists(folder / "a.glb"));
  EXPECT_ERROR(write_glb(folder / "missing" / "a.glb", small_mesh()), "a.glb");
}

}  // namespace
}  // namespace roomwise::fusion
