// Where was the camera in frame 10 of a recording, seen from frame 0?
//   1_locate_a_frame RECORDING [CAMERA]      CAMERA: fr1, fr2, fr3, kinect-v1, xtion or a
//   camera.txt

#include <fmt/format.h>

#include "roomwise/image/resample.h"
#include "roomwise/motion/motion_estimator.h"
#include "roomwise/recording/camera_file.h"
#include "roomwise/recording/open_recording.h"

using namespace roomwise;

static Expected<motion::MotionOutcome> locate(const std::string& folder,
                                              const std::string& camera_name) {
  recording::RecordingOptions options;
  if (!camera_name.empty()) {
    ROOMWISE_TRY(options.camera, recording::resolve_camera(camera_name));
  }
  ROOMWISE_TRY(const auto source, recording::open_recording(folder, options));
  const geometry::PinholeCamera& camera = source->info().camera;
  const auto surf = features::make_extractor(features::FeatureKind::kSurf, 1000);

  const auto next_features = [&]() -> Expected<motion::MeasuredFeatures> {
    ROOMWISE_TRY(const auto frame, source->next());
    if (!frame) return fail("{}: has fewer frames than that", folder);
    return motion::measure_features(surf->extract(image::to_gray(frame->color)), frame->depth,
                                    camera);
  };
  ROOMWISE_TRY(const motion::MeasuredFeatures reference, next_features());
  source->skip_before(10);
  ROOMWISE_TRY(const motion::MeasuredFeatures current, next_features());
  return motion::estimate_motion(reference, current, camera, {}, RandomStream(1));
}

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: {} RECORDING [CAMERA]\n", argv[0]);
    return 2;
  }
  const auto outcome = locate(argv[1], argc > 2 ? argv[2] : "");
  if (!outcome) {
    fmt::print(stderr, "{}\n", outcome.error().message);
    return 1;
  }
  fmt::print("{}\n", outcome->describe());
  if (outcome->found()) {
    const geometry::RigidTransform& reference_from_current = outcome->pose.reference_from_current;
    fmt::print("the camera moved {:.3f} m and turned {:.1f} degrees\n",
               reference_from_current.distance_m(),
               reference_from_current.angle_rad() * 180 / EIGEN_PI);
  }
  return 0;
}
