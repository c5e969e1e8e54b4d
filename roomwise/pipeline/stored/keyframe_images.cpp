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

}  // namespace roomwise::pipeline
