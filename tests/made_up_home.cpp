#include "made_up_home.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "roomwise/fusion/testing/test_scenes.h"
#include "roomwise/home/home.h"
#include "roomwise/image/codec.h"
#include "roomwise/image/exif.h"
#include "roomwise/image/testing/exif_writer.h"

namespace roomwise::testing {
namespace {

using Eigen::Vector3d;
using fusion::testing::looking_at;
using geometry::RigidTransform;

// The truth's frame: z up, the floor at 0. The map's is the first camera's.
struct Taken {
  RigidTransform truth_from_camera;
  std::uint64_t component = 0;
  std::string room;
};

const Vector3d kSofaLow(0.1, 0.4, 0), kSofaHigh(0.8, 1.6, 0.7);
const Vector3d kTableLow(2.2, 4.6, 0), kTableHigh(2.9, 5.4, 0.8);

fusion::testing::Scene flat() {
  using fusion::testing::box;
  using fusion::testing::half_space;
  return {half_space(Vector3d::UnitZ(), 0),
          half_space(Vector3d::UnitX(), 0),
          half_space(-Vector3d::UnitX(), -3),
          half_space(Vector3d::UnitY(), 0),
          half_space(-Vector3d::UnitY(), -6.1),
          box({-0.1, 3, -0.1}, {1, 3.1, 2.6}),
          box({1.9, 3, -0.1}, {3.1, 3.1, 2.6}),
          box(kSofaLow, kSofaHigh),
          box(kTableLow, kTableHigh)};
}

// The colour of a place, from it alone and without steps, so that it is the same from everywhere.
Rgb8 color_at(const Vector3d& place) {
  const auto wave = [](double phase) {
    return static_cast<std::uint8_t>(std::lround(128 + 100 * std::sin(phase)));
  };
  return {wave(4 * place.x() + 1.3 * place.z()), wave(4 * place.y() + 0.7 * place.x()),
          wave(4 * place.z() + 0.9 * place.y())};
}

std::vector<Taken> around(const Vector3d& middle, const std::string& room) {
  std::vector<Taken> taken;
  for (int i = 0; i < 12; ++i) {
    const double angle = 0.3 + 2 * std::numbers::pi * i / 12;
    const Vector3d out(std::cos(angle), std::sin(angle), 0);
    taken.push_back({looking_at(middle + 0.2 * out, middle + out - Vector3d(0, 0, 0.8)), 0, room});
  }
  return taken;
}

std::vector<Taken> first_walk() {
  std::vector<Taken> walk = around({1.5, 1.5, 1.4}, kMadeUpLiving);
  for (double y = 1.5; y < 4.6; y += 0.25) {
    walk.push_back({looking_at({1.45, y, 1.4}, {1.45, y + 1, 0.7}), 0,
                    y < 3.05 ? kMadeUpLiving : kMadeUpKitchen});
  }
  for (Taken& one : around({1.5, 4.6, 1.4}, kMadeUpKitchen)) walk.push_back(one);
  return walk;
}

std::vector<Taken> later_walk() {
  std::vector<Taken> walk;
  for (int i = 0; i < 4; ++i) {
    walk.push_back({looking_at({1.8, 0.8 + 0.2 * i, 1.3}, {0.4, 1, 0.4}), 0, kMadeUpLiving});
  }
  walk.push_back({looking_at({1.5, 4.2, 1.2}, {2.6, 5, 0.4}), 1, kMadeUpKitchen});
  walk.push_back({looking_at({1.4, 4.2, 1.2}, {2.6, 5, 0.4}), 1, kMadeUpKitchen});
  return walk;
}

using Encode = Bytes (*)(const image::ColorImage&);

Bytes as_png(const image::ColorImage& color) {
  return image::encode_png(color);
}
Bytes as_jpeg(const image::ColorImage& color) {
  return image::encode_jpeg(color, 98);
}
// As a phone stores it that was held upright: the picture lies, and Exif says how to turn it.
Bytes as_turned_jpeg(const image::ColorImage& color) {
  constexpr int kThreeQuarters = 8;  // undoes what ExifWriter writes
  return image::testing::with_exif(as_jpeg(image::apply_orientation(color, kThreeQuarters)),
                                   image::testing::ExifWriter(true).write({}));
}

home::KeyframeImages images_of(const RigidTransform& truth_from_camera,
                               const geometry::PinholeCamera& camera, bool has_depth,
                               Encode encode) {
  fusion::testing::Picture picture = fusion::testing::render(flat(), truth_from_camera, camera);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const double z_m = picture.depth.at(x, y) / camera.depth_units_per_metre;
      picture.color.at(x, y) = color_at(truth_from_camera * camera.unproject({x, y}, z_m));
    }
  }
  if (!has_depth) picture.depth = image::DepthImage(camera.width, camera.height, 0);
  return {encode(picture.color), image::encode_png(picture.depth)};
}

struct Walk {
  std::string name;
  geometry::PinholeCamera camera;
  std::vector<Taken> taken;
};

Expected<void> add_walk(home::Home& home, const Walk& walk, const RigidTransform& world_from_truth,
                        const MadeUpHome& options) {
  ROOMWISE_TRY(const home::RecordingId id,
               home.add_recording({walk.name, "", walk.camera, walk.taken.size()}));
  ROOMWISE_TRY(const home::KeyframeId first, home.next_keyframe_id());
  home::MapCommit step;
  step.recording = id;
  step.next_frame_index = walk.taken.size();
  std::vector<recording::RoomRange> ranges;
  for (std::size_t i = 0; i < walk.taken.size(); ++i) {
    const Taken& one = walk.taken[i];
    const auto time_ns = (static_cast<TimestampNs>(first + i) + 1'700'000'000) * 1'000'000'000;
    home::NewKeyframe& keyframe = step.keyframes.emplace_back();
    keyframe.id = first + i;
    keyframe.frame_index = i;
    keyframe.timestamp_ns = time_ns;
    keyframe.pose = {world_from_truth * one.truth_from_camera, one.component};
    keyframe.images =
        images_of(one.truth_from_camera, walk.camera, options.has_depth,
                  walk.camera.distortion.is_none() ? (i == 0 ? as_turned_jpeg : as_jpeg) : as_png);
    step.frames.push_back({i, time_ns, home::FramePlace{first + i, {}}, ""});
    if (!ranges.empty() && ranges.back().room == one.room) {
      ranges.back().last_frame = i;
    } else {
      ranges.push_back({i, i, one.room, 1});
    }
  }
  ROOMWISE_RETURN_IF_ERROR(home.commit(step));
  ROOMWISE_RETURN_IF_ERROR(home.finish_recording(id));
  return options.has_rooms ? home.replace_room_ranges(id, ranges) : Expected<void>{};
}

// The box, as the key-frame sees it that was taken there.
objects::Instance thing(const std::string& name, const Vector3d& low, const Vector3d& high,
                        home::KeyframeId keyframe, const RigidTransform& truth_from_keyframe) {
  objects::Instance instance;
  instance.name = name;
  instance.probability = 0.875;
  instance.names = {{name, 0.75}, {"bed", 0.25}};
  instance.observations = 5;
  instance.expected = 6;
  instance.keyframe_id = keyframe;
  instance.picture_box = {10, 20, 100, 90};
  instance.box_keyframe = {
      truth_from_keyframe.inverse() *
          RigidTransform{Eigen::Quaterniond::Identity(), Vector3d((low + high) / 2)},
      high - low};
  instance.sigma_m = {0.05, 0.1, 0.02};
  return instance;
}

}  // namespace

geometry::PinholeCamera made_up_lens_camera() {
  return {130, 131, 80.5, 58.25, 160, 120, {0.12, -0.2, 0.003, -0.002, 0.05}, 5000};
}

geometry::PinholeCamera made_up_phone_camera() {
  return {150, 150, 95, 62, 192, 128, {}, 1000};
}

Expected<void> make_made_up_home(const std::filesystem::path& file, const MadeUpHome& options) {
  ROOMWISE_TRY(home::Home home, home::Home::create(file));
  if (options.has_rooms) {
    ROOMWISE_RETURN_IF_ERROR(home.replace_rooms(
        std::vector<rooms::Room>{{kMadeUpLiving, "living room"}, {kMadeUpKitchen, "kitchen"}}));
  }
  const std::vector<Taken> first = first_walk(), later = later_walk();
  const RigidTransform world_from_truth = first[0].truth_from_camera.inverse();
  ROOMWISE_RETURN_IF_ERROR(
      add_walk(home, {kMadeUpWalk, made_up_lens_camera(), first}, world_from_truth, options));
  ROOMWISE_RETURN_IF_ERROR(
      add_walk(home, {kMadeUpLaterWalk, made_up_phone_camera(), later}, world_from_truth, options));
  if (!options.has_things) return {};
  const std::size_t last = first.size() + later.size() - 1;
  return home.replace_instances(std::vector<objects::Instance>{
      thing("canapé \"3\"", kSofaLow, kSofaHigh, 5, first[5].truth_from_camera),
      thing("table", kTableLow, kTableHigh, first.size() - 1, first.back().truth_from_camera),
      thing("table", kTableLow, kTableHigh, last, later.back().truth_from_camera)});
}

}  // namespace roomwise::testing
