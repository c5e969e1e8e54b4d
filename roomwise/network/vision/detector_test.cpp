#include "roomwise/network/vision/detector.h"

#include <gmock/gmock.h>

#include <array>
#include <cmath>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/image/codec.h"
#include "roomwise/network/testing/tiny_network.h"
#include "roomwise/network/vision/onnx_classifier.h"

namespace roomwise::network {
namespace {

using roomwise::testing::find_data;
using roomwise::testing::find_model;
using roomwise::testing::ScratchFolder;
using ::testing::HasSubstr;

constexpr std::size_t kLabels = 2;
constexpr std::size_t kRow = kLabels + 32;

ModelCard small_card() {
  ModelCard card;
  card.task = Task::kNanoDetPlus;
  card.input_width_px = 64;
  card.input_height_px = 32;
  return card;
}

// Rows that find nothing, but for some.
struct Rows {
  std::vector<float> values = std::vector<float>(nanodet_anchors(small_card()) * kRow, -20.F);

  // The anchor finds a thing whose sides are `bins` strides away.
  void find(std::size_t anchor, std::size_t label, float logit, std::array<std::size_t, 4> bins) {
    float* row = values.data() + anchor * kRow;
    row[label] = logit;
    for (std::size_t side = 0; side < 4; ++side) row[kLabels + side * 8 + bins[side]] = 20;
  }
};

TEST(NanoDet, HasAnAnchorForEachCellOfEachStride) {
  EXPECT_EQ(nanodet_anchors(small_card()), 8u * 4 + 4 * 2 + 2 * 1 + 1 * 1);
}

TEST(NanoDet, DecodesBoxesAroundTheirAnchors) {
  Rows rows;
  rows.find(1 * 8 + 3, 1, 2, {1, 1, 2, 1});  // stride 8: at (24, 8)
  rows.find(32, 0, 1, {0, 0, 7, 7});         // stride 16: at (0, 0), reaching out of the picture
  const auto found = decode_nanodet(rows.values, small_card(), kLabels, 0.5F);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].label, 1u);
  EXPECT_NEAR(found[0].score, 1 / (1 + std::exp(-2.0)), 1e-6);
  EXPECT_NEAR(found[0].box.left, 16, 1e-3);
  EXPECT_NEAR(found[0].box.top, 0, 1e-3);
  EXPECT_NEAR(found[0].box.right, 40, 1e-3);
  EXPECT_NEAR(found[0].box.bottom, 16, 1e-3);
  EXPECT_EQ(found[1].label, 0u);
  EXPECT_NEAR(found[1].box.right, 64, 1e-3);
  EXPECT_NEAR(found[1].box.bottom, 32, 1e-3);
}

TEST(NanoDet, KeepsTheBestOfBoxesOfOneThing) {
  Rows rows;
  rows.find(11, 1, 2, {2, 1, 2, 2});
  rows.find(10, 1, 3, {1, 1, 3, 2});  // the same box, surer
  rows.find(12, 0, 1, {3, 1, 1, 2});  // the same box, another thing
  const auto found = decode_nanodet(rows.values, small_card(), kLabels, 0.5F);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].label, 1u);
  EXPECT_NEAR(found[0].score, 1 / (1 + std::exp(-3.0)), 1e-6);
  EXPECT_EQ(found[1].label, 0u);
}

TEST(NanoDet, LeavesOutWhatIsTooUnsure) {
  Rows rows;
  rows.find(11, 1, 0.1F, {1, 1, 1, 1});
  EXPECT_EQ(decode_nanodet(rows.values, small_card(), kLabels, 0.5F).size(), 1u);
  EXPECT_TRUE(decode_nanodet(rows.values, small_card(), kLabels, 0.6F).empty());
}

TEST(Detector, RefusesOtherNetworks) {
  const ScratchFolder folder;
  const auto weights = folder / "tiny.onnx";
  ASSERT_OK(write_file(weights, roomwise::testing::mean_color_network()));
  ASSERT_OK(write_file(folder / "labels.txt", "red\ngreen\nblue\n"));
  const auto write_card = [&](const std::string& more) {
    ASSERT_OK(write_file(folder / "tiny.card.json",
                         R"({"input": {"width": 6, "height": 4})" + more + "}"));
  };
  write_card("");
  EXPECT_ERROR(Detector::load(weights), "tiny.onnx: its card does not say that it finds things");
  write_card(R"(, "task": "nanodet-plus")");
  EXPECT_ERROR(Detector::load(weights), "a detector needs labels");
  write_card(R"(, "task": "nanodet-plus", "labels": "labels.txt")");
  EXPECT_ERROR(Detector::load(weights), "is no NanoDet-Plus of 3 labels: gives 3 values, not 140");
  EXPECT_ERROR(OnnxClassifier::load(weights), "finds things in pictures");
}

// Boxes around things in two photos, measured by eye.
TEST(Detector, FindsThingsWhereTheyAre) {
  const auto weights = find_model("nanodet-plus-m-416.onnx");
  ROOMWISE_REQUIRE_FILE(weights);
  const auto photos = find_data("object_photos");
  ROOMWISE_REQUIRE_FILE(photos);
  const auto detector = Detector::load(*weights);
  ASSERT_OK(detector);
  struct Seen {
    const char* photo;
    const char* label;
    PixelBox box;
  };
  for (const Seen& seen : {Seen{"n04447861_toilet_seat.jpg", "toilet", {28, 68, 249, 312}},
                           Seen{"n02099601_golden_retriever.jpg", "dog", {42, 117, 210, 390}}}) {
    const auto photo = image::read_color(*photos / seen.photo);
    ASSERT_OK(photo);
    const auto found = (*detector)->detect(*photo, 0.4F);
    ASSERT_OK(found);
    ASSERT_EQ(found->size(), 1u) << seen.photo;
    EXPECT_EQ((*detector)->labels()[found->front().label], seen.label);
    EXPECT_GT(intersection_over_union(found->front().box, seen.box), 0.85F) << seen.photo;
  }
  EXPECT_ERROR((*detector)->detect(image::ColorImage(), 0.4F), "no pixels");
}

}  // namespace
}  // namespace roomwise::network
