#include "roomwise/recording/tum_recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/testing/testing.h"
#include "roomwise/image/codec.h"
#include "roomwise/image/testing/exif_writer.h"
#include "roomwise/recording/tum_writer.h"

namespace roomwise::recording {
namespace {

using roomwise::testing::find_data;
using roomwise::testing::ScratchFolder;

constexpr int kWidth = 8;
constexpr int kHeight = 6;

// A recording of four colour and four depth images; colour 2 has no depth image near it.
class TumFolder : public ::testing::Test {
 protected:
  TumFolder() {
    write("camera.txt", "# fx fy cx cy width height depth_units_per_metre\n7 7 4 3 8 6 1000\n");
    write("rgb.txt",
          "# color images\n# timestamp filename\n0.000 rgb/0.png\n0.033 rgb/1.jpg\n"
          "0.066 rgb/2.png\n0.100 rgb/3.png\n");
    write("depth.txt",
          "# depth maps\n0.001 depth/0.png\n0.034 depth/1.png\n0.101 depth/3.png\n"
          "0.140 depth/2.png\n");
    for (std::uint8_t i = 0; i < 4; ++i) {
      const image::ColorImage color(kWidth, kHeight, {i, 100, 200});
      const image::DepthImage depth(kWidth, kHeight, static_cast<std::uint16_t>(1000 + i));
      write(fmt::format("rgb/{}.{}", i, i == 1 ? "jpg" : "png"),
            i == 1 ? image::encode_jpeg(color, 95) : image::encode_png(color));
      write(fmt::format("depth/{}.png", i), image::encode_png(depth));
    }
  }

  template <typename Content>  // text or bytes
  void write(const std::filesystem::path& name, const Content& content) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    EXPECT_OK(write_file(folder_ / name, content));
  }
  [[nodiscard]] Expected<std::unique_ptr<TumRecording>> open(
      const RecordingOptions& options = {}) const {
    return TumRecording::open(folder_.path(), options);
  }
  // "FOLDER/rgb.txt:3"
  [[nodiscard]] std::string place(const char* file, int line) const {
    return fmt::format("{}:{}", (folder_ / file).string(), line);
  }

  ScratchFolder folder_;
};

TEST_F(TumFolder, AnInertialSensorIsReadBesideItAndNeverStopsIt) {
  write("imu.txt", "0.00 0 0 0.1 0 -9.8 0\n0.05 0 0 0.1 0 -9.8 0\n0.1 0 0 0.1 0 -9.8 0\n");
  EXPECT_EQ((*open())->inertial().samples().size(), 3U);
  EXPECT_THAT((*open())->notes(), ::testing::IsEmpty());

  write("imu.txt", "1000 0 0 0.1 0 -9.8 0\n1001 0 0 0.1 0 -9.8 0\n");
  EXPECT_TRUE((*open())->inertial().empty());
  EXPECT_THAT((*open())->notes(), ::testing::ElementsAre(::testing::HasSubstr("of no picture")));

  write("imu.txt", "what is this\n");
  const auto recording = open();
  ASSERT_OK(recording);
  EXPECT_TRUE((*recording)->inertial().empty());
  EXPECT_FALSE((*recording)->notes().empty());

  write("imu.txt", "0.00 0 0 0.1 0 -9.8 0\n0.1 0 0 0.1 0 -9.8 0\n");
  write("odometry.txt", "0.0 0 0 0 0 0 0 1\n0.1 0 0 0 0 0 0 1\n");
  EXPECT_TRUE((*open())->inertial().empty()) << "its poses hold what the sensor felt";
}

TEST_F(TumFolder, GivesFramesWithTheirPlaceInTheListOfColour) {
  auto recording = open();
  ASSERT_OK(recording);
  FrameSource& source = **recording;
  EXPECT_EQ(source.info().name, folder_.path().filename());
  EXPECT_EQ(source.info().camera.fx, 7);
  EXPECT_EQ(source.info().frames_remaining, 3U);
  std::vector<std::uint64_t> indices;
  for (;;) {
    auto frame = source.next();
    ASSERT_OK(frame);
    if (!frame->has_value()) break;
    const std::uint64_t index = (*frame)->index;
    indices.push_back(index);
    EXPECT_EQ((*frame)->timestamp_ns, (*recording)->colors().timestamps_ns()[index]);
    EXPECT_NEAR((*frame)->color.at(3, 2).r, static_cast<int>(index), 2);
    EXPECT_EQ((*frame)->depth.at(3, 2), 1000 + index);
    EXPECT_EQ((*frame)->encoded_color, (*recording)->colors().read(index).value());
    EXPECT_EQ(image::decode_depth((*frame)->encoded_depth).value(), (*frame)->depth);
  }
  EXPECT_THAT(indices, ::testing::ElementsAre(0, 1, 3)) << "2 has no depth";
  EXPECT_EQ(source.info().frames_remaining, 0U);
  EXPECT_FALSE(source.next()->has_value()) << "stays at the end";
}

TEST_F(TumFolder, SaysThatAPictureTellsWhereItWasTakenAndGivesItsFileWithout) {
  EXPECT_FALSE(open().value()->info().personal_data.any());
  const Bytes plain = image::encode_jpeg(image::ColorImage(kWidth, kHeight, {9, 9, 9}), 95);
  write("rgb/3.png", image::testing::with_exif(plain, image::testing::exif_with_place(3)));
  const auto recording = open();
  ASSERT_OK(recording);
  EXPECT_EQ((*recording)->info().personal_data, (image::PersonalData{true, true, true}));
  const auto frame = (*recording)->frame(3);
  ASSERT_OK(frame);
  const Bytes file = image::color_file(**frame);
  EXPECT_EQ(image::testing::secrets_in(file), "");
  EXPECT_EQ(image::testing::secrets_in((*frame)->encoded_color), "") << "whoever sends the frame";
  EXPECT_EQ(image::decode_color(file).value(), (*frame)->color) << "turned as before";
  EXPECT_EQ((*recording)->read_color_file(3).value(), file);
}

TEST_F(TumFolder, WebPIsReadAndKeptAsAnotherKind) {
  const Bytes webp{0x52, 0x49, 0x46, 0x46, 0x26, 0x00, 0x00, 0x00, 0x57, 0x45, 0x42, 0x50,
                   0x56, 0x50, 0x38, 0x4C, 0x1A, 0x00, 0x00, 0x00, 0x2F, 0x07, 0x40, 0x01,
                   0x00, 0x07, 0x50, 0x32, 0x85, 0x00, 0x02, 0xA0, 0xA0, 0x29, 0x72, 0xFF,
                   0x63, 0x00, 0x04, 0xE1, 0x7F, 0xDB, 0x44, 0x44, 0xFF, 0x43};
  const image::ColorImage color(kWidth, kHeight, {3, 100, 200});
  write("rgb/3.png", webp);
  const auto recording = open();
  ASSERT_OK(recording);
  const auto frame = (*recording)->frame(3);
  ASSERT_OK(frame);
  EXPECT_EQ((*frame)->color, color);
  EXPECT_EQ((*recording)->read_color_file(3).value(), image::encode_png(color));
  EXPECT_EQ(image::color_file(**frame), image::encode_png(color));
  const ScratchFolder copy;
  const auto writer = TumWriter::create(copy.path(), (*recording)->info().camera);
  ASSERT_OK(writer);
  EXPECT_OK((*writer)->write(**frame));
}

TEST_F(TumFolder, SkipsFramesByIndex) {
  auto recording = open();
  ASSERT_OK(recording);
  (*recording)->skip_before(2);
  EXPECT_EQ((*recording)->info().frames_remaining, 1U);
  EXPECT_EQ((*recording)->next()->value().index, 3U);
  (*recording)->skip_before(100);
  EXPECT_FALSE((*recording)->next()->has_value());
}

TEST_F(TumFolder, GivesAnyFrameByItsIndex) {
  auto recording = open();
  ASSERT_OK(recording);
  const auto last = (*recording)->frame(3);
  ASSERT_OK(last);
  ASSERT_TRUE(last->has_value());
  EXPECT_EQ((*last)->depth.at(3, 2), 1003);
  EXPECT_FALSE((*recording)->frame(2)->has_value()) << "it has no depth";
  EXPECT_FALSE((*recording)->frame(4)->has_value());
  EXPECT_EQ((*recording)->next()->value().index, 0U) << "next() goes on where it was";
}

TEST_F(TumFolder, GivesColourWithoutDepthToo) {
  const auto colors = ImageList::open(folder_.path(), "rgb.txt");
  ASSERT_OK(colors);
  ASSERT_EQ(colors->size(), 4U);
  EXPECT_EQ(colors->read_color(2)->at(0, 0), (Rgb8{2, 100, 200}));
}

TEST_F(TumFolder, TakesTheCameraGivenInsteadOfTheFile) {
  RecordingOptions options;
  options.camera = geometry::PinholeCamera{9, 9, 4, 3, kWidth, kHeight, {}, 5000};
  EXPECT_EQ(open(options).value()->info().camera.fx, 9);
  std::filesystem::remove(folder_ / "camera.txt");
  EXPECT_OK(open(options));
  EXPECT_ERROR(open(), "give --camera fr1|fr2|fr3|kinect-v1|xtion");
}

TEST_F(TumFolder, TakesADifferenceOfTimeAsToleratedByOption) {
  RecordingOptions options;
  options.tolerance_ns = 80'000'000;
  EXPECT_EQ(open(options).value()->info().frames_remaining, 4U);
  options.tolerance_ns = 0;
  EXPECT_ERROR(open(options), "tolerance_ns = 0");
}

TEST_F(TumFolder, ReadsWindowsLinesBlankLinesAndManyBlanks) {
  write("rgb.txt",
        "\xEF\xBB\xBF# color images\r\n\r\n  0.000 \t rgb/0.png\r\n0.033   rgb/1.jpg\r\n");
  auto recording = open();
  ASSERT_OK(recording);
  EXPECT_EQ((*recording)->info().frames_remaining, 2U);
  EXPECT_OK((*recording)->next());
}

TEST_F(TumFolder, SaysWhatIsMissing) {
  EXPECT_ERROR(TumRecording::open(folder_ / "nowhere"), "nowhere: is no folder");
  std::filesystem::remove(folder_ / "depth.txt");
  EXPECT_ERROR(open(), (folder_ / "depth.txt").string() + ": is missing");
  std::filesystem::remove(folder_ / "rgb.txt");
  EXPECT_ERROR(open(), (folder_ / "rgb.txt").string() + ": is missing");
}

TEST_F(TumFolder, NamesTheLineOfTheListThatIsWrong) {
  const auto with = [&](std::string_view text) {
    write("rgb.txt", text);
    return open();
  };
  EXPECT_ERROR(with(""), "rgb.txt: lists no image");
  EXPECT_ERROR(with("# only a comment\n"), "rgb.txt: lists no image");
  EXPECT_ERROR(with("#\n0.0 rgb/0.png extra\n"), place("rgb.txt", 2) + ": 3 words");
  EXPECT_ERROR(with("0.0\n0.1 rgb/1.jpg\n"), place("rgb.txt", 1) + ": 1 words");
  EXPECT_ERROR(with("soon rgb/0.png\n"), place("rgb.txt", 1) + ": 'soon' is not a time stamp");
  EXPECT_ERROR(with("0.0 rgb/0.png\nnan rgb/1.jpg\n"), place("rgb.txt", 2) + ": 'nan'");
  EXPECT_ERROR(with("0.1 rgb/0.png\n0.0 rgb/1.jpg\n"),
               place("rgb.txt", 2) + ": the time 0.0 does not increase");
  EXPECT_ERROR(with("0.1 rgb/0.png\n0.1 rgb/1.jpg\n"), "does not increase");
  EXPECT_ERROR(with("0.1 /etc/passwd\n"), "'/etc/passwd' lies outside the recording");
  EXPECT_ERROR(with("0.1 rgb/../../x.png\n"), "lies outside the recording");
}

TEST_F(TumFolder, SaysThatTheListsDoNotOverlap) {
  write("depth.txt", "1000.5 depth/0.png\n1001 depth/1.png\n");
  EXPECT_ERROR(open(), "0.000000 to 0.100000 s");
  EXPECT_ERROR(open(), "1000.500000 to 1001.000000 s");
}

// A frame that cannot be read is an error; the source goes on with the next.
TEST_F(TumFolder, NamesTheImageThatIsWrongAndGoesOn) {
  const auto first_frame = [&] {
    auto recording = open();
    EXPECT_OK(recording);
    auto frame = (*recording)->next();
    EXPECT_EQ((*recording)->next()->value().index, 1U) << "the frame after the bad one";
    return frame;
  };
  const Bytes good_color = read_file(folder_ / "rgb/0.png").value();
  const Bytes good_depth = read_file(folder_ / "depth/0.png").value();

  std::filesystem::remove(folder_ / "rgb/0.png");
  EXPECT_ERROR(first_frame(), place("rgb.txt", 3));
  EXPECT_ERROR(first_frame(), "rgb/0.png: cannot be opened: No such file or directory");

  write("rgb/0.png", std::span(good_color).first(good_color.size() / 2));
  EXPECT_ERROR(first_frame(), "rgb/0.png: is a truncated or damaged PNG");
  write("rgb/0.png", std::string("hello"));
  EXPECT_ERROR(first_frame(), "rgb/0.png: is neither a JPEG nor a PNG");
  write("rgb/0.png", image::encode_png(image::ColorImage(4, 4)));
  EXPECT_ERROR(first_frame(), "rgb/0.png: has 4x4 pixels, the camera 8x6");
  write("rgb/0.png", good_color);

  write("depth/0.png", image::encode_png(image::ColorImage(kWidth, kHeight)));
  EXPECT_ERROR(first_frame(), "depth/0.png: is an 8-bit RGB picture; a depth image must be");
  write("depth/0.png", image::encode_png(image::DepthImage(4, 4)));
  EXPECT_ERROR(first_frame(), place("depth.txt", 2));
  EXPECT_ERROR(first_frame(), "depth/0.png: has 4x4 pixels, its colour image 8x6");
  write("depth/0.png", std::span(good_depth).first(good_depth.size() - 1));
  EXPECT_ERROR(first_frame(), "depth/0.png: is a truncated or damaged PNG");
}

// A killed recorder leaves a last line that is torn anywhere.
TEST_F(TumFolder, LeavesOutATornLastLine) {
  const std::string whole = "0.000 rgb/0.png\n0.033 rgb/1.jpg\n";
  const std::string last = "0.066 rgb/2.png\n";
  for (std::size_t size = 0; size <= last.size(); ++size) {
    write("rgb.txt", whole + last.substr(0, size));
    const auto colors = ImageList::open(folder_.path(), "rgb.txt");
    ASSERT_OK(colors);
    const bool has_last = size + 1 >= last.size();  // only the line end is missing, or nothing
    EXPECT_EQ(colors->size(), has_last ? 3U : 2U) << size;
  }
}

TEST(TumRecordingOfRealData, HasAsManyPairsAsTheToolOfTumFinds) {
  const auto rpy = find_data("rgbd_dataset_freiburg1_rpy");
  const auto walk = find_data("office_walk");
  const auto desk = find_data("tum_fr1_desk_9frames");
  ROOMWISE_REQUIRE_FILE(rpy && walk && desk);
  RecordingOptions fr1;
  fr1.camera = geometry::camera_preset("fr1").value();
  EXPECT_EQ(TumRecording::open(*rpy, fr1).value()->info().frames_remaining, 694U);
  EXPECT_EQ(TumRecording::open(*walk).value()->info().frames_remaining, 373U);
  EXPECT_EQ(TumRecording::open(*desk, fr1).value()->info().frames_remaining, 9U);
  EXPECT_ERROR(TumRecording::open(*desk), "has no camera.txt");
}

TEST(TumRecordingOfRealData, GivesUntouchedTumImages) {
  const auto desk = find_data("tum_fr1_desk_9frames");
  ROOMWISE_REQUIRE_FILE(desk);
  RecordingOptions fr1;
  fr1.camera = geometry::camera_preset("fr1").value();
  auto recording = TumRecording::open(*desk, fr1);
  ASSERT_OK(recording);
  for (std::uint64_t i = 0; i < 9; ++i) {
    auto frame = (*recording)->next();
    ASSERT_OK(frame);
    ASSERT_TRUE(frame->has_value());
    EXPECT_EQ((*frame)->index, i);
    const double centre_m = image::depth_m((*frame)->depth, (*recording)->info().camera, 320, 300);
    EXPECT_TRUE(centre_m == 0 || (centre_m > 0.3 && centre_m < 5)) << centre_m;
  }
  EXPECT_FALSE((*recording)->next()->has_value());
}

}  // namespace
}  // namespace roomwise::recording
