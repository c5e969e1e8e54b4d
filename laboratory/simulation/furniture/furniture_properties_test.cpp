#include "laboratory/simulation/furniture/furniture_properties.h"

#include <gmock/gmock.h>

#include "roomwise/base/testing/testing.h"

namespace roomwise::simulation {
namespace {

constexpr std::string_view kProperties = R"(# PluginFurnitureCatalog.properties
id=House
license=Public domain

id#2=House#lamp
name#2=Lampe \u00e0 pied
model#2=/house/lamp/lamp.obj
width#2=30
depth#2=40.5
height#2=120
elevation#2=2
dropOnTopElevation#2=-1
modelRotation#2=0 0 1 0 1 0 -1 0 0
creator#2=A. Maker

name#3=Table
model#3=/house/table/table.obj
width#3=80
depth#3=60
height#3=70
creator#3=B. Maker
)";

TEST(FurnitureProperties, ReadsModelsInMetresWithTheirDefaults) {
  const auto models = parse_furniture_properties(kProperties);
  ASSERT_OK(models);
  ASSERT_EQ(models->size(), 2U);
  const FurnitureProperties& lamp = (*models)[0];
  EXPECT_EQ(lamp.id, "house/lamp");
  EXPECT_EQ(lamp.model_path, "house/lamp/lamp.obj");
  EXPECT_EQ(lamp.name, "Lampe à pied");
  EXPECT_EQ(lamp.creator, "A. Maker");
  EXPECT_EQ(lamp.license, "Public domain");
  EXPECT_TRUE(lamp.size_m.isApprox(Eigen::Vector3d(0.30, 0.405, 1.20)));
  EXPECT_DOUBLE_EQ(lamp.elevation_m, 0.02);
  EXPECT_EQ(lamp.top_m, 0);
  EXPECT_EQ(lamp.rotation * Eigen::Vector3d::UnitX(), -Eigen::Vector3d::UnitZ());

  const FurnitureProperties& table = (*models)[1];
  EXPECT_DOUBLE_EQ(table.top_m, 0.70);
  EXPECT_EQ(table.elevation_m, 0);
  EXPECT_EQ(table.rotation, Eigen::Matrix3d::Identity());
}

TEST(FurnitureProperties, NamesThePropertyThatIsWrong) {
  EXPECT_ERROR(parse_furniture_properties("name#7=Bed\nmodel#7=/a/b.obj\ncreator#7=C\n"),
               "width#7 is missing");
  std::string text(kProperties);
  text.replace(text.find("40.5"), 4, "wide");
  EXPECT_ERROR(parse_furniture_properties(text), "depth#2 is not a number");
  text = kProperties;
  text.replace(text.find("width#3=80"), 10, "width#3=-8");
  EXPECT_ERROR(parse_furniture_properties(text), "#3 is not positive");
  text = kProperties;
  text.replace(text.find("0 0 1 0"), 7, "0 0 1");
  EXPECT_ERROR(parse_furniture_properties(text), "modelRotation#2 is not nine numbers");
}

}  // namespace
}  // namespace roomwise::simulation
