#include "roomwise/live/device/frame_processor.h"

#include <gmock/gmock.h>

#include <numbers>

#include "roomwise/base/testing/testing.h"
#include "roomwise/image/codec.h"
#include "roomwise/pipeline/mapping/map_recording.h"
#include "roomwise/pipeline/rooms/room_learning.h"
#include "roomwise/pipeline/testing/synthetic_walk.h"

namespace roomwise::live {
namespace {

TEST(CameraPose, TheHeadingIsThatOfTheOpticalAxis) {
  // A camera that looks along y: its z is the level's y, its y points down.
  Eigen::Matrix3d plan_from_camera;
  plan_from_camera << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  CameraPose place;
  place.plan_from_camera = {Eigen::Quaterniond(plan_from_camera), {1, 2, 1.3}};
  EXPECT_NEAR(place.heading_rad(), std::numbers::pi / 2, 1e-12);
}

// ---- an eye on a home without rooms and without a map ----

service::DeviceCamera camera(bool has_depth) {
  geometry::PinholeCamera pinhole = *geometry::camera_preset("fr1");
  pinhole.width = 8;
  pinhole.height = 6;
  return {8, 6, pinhole, has_depth};
}
CameraFrame frame(double t_ms, Bytes depth = {}) {
  return {t_ms, image::encode_jpeg(image::ColorImage(8, 6), 90), std::move(depth)};
}

TEST(FrameProcessor, SaysNothingOfAHomeThatLearnedNothing) {
  FrameProcessor eye(camera(false));
  const auto result = eye.look(frame(5), std::make_shared<HomeView>());
  ASSERT_OK(result);
  EXPECT_EQ(result->t_ms, 5);
  EXPECT_FALSE(result->decision);
  EXPECT_FALSE(result->place);
  EXPECT_FALSE(result->picture.empty());
}

// Who is told two steps unseen needs more room than who is told of an obstacle.
TEST(FrameProcessor, TellsOfWhatDepthShowsBeyondTheNextStep) {
  service::DeviceCamera looks = camera(true);
  looks.calibrated->fx = looks.calibrated->fy = 8;
  looks.calibrated->cx = 4;
  looks.calibrated->cy = 3;
  looks.calibrated->depth_units_per_metre = 1000;
  FrameProcessor eye(looks);
  const auto look = [&](std::uint16_t depth_mm) {
    const image::DepthImage depth(8, 6, depth_mm);
    return eye.look(frame(depth_mm, image::encode_png(depth)), std::make_shared<HomeView>())
        .value();
  };
  const FrameResult beyond = look(1100);
  EXPECT_FALSE(beyond.obstacle);
  EXPECT_NEAR(beyond.seen_ahead_m.value_or(0), 1.1, 0.01);
  const FrameResult near = look(800);
  EXPECT_TRUE(near.obstacle);
  EXPECT_NEAR(near.seen_ahead_m.value_or(0), 0.8, 0.01);
  EXPECT_FALSE(look(3000).seen_ahead_m);
}

TEST(FrameProcessor, RefusesPicturesThatAreNotTheCameras) {
  const auto home = std::make_shared<HomeView>();
  EXPECT_ERROR(FrameProcessor(std::nullopt).look(frame(1), home), "no camera");
  FrameProcessor eye(camera(true));
  CameraFrame other = frame(1);
  other.color = image::encode_jpeg(image::ColorImage(9, 6), 90);
  EXPECT_ERROR(eye.look(other, home), "8 x 6");
  other.color = image::encode_jpeg(image::ColorImage(800, 600), 90);
  EXPECT_ERROR(eye.look(other, home), "more than the 96");
  other.color = {1, 2, 3};
  EXPECT_ERROR(eye.look(other, home), "neither a JPEG");
  EXPECT_ERROR(eye.look(frame(2, image::encode_png(image::DepthImage(7, 6))), home), "depth image");
  EXPECT_OK(eye.look(frame(3, image::encode_png(image::DepthImage(8, 6))), home));
  FrameProcessor without_depth(camera(false));
  EXPECT_ERROR(without_depth.look(frame(4, image::encode_png(image::DepthImage(8, 6))), home),
               "without depth");
}

// ---- an eye on a home whose two rooms look alike ----

// A mapped walk whose frames were named hall and kitchen in turn, so that no picture tells which it
// is; where the rooms lie is made up by each test.
class EyeWithPlaces : public ::testing::Test {
 protected:
  static constexpr int kFrames = 60;

  static void SetUpTestSuite() {
    folder_ = std::make_unique<testing::ScratchFolder>();
    ThreadPool pool(2);
    SilentProgress progress;
    StageClock clock;
    pipeline::RunContext run{pool, progress, clock};
    pipeline::testing::SyntheticWalk walk(kFrames);
    home::Home home = pipeline::create_home(*folder_ / "a.home").value();
    networks_.push_back(std::make_unique<pipeline::testing::ColorNetwork>());
    ASSERT_OK(pipeline::map_recording(
        walk, {"walk", "made up", walk.info().camera, walk.info().frames_remaining}, home,
        networks_, {}, run));
    std::vector<recording::RoomRange> ranges;
    for (std::uint64_t first = 0; first < kFrames; first += 2) {
      const int visit = static_cast<int>(first / 4) + 1;
      ranges.push_back({first, first + 1, first % 4 == 0 ? "hall" : "kitchen", visit});
    }
    ASSERT_OK(pipeline::name_rooms(home, 1, *recording::RoomLabels::from_ranges(ranges)));
    ASSERT_OK(pipeline::learn_rooms_from_keyframes(home, {}, {}, {}, run));
    auto localizer = pipeline::HomeLocalizer::create(home, {}, run);
    ASSERT_OK(localizer);
    auto map = std::make_shared<LiveMap>();
    map->localizer = std::make_shared<const pipeline::HomeLocalizer>(*std::move(localizer));
    auto view = view_home(home, networks_, map);
    ASSERT_OK(view);
    ASSERT_TRUE((*view)->recognizer) << (*view)->why_no_recognizer;
    view_ = *view;
  }
  static void TearDownTestSuite() {
    view_.reset();
    networks_.clear();
    folder_.reset();
  }

  // The home where all floor around the walk is that of one room.
  static std::shared_ptr<const HomeView> home_all_of(const std::string& room) {
    constexpr double kHalf_m = 4;
    const image::Image<fusion::FloorCell> cells(80, 80, fusion::FloorCell::kFree);
    const fusion::FloorGrid grid(Eigen::Vector2d::Constant(-kHalf_m), 0.1, cells);
    rooms::WalkedPath path;
    for (double x_m = -3; x_m < 3; x_m += 0.1) path.push_back({{x_m, 0}, room});
    auto view = std::make_shared<HomeView>(*view_);
    view->layout = rooms::RoomLayout::make(grid, std::span(&path, 1)).value();
    return view;
  }
  static image::RgbdFrame seen(std::uint64_t index) {
    pipeline::testing::SyntheticWalk walk(kFrames);
    walk.skip_before(index);
    return walk.next().value().value();
  }
  static CameraFrame message(const image::RgbdFrame& frame) {
    return {static_cast<double>(frame.timestamp_ns) / 1e6, image::encode_jpeg(frame.color, 95),
            image::encode_png(frame.depth)};
  }
  static FrameProcessor eye() {
    const geometry::PinholeCamera camera = pipeline::testing::SyntheticWalk(1).info().camera;
    return FrameProcessor(service::DeviceCamera{camera.width, camera.height, camera, true});
  }

  inline static std::unique_ptr<testing::ScratchFolder> folder_;
  inline static pipeline::Networks networks_;
  inline static std::shared_ptr<const HomeView> view_;
};

// A phone tells the size of its pictures and no more.
TEST_F(EyeWithPlaces, APhoneThatNobodyCalibratedHasAPlaceToo) {
  const geometry::PinholeCamera camera = pipeline::testing::SyntheticWalk(1).info().camera;
  FrameProcessor looking(service::DeviceCamera{camera.width, camera.height});
  std::optional<CameraPose> place;
  std::optional<mapping::LensCalibration> lens;
  for (std::uint64_t index = 3; index < kFrames; index += 6) {
    CameraFrame picture = message(seen(index));
    picture.depth.clear();
    const auto result = looking.look(picture, home_all_of("hall"));
    ASSERT_OK(result);
    if (result->place) place = result->place;
    if (result->lens) lens = result->lens;
  }
  ASSERT_TRUE(place);
  EXPECT_EQ(place->room, "hall");
  ASSERT_TRUE(lens);
  const double focal_px = lens->known().camera(camera.width, camera.height).fx;
  EXPECT_NEAR(focal_px / camera.fx, 1, 0.05);
}

TEST_F(EyeWithPlaces, ThePlaceDecidesWhereThePictureLeavesRoomsOpen) {
  for (const std::string room : {"hall", "kitchen"}) {
    FrameProcessor looking = eye();
    const auto result = looking.look(message(seen(21)), home_all_of(room));
    ASSERT_OK(result);
    ASSERT_TRUE(result->place);
    EXPECT_EQ(result->place->room, room);
    ASSERT_TRUE(result->decision);
    EXPECT_EQ(result->decision->room(), room) << result->decision->why;
    EXPECT_THAT(result->decision->why, ::testing::HasSubstr("its place on the map is in " + room));
    EXPECT_FALSE(result->more_to_see) << "there is nothing to find out by turning";
  }
}

// Without a map. Of the hall, which lies between the others, more is believed after a while.
std::shared_ptr<const HomeView> hall_between_others(const std::filesystem::path& mapped,
                                                    const pipeline::Networks& networks) {
  const testing::ScratchFolder folder;
  std::filesystem::copy_file(mapped, folder / "b.home");
  home::Home home = home::Home::open(folder / "b.home").value();
  std::vector<recording::RoomRange> ranges;
  const std::array<std::string, 4> names{"hall", "kitchen", "hall", "bath"};
  for (std::uint64_t first = 0; first < 60; first += 2) {
    ranges.push_back({first, first + 1, names.at(first / 2 % 4), static_cast<int>(first / 2) + 1});
  }
  EXPECT_OK(pipeline::name_rooms(home, 1, *recording::RoomLabels::from_ranges(ranges)));
  ThreadPool pool(2);
  SilentProgress progress;
  StageClock clock;
  pipeline::RunContext run{pool, progress, clock};
  EXPECT_OK(pipeline::learn_rooms_from_keyframes(home, {}, {}, {}, run));
  return view_home(home, networks, nullptr).value();
}
double believed_of_hall(const FrameResult& result) {
  return std::ranges::find(result.decision->rooms, "hall", &rooms::RoomScore::room)->score;
}

// A device's clock began with the device.
TEST_F(EyeWithPlaces, TimeCountsFromTheFirstPictureByTheClockThatTellsOfMore) {
  const auto view = hall_between_others(*folder_ / "a.home", networks_);
  ASSERT_TRUE(view->recognizer) << view->why_no_recognizer;
  const auto first_at = [&](double t_ms) {
    CameraFrame picture = message(seen(21));
    picture.t_ms = t_ms;
    return believed_of_hall(eye().look(picture, view).value());
  };
  EXPECT_NEAR(first_at(0), first_at(50'000), 1e-9);
  const auto second_at = [&](double t_ms, double came_s) {
    FrameProcessor looking = eye();
    CameraFrame picture = message(seen(21));
    picture.t_ms = 500;
    EXPECT_OK(looking.look(picture, view));
    picture.t_ms = t_ms;
    picture.came_s = came_s;
    return believed_of_hall(looking.look(picture, view).value());
  };
  const double after_half_a_minute = second_at(30'500, 0);
  EXPECT_GT(std::abs(after_half_a_minute - second_at(500, 0)), 1e-6);
  EXPECT_NEAR(second_at(500, 30), after_half_a_minute, 1e-9) << "a clock that stands";
  EXPECT_NEAR(second_at(501, 30), after_half_a_minute, 1e-9) << "that is too coarse";
  EXPECT_NEAR(second_at(-1e6, 30), after_half_a_minute, 1e-9) << "that went back";
}

// Something new stands before the camera, and then hides what the map knows of.
TEST_F(EyeWithPlaces, APictureThatAloneHasNoPlaceIsFollowedFromTheOneBefore) {
  image::RgbdFrame first = seen(21);
  RandomStream random(1);
  const int middle = first.color.width() / 2;
  for (int y = 0; y < first.color.height(); ++y) {
    for (int x = 0; x < middle; ++x) {
      const auto level = static_cast<std::uint8_t>((x / 6 + y / 6) % 2 * 200 + random.index(40));
      first.color.at(x, y) = {level, static_cast<std::uint8_t>(random.index(255)), level};
    }
  }
  image::RgbdFrame second = first;
  for (int y = 0; y < second.color.height(); ++y) {
    for (int x = middle; x < second.color.width(); ++x) {
      second.color.at(x, y) = {};
      second.depth.at(x, y) = 0;
    }
  }
  CameraFrame before = message(first), after = message(second);
  FrameProcessor alone = eye();
  EXPECT_FALSE(alone.look(after, home_all_of("hall")).value().place);
  FrameProcessor follows = eye();
  const auto placed = follows.look(before, home_all_of("hall"));
  ASSERT_OK(placed);
  ASSERT_TRUE(placed->place);
  after.t_ms = before.t_ms + 500;
  const auto followed = follows.look(after, home_all_of("hall"));
  ASSERT_OK(followed);
  ASSERT_TRUE(followed->place);
  EXPECT_LT((followed->place->position_plan() - placed->place->position_plan()).norm(), 0.05);
  // Not over a gap in which anything may have happened.
  after.t_ms += 10'000;
  EXPECT_FALSE(follows.look(after, home_all_of("hall")).value().place);
}

TEST_F(EyeWithPlaces, WithoutALayoutThePlaceTellsNoRoom) {
  FrameProcessor looking = eye();
  auto view = std::make_shared<HomeView>(*view_);
  view->layout.reset();
  const auto result = looking.look(message(seen(21)), view);
  ASSERT_OK(result);
  ASSERT_TRUE(result->place);
  EXPECT_EQ(result->place->room, std::nullopt);
  EXPECT_EQ(result->decision->verdict, rooms::Verdict::kEither);
  EXPECT_THAT(result->decision->why, ::testing::HasSubstr("the map has no rooms"));
}

TEST_F(EyeWithPlaces, APictureThatFitsNowhereIsNotNamedByARoomOfTheMap) {
  image::RgbdFrame elsewhere = seen(21);
  RandomStream random(1);
  for (int y = 0; y < elsewhere.color.height(); ++y) {
    for (int x = 0; x < elsewhere.color.width(); ++x) {
      const auto level = static_cast<std::uint8_t>(random.uniform() * 255);
      elsewhere.color.at(x, y) = {level, level, level};
      elsewhere.depth.at(x, y) = static_cast<std::uint16_t>(1000 + random.uniform() * 2000);
    }
  }
  FrameProcessor looking = eye();
  const auto result = looking.look(message(elsewhere), home_all_of("hall"));
  ASSERT_OK(result);
  EXPECT_FALSE(result->place);
  EXPECT_NE(result->decision->verdict, rooms::Verdict::kRoom);
  EXPECT_THAT(result->decision->why, ::testing::HasSubstr("no place on the map"));
}

}  // namespace
}  // namespace roomwise::live
