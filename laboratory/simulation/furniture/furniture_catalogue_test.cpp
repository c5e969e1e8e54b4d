#include "laboratory/simulation/furniture/furniture_catalogue.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <set>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/base/thread_pool.h"

namespace roomwise::simulation {
namespace {

const FurnitureCatalogue& catalogue() {
  static const auto opened = FurnitureCatalogue::open();
  if (!opened) throw std::runtime_error(opened.error().message);
  return *opened;
}

// What is wrong with a loaded model; empty where nothing is.
std::string flaw_of(const FurnitureModel& model, const TriangleMesh& mesh) {
  constexpr float kTolerance_m = 1e-4F;
  if (mesh.triangles.empty()) return "no triangles";
  if (mesh.normals.size() != mesh.positions.size() ||
      mesh.texture_coordinates.size() != mesh.positions.size()) {
    return "positions, normals and texture coordinates differ in number";
  }
  Eigen::AlignedBox3f box;
  for (const auto& position : mesh.positions) box.extend(position);
  const Eigen::Vector3f size = model.size_m.cast<float>();
  const Eigen::Vector3f lowest(-size.x() / 2, -size.y() / 2, 0);
  if (!box.min().allFinite() || !box.max().allFinite() ||
      (box.min() - lowest).minCoeff() < -kTolerance_m ||
      (box.max() - lowest - size).maxCoeff() > kTolerance_m) {
    return "outside its size";
  }
  if (std::abs(box.min().z()) > kTolerance_m) return "does not stand on the ground";
  for (const auto& normal : mesh.normals) {
    if (!(std::abs(normal.norm() - 1) < 1e-3F)) return "a normal is not of unit length";
  }
  for (const auto& coordinate : mesh.texture_coordinates) {
    if (!coordinate.allFinite()) return "a texture coordinate is not finite";
  }
  for (const auto& triangle : mesh.triangles) {
    if (triangle.material >= mesh.materials.size()) return "an unknown material";
    for (const auto corner : triangle.corners) {
      if (corner >= mesh.positions.size()) return "an index out of range";
    }
  }
  for (const auto& material : mesh.materials) {
    if (!(material.diffuse.minCoeff() >= 0 && material.diffuse.maxCoeff() <= 0.9001F)) {
      return "a surface that gives off light";
    }
  }
  return {};
}

// Tests run the loader on many threads: it has to be thread-safe.
TEST(FurnitureCatalogue, EveryModelLoadsAndFitsItsSize) {
  const auto models = catalogue().models();
  std::vector<std::string> flaws(models.size());
  ThreadPool pool(4);
  pool.parallel_for(models.size(), [&](std::size_t i) {
    const auto mesh = catalogue().load(models[i].id);
    flaws[i] = mesh ? flaw_of(models[i], *mesh) : mesh.error().message;
  });
  for (std::size_t i = 0; i < models.size(); ++i) {
    EXPECT_EQ(flaws[i], "") << models[i].id;
  }
}

TEST(FurnitureCatalogue, HasModelsOfEveryKindThatHomesNeed) {
  const auto count = [](std::string_view kind) { return catalogue().of_kind(kind).size(); };
  for (const char* kind : {"bed",
                           "lamp",
                           "wardrobe",
                           "stove",
                           "toilet",
                           "chair",
                           "sofa",
                           "armchair",
                           "coffee_table",
                           "dining_table",
                           "desk",
                           "office_chair",
                           "bookcase",
                           "tv",
                           "kitchen_cabinet",
                           "kitchen_wall_cabinet",
                           "washbasin",
                           "bathtub",
                           "plant",
                           "small_plant",
                           "cup",
                           "shoes",
                           "toy",
                           "bin",
                           "vase",
                           "bottle",
                           "washing_machine"}) {
    EXPECT_GE(count(kind), 3U) << kind;
  }
  for (const char* kind : {"microwave", "nightstand", "chest_of_drawers", "tv_stand", "sink", "rug",
                           "laptop", "computer", "book", "bowl", "fruit"}) {
    EXPECT_GE(count(kind), 2U) << kind;
  }
  for (const char* kind : {"fridge", "floor_lamp", "ceiling_lamp", "shower", "teapot", "toaster",
                           "kettle", "coat_rack", "curtain", "radiator", "shelf", "clock"}) {
    EXPECT_GE(count(kind), 1U) << kind;
  }
  EXPECT_TRUE(catalogue().of_kind("mirror").empty());
}

TEST(FurnitureCatalogue, SizesAreThoseOfAHome) {
  std::set<std::string> ids;
  for (const FurnitureModel& model : catalogue().models()) {
    EXPECT_TRUE(ids.insert(model.id).second) << model.id << " is listed twice";
    EXPECT_GT(model.size_m.minCoeff(), 0) << model.id;
    EXPECT_LT(model.size_m.head<2>().maxCoeff(), 3.5) << model.id;
    EXPECT_LE(model.elevation_m + model.size_m.z(), 2.55) << model.id;
    EXPECT_LE(model.top_m, model.size_m.z() + 1e-9) << model.id;
  }
  const auto expect_height = [](const char* kind, double lowest_m, double highest_m) {
    for (const FurnitureModel* model : catalogue().of_kind(kind)) {
      EXPECT_GE(model->size_m.z(), lowest_m) << model->id;
      EXPECT_LE(model->size_m.z(), highest_m) << model->id;
    }
  };
  expect_height("chair", 0.7, 1.2);
  expect_height("dining_table", 0.7, 0.8);
  expect_height("kitchen_cabinet", 0.8, 0.95);
  expect_height("cup", 0.03, 0.15);
}

TEST(FurnitureCatalogue, ThingsArePutDownOnTables) {
  for (const char* kind : {"dining_table", "desk", "coffee_table", "nightstand"}) {
    for (const FurnitureModel* model : catalogue().of_kind(kind)) {
      EXPECT_GT(model->top_m, 0.3) << model->id;
    }
  }
  for (const FurnitureModel* lamp : catalogue().of_kind("lamp")) EXPECT_EQ(lamp->top_m, 0);
}

TEST(FurnitureCatalogue, FrontsLookAlongNegativeY) {
  // The backrest of a chair stands at its back, the headboard of a bed at the far end.
  for (const char* id : {"blendswap-cc-0/oakChair", "scopia/bed1", "blendswap-cc-by/couch3"}) {
    const auto mesh = catalogue().load(id);
    ASSERT_OK(mesh);
    const double height_m = catalogue().find(id)->size_m.z();
    double sum = 0;
    for (const auto& position : mesh->positions) {
      if (position.z() > 0.9 * height_m) sum += position.y();
    }
    EXPECT_GT(sum, 0) << id;
  }
}

TEST(FurnitureCatalogue, CreditsNameMakerAndLicenceOfEveryModel) {
  std::vector<std::string> ids;
  for (const FurnitureModel& model : catalogue().models()) ids.push_back(model.id);
  const auto credits = catalogue().credits(ids);
  ASSERT_OK(credits);
  for (const FurnitureModel& model : catalogue().models()) {
    EXPECT_FALSE(model.creator.empty()) << model.id;
    EXPECT_THAT(model.license, ::testing::AnyOf(::testing::HasSubstr("Public domain"),
                                                ::testing::HasSubstr("Attribution")));
    EXPECT_THAT(*credits, ::testing::HasSubstr(fmt::format("({}) by {}: {}\n", model.id,
                                                           model.creator, model.license)));
  }
  EXPECT_ERROR(catalogue().credits(std::vector<std::string>{"house/absent"}), "house/absent");
}

TEST(FurnitureCatalogue, NamesThePackageWhereTheFurnitureIsMissing) {
  EXPECT_ERROR(FurnitureCatalogue::open("/absent/folder"), "sweethome3d-furniture");
  EXPECT_ERROR(FurnitureCatalogue::open("/absent/folder"), "/absent/folder");

  const testing::ScratchFolder folder;
  ASSERT_OK(write_file(folder / "BlendSwap.sh3f", std::string_view("PK but no archive")));
  EXPECT_ERROR(FurnitureCatalogue::open(folder.path()), "BlendSwap.sh3f");
  EXPECT_ERROR(FurnitureCatalogue::open(folder.path()), "sweethome3d-furniture");
}

TEST(FurnitureCatalogue, NamesTheModelThatNoArchiveHolds) {
  const testing::ScratchFolder folder;
  std::filesystem::create_symlink("/usr/share/sweethome3d/furniture/KatorLegaz.sh3f",
                                  folder / "KatorLegaz.sh3f");
  EXPECT_ERROR(FurnitureCatalogue::open(folder.path()), "blendswap-cc-0/bed1");
  EXPECT_ERROR(catalogue().load("house/absent"), "house/absent");
  EXPECT_EQ(catalogue().find("house/absent"), nullptr);
}

}  // namespace
}  // namespace roomwise::simulation
