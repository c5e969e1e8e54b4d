#include "laboratory/simulation/furniture/mesh_loader.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>

#include "laboratory/simulation/testing/test_homes.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/image/codec.h"

namespace roomwise::simulation {
namespace {

// A model's folder in memory.
class Folder {
 public:
  Folder& add(const std::string& name, std::string_view text) {
    files_[name] = Bytes(text.begin(), text.end());
    return *this;
  }
  Folder& add_picture(const std::string& name, int width, int height, Rgb8 color) {
    files_[name] = image::encode_png(image::ColorImage(width, height, color));
    return *this;
  }
  [[nodiscard]] Expected<TriangleMesh> load(const MeshFit& fit = {}) const {
    ModelFolder folder;
    for (const auto& [name, bytes] : files_) folder.names.push_back(name);
    folder.read = [this](const std::string& name) -> Expected<Bytes> {
      const auto found = files_.find(name);
      if (found == files_.end()) return fail("{}: not there", name);
      return found->second;
    };
    return load_mesh(folder, "model.obj", fit);
  }

 private:
  std::map<std::string, Bytes> files_;
};

// Two faces of a box that meet at a right angle, without normals.
constexpr std::string_view kCorner =
    "v 0 0 0\nv 2 0 0\nv 2 4 0\nv 0 4 0\nv 0 0 6\nv 0 4 6\n"
    "f 1 2 3 4\nf 1 4 6 5\n";

constexpr std::string_view kTextured =
    "mtllib m.mtl\nusemtl cloth\n"
    "v 0 0 0\nv 1 0 0\nv 0 1 1\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";

TEST(MeshLoader, StretchesTheModelToItsSizeWithItsBottomAtTheOrigin) {
  const auto mesh = Folder().add("model.obj", kCorner).load({.size_m = {1, 2, 3}});
  ASSERT_OK(mesh);
  Eigen::AlignedBox3f box;
  for (const auto& position : mesh->positions) box.extend(position);
  EXPECT_TRUE(box.min().isApprox(Eigen::Vector3f(-0.5, -1, 0)));
  EXPECT_TRUE(box.max().isApprox(Eigen::Vector3f(0.5, 1, 3)));
}

TEST(MeshLoader, TurnsTheModelBeforeItIsStretched) {
  MeshFit fit;
  fit.object_from_model << 1, 0, 0, 0, 0, -1, 0, 1, 0;  // y up becomes z up
  fit.size_m = {1, 1, 5};
  const auto mesh = Folder().add("model.obj", kCorner).load(fit);
  ASSERT_OK(mesh);
  // The point (2, 4, 0) of the file: right, at the top, at the back.
  EXPECT_THAT(mesh->positions, ::testing::Contains(Eigen::Vector3f(0.5F, 0.5F, 5)));
}

TEST(MeshLoader, KeepsCreasesWhereTheFileHasNoNormals) {
  const auto mesh = Folder().add("model.obj", kCorner).load();
  ASSERT_OK(mesh);
  ASSERT_EQ(mesh->triangles.size(), 4U);
  for (const auto& normal : mesh->normals) {
    EXPECT_TRUE(normal.cwiseAbs().maxCoeff() > 0.999F) << normal.transpose();
  }
  EXPECT_EQ(mesh->positions.size(), 8U) << "the two corners of the crease are there twice";
}

TEST(MeshLoader, CoversConcaveFaces) {
  // A U of seven squares.
  const auto mesh = Folder()
                        .add("model.obj",
                             "v 0 0 0\nv 3 0 0\nv 3 3 0\nv 2 3 0\nv 2 1 0\nv 1 1 0\nv 1 3 0\n"
                             "v 0 3 0\nf 1 2 3 4 5 6 7 8\n")
                        .load({.size_m = {3, 3, 1}});
  ASSERT_OK(mesh);
  EXPECT_EQ(mesh->triangles.size(), 6U);
  EXPECT_NEAR(area_of(*mesh), 7, 1e-5);
}

TEST(MeshLoader, ReadsFacesOfVeryManyCorners) {
  constexpr int kCorners = 300;
  std::string points, face = "f";
  for (int i = 0; i < kCorners; ++i) {
    const double angle = i * 2 * 3.14159265358979 / kCorners;
    points += fmt::format("v {} {} 0\n", std::cos(angle), std::sin(angle));
    face += fmt::format(" {}", i + 1);
  }
  const auto mesh = Folder().add("model.obj", points + face + "\n").load({.size_m = {2, 2, 1}});
  ASSERT_OK(mesh);
  EXPECT_NEAR(area_of(*mesh), 3.14159, 0.01);
}

TEST(MeshLoader, SmoothsFacesThatNearlyContinueEachOther) {
  const auto mesh = Folder()
                        .add("model.obj",
                             "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0.2\nv 2 1 0.2\n"
                             "f 1 2 3 4\nf 2 5 6 3\n")
                        .load({.size_m = {2, 1, 0.2}});
  ASSERT_OK(mesh);
  EXPECT_EQ(mesh->positions.size(), 6U) << "corners with one normal are one vertex";
}

TEST(MeshLoader, TurnsFacesThatContradictTheirNormals) {
  const auto mesh =
      Folder().add("model.obj", "v 0 0 0\nv 1 0 0\nv 0 1 1\nvn 0 1 -1\nf 1//1 2//1 3//1\n").load();
  ASSERT_OK(mesh);
  const auto& corners = mesh->triangles.at(0).corners;
  const Eigen::Vector3f turned =
      (mesh->positions[corners[1]] - mesh->positions[corners[0]])
          .cross(mesh->positions[corners[2]] - mesh->positions[corners[0]]);
  EXPECT_GT(turned.dot(mesh->normals[corners[0]]), 0);
  EXPECT_GT(mesh->normals[corners[0]].y(), 0.7F) << "the file's normal is kept";
}

TEST(MeshLoader, ReplacesNormalsThatMakeNoSense) {
  const auto mesh =
      Folder()
          .add("model.obj", "v 0 0 0\nv 1 0 0\nv 0 1 1\nvn 0 0 0\nvn nan 0 1\nf 1//1 2//2 3//9\n")
          .load();
  ASSERT_OK(mesh);
  for (const auto& normal : mesh->normals) EXPECT_NEAR(normal.norm(), 1, 1e-5);
}

TEST(MeshLoader, TakesColoursAsLinearLight) {
  const auto mesh = Folder()
                        .add("model.obj", kTextured)
                        .add("m.mtl",
                             "newmtl cloth\nKd 0.5 0.5 0\nKs 0.5 0.5 0.5\nNs 50\n"
                             "d 0.25\nillum 2\n")
                        .load();
  ASSERT_OK(mesh);
  const SurfaceMaterial& cloth = mesh->materials.at(mesh->triangles.at(0).material);
  EXPECT_NEAR(cloth.diffuse.x(), 0.214, 0.001);
  EXPECT_FLOAT_EQ(cloth.opacity, 0.25F);
  EXPECT_LT(cloth.specular, 0.05F) << "the default highlight is not metal";
  EXPECT_FLOAT_EQ(cloth.shininess, 50);
  EXPECT_EQ(cloth.texture, nullptr);
}

TEST(MeshLoader, FindsTexturesByTheirFileNameAlone) {
  const auto mesh = Folder()
                        .add("model.obj", kTextured)
                        .add("m.mtl", "newmtl cloth\nKd 0.8 0.8 0.8\nmap_Kd C:\\me\\Red.PNG\n")
                        .add_picture("other.png", 2, 2, {0, 255, 0})
                        .add_picture("red.png", 4, 2, {255, 0, 0})
                        .load();
  ASSERT_OK(mesh);
  const SurfaceMaterial& cloth = mesh->materials.at(mesh->triangles.at(0).material);
  ASSERT_NE(cloth.texture, nullptr);
  EXPECT_EQ(cloth.texture->at(0, 0), (Rgb8{255, 0, 0}));
  EXPECT_NEAR(cloth.diffuse.x(), 0.9, 0.001) << "the texture alone is the colour";
  EXPECT_EQ(mesh->texture_coordinates[mesh->triangles[0].corners[1]], Eigen::Vector2f(1, 0));
}

TEST(MeshLoader, TakesTheOnlyPictureOrTheColourWhereATextureIsAbsent) {
  const std::string_view mtl = "newmtl cloth\nKd 0 0 1\nmap_Kd absent.jpg\n";
  auto one = Folder();
  one.add("model.obj", kTextured).add("m.mtl", mtl).add_picture("a.png", 2, 2, {255, 0, 0});
  auto mesh = one.load();
  ASSERT_OK(mesh);
  EXPECT_NE(mesh->materials.at(0).texture, nullptr);

  mesh = one.add_picture("b.png", 2, 2, {255, 0, 0}).load();
  ASSERT_OK(mesh);
  EXPECT_EQ(mesh->materials.at(0).texture, nullptr);
  EXPECT_GT(mesh->materials.at(0).diffuse.z(), 0.8F);
}

TEST(MeshLoader, ShrinksLargeTextures) {
  const auto mesh = Folder()
                        .add("model.obj", kTextured)
                        .add("m.mtl", "newmtl cloth\nmap_Kd big.png\n")
                        .add_picture("big.png", 2048, 512, {10, 20, 30})
                        .load();
  ASSERT_OK(mesh);
  EXPECT_EQ(mesh->materials.at(0).texture->width(), 1024);
  EXPECT_EQ(mesh->materials.at(0).texture->height(), 256);
}

TEST(MeshLoader, TellsWhatIsWrongWithAModel) {
  EXPECT_ERROR(Folder().load(), "model.obj");
  EXPECT_ERROR(Folder().add("model.obj", "v 0 0 0\n").load(), "model.obj: the model has no faces");
  EXPECT_ERROR(Folder()
                   .add("model.obj", kTextured)
                   .add("m.mtl", "newmtl cloth\nmap_Kd bad.png\n")
                   .add("bad.png", "not a picture")
                   .load(),
               "bad.png");
}

}  // namespace
}  // namespace roomwise::simulation
