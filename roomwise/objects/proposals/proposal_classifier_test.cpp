#include "roomwise/objects/proposals/proposal_classifier.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "roomwise/base/testing/testing.h"
#include "roomwise/image/codec.h"
#include "roomwise/network/vision/onnx_classifier.h"

namespace roomwise::objects {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// An upright block of cells, with views that all say the same.
ScoredProposal block(const Vector3d& center, const Vector3d& size_m, const ClassScores& said,
                     std::size_t views = 8) {
  ScoredProposal looked;
  looked.proposal.box_world = {{Eigen::Quaterniond::Identity(), center}, size_m};
  constexpr double kCell_m = 0.05;
  const Vector3d low = center - size_m / 2;
  for (double x = 0.5 * kCell_m; x < size_m.x(); x += kCell_m) {
    for (double y = 0.5 * kCell_m; y < size_m.y(); y += kCell_m) {
      for (double z = 0.5 * kCell_m; z < size_m.z(); z += kCell_m) {
        looked.proposal.surface_world.push_back((low + Vector3d(x, y, z)).cast<float>());
      }
    }
  }
  looked.views.resize(views);
  looked.said.assign(views, said);
  return looked;
}
ScoredProposal lamp_at(const Vector3d& center, double score, const Vector3d& size_m) {
  return block(center, size_m, {{"lamp", score}});
}
const Vector3d kLampSize(0.3, 0.3, 0.4);
// What a proposal is called that stands alone; empty where nothing is said.
std::string name_of(const ScoredProposal& looked) {
  const auto names = classify_proposals(std::vector{looked});
  return names.empty() ? "" : names.at(0).word;
}

TEST(NameProposals, TakesTheWordThatTheViewsSayMostInTheMean) {
  ScoredProposal looked = block({0, 0, 0.2}, kLampSize, {{"lamp", 0.6}, {"plant", 0.1}}, 4);
  looked.said[0] = {{"plant", 0.9}};
  const auto names = classify_proposals(std::vector{looked});
  ASSERT_THAT(names, SizeIs(1));
  EXPECT_EQ(names[0].word, "lamp");
  EXPECT_NEAR(names[0].score, 0.45, 1e-12) << "a view that says nothing of it counts, too";
}

TEST(NameProposals, IsSilentWhereTooLittleIsSaidOrFromTooFewSides) {
  EXPECT_THAT(classify_proposals(std::vector{lamp_at({0, 0, 0.2}, 0.29, kLampSize)}), IsEmpty());
  EXPECT_THAT(classify_proposals(std::vector{lamp_at({0, 0, 0.2}, 0.31, kLampSize)}), SizeIs(1));
  EXPECT_THAT(classify_proposals(std::vector{block({0, 0, 0.2}, kLampSize, {{"lamp", 0.9}}, 2)}),
              IsEmpty());
}

TEST(NameProposals, NothingIsCalledWhatIsNeverOfItsSize) {
  const ClassScores said{{"wardrobe", 0.8}, {"lamp", 0.4}};
  EXPECT_EQ(name_of(block({0, 0, 0.2}, kLampSize, said)), "lamp");
  EXPECT_EQ(name_of(block({0, 0, 1}, {1.2, 0.6, 2}, said)), "wardrobe");
}

TEST(NameProposals, ABinIsNoToiletThoughItIsCalledSo) {
  const ClassScores said{{"toilet seat", 0.9}, {"lamp", 0.5}};
  EXPECT_EQ(name_of(block({0, 0, 0.35}, {0.37, 0.38, 0.7}, said)), "lamp");
  EXPECT_EQ(name_of(block({0, 0, 0.35}, {0.37, 0.65, 0.7}, said)), "toilet seat");
}

TEST(NameProposals, AScoreThatIsNoNumberIsNothing) {
  const ClassScores said{{"lamp", std::nan("")}, {"plant", 0.9}, {"vase", std::nan("")}};
  EXPECT_EQ(name_of(block({0, 0, 0.2}, kLampSize, said)), "plant");
  ScoredProposal thin = block({0, 0, 0.9}, {0.9, 0.35, 1.8}, {{"bookcase", 0.5}});
  thin.proposal.top_m = 1.8;
  thin.said[0]["fridge"] = std::nan("");
  EXPECT_EQ(name_of(thin), "bookcase");
}

TEST(NameProposals, FormSpeaksForATableAndAChair) {
  ScoredProposal looked = block({0, 0, 0.38}, {1.2, 0.8, 0.76}, {{"bed", 0.31}});
  EXPECT_EQ(name_of(looked), "") << "it is too short for a bed";
  looked.proposal.form = FurnitureForm::kTable;
  EXPECT_EQ(name_of(looked), "table");
  looked.said.assign(looked.views.size(), {{"plant", 0.15}});
  EXPECT_EQ(name_of(looked), "") << "large plants have a level midst, too";

  ScoredProposal seat = block({0, 0, 0.45}, {0.5, 0.5, 0.9}, {{"toilet seat", 0.35}});
  EXPECT_EQ(name_of(seat), "toilet seat");
  seat.proposal.form = FurnitureForm::kChair;
  EXPECT_EQ(name_of(seat), "chair");
  seat.said.assign(seat.views.size(), {{"toilet seat", 0.8}});
  EXPECT_EQ(name_of(seat), "toilet seat") << "that has a seat and a back, too";
}

TEST(NameProposals, WhatHasTheFormOfASofaIsNoBed) {
  ScoredProposal looked = block({0, 0, 0.4}, {1.9, 0.85, 0.8}, {{"bed", 0.7}});
  EXPECT_EQ(name_of(looked), "bed");
  looked.proposal.form = FurnitureForm::kSofa;
  EXPECT_EQ(name_of(looked), "sofa");
}

TEST(NameProposals, AFridgeThatIsThinnerOrWiderThanAnyIsABookcaseOrAWardrobe) {
  const auto name_of_case = [](const Vector3d& size_m, const ClassScores& said) {
    ScoredProposal looked = block({0, 0, size_m.z() / 2}, size_m, said);
    looked.proposal.top_m = size_m.z();
    return name_of(looked);
  };
  EXPECT_EQ(name_of_case({0.9, 0.35, 1.8}, {{"fridge", 0.35}}), "bookcase");
  EXPECT_EQ(name_of_case({0.9, 0.35, 1.8}, {{"fridge", 0.2}, {"wardrobe", 0.2}}), "bookcase");
  EXPECT_EQ(name_of_case({0.7, 0.65, 1.8}, {{"fridge", 0.35}}), "fridge");
  EXPECT_EQ(name_of_case({1.15, 0.6, 1.8}, {{"fridge", 0.35}}), "fridge");
  EXPECT_EQ(name_of_case({1.15, 0.6, 2.0}, {{"fridge", 0.35}}), "wardrobe");
  EXPECT_EQ(name_of_case({0.6, 0.47, 1.8}, {{"fridge", 0.35}}), "fridge") << "at a wall";
  EXPECT_EQ(name_of_case({0.9, 0.35, 1.8}, {{"wardrobe", 0.35}}), "wardrobe") << "its front alone";
  EXPECT_EQ(name_of_case({1.7, 0.45, 1.9}, {{"fridge", 0.35}}), "wardrobe");
  EXPECT_EQ(name_of_case({1.7, 0.45, 1.6}, {{"fridge", 0.35}}), "") << "a sideboard";
}

TEST(NameProposals, WhatIsTallThinAndNarrowIsABookcase) {
  const auto name_of_case = [](const Vector3d& size_m, double top_m) {
    ScoredProposal looked =
        block({0, 0, top_m - size_m.z() / 2}, size_m, {{"wardrobe", 0.2}, {"bookcase", 0.12}});
    looked.proposal.top_m = top_m;
    return name_of(looked);
  };
  EXPECT_EQ(name_of_case({0.5, 0.3, 1.75}, 1.85), "bookcase");
  EXPECT_EQ(name_of_case({0.9, 0.3, 1.75}, 1.85), "") << "it may be a wardrobe's front";
  EXPECT_EQ(name_of_case({0.5, 0.47, 1.75}, 1.85), "") << "a wardrobe of one door, at a wall";
  EXPECT_EQ(name_of_case({0.5, 0.3, 1.2}, 1.85), "") << "it hangs";
  EXPECT_EQ(name_of_case({0.5, 0.3, 1.2}, 1.3), "");
}

TEST(NameProposals, AFrontThatIsWiderThanDoorsIsAWardrobes) {
  const auto name_of_front = [](const Vector3d& size_m, double top_m) {
    ScoredProposal looked = block({0, 0, top_m - size_m.z() / 2}, size_m, {{"wardrobe", 0.6}});
    looked.proposal.top_m = top_m;
    return name_of(looked);
  };
  EXPECT_EQ(name_of_front({2.0, 0.25, 1.9}, 2.0), "wardrobe");
  EXPECT_EQ(name_of_front({1.3, 0.25, 1.9}, 2.0), "") << "a double door";
  EXPECT_EQ(name_of_front({2.0, 0.15, 1.9}, 2.0), "") << "a wall's bend";
  EXPECT_EQ(name_of_front({2.0, 0.25, 1.3}, 2.0), "") << "it hangs";
  EXPECT_EQ(name_of_front({2.0, 0.25, 1.6}, 1.7), "");
}

TEST(NameProposals, AVaseIsAsLargeAsVasesMostlyAre) {
  const auto name_of_vessel = [](const Vector3d& size_m, double top_m) {
    ScoredProposal looked = block({0, 0, top_m - size_m.z() / 2}, size_m, {{"vase", 0.6}});
    looked.proposal.top_m = top_m;
    return name_of(looked);
  };
  EXPECT_EQ(name_of_vessel({0.3, 0.25, 0.3}, 1.1), "vase");
  EXPECT_EQ(name_of_vessel({0.3, 0.25, 0.15}, 1.1), "") << "a bowl";
  EXPECT_EQ(name_of_vessel({0.15, 0.15, 0.25}, 1.1), "") << "a bottle";
  EXPECT_EQ(name_of_vessel({0.5, 0.25, 0.3}, 1.1), "");
  EXPECT_EQ(name_of_vessel({0.3, 0.3, 0.45}, 0.5), "") << "a bin";
}

TEST(NameProposals, WhatIsCutIsNamedWhereNothingThatStandsApartIs) {
  const ScoredProposal bed = block({0, 0, 0.25}, {1.6, 2.0, 0.5}, {{"bed", 0.6}});
  ScoredProposal cut = block({0.5, 0, 0.25}, {1.0, 0.9, 0.5}, {{"sofa", 0.9}});
  cut.proposal.is_cut = true;
  ScoredProposal elsewhere = block({3, 0, 0.25}, {1.0, 0.9, 0.5}, {{"sofa", 0.4}});
  elsewhere.proposal.is_cut = true;
  auto names = classify_proposals(std::vector{bed, cut, elsewhere});
  ASSERT_THAT(names, SizeIs(2));
  EXPECT_EQ(names[0].word, "bed") << "though the cut piece is said more surely to be a sofa";
  EXPECT_EQ(names[1].proposal, 2U);
  ScoredProposal nameless = bed;
  nameless.said.assign(8, {});
  names = classify_proposals(std::vector{nameless, cut});
  ASSERT_THAT(names, SizeIs(1));
  EXPECT_EQ(names[0].proposal, 1U);
}

TEST(NameProposals, WhatHoldsAPartOfAnotherKindIsOneThing) {
  ScoredProposal whole = block({0, 0, 0.4}, {1.9, 0.85, 0.8}, {{"bed", 0.5}});
  whole.proposal.form = FurnitureForm::kSofa;
  const ScoredProposal back = block({0, 0, 0.6}, {1.9, 0.85, 0.4}, {{"bed", 0.6}});
  const auto names = classify_proposals(std::vector{whole, back});
  ASSERT_THAT(names, SizeIs(1));
  EXPECT_EQ(names[0].word, "sofa");
}

TEST(NameProposals, OfAThingItsPartAndWhatItStandsOnOnlyTheThingIsNamed) {
  const ScoredProposal lamp = lamp_at({0, 0, 0.7}, 0.8, kLampSize);
  const ScoredProposal shade = lamp_at({0, 0, 0.8}, 0.9, {0.3, 0.3, 0.2});
  const ScoredProposal with_nightstand = lamp_at({0, 0, 0.45}, 0.5, {0.4, 0.4, 0.9});
  const ScoredProposal elsewhere = lamp_at({2, 0, 0.7}, 0.4, kLampSize);
  const auto names = classify_proposals(std::vector{with_nightstand, lamp, shade, elsewhere});
  ASSERT_THAT(names, SizeIs(2));
  EXPECT_EQ(names[0].proposal, 1U) << "the shade is said a little more surely, and is a part";
  EXPECT_EQ(names[1].proposal, 3U);
}

class NetworkNamer : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto weights = roomwise::testing::find_model("mobilenet-v2-imagenet.onnx");
    const auto boxes = roomwise::testing::find_model("nanodet-plus-m-416.onnx");
    ROOMWISE_REQUIRE_FILE(weights);
    ROOMWISE_REQUIRE_FILE(boxes);
    proposal_classifier_ = network_proposal_classifier(
        network::Detector::load(*boxes).value(), network::OnnxClassifier::load(*weights).value());
  }
  // Of a photo that shows the thing alone.
  [[nodiscard]] Expected<ClassScores> said_of(const std::string& photo) const {
    const auto file = roomwise::testing::find_data("object_photos/" + photo);
    if (!file) return fail("{} is not here", photo);
    ROOMWISE_TRY(const image::ColorImage picture, image::read_color(*file));
    return proposal_classifier_->look(
        picture, {0, 0, static_cast<float>(picture.width()), static_cast<float>(picture.height())});
  }

  std::unique_ptr<ProposalClassifier> proposal_classifier_;
};

TEST_F(NetworkNamer, NamesWhatAPhotoShows) {
  const auto photo = roomwise::testing::find_data("object_photos/n04550184_wardrobe.jpg");
  ROOMWISE_REQUIRE_FILE(photo);
  for (const auto& [file, word] :
       std::map<std::string, std::string>{{"n04380533_table_lamp.jpg", "lamp"},
                                          {"n04550184_wardrobe.jpg", "wardrobe"},
                                          {"n03018349_china_cabinet.jpg", "bookcase"},
                                          {"n03063599_coffee_mug.jpg", "vase"},
                                          {"n04447861_toilet_seat.jpg", "toilet seat"}}) {
    const auto said = said_of(file);
    ASSERT_OK(said);
    ASSERT_FALSE(said->empty());
    const auto most =
        std::ranges::max_element(*said, {}, [](const auto& one) { return one.second; });
    EXPECT_EQ(most->first, word) << file;
    EXPECT_GT(most->second, 0.4) << file;
  }
}

TEST(LabelsOfProposals, MeanTheirWords) {
  const auto words = ObjectVocabulary::standard();
  const auto labels = labels_of_proposals();
  EXPECT_EQ(labels.size(), words.objects().size() + 1) << "the radiator is a look-alike";
  for (const auto& [word, label] : labels) {
    if (word == "radiator") continue;
    EXPECT_EQ(words.object_of(label), word);
  }
}

TEST(ScoresOfDetections, AreTheBestOfThoseThatCoverTheBox) {
  const std::vector<std::string> words{"chair", "", "table"};
  const network::PixelBox box{100, 100, 200, 200};
  const std::vector<network::Detection> found{{0, 0.4F, {100, 100, 200, 190}},
                                              {0, 0.6F, {110, 100, 200, 200}},
                                              {1, 0.9F, {100, 100, 200, 200}},
                                              {2, 0.8F, {160, 100, 300, 200}}};
  const ClassScores scores = scores_of(found, box, words);
  ASSERT_EQ(scores.size(), 1U) << "a label without a word, and a table that stands beside";
  EXPECT_NEAR(scores.at("chair"), 0.6, 1e-6);
}

TEST(JoinScores, BelievesByHalfWhatOneAloneSaysOfAWordThatBothKnow) {
  const std::set<std::string> both{"toilet seat", "chair"};
  const ClassScores scores =
      join_scores({{"toilet seat", 0.1}, {"lamp", 0.7}, {"chair", 0.1}},
                  {{"toilet seat", 0.7}, {"sofa", 0.6}, {"chair", 0.5}}, both);
  EXPECT_NEAR(scores.at("toilet seat"), 0.4, 1e-12);
  EXPECT_NEAR(scores.at("lamp"), 0.7, 1e-12) << "the classifier's";
  EXPECT_NEAR(scores.at("sofa"), 0.6, 1e-12) << "the detector's";
  EXPECT_NEAR(scores.at("chair"), 0.5, 1e-12) << "of chairs the classifier knows a few";
  EXPECT_NEAR(join_scores({{"chair", 0.9}}, {}, both).at("chair"), 0.45, 1e-12);
}

TEST_F(NetworkNamer, APictureWithoutPixelsIsAnError) {
  const auto said = proposal_classifier_->look({}, {0, 0, 10, 10});
  ASSERT_FALSE(said);
  EXPECT_THAT(said.error().message, HasSubstr("without pixels"));
}

}  // namespace
}  // namespace roomwise::objects
