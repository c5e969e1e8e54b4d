// Digests of what mapping makes of a recording, a stage each, so that two machines that differ say
// where it begins:
//   path_digest RECORDING CAMERA [FRAMES]      a TUM folder; CAMERA: fr1, ... or a camera.txt
#include <cstdio>
#include <cstring>

#include "arguments.h"
#include "roomwise/base/file.h"
#include "roomwise/features/feature_extractor.h"
#include "roomwise/image/resample.h"
#include "roomwise/mapping/backend/map_solver.h"
#include "roomwise/mapping/frontend/mapper.h"
#include "roomwise/recording/camera_file.h"
#include "roomwise/recording/tum_recording.h"

namespace roomwise::bench {
namespace {

constexpr const char* kUsage = "path_digest RECORDING CAMERA [FRAMES]";
constexpr int kKeypoints = 1000;

// The bits of numbers, one after the other.
class Bits {
 public:
  template <typename Number>
  void add(const Number* numbers, std::size_t count) {
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(numbers);
    bytes_.insert(bytes_.end(), bytes, bytes + count * sizeof(Number));
  }
  void add(const geometry::RigidTransform& pose) {
    add(pose.rotation.coeffs().data(), 4);
    add(pose.translation.data(), 3);
  }
  void print(const char* stage) const {
    std::printf("%-22s %9zu bytes  %s\n", stage, bytes_.size(), sha256_hex(bytes_).c_str());
  }

 private:
  std::vector<std::uint8_t> bytes_;
};

struct Digests {
  Bits pictures, keypoints, angles, descriptors, points, views, places, edges, information,
      keyframes;
};

void add_measurements(const motion::MeasuredFeatures& found, const motion::RgbdPyramid& view,
                      Digests& digests) {
  for (const features::Keypoint& keypoint : found.features.keypoints) {
    digests.keypoints.add(keypoint.position_px.data(), 2);
    digests.keypoints.add(&keypoint.size_px, 1);
    digests.keypoints.add(&keypoint.response, 1);
    digests.angles.add(&keypoint.angle_rad, 1);
  }
  const auto& rows = std::get<features::FloatDescriptors>(found.features.descriptors);
  digests.descriptors.add(rows.data(), static_cast<std::size_t>(rows.size()));
  for (std::size_t i = 0; i < found.size(); ++i) {
    digests.points.add(found.pixels[i].data(), 2);
    digests.points.add(found.points[i].data(), 3);
  }
  for (const motion::PyramidLevel& level : view.levels) {
    digests.views.add(level.gray.pixels().data(), level.gray.pixels().size());
    digests.views.add(level.depth.pixels().data(), level.depth.pixels().size());
  }
}

Expected<void> add_map(mapping::Mapper& mapper, Digests& digests) {
  for (const scene::Frame& frame : mapper.frames()) {
    if (frame.place) digests.places.add(frame.place->keyframe_from_camera);
  }
  for (const scene::PoseGraphEdge& edge : mapper.edges()) {
    digests.edges.add(edge.from_from_to);
    digests.information.add(edge.information.data(), 36);
  }
  const std::size_t keyframes = mapper.keyframes().size();
  ROOMWISE_TRY(const mapping::MapSolution solution, mapping::solve_map(keyframes, mapper.edges()));
  for (const geometry::RigidTransform& pose : solution.world_from_keyframe)
    digests.keyframes.add(pose);
  std::printf("%zu frames, %zu key-frames, %zu edges\n", mapper.frames().size(), keyframes,
              mapper.edges().size());
  return {};
}

Expected<void> digest(int argc, char** argv) {
  if (argc < 3 || argc > 4) return fail("usage: {}", kUsage);
  ROOMWISE_TRY(const int frames, argc == 4 ? parse_count(argv[3], kUsage) : Expected<int>(1 << 30));
  recording::RecordingOptions options;
  ROOMWISE_TRY(options.camera, recording::resolve_camera(argv[2]));
  ROOMWISE_TRY(const auto source, recording::TumRecording::open(argv[1], options));
  const geometry::PinholeCamera& camera = source->info().camera;
  const auto extractor = features::make_extractor(features::FeatureKind::kSurf, kKeypoints);
  mapping::Mapper mapper(camera, {});
  Digests digests;
  for (int i = 0; i < frames; ++i) {
    ROOMWISE_TRY(const auto frame, source->next());
    if (!frame) break;
    const image::GrayImage gray = image::to_gray(frame->color);
    digests.pictures.add(gray.pixels().data(), gray.pixels().size());
    auto found = motion::measure_features(extractor->extract(gray), frame->depth, camera);
    auto view = motion::make_rgbd_pyramid(gray, frame->depth, camera);
    add_measurements(found, view, digests);
    ROOMWISE_RETURN_IF_ERROR(
        mapper.add_frame(frame->index, frame->timestamp_ns, {std::move(found), std::move(view)}));
  }
  ROOMWISE_RETURN_IF_ERROR(add_map(mapper, digests));
  digests.pictures.print("pictures, decoded");
  digests.keypoints.print("key-points");
  digests.angles.print("angles of key-points");
  digests.descriptors.print("descriptors");
  digests.points.print("points of features");
  digests.views.print("views");
  digests.places.print("places of frames");
  digests.edges.print("edges");
  digests.information.print("information of edges");
  digests.keyframes.print("poses of key-frames");
  return {};
}

}  // namespace
}  // namespace roomwise::bench

int main(int argc, char** argv) {
  const auto done = roomwise::bench::digest(argc, argv);
  if (!done) std::fprintf(stderr, "path_digest: %s\n", done.error().message.c_str());
  return done ? 0 : 1;
}
