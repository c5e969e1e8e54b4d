#include "roomwise/objects/kinds/kinds.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "roomwise/base/testing/testing.h"

namespace roomwise::objects {
namespace {

TEST(Kinds, AreCompiledInAndMeanEachLabelOnce) {
  std::set<std::string> labels;
  for (const Kind& kind : standard_kinds()) {
    EXPECT_FALSE(kind.labels.empty()) << kind.name;
    EXPECT_LT(kind.size_m.maxCoeff(), 3) << kind.name;
    EXPECT_GE(kind.size_m.x(), kind.size_m.y()) << kind.name << ": the longer side comes first";
    for (const std::string& label : kind.labels) {
      EXPECT_TRUE(labels.insert(label.substr(0, label.find(','))).second)
          << label << " stands in two rows, or twice in one";
    }
  }
  ASSERT_NE(find_kind("cup"), nullptr);
  EXPECT_TRUE(find_kind("cup")->is_moved_about);
  EXPECT_FALSE(find_kind("cup")->stands_on_floor);
  EXPECT_FALSE(find_kind("radiator")->is_spoken_of);
  EXPECT_EQ(find_kind("dragon"), nullptr);
}

TEST(Kinds, KnowHowLargeThingsAre) {
  EXPECT_DOUBLE_EQ(typical_length_m("bed"), 2);
  EXPECT_GT(usual_extent_m("bed"), 5 * usual_extent_m("cup"));
  EXPECT_DOUBLE_EQ(typical_length_m("dragon"), 0.5);
  EXPECT_DOUBLE_EQ(usual_extent_m("dragon"), 0.5);
}

TEST(Kinds, NameTheRowThatIsWrong) {
  const auto row = [](const std::string& size) {
    return R"({"name": "egg", "labels": ["egg"], "size_m": )" + size +
           R"(, "on_floor": false, "moves": true})";
  };
  const auto parse = [](const std::string& rows) {
    return parse_kinds("{\"kinds\": [" + rows + "]}");
  };
  EXPECT_OK(parse(row("[0.06, 0.05, 0.05]")));
  EXPECT_ERROR(parse(row("[0.06, 0, 0.05]")), "kind \"egg\": size_m must be positive");
  EXPECT_ERROR(parse(row("[0.06, 0.05]")), "kind 1");
  EXPECT_ERROR(parse(row("[1, 1, 1]") + "," + row("[1, 1, 1]")), "kind \"egg\" has two rows");
  EXPECT_ERROR(parse_kinds("{"), "kind 0");
}

}  // namespace
}  // namespace roomwise::objects
