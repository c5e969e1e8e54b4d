#include "roomwise/pipeline/stored/keyframe_images.h"

#include "roomwise/image/codec.h"

namespace roomwise::pipeline {

namespace {

template <typename Image>
Expected<Image> of_camera(Image image, std::string_view what,
                          const geometry::PinholeCamera& camera) {
  if (image.width() == camera.width && image.height() == camera.height) return image;
  return fail("the {} image is {}x{}, its camera takes {}x{}", what, image.width(), image.height(),
              camera.width, camera.height);
}

}  // namespace

Expected<image::DepthImage> decode_depth(const Bytes& depth,
                                         const geometry::PinholeCamera& camera) {
  ROOMWISE_TRY(image::DepthImage decoded, image::decode_depth(depth));
  return of_camera(std::move(decoded), "depth", camera);
}

Expected<DecodedImages> decode(const home::KeyframeImages& images,
                               const geometry::PinholeCamera& camera) {
  ROOMWISE_TRY(image::ColorImage decoded, image::decode_color(images.color));
  ROOMWISE_TRY(image::ColorImage color, of_camera(std::move(decoded), "colour", camera));
  ROOMWISE_TRY(image::DepthImage depth, decode_depth(images.depth, camera));
  return DecodedImages{std::move(color), std::move(depth)};
}

DecodedImages blank(const geometry::PinholeCamera& camera) {
  return {image::ColorImage(camera.width, camera.height),
          image::DepthImage(camera.width, camera.height)};
}

Expected<std::map<home::RecordingId, geometry::PinholeCamera>> recording_cameras(
    const home::Home& home) {
  ROOMWISE_TRY(const auto recordings, home.recordings());
  std::map<home::RecordingId, geometry::PinholeCamera> cameras;
  for (const home::StoredRecording& stored : recordings) {
    cameras.emplace(stored.id, stored.recording.camera);
  }
  return cameras;
}

Expected<std::vector<home::Keyframe>> map_keyframes(const home::Home& home) {
  ROOMWISE_TRY(auto keyframes, home.keyframes());
  std::erase_if(keyframes,
                [](const home::Keyframe& keyframe) { return keyframe.pose.component != 0; });
  return keyframes;
}

Expected<std::vector<WalkedFrame>> walked_frames(const home::Home& home,
                                                 std::optional<home::RecordingId> walk) {
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  ROOMWISE_TRY(const auto recordings, home.recordings());
  std::vector<WalkedFrame> walked;
  for (const home::StoredRecording& recording : recordings) {
    if (walk && recording.id != *walk) continue;
    ROOMWISE_TRY(const auto frames, home.frames(recording.id));
    for (const home::Frame& one : frames) {
      if (!one.place || one.place->keyframe >= keyframes.size()) continue;
      const home::KeyframePose& pose = keyframes[one.place->keyframe].pose;
      if (pose.component != 0) continue;
      walked.push_back({recording.id, one.index, one.timestamp_ns,
                        pose.world_from_keyframe * one.place->keyframe_from_camera.translation});
    }
  }
  return walked;
}

}  // namespace roomwise::pipeline
