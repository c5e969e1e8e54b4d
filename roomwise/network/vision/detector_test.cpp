#include "roomwise/network/vision/detector.h"

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <limits>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/image/codec.h"
#include "roomwise/network/testing/tiny_network.h"
#include "roomwise/network/vision/onnx_classifier.h"
#include "roomwise/network/vision/picture_input.h"

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
  std::vector<float> values =
      std::vector<float>(detector_output_size(small_card(), kLabels), -20.F);

  // The anchor finds a thing whose sides are `bins` strides away.
  void find(std::size_t anchor, std::size_t label, float logit, std::array<std::size_t, 4> bins) {
    float* row = values.data() + anchor * kRow;
    row[label] = logit;
    for (std::size_t side = 0; side < 4; ++side) row[kLabels + side * 8 + bins[side]] = 20;
  }
};

TEST(NanoDet, HasAnAnchorForEachCellOfEachStride) {
  EXPECT_EQ(detector_output_size(small_card(), kLabels), (8u * 4 + 4 * 2 + 2 * 1 + 1 * 1) * kRow);
}

TEST(NanoDet, DecodesBoxesAroundTheirAnchors) {
  Rows rows;
  rows.find(1 * 8 + 3, 1, 2, {1, 1, 2, 1});  // stride 8: at (24, 8)
  rows.find(32, 0, 1, {0, 0, 7, 7});         // stride 16: at (0, 0), reaching out of the picture
  const auto found = decode_detections(rows.values, small_card(), kLabels, 0.5F);
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
  const auto found = decode_detections(rows.values, small_card(), kLabels, 0.5F);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].label, 1u);
  EXPECT_NEAR(found[0].score, 1 / (1 + std::exp(-3.0)), 1e-6);
  EXPECT_EQ(found[1].label, 0u);
}

TEST(NanoDet, LeavesOutWhatIsTooUnsure) {
  Rows rows;
  rows.find(11, 1, 0.1F, {1, 1, 1, 1});
  EXPECT_EQ(decode_detections(rows.values, small_card(), kLabels, 0.5F).size(), 1u);
  EXPECT_TRUE(decode_detections(rows.values, small_card(), kLabels, 0.6F).empty());
}

// Cells of 8 px: 8 across and 4 down; of 16: 4 and 2; of 32: 2 and 1.
constexpr std::size_t kCells = 8 * 4 + 4 * 2 + 2 * 1;

ModelCard small_card(Task task) {
  ModelCard card = small_card();
  card.task = task;
  return card;
}

void expect_box(const PixelBox& box, const PixelBox& expected) {
  EXPECT_NEAR(box.left, expected.left, 1e-3);
  EXPECT_NEAR(box.top, expected.top, 1e-3);
  EXPECT_NEAR(box.right, expected.right, 1e-3);
  EXPECT_NEAR(box.bottom, expected.bottom, 1e-3);
}

void expect_only(const std::vector<Detection>& found, const Detection& expected) {
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].label, expected.label);
  EXPECT_NEAR(found[0].score, expected.score, 1e-6);
  expect_box(found[0].box, expected.box);
}

TEST(Yolox, DecodesBoxesFromTheirCells) {
  const ModelCard card = small_card(Task::kYolox);
  ASSERT_EQ(detector_output_size(card, kLabels), kCells * 7);
  std::vector<float> values(kCells * 7, 0.F);
  // The second cell of 16 px: its middle half a cell right of (16, 0) and one down, 32 x 16 px.
  const std::array row{0.5F, 1.F, std::log(2.F), 0.F, 0.9F, 0.2F, 0.8F};
  std::ranges::copy(row, values.begin() + 33 * 7);
  expect_only(decode_detections(values, card, kLabels, 0.5F), {1u, 0.72F, {8, 8, 40, 24}});
}

TEST(Yolov5, DecodesPixelsOfThreeShapesACell) {
  const ModelCard card = small_card(Task::kYolov5);
  ASSERT_EQ(detector_output_size(card, kLabels), 3 * kCells * 7);
  std::vector<float> values(3 * kCells * 7, 0.F);
  const std::array row{30.F, 10.F, 8.F, 4.F, 0.8F, 1.F, 0.F};
  std::ranges::copy(row, values.end() - 7);
  expect_only(decode_detections(values, card, kLabels, 0.5F), {0u, 0.8F, {26, 8, 34, 12}});
}

TEST(Yolov8, DecodesColumns) {
  const ModelCard card = small_card(Task::kYolov8);
  ASSERT_EQ(detector_output_size(card, kLabels), kCells * 6);
  std::vector<float> values(kCells * 6, 0.F);
  const std::array column{60.F, 10.F, 16.F, 4.F, 0.1F, 0.7F};
  for (std::size_t i = 0; i < column.size(); ++i) values[i * kCells + 5] = column[i];
  // Cut by the picture's border.
  expect_only(decode_detections(values, card, kLabels, 0.5F), {1u, 0.7F, {52, 8, 64, 12}});
}

// Numbers that are none, or overflow, are no boxes outside of the picture.
TEST(Detections, AreNoneOfWhatIsNoNumber) {
  const ModelCard card = small_card(Task::kYolox);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::vector<float> values(kCells * 7, nan);
  EXPECT_TRUE(decode_detections(values, card, kLabels, 0.5F).empty());
  for (std::size_t i = 0; i < values.size(); i += 7) {
    values[i + 4] = values[i + 5] = 1;
    values[i + 6] = 0;
  }
  EXPECT_TRUE(decode_detections(values, card, kLabels, 0.5F).empty());
  std::ranges::copy(std::array{0.F, 0.F, 1e6F, 1e6F}, values.begin());
  const auto found = decode_detections(values, card, kLabels, 0.5F);
  ASSERT_EQ(found.size(), 1u);
  expect_box(found[0].box, {0, 0, 64, 32});
}

// A picture of other proportions is neither stretched nor cut.
TEST(PictureInput, PadsWhatHasOtherProportions) {
  ModelCard card = small_card(Task::kYolox);
  card.fit = PictureFit::kPad;
  const image::ColorImage picture(20, 20, {200, 100, 50});
  const PictureScale scale = picture_scale(picture, card);
  EXPECT_FLOAT_EQ(scale.across, 1.6F);
  EXPECT_FLOAT_EQ(scale.down, 1.6F);
  const Tensor input = picture_input(picture, card);
  ASSERT_EQ(input.values.size(), 3u * 64 * 32);
  const auto at = [&](std::size_t x, std::size_t y) { return input.values[y * 64 + x]; };
  EXPECT_EQ(at(0, 0), 200);
  EXPECT_EQ(at(31, 31), 200);
  EXPECT_EQ(at(32, 0), 114);
  EXPECT_EQ(at(63, 31), 114);
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
  EXPECT_ERROR(Detector::load(weights), "is no nanodet-plus of 3 labels: gives 3 values, not 140");
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
