#include "roomwise/objects/detection/object_vocabulary.h"

#include <gmock/gmock.h>

#include "roomwise/base/testing/testing.h"
#include "roomwise/network/formats/network_file.h"

namespace roomwise::objects {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(ObjectVocabulary, StandardHoldsTheSevenObjectsOfThePaper) {
  const auto vocabulary = ObjectVocabulary::standard();
  for (const char* name :
       {"bed", "fridge", "lamp", "microwave", "stove", "toilet seat", "wardrobe"}) {
    EXPECT_TRUE(vocabulary.objects().contains(name)) << name;
  }
  EXPECT_EQ(vocabulary.object_of("studio couch, day bed"), "bed");
  EXPECT_EQ(vocabulary.object_of("four-poster"), "bed");
  EXPECT_EQ(vocabulary.object_of("lampshade, lamp shade"), "lamp");
  EXPECT_EQ(vocabulary.object_of("banana"), std::nullopt);
}

TEST(ObjectVocabulary, StandardKnowsWhatDetectorsCallThings) {
  const auto vocabulary = ObjectVocabulary::standard();
  EXPECT_EQ(vocabulary.object_of("bed"), "bed");
  EXPECT_EQ(vocabulary.object_of("couch"), "sofa");
  EXPECT_EQ(vocabulary.object_of("refrigerator"), "fridge");
  EXPECT_EQ(vocabulary.object_of("dining table"), "table");
  EXPECT_EQ(vocabulary.object_of("oven"), "stove");
  EXPECT_EQ(vocabulary.object_of("toilet"), "toilet seat");
  EXPECT_EQ(vocabulary.object_of("potted plant"), "plant");
  EXPECT_EQ(vocabulary.object_of("zebra"), std::nullopt);
}

TEST(ObjectVocabulary, ALabelOfTheStandardMeansOneObject) {
  const auto vocabulary = ObjectVocabulary::standard();
  for (const auto& [object, labels] : vocabulary.objects()) {
    for (const std::string& label : labels) EXPECT_EQ(vocabulary.object_of(label), object) << label;
  }
}

TEST(ObjectVocabulary, StandardLabelsAreTheNetworksOwn) {
  const auto file = roomwise::testing::find_model("imagenet-labels-1001.txt");
  ROOMWISE_REQUIRE_FILE(file);
  auto labels = network::read_labels(*file);
  ASSERT_OK(labels);
  const auto detector = roomwise::testing::find_model("coco-labels-80.txt");
  ROOMWISE_REQUIRE_FILE(detector);
  const auto others = network::read_labels(*detector);
  ASSERT_OK(others);
  labels->insert(labels->end(), others->begin(), others->end());
  const std::set<std::string> of_our_own{"armchair", "coffee table", "fridge", "kitchen sink",
                                         "lamp",     "office chair", "plant",  "sofa"};
  const auto vocabulary = ObjectVocabulary::standard();
  for (const auto& [object, own_labels] : vocabulary.objects()) {
    for (const std::string& label : own_labels) {
      if (of_our_own.contains(label)) continue;
      EXPECT_THAT(*labels, ::testing::Contains(label)) << object;
    }
  }
}

TEST(ObjectVocabulary, NamesWhatOurOwnNetworkSees) {
  const auto vocabulary = ObjectVocabulary::standard();
  EXPECT_EQ(vocabulary.object_of("bed"), "bed");
  EXPECT_EQ(vocabulary.object_of("toilet"), "toilet seat");
  EXPECT_EQ(vocabulary.object_of("wardrobe"), "wardrobe");
  // A room is not a thing in it.
  EXPECT_EQ(vocabulary.object_of("room: toilet"), std::nullopt);
  EXPECT_EQ(vocabulary.object_of("room: bedroom"), std::nullopt);
}

TEST(ObjectVocabulary, FirstNameOfALabelIsEnough) {
  EXPECT_TRUE(same_label("studio couch", "studio couch, day bed"));
  EXPECT_TRUE(same_label("Studio Couch , day bed", "studio couch,day bed"));
  EXPECT_FALSE(same_label("day bed", "studio couch, day bed"));
  EXPECT_FALSE(same_label("studio", "studio couch, day bed"));
  EXPECT_FALSE(same_label("maillot, tank suit", "maillot, leotard"));
}

TEST(ObjectVocabulary, AddsObjectsAndLabels) {
  ObjectVocabulary vocabulary;
  ASSERT_OK(vocabulary.add("sink", {"washbasin"}));
  ASSERT_OK(vocabulary.add("sink", {"tub, vat", "washbasin, handbasin"}));
  EXPECT_EQ(vocabulary.object_of("washbasin, handbasin"), "sink");
  EXPECT_EQ(vocabulary.object_of("tub, vat"), "sink");
  EXPECT_EQ(vocabulary.objects().at("sink").size(), 2u) << "one label in two spellings is one";
}

TEST(ObjectVocabulary, ALabelMeansOneObjectOnly) {
  auto vocabulary = ObjectVocabulary::standard();
  EXPECT_ERROR(vocabulary.add("divan", {"ottoman", "studio couch"}), "means \"bed\" already");
  EXPECT_FALSE(vocabulary.objects().contains("divan")) << "an error changes nothing";
  EXPECT_EQ(vocabulary.object_of("ottoman"), std::nullopt);
}

TEST(ObjectVocabulary, RefusesEmptyNamesAndLabels) {
  ObjectVocabulary vocabulary;
  EXPECT_ERROR(vocabulary.add(" ", {"washbasin"}), "needs a name");
  EXPECT_ERROR(vocabulary.add("sink", {}), "at least one label");
  EXPECT_ERROR(vocabulary.add("sink", {""}), "label is empty");
}

TEST(ObjectVocabulary, RemovesObjects) {
  auto vocabulary = ObjectVocabulary::standard();
  ASSERT_OK(vocabulary.remove("bed"));
  EXPECT_EQ(vocabulary.object_of("four-poster"), std::nullopt);
  EXPECT_ERROR(vocabulary.remove("bed"), "no object \"bed\"; there are backpack");
}

TEST(FindLabel, GivesTheNetworksSpelling) {
  const std::vector<std::string> labels = {"desk", "table lamp", "studio couch, day bed"};
  EXPECT_EQ(find_label(labels, "Studio couch").value(), "studio couch, day bed");
  EXPECT_ERROR(find_label(labels, "bed"), "unknown label \"bed\"");
  EXPECT_ERROR(find_label(labels, "bed"), "it has studio couch, day bed");
  EXPECT_ERROR(find_label(labels, "zebra"), "see its labels file");
}

}  // namespace
}  // namespace roomwise::objects
