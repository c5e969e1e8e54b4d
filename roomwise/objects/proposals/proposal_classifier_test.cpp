#include "roomwise/objects/proposals/proposal_classifier.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "roomwise/base/testing/testing.h"
#include "roomwise/image/codec.h"
#include "roomwise/network/vision/onnx_classifier.h"
#include "roomwise/objects/detection/object_vocabulary.h"

namespace roomwise::objects {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

Proposal thing_of(const Vector3d& size_m, double top_m) {
  Proposal thing;
  thing.box_world = {{Eigen::Quaterniond::Identity(), {0, 0, top_m - size_m.z() / 2}}, size_m};
  thing.top_m = top_m;
  return thing;
}
// That stands on the floor.
Proposal thing_of(const Vector3d& size_m) {
  return thing_of(size_m, size_m.z());
}

// An upright block of cells, with views that all say the same.
ScoredProposal block(const Vector3d& center, const Vector3d& size_m, const ClassScores& said) {
  ScoredProposal looked{thing_of(size_m), std::vector<ProposalView>(8), {8, said}};
  constexpr double kCell_m = 0.05;
  const Vector3d low = center - size_m / 2;
  for (double x = 0.5 * kCell_m; x < size_m.x(); x += kCell_m) {
    for (double y = 0.5 * kCell_m; y < size_m.y(); y += kCell_m) {
      for (double z = 0.5 * kCell_m; z < size_m.z(); z += kCell_m) {
        looked.proposal.surface_world.push_back((low + Vector3d(x, y, z)).cast<float>());
      }
    }
  }
  return looked;
}
const Vector3d kLampSize(0.3, 0.3, 0.4);

TEST(ClassifyProposals, TakesTheKindThatTheViewsSayMostInTheMean) {
  ScoredProposal looked = block({0, 0, 0.2}, kLampSize, {{"lamp", 0.6}, {"plant", 0.1}});
  looked.said.resize(4);
  looked.said[0] = {{"plant", 0.9}};
  const auto names = classify_proposals(std::vector{looked});
  ASSERT_THAT(names, SizeIs(1));
  EXPECT_EQ(names[0].word, "lamp");
  EXPECT_NEAR(names[0].score, 0.45, 1e-12) << "a view that says nothing of it counts, too";
}

TEST(ClassifyProposals, IsSilentWhereNothingIsSaid) {
  ScoredProposal unseen = block({0, 0, 0.2}, kLampSize, {});
  EXPECT_THAT(classify_proposals(std::vector{unseen}), IsEmpty());
  unseen.views.clear();
  unseen.said.clear();
  EXPECT_THAT(classify_proposals(std::vector{unseen}), IsEmpty());
}

TEST(ClassifyProposals, AScoreThatIsNoNumberIsNothing) {
  const ClassScores said{{"lamp", std::nan("")}, {"plant", 0.9}, {"vase", std::nan("")}};
  const auto names = classify_proposals(std::vector{block({0, 0, 0.2}, kLampSize, said)});
  ASSERT_THAT(names, SizeIs(1));
  EXPECT_EQ(names[0].word, "plant");
}

TEST(ClassifyProposals, OfPartsOfOneThingTheSurestIsTold) {
  const ScoredProposal lamp = block({0, 0, 0.7}, kLampSize, {{"lamp", 0.8}});
  const ScoredProposal shade = block({0, 0, 0.8}, {0.3, 0.3, 0.2}, {{"lamp", 0.6}});
  const ScoredProposal plant = block({0, 0, 0.8}, {0.3, 0.3, 0.2}, {{"plant", 0.5}});
  const ScoredProposal elsewhere = block({2, 0, 0.7}, kLampSize, {{"lamp", 0.4}});
  const auto names = classify_proposals(std::vector{shade, lamp, plant, elsewhere});
  ASSERT_THAT(names, SizeIs(3));
  EXPECT_EQ(names[0].proposal, 1U);
  EXPECT_EQ(names[1].proposal, 2U) << "of two kinds it is decided later, by all that was seen";
  EXPECT_EQ(names[2].proposal, 3U);
}

class KindsOfLabelsTest : public ::testing::Test {
 protected:
  [[nodiscard]] double score(const std::string& label, float said, const Proposal& thing) const {
    const std::vector<std::string> labels{label};
    const auto scores = KindsOfLabels(labels, kinds_).scores(std::vector{said}, thing);
    return scores.empty() ? 0 : scores.begin()->second;
  }

  // One that stands on the floor, about as large as a wardrobe, and one of any size.
  const std::vector<Kind> kinds_ = parse_kinds(R"({"kinds": [
      {"name": "case", "labels": ["case"], "on_floor": true,
       "size_m": {"least": [0.7, 0.3, 0.8], "usual": [1.2, 0.6, 1.9], "most": [3.6, 1, 2.6]}},
      {"name": "heap", "labels": ["heap, pile"]}]})")
                                       .value();
};

TEST_F(KindsOfLabelsTest, BelieveWhatIsSaidOfAThingAsLargeAsItsKind) {
  EXPECT_GT(score("case", 0.8F, thing_of({1.1, 0.6, 2.0})), 0.75);
  EXPECT_GT(score("case", 0.8F, thing_of({0.45, 1.1, 2.0})), 0.7) << "half of its depth was seen";
  EXPECT_LT(score("case", 0.8F, thing_of({0.9, 0.06, 2.0})), 0.1) << "a door's leaf";
  EXPECT_LT(score("case", 0.8F, thing_of({0.3, 0.3, 0.4})), 0.1);
}

TEST_F(KindsOfLabelsTest, TheFootOfWhatStandsOnTheFloorMayBeHidden) {
  const Vector3d upper_half(1.1, 0.6, 0.3);
  EXPECT_GT(score("case", 0.8F, thing_of(upper_half, 2.0)), 0.75);
  EXPECT_LT(score("case", 0.8F, thing_of(upper_half)), 0.2);
}

TEST_F(KindsOfLabelsTest, OfAKindWhoseSizeNobodyKnowsAnySizeIsAsGood) {
  EXPECT_NEAR(score("heap", 0.8F, thing_of({1, 1, 1})), 0.4, 1e-6);
  EXPECT_NEAR(score("heap", 0.8F, thing_of({0.1, 0.1, 0.1})), 0.4, 1e-6);
  EXPECT_EQ(score("zebra", 0.8F, thing_of({1, 1, 1})), 0) << "no kind has this label";
}

TEST(LabelsOfBox, AreTheBestOfThoseThatCoverTheBox) {
  const network::PixelBox box{100, 100, 200, 200};
  const std::vector<network::Detection> found{{0, 0.4F, {100, 100, 200, 190}},
                                              {0, 0.6F, {110, 100, 200, 200}},
                                              {2, 0.8F, {160, 100, 300, 200}}};
  EXPECT_THAT(labels_of_box(found, box, 3), ::testing::ElementsAre(0.6F, 0, 0))
      << "the last stands beside it";
}

class NetworkClassifierTest : public ::testing::Test {
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
  [[nodiscard]] Expected<ClassScores> said_of(const std::string& photo,
                                              const Proposal& thing) const {
    const auto file = roomwise::testing::find_data("object_photos/" + photo);
    if (!file) return fail("{} is not here", photo);
    ROOMWISE_TRY(const image::ColorImage picture, image::read_color(*file));
    return proposal_classifier_->look(
        picture, {0, 0, static_cast<float>(picture.width()), static_cast<float>(picture.height())},
        thing);
  }

  std::unique_ptr<ProposalClassifier> proposal_classifier_;
};

TEST_F(NetworkClassifierTest, NamesWhatAPhotoShows) {
  const auto photo = roomwise::testing::find_data("object_photos/n04550184_wardrobe.jpg");
  ROOMWISE_REQUIRE_FILE(photo);
  struct Shown {
    std::string file, kind;
    Proposal thing;
  };
  for (const auto& [file, kind, thing] :
       {Shown{"n04380533_table_lamp.jpg", "lamp", thing_of({0.35, 0.35, 0.6}, 1.2)},
        Shown{"n04550184_wardrobe.jpg", "wardrobe", thing_of({1.2, 0.6, 2.0})},
        Shown{"n04447861_toilet_seat.jpg", "toilet seat", thing_of({0.4, 0.65, 0.8})}}) {
    const auto said = said_of(file, thing);
    ASSERT_OK(said);
    ASSERT_FALSE(said->empty());
    const auto most =
        std::ranges::max_element(*said, {}, [](const auto& one) { return one.second; });
    EXPECT_EQ(most->first, kind) << file;
    EXPECT_GT(most->second, 0.4) << file;
    const auto of_other_size = said_of(file, thing_of({4, 4, 0.05}));
    ASSERT_OK(of_other_size);
    const auto same = of_other_size->find(kind);
    EXPECT_LT(same == of_other_size->end() ? 0 : same->second, 0.1) << "as large as a carpet";
  }
}

TEST_F(NetworkClassifierTest, APictureWithoutPixelsIsAnError) {
  const auto said = proposal_classifier_->look({}, {0, 0, 10, 10}, {});
  ASSERT_FALSE(said);
  EXPECT_THAT(said.error().message, HasSubstr("without pixels"));
}

TEST(LabelsOfProposals, MeanTheirKinds) {
  const auto words = ObjectVocabulary::standard();
  const auto labels = labels_of_proposals();
  EXPECT_GE(labels.size(), words.objects().size());
  for (const auto& [word, label] : labels) {
    const bool is_spoken_of = find_kind(word)->is_spoken_of;
    EXPECT_EQ(words.object_of(label), is_spoken_of ? std::optional(word) : std::nullopt);
  }
}

}  // namespace
}  // namespace roomwise::objects
