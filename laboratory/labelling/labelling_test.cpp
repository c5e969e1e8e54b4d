#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "laboratory/labelling/label_page.h"
#include "laboratory/labelling/lift.h"
#include "laboratory/labelling/recording_truth.h"
#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/recording/open_recording.h"
#include "roomwise/recording/tum_writer.h"

namespace roomwise::labelling {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using roomwise::testing::ScratchFolder;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

geometry::PinholeCamera camera() {
  geometry::PinholeCamera camera;
  camera.fx = 500, camera.fy = 510, camera.cx = 320, camera.cy = 240;
  camera.width = 640, camera.height = 480;
  return camera;
}

// Looks from `from` at `at`, y of the world is down in the picture.
geometry::RigidTransform look(const Vector3d& from, const Vector3d& at) {
  const Vector3d z = (at - from).normalized();
  const Vector3d x = Vector3d::UnitY().cross(z).normalized();
  Eigen::Matrix3d axes;
  axes << x, z.cross(x), z;
  return geometry::RigidTransform::from_matrix(axes, from);
}

// The box that a perfect reader draws about a ball.
PlacedView view_of(const Vector3d& middle, double diameter_m, const Vector3d& from,
                   const Vector3d& at) {
  PlacedView view;
  view.camera = camera();
  view.world_from_camera = look(from, at);
  const Vector3d point = view.world_from_camera.inverse() * middle;
  const Eigen::Vector2d pixel = view.camera.project(point);
  const double half_x = 0.5 * diameter_m * view.camera.fx / point.z();
  const double half_y = 0.5 * diameter_m * view.camera.fy / point.z();
  view.box = {static_cast<float>(pixel.x() - half_x), static_cast<float>(pixel.y() - half_y),
              static_cast<float>(pixel.x() + half_x), static_cast<float>(pixel.y() + half_y)};
  return view;
}

const Vector3d kMiddle(0.3, -0.2, 3);

TEST(Lift, RaysMeetInTheMiddleWithoutDepth) {
  const std::vector<PlacedView> views{view_of(kMiddle, 0.5, {-1, 0, 0}, {0, 0, 3}),
                                      view_of(kMiddle, 0.5, {1.2, 0.1, 0.2}, {0, 0, 3})};
  const auto thing = lift(views);
  ASSERT_TRUE(thing);
  EXPECT_LT((thing->box_world.center() - kMiddle).norm(), 1e-3);
  EXPECT_NEAR(thing->box_world.size_m.x(), 0.5, 0.02);
  EXPECT_NEAR(thing->box_world.size_m.y(), 0.5, 0.02);
  ASSERT_TRUE(thing->residual_px);
  EXPECT_LT(*thing->residual_px, 0.1);
  EXPECT_LT(thing->sigma_m, 0.1);
}

TEST(Lift, DepthBehindTheThingHardlyMovesWhereRaysMeet) {
  std::vector<PlacedView> views{view_of(kMiddle, 0.5, {-1, 0, 0}, {0, 0, 3}),
                                view_of(kMiddle, 0.5, {1.2, 0.1, 0.2}, {0, 0, 3})};
  for (PlacedView& view : views) {
    view.depth_m = (view.world_from_camera.inverse() * kMiddle).z() + 0.4;  // the wall behind it
  }
  const auto thing = lift(views);
  ASSERT_TRUE(thing);
  EXPECT_LT((thing->box_world.center() - kMiddle).norm(), 0.1);
}

TEST(Lift, OneViewNeedsDepth) {
  std::vector<PlacedView> views{view_of(kMiddle, 0.3, {0, 0, 0}, {0, 0, 3})};
  EXPECT_FALSE(lift(views)) << "anywhere along the ray";
  views[0].depth_m = 2.925;  // its front
  const auto thing = lift(views);
  ASSERT_TRUE(thing);
  EXPECT_LT((thing->box_world.center() - kMiddle).norm(), 0.08);
  EXPECT_GT(thing->sigma_m, 0.1) << "half the thing's size";
  EXPECT_FALSE(thing->residual_px) << "nothing to differ from";
  EXPECT_FALSE(lift({})) << "nothing was drawn";
}

TEST(Lift, ACutBoxSaysLittleOfItsMiddle) {
  std::vector<PlacedView> views{view_of(kMiddle, 0.5, {-1, 0, 0}, {0, 0, 3}),
                                view_of(kMiddle, 0.5, {1.2, 0.1, 0.2}, {0, 0, 3}),
                                view_of(kMiddle, 0.5, {0.2, 0.5, 0.4}, {0, 0, 3})};
  views[2].box.right = 0.5F * (views[2].box.left + views[2].box.right);  // its left half
  const double taken_whole = (lift(views)->box_world.center() - kMiddle).norm();
  views[2].cut.right = true;
  const double known_cut = (lift(views)->box_world.center() - kMiddle).norm();
  EXPECT_LT(known_cut, 0.5 * taken_whole);
}

TEST(Lift, MovesWithTheWorld) {
  std::vector<PlacedView> views{view_of(kMiddle, 0.5, {-1, 0, 0}, {0, 0, 3}),
                                view_of(kMiddle, 0.5, {1.2, 0.1, 0.2}, {0, 0, 3})};
  const auto before = lift(views);
  const geometry::RigidTransform moved{
      Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized())), {4, -5, 6}};
  for (PlacedView& view : views) view.world_from_camera = moved * view.world_from_camera;
  const auto after = lift(views);
  ASSERT_TRUE(before && after);
  EXPECT_LT((after->box_world.center() - moved * before->box_world.center()).norm(), 1e-6);
  EXPECT_NEAR(after->sigma_m, before->sigma_m, 1e-6);
}

TEST(DepthInMiddle, IsTheMedianOfWhatWasMeasuredThere) {
  image::DepthImage depth(640, 480, 1500);
  for (int y = 200; y < 260; ++y) {
    for (int x = 300; x < 340; ++x) depth.at(x, y) = 2500;
  }
  EXPECT_EQ(depth_in_middle_m(depth, camera(), {290, 190, 350, 270}), 2.5);
  EXPECT_EQ(depth_in_middle_m(depth, camera(), {0, 0, 100, 100}), 1.5);
  for (std::uint16_t& value : depth.pixels()) value = 0;
  EXPECT_EQ(depth_in_middle_m(depth, camera(), {0, 0, 100, 100}), std::nullopt);
}

LiftedLabels reader(const std::string& name,
                    const std::vector<std::tuple<std::string, Vector3d, bool>>& things) {
  LiftedLabels labels{"walk", name, {}, {}};
  for (const auto& [what, center, is_sure] : things) {
    LabelledThing label;
    label.id = static_cast<std::int64_t>(labels.things.size());
    label.name = what;
    label.is_name_sure = is_sure;
    label.views.resize(2);
    label.is_transient = what == "person";
    labels.things.emplace_back(
        label, LiftedThing{{{Eigen::Quaterniond::Identity(), center}, {0.5, 0.5, 0.5}}, 0.05, 1});
  }
  return labels;
}

TEST(MergeReaders, ExpectsWhatBothMarkedAlike) {
  const std::vector<LiftedLabels> readers{reader("A", {{"chair", {0, 0, 0}, true},
                                                       {"chair", {1, 0, 0}, true},
                                                       {"screen", {3, 0, 0}, true},
                                                       {"cup", {5, 0, 0}, false},
                                                       {"person", {6, 0, 0}, true}}),
                                          reader("B", {{"chair", {0.9, 0, 0}, true},
                                                       {"laptop", {3.1, 0, 0}, true},
                                                       {"cup", {5, 0, 0}, true},
                                                       {"lamp", {9, 0, 0}, true},
                                                       {"person", {6, 0, 0}, true}})};
  ReaderAgreement agreement;
  const RecordingTruth truth = merge_readers(readers, agreement).value();
  EXPECT_EQ(agreement.both, 2U) << "the second chair, the cup";
  EXPECT_EQ(agreement.other_name, 1U) << "a screen or a laptop";
  EXPECT_THAT(agreement.only_one, ElementsAre(1, 1)) << "the first chair; the lamp";
  EXPECT_THAT(agreement.between_m, SizeIs(3));
  EXPECT_THAT(truth.readers, ElementsAre("A", "B"));
  ASSERT_THAT(truth.things, SizeIs(5)) << "nobody who was there";
  EXPECT_FALSE(truth.things[0].is_expected) << "only one marked it";
  EXPECT_TRUE(truth.things[1].is_expected);
  EXPECT_NEAR(truth.things[1].box_world.center().x(), 0.95, 1e-9);
  EXPECT_EQ(truth.things[1].views, 4U);
  EXPECT_FALSE(truth.things[2].is_expected);
  EXPECT_THAT(truth.things[2].also_called, ElementsAre("laptop"));
  EXPECT_FALSE(truth.things[3].is_expected) << "one is not sure that it is a cup";
  EXPECT_EQ(truth.things[4].name, "lamp");
}

TEST(MergeReaders, WhoMarkedTwiceConfirmsNothing) {
  ReaderAgreement agreement;
  const LiftedLabels one = reader("A", {{"chair", {0, 0, 0}, true}});
  EXPECT_ERROR(merge_readers(std::vector{one, one}, agreement),
               "both files are of the reader A; give files of two readers");
}

TEST(MergeReaders, OneReaderAloneExpectsNothing) {
  ReaderAgreement agreement;
  const std::vector<LiftedLabels> readers{reader("A", {{"chair", {0, 0, 0}, true}})};
  const RecordingTruth truth = merge_readers(readers, agreement).value();
  ASSERT_THAT(truth.things, SizeIs(1));
  EXPECT_FALSE(truth.things[0].is_expected);
}

TEST(RecordingTruthFile, ComesBackAsItWas) {
  const ScratchFolder folder;
  ReaderAgreement agreement;
  const std::vector<LiftedLabels> readers{reader("A", {{"chair", {0.25, 0, 1}, true}}),
                                          reader("B", {{"chair", {0.25, 0, 1}, true}})};
  const RecordingTruth truth = merge_readers(readers, agreement).value();
  ASSERT_OK(write_recording_truth(folder / "t.json", truth));
  const auto read = read_recording_truth(folder / "t.json");
  ASSERT_OK(read);
  EXPECT_EQ(read->recording, "walk");
  ASSERT_THAT(read->things, SizeIs(1));
  const TrueThing& thing = read->things[0];
  EXPECT_EQ(thing.name, "chair");
  EXPECT_TRUE(thing.is_expected);
  EXPECT_LT((thing.box_world.center() - Vector3d(0.25, 0, 1)).norm(), 1e-3);
  EXPECT_THAT(thing.readers, ElementsAre("A", "B"));

  ASSERT_OK(write_file(folder / "t.json", "{\"recording\": \"walk\"}"));
  EXPECT_ERROR(read_recording_truth(folder / "t.json"), "lift-labels");
  EXPECT_ERROR(read_recording_truth(folder / "none.json"), "none.json");
}

TEST(ReaderLabelsFile, NamesWhatIsWrong) {
  const ScratchFolder folder;
  const auto read = [&](const std::string& things) {
    EXPECT_OK(write_file(folder / "a.json",
                         "{\"recording\": \"walk\", \"reader\": \"A\", "
                         "\"things\": [" +
                             things + "]}"));
    return read_reader_labels(folder / "a.json");
  };
  const auto labels = read(
      R"({"id": 3, "name": "cup", "sure": false, "side": ["front"],
          "views": [{"frame": 7, "box": [1, 2, 30, 40], "cut": ["left"], "occluded": true}]})");
  ASSERT_OK(labels);
  ASSERT_THAT(labels->things, SizeIs(1));
  EXPECT_EQ(labels->things[0].views[0].frame, 7U);
  EXPECT_TRUE(labels->things[0].views[0].cut.left);
  EXPECT_TRUE(labels->things[0].views[0].is_occluded);
  EXPECT_FALSE(labels->things[0].is_name_sure);
  EXPECT_THAT(read("")->things, IsEmpty());
  EXPECT_ERROR(read(R"({"id": 3, "name": "cup", "views": [{"frame": 7, "box": [9, 2, 3, 40]}]})"),
               "thing 3 (cup): its box in frame 7 is empty");
  EXPECT_ERROR(read(R"({"id": 3, "name": "cup",
                        "views": [{"frame": 7, "box": [1, 2, 3, 4], "cut": ["up"]}]})"),
               "'up' is no border");
  EXPECT_ERROR(read(R"({"id": 3, "name": "a", "views": []}, {"id": 3, "name": "b", "views": []})"),
               "two things have the id 3");
  EXPECT_ERROR(read(R"({"id": "x"})"), "a.json: is no file of a reader's labels");
}

class LabelPage : public ::testing::Test {
 protected:
  LabelPage() {
    auto writer = recording::TumWriter::create(folder_ / "walk", camera());
    for (int i = 0; i < 10; ++i) {
      image::RgbdFrame frame;
      frame.timestamp_ns = (i + 1) * 100'000'000;
      frame.color = image::ColorImage(640, 480, {static_cast<std::uint8_t>(i), 2, 3});
      frame.depth = image::DepthImage(640, 480, 1500);
      EXPECT_OK((*writer)->write(frame));
    }
    EXPECT_OK((*writer)->close());
    recording_ = *recording::open_recording(folder_ / "walk");
    fs::create_directories(folder_ / "page");
    for (const char* file : {"index.html", "labelling.js", "labelling.css"}) {
      EXPECT_OK(write_file(folder_ / "page" / file, file));
    }
  }

  Expected<std::size_t> write(const LabelPageOptions& options) {
    return write_label_page(*recording_, folder_ / "page", options, folder_ / "out");
  }
  // What recording.js gives `name`.
  nlohmann::json given(const std::string& name) {
    const std::string text = *read_text_file(folder_ / "out/recording.js");
    const auto from = text.find("window." + name + " = ");
    if (from == std::string::npos) return nullptr;
    const auto begin = from + name.size() + 10;
    return nlohmann::json::parse(text.substr(begin, text.find(";\n", begin) - begin));
  }

  ScratchFolder folder_;
  std::unique_ptr<recording::Recording> recording_;
};

TEST_F(LabelPage, HoldsPicturesEvenlySpreadAndThoseOfTheLabels) {
  LabelPageOptions options{4, {"chair", "</script>"}, ReaderLabels{"walk", "B", {}}};
  options.labels->things.push_back({7,
                                    "cup",
                                    false,
                                    {"top"},
                                    {{3, {1, 2, 30, 40}, {true, false, false, false}, true}},
                                    "x",
                                    true});
  EXPECT_EQ(write(options).value(), 5U);
  const auto recording = given("recording");
  EXPECT_EQ(recording["name"], "walk");
  EXPECT_EQ(recording["words"][1], "</script>");
  std::vector<int> frames;
  for (const auto& picture : recording["pictures"]) {
    frames.push_back(picture["frame"]);
    EXPECT_EQ(picture["width"], 640);
    const auto bytes = read_file(folder_ / "out" / picture["file"].get<std::string>());
    EXPECT_EQ(bytes.value(), recording_->read_color_file(picture["frame"]).value());
  }
  EXPECT_THAT(frames, ElementsAre(0, 2, 3, 5, 7));
  EXPECT_EQ(*read_text_file(folder_ / "out/labelling.js"), "labelling.js");
  EXPECT_THAT(*read_text_file(folder_ / "out/recording.js"), ::testing::Not(HasSubstr("</")))
      << "it would end the script";

  EXPECT_OK(write_file(folder_ / "b.json", given("labels").dump()));
  const auto again = read_reader_labels(folder_ / "b.json");
  ASSERT_OK(again);
  EXPECT_EQ(to_json(*again), to_json(*options.labels)) << "the page begins with what was given";
}

TEST_F(LabelPage, RefusesWhatWouldOverwriteOrDoesNotBelongTogether) {
  EXPECT_ERROR(write({3, {}, ReaderLabels{"flat", "B", {}}}),
               "labels of flat do not belong to walk");
  EXPECT_ERROR(write({0, {}, std::nullopt}), "pictures is 0");
  ReaderLabels labels{
      "walk", "B", {{1, "cup", true, {}, {{99, {1, 2, 3, 4}, {}, false}}, "", false}}};
  EXPECT_ERROR(write({3, {}, labels}), "frame 99 of the labels: the recording has no such picture");
  fs::remove_all(folder_ / "out");
  EXPECT_OK(write({3, {}, std::nullopt}));
  EXPECT_TRUE(given("labels").is_null());
  EXPECT_ERROR(write({3, {}, std::nullopt}), "out: is not empty; give a new folder");
  fs::remove(folder_ / "page/labelling.css");
  fs::remove_all(folder_ / "out");
  EXPECT_ERROR(write({3, {}, std::nullopt}), "labelling.css");
  EXPECT_FALSE(fs::exists(folder_ / "out")) << "nothing is begun that cannot be ended";
}

}  // namespace
}  // namespace roomwise::labelling
