#include "roomwise/recording/phone/phone_recording.h"

#include <algorithm>

#include "roomwise/image/codec.h"
#include "roomwise/recording/phone/one_camera.h"

namespace roomwise::recording {
namespace {

using geometry::PinholeCamera;

constexpr int kMaxSide_px = 640;
constexpr int kResampledJpegQuality = 95;

Expected<image::ColorImage> read_color_of(const PhoneListing& listing, std::size_t place) {
  if (listing.read_color) return listing.read_color(place);
  return image::read_color(listing.pictures[place].color);
}

// The first that can be read; the first's error where none can.
Expected<image::ColorImage> any_color_of(const PhoneListing& listing) {
  auto first = read_color_of(listing, 0);
  for (std::size_t i = 1; !first && i < listing.pictures.size(); ++i) {
    if (auto other = read_color_of(listing, i)) return other;
  }
  return first;
}

// The cameras of a phone are of its pictures' size, which only the pictures say.
Expected<void> give_size(PhoneListing& listing) {
  ROOMWISE_TRY(const auto first, any_color_of(listing));
  for (PhonePicture& picture : listing.pictures) {
    PinholeCamera& camera = picture.camera;
    if (camera.width == 0) camera.width = first.width();
    if (camera.height == 0) camera.height = first.height();
    if (const auto valid = camera.validate(); !valid) {
      return fail("{}: its camera: {}", picture.color.string(), valid.error().message);
    }
    if (camera.width != first.width() || camera.height != first.height()) {
      return fail("{}: its camera is of {}x{} pixels, but the pictures have {}x{}",
                  picture.color.string(), camera.width, camera.height, first.width(),
                  first.height());
    }
  }
  return {};
}

Expected<std::vector<RecordedPicture>> listed(const std::vector<PhonePicture>& pictures) {
  std::vector<RecordedPicture> all;
  for (const PhonePicture& one : pictures) {
    if (!all.empty() && one.timestamp_ns <= all.back().timestamp_ns) {
      return fail("{}: its time {} s is not after that of the picture before, {} s",
                  one.color.string(), format_timestamp(one.timestamp_ns),
                  format_timestamp(all.back().timestamp_ns));
    }
    all.push_back({one.index, one.timestamp_ns, !one.depth.empty()});
  }
  return all;
}

}  // namespace

Expected<std::unique_ptr<Recording>> PhoneRecording::open(PhoneListing listing,
                                                          const RecordingOptions& options) {
  RecordingContents contents;
  contents.kind = listing.kind;
  contents.info.name = listing.name;
  if (listing.pictures.empty()) {
    return fail("{}: holds no picture of which all is there", listing.name);
  }
  ROOMWISE_TRY(contents.pictures, listed(listing.pictures));
  if (std::ranges::none_of(contents.pictures, &RecordedPicture::has_depth)) {
    return fail("{}: no picture has a depth image; was it recorded without a LiDAR?", listing.name);
  }
  ROOMWISE_CHECK_OK(give_size(listing));
  std::vector<PinholeCamera> cameras;
  for (const PhonePicture& picture : listing.pictures) cameras.push_back(picture.camera);
  contents.info.camera = common_camera(cameras, kMaxSide_px);
  if (options.camera && *options.camera != contents.info.camera) {
    return fail("{}: says itself which camera took it; leave the other camera out", listing.name);
  }
  contents.device_poses = std::move(listing.device_poses);
  contents.poses_are_motion = listing.poses_are_motion;
  contents.device_up = listing.device_up;
  return std::unique_ptr<Recording>(new PhoneRecording(std::move(contents), std::move(listing)));
}

const PhonePicture& PhoneRecording::original(const RecordedPicture& picture) const {
  return *std::ranges::lower_bound(listing_.pictures, picture.index, {}, &PhonePicture::index);
}

PinholeCamera PhoneRecording::original_camera(const RecordedPicture& picture) const {
  return original(picture).camera;
}

std::string PhoneRecording::describe(const RecordedPicture& picture) const {
  const std::string file = original(picture).color.string();
  return listing_.read_color ? fmt::format("{}: picture {}", file, picture.index) : file;
}

Expected<image::ColorImage> PhoneRecording::read_original(const PhonePicture& picture) const {
  return read_color_of(listing_, static_cast<std::size_t>(&picture - listing_.pictures.data()));
}

Expected<Bytes> PhoneRecording::read_encoded(const PhonePicture& picture) const {
  ROOMWISE_TRY(const auto color, read_original(picture));
  if (color.width() != picture.camera.width || color.height() != picture.camera.height) {
    return fail("{}: has {}x{} pixels, the recording's first picture {}x{}", picture.color.string(),
                color.width(), color.height(), picture.camera.width, picture.camera.height);
  }
  return image::encode_jpeg(as_seen_by(color, picture.camera, info().camera),
                            kResampledJpegQuality);
}

Expected<image::DepthImage> PhoneRecording::read_depth(const PhonePicture& picture) const {
  ROOMWISE_TRY(image::DepthImage depth, image::read_depth(picture.depth));
  if (listing_.no_depth != 0) std::ranges::replace(depth.pixels(), listing_.no_depth, 0);
  const PinholeCamera from =
      listing_.depth_camera.value_or(depth_camera(picture.camera, depth.width(), depth.height()));
  if (from.width != depth.width() || from.height != depth.height()) {
    return fail("{}: has {}x{} pixels, expected {}x{}", picture.depth.string(), depth.width(),
                depth.height(), from.width, from.height);
  }
  return as_seen_by(depth, from, info().camera);
}

Expected<image::ColorImage> PhoneRecording::read_picture(const RecordedPicture& picture) const {
  ROOMWISE_TRY(const Bytes encoded, read_encoded(original(picture)));
  return image::decode_color(encoded);
}

Expected<Bytes> PhoneRecording::read_picture_file(const RecordedPicture& picture) const {
  return read_encoded(original(picture));
}

Expected<image::RgbdFrame> PhoneRecording::read_frame(const RecordedPicture& picture) const {
  image::RgbdFrame frame;
  frame.index = picture.index;
  frame.timestamp_ns = picture.timestamp_ns;
  ROOMWISE_TRY(frame.encoded_color, read_encoded(original(picture)));
  // As a resumed run will find it.
  ROOMWISE_TRY(frame.color, image::decode_color(frame.encoded_color));
  ROOMWISE_TRY(frame.depth, read_depth(original(picture)));
  frame.encoded_depth = image::encode_png(frame.depth);
  return frame;
}

}  // namespace roomwise::recording
