#include "roomwise/objects/kinds/kinds.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <set>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/objects/detection/object_vocabulary.h"

namespace roomwise::objects {
namespace {

using Eigen::Vector3d;
using ::testing::IsEmpty;

TEST(Kinds, AreCompiledInAndMeanEachLabelOnce) {
  std::set<std::string> labels;
  for (const Kind& kind : standard_kinds()) {
    EXPECT_EQ(kind.labels.empty(), !kind.size) << kind.name << ": what is looked for has a size";
    for (const std::string& label : kind.labels) {
      EXPECT_TRUE(labels.insert(label.substr(0, label.find(','))).second)
          << label << " stands in two rows, or twice in one";
    }
    if (!kind.size) continue;
    const Vector3d& usual_m = kind.size->usual_m;
    EXPECT_LT(usual_m.maxCoeff(), 3) << kind.name;
    EXPECT_GE(usual_m.x(), usual_m.y()) << kind.name << ": the longer side comes first";
  }
  ASSERT_NE(find_kind("cup"), nullptr);
  EXPECT_TRUE(find_kind("cup")->is_moved_about);
  EXPECT_FALSE(find_kind("cup")->stands_on_floor);
  EXPECT_FALSE(find_kind("radiator")->is_spoken_of);
  EXPECT_EQ(find_kind("cup")->called.at("de").forms.at("plural"), "Tassen");
  EXPECT_THAT(find_kind("stairs")->labels, IsEmpty()) << "a word only";
  EXPECT_EQ(find_kind("dragon"), nullptr);
}

TEST(Kinds, KnowHowLargeThingsAre) {
  EXPECT_DOUBLE_EQ(typical_length_m("bed"), 2);
  EXPECT_GT(usual_extent_m("bed"), 5 * usual_extent_m("cup"));
  EXPECT_DOUBLE_EQ(typical_length_m("dragon"), 0.5);
  EXPECT_DOUBLE_EQ(usual_extent_m("stairs"), 0.5);
}

TEST(Kinds, WhatIsCarriedAboutIsSoonElsewhereAndWhatIsFixedStays) {
  EXPECT_DOUBLE_EQ(probability_still_there("cup", 0), 1);
  EXPECT_NEAR(probability_still_there("cup", stay_times().carried_days), std::exp(-1), 1e-12);
  EXPECT_NEAR(probability_still_there("sofa", stay_times().furniture_days), std::exp(-1), 1e-12);
  EXPECT_GT(probability_still_there("toilet", 365), probability_still_there("sofa", 365));
  EXPECT_DOUBLE_EQ(probability_still_there("dragon", 30), probability_still_there("sofa", 30))
      << "nobody knows";
}

TEST(Kinds, ASizeIsMostProbableNearTheUsualOne) {
  const SizeDistribution size{{1, 0.5, 0.5}, {2, 1, 1}, {3, 2, 2}};
  const double usual = size.log_density({2, 1, 1});
  EXPECT_NEAR(usual - size.log_density({3, 1, 1}), 2, 1e-12) << "two standard deviations above";
  EXPECT_NEAR(usual - size.log_density({2, 0.5, 1}), 2, 1e-12) << "and below";
  const SizeDistribution wider{{0.5, 0.25, 0.25}, {2, 1, 1}, {8, 4, 4}};
  EXPECT_LT(wider.log_density({2, 1, 1}), usual) << "what may be of any size is seldom of this one";
}

std::string row(const std::string& fields) {
  return R"({"kinds": [{"name": "egg")" + fields + "}]}";
}

TEST(Kinds, NameTheRowThatIsWrong) {
  const auto of_size = [](const std::string& least) {
    return row(R"(, "size_m": {"least": )" + least +
               R"(, "usual": [0.06, 0.05, 0.05], "most": [0.1, 0.1, 0.1]})");
  };
  EXPECT_OK(parse_kinds(row("")));
  EXPECT_OK(parse_kinds(of_size("[0.04, 0.03, 0.03]")));
  EXPECT_ERROR(parse_kinds(of_size("[0.04, 0, 0.03]")), "kind \"egg\": size_m must be positive");
  EXPECT_ERROR(parse_kinds(of_size("[0.04, 0.05, 0.03]")), "least < usual < most");
  EXPECT_ERROR(parse_kinds(of_size("[0.04, 0.03]")), "row 1");
  EXPECT_ERROR(parse_kinds(row(R"(, "lables": ["egg"])")), "no field \"lables\"");
  EXPECT_ERROR(parse_kinds(row(R"(, "moves": "often")")), "row 1");
  EXPECT_ERROR(parse_kinds(row(R"(, "moves": true, "fixed": true)")), "one of both at most");
  EXPECT_ERROR(parse_kinds(R"({"kinds": [{"name": "egg"}, {"name": "egg"}]})"),
               "kind \"egg\" has two rows");
  EXPECT_ERROR(parse_kinds("{"), "row 1");
  for (const char* name : {"", " ", "two\\nlines"}) {
    EXPECT_ERROR(parse_kinds(fmt::format(R"({{"kinds": [{{"name": "{}"}}]}})", name)),
                 "the kind in row 1: its name must be one line of text");
  }
}

TEST(Kinds, TakeRowsOfSomebodysOwn) {
  const std::size_t before = standard_kinds().size();
  EXPECT_ERROR(add_kinds(row(R"(, "moves": 7)")), "row 1");
  EXPECT_EQ(standard_kinds().size(), before);
  ASSERT_OK(add_kinds(row(R"(, "labels": ["ostrich egg"], "moves": true)")));
  ASSERT_NE(find_kind("egg"), nullptr);
  EXPECT_TRUE(find_kind("egg")->is_moved_about);
  ASSERT_OK(add_kinds(row(R"(, "moves": false)")));
  EXPECT_FALSE(find_kind("egg")->is_moved_about) << "a row takes the place of the one of its name";
  EXPECT_EQ(standard_kinds().size(), before + 1);
}

TEST(Kinds, OfSomebodysOwnThatTakeAnothersLabelAreRefused) {
  ASSERT_OK(ObjectVocabulary::check_kinds());
  const std::string label = find_kind("fridge")->labels.front();
  ASSERT_OK(
      add_kinds(fmt::format(R"({{"kinds": [{{"name": "my fridge", "labels": ["{}"]}}]}})", label)));
  EXPECT_ERROR(ObjectVocabulary::check_kinds(), "means \"fridge\" already");
  ASSERT_OK(add_kinds(R"({"kinds": [{"name": "my fridge", "labels": [""]}]})"));
  EXPECT_ERROR(ObjectVocabulary::check_kinds(), "a label is empty");
  ASSERT_OK(add_kinds(R"({"kinds": [{"name": "my fridge"}]})"));
  EXPECT_OK(ObjectVocabulary::check_kinds());
}

// What a kind is stands in its row alone: code that asks for one by name is a rule for one noun.
TEST(Kinds, NoSourceOfObjectsNamesOne) {
  std::set<std::string> words;
  for (const Kind& kind : standard_kinds()) {
    words.insert(kind.name);
    for (const std::string& label : kind.labels) words.insert(label.substr(0, label.find(',')));
  }
  const std::filesystem::path folder(ROOMWISE_SOURCE_OF_OBJECTS);
  const std::regex literal(R"lit("((?:[^"\\\n]|\\.)*)")lit"), comment("//[^\n]*");
  int sources = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().filename();
    const std::string extension = entry.path().extension();
    if ((extension != ".cpp" && extension != ".h") || name.ends_with("_test.cpp")) continue;
    if (entry.path().parent_path().filename() == "testing") continue;
    ++sources;
    const std::string text = std::regex_replace(read_text_file(entry.path()).value(), comment, "");
    for (std::sregex_iterator match(text.begin(), text.end(), literal), end; match != end;
         ++match) {
      const std::string said = (*match)[1];
      EXPECT_FALSE(words.contains(said.substr(0, said.find(','))))
          << name << ": \"" << said << "\"";
    }
  }
  EXPECT_GT(sources, 20);
}

}  // namespace
}  // namespace roomwise::objects
