#include "roomwise/recording/phone/phone_recording.h"

#include <algorithm>
#include <array>

#include "roomwise/image/codec.h"
#include "roomwise/recording/personal_files.h"
#include "roomwise/recording/phone/longest_rise.h"
#include "roomwise/recording/phone/one_camera.h"
#include "roomwise/recording/phone/quarter_turn.h"

namespace roomwise::recording {
namespace {

using geometry::PinholeCamera;

constexpr int kMaxSide_px = 640;
constexpr int kResampledJpegQuality = 95;

Expected<image::ColorImage> read_color_of(const PhoneListing& listing,
                                          const PhonePicture& picture) {
  if (listing.read_color) return listing.read_color(picture.place);
  return image::read_color_as_taken(picture.color);
}

// That most of the first few have that can be read; the first's error where none can.
Expected<PictureSize> size_of_pictures(const PhoneListing& listing) {
  constexpr std::size_t kMaxEnough = 5;
  const std::size_t enough = listing.read_color ? 1 : kMaxEnough;  // a video is of one size
  std::vector<PictureSize> sizes;
  std::optional<Error> why;
  for (const PhonePicture& picture : listing.pictures) {
    if (sizes.size() == enough) break;
    const auto color = read_color_of(listing, picture);
    if (color) sizes.emplace_back(color->width(), color->height());
    if (!color && !why) why = color.error();
  }
  if (sizes.empty()) return Unexpected(*std::move(why));
  return sizes[first_of_most(sizes)];
}

Expected<void> check_camera(const PhonePicture& picture, const PictureSize& size) {
  const PinholeCamera& camera = picture.camera;
  if (const auto valid = camera.validate(); !valid) {
    return fail("{}: its camera: {}", picture.color.string(), valid.error().message);
  }
  if (PictureSize(camera.width, camera.height) == size) return {};
  return fail("{}: its camera is of {}x{} pixels, but the pictures have {}x{}",
              picture.color.string(), camera.width, camera.height, size.first, size.second);
}

// Takes the pictures that are damaged out, and gives the cameras, which are of the pictures' size,
// that size: only the pictures say it.
Expected<void> keep_whole_pictures(PhoneListing& listing) {
  ROOMWISE_TRY(const PictureSize size, size_of_pictures(listing));
  const auto time_of = [](const PhonePicture& picture) { return picture.timestamp_ns; };
  keep_longest_rise(listing.pictures, time_of, [&](const PhonePicture& picture) {
    listing.damaged.push_back(
        {picture.index,
         fmt::format("{}: its time {} s does not fit those of the other pictures",
                     picture.color.string(), format_timestamp(picture.timestamp_ns))});
  });
  std::vector<PhonePicture> whole;
  for (PhonePicture& picture : listing.pictures) {
    if (picture.camera.width == 0) picture.camera.width = size.first;
    if (picture.camera.height == 0) picture.camera.height = size.second;
    const auto fine = check_camera(picture, size);
    if (fine) {
      whole.push_back(std::move(picture));
    } else {
      listing.damaged.push_back({picture.index, fine.error().message});
    }
  }
  listing.pictures = std::move(whole);
  std::ranges::sort(listing.damaged, {}, &DamagedFrame::index);
  return {};
}

image::PersonalData facts_of_pictures(const PhoneListing& listing) {
  if (listing.read_color) return {};
  return personal_data_of_some(listing.pictures.size(), [&](std::size_t place) {
    return read_file(listing.pictures[place].color);
  });
}

void note_depth(RecordingContents& contents) {
  const auto without = std::ranges::count(contents.pictures, false, &RecordedPicture::has_depth);
  if (without == 0) return;
  contents.notes.push_back(fmt::format("{} of {} pictures have no depth image: they are no frames",
                                       without, contents.pictures.size()));
}

void note_depth_views(const std::vector<PhonePicture>& pictures, RecordingContents& contents) {
  std::size_t count = 0;
  for (const PhonePicture& picture : pictures) {
    if (!picture.depth.empty()) count += picture.depth_views.size();
  }
  if (count == 0) return;
  contents.notes.push_back(fmt::format(
      "{} depth images between pictures add to the surfaces, where they can be read", count));
}

// How far pictures are turned to stand upright. Camera and poses of `contents` become those of the
// turned pictures.
int turn_upright(const std::optional<Eigen::Vector3d>& device_up, RecordingContents& contents) {
  if (!device_up) return 0;
  const int turns = upright_turns(contents.device_poses, *device_up).value_or(0);
  if (turns == 0) return 0;
  contents.info.camera = turned(contents.info.camera, turns);
  const auto camera_from_turned = turned_from_camera(turns).inverse();
  for (StampedPose& pose : contents.device_poses) {
    pose.world_from_camera = pose.world_from_camera * camera_from_turned;
  }
  constexpr std::array<std::string_view, 4> kHow{"", "by a quarter to the right", "upside down",
                                                 "by a quarter to the left"};
  contents.notes.push_back(fmt::format("the phone was not held level: its pictures are turned {}",
                                       kHow.at(static_cast<std::size_t>(turns))));
  return turns;
}

}  // namespace

Expected<std::unique_ptr<Recording>> PhoneRecording::open(PhoneListing listing,
                                                          const RecordingOptions& options) {
  RecordingContents contents;
  contents.kind = listing.kind;
  contents.info.name = listing.name;
  if (listing.pictures.empty()) return no_whole_frame(listing.name, listing.damaged);
  ROOMWISE_RETURN_IF_ERROR(keep_whole_pictures(listing));
  if (listing.pictures.empty()) return no_whole_frame(listing.name, listing.damaged);
  for (const PhonePicture& one : listing.pictures) {
    contents.pictures.push_back({one.index, one.timestamp_ns, !one.depth.empty()});
  }
  if (std::ranges::none_of(contents.pictures, &RecordedPicture::has_depth)) {
    return fail("{}: no picture has a depth image; was it recorded without a LiDAR?", listing.name);
  }
  std::vector<PinholeCamera> cameras;
  for (const PhonePicture& picture : listing.pictures) cameras.push_back(picture.camera);
  const PinholeCamera common = common_camera(cameras, kMaxSide_px);
  contents.info.camera = common;
  contents.notes = std::move(listing.notes);
  contents.device_poses = std::move(listing.device_poses);
  const int turns = turn_upright(listing.device_up, contents);
  if (options.camera && *options.camera != contents.info.camera) {
    return fail("{}: says itself which camera took it; leave the other camera out", listing.name);
  }
  contents.info.personal_data = listing.personal_data;
  contents.info.personal_data |= facts_of_pictures(listing);
  contents.damaged = listing.damaged;
  note_depth(contents);
  note_depth_views(listing.pictures, contents);
  contents.poses_are_device_motion = listing.poses_are_device_motion;
  contents.device_up = listing.device_up;
  contents.reads_in_order = listing.read_color != nullptr;
  return std::unique_ptr<Recording>(
      new PhoneRecording(std::move(contents), std::move(listing), common, turns));
}

const PhonePicture& PhoneRecording::original(const RecordedPicture& picture) const {
  return *std::ranges::lower_bound(listing_.pictures, picture.index, {}, &PhonePicture::index);
}

PinholeCamera PhoneRecording::original_camera(const RecordedPicture& picture) const {
  return turned(original(picture).camera, turns_);
}

std::string PhoneRecording::describe(const RecordedPicture& picture) const {
  const std::string file = original(picture).color.string();
  return listing_.read_color ? fmt::format("{}: picture {}", file, picture.index) : file;
}

Expected<Bytes> PhoneRecording::read_encoded(const PhonePicture& picture) const {
  ROOMWISE_TRY(const auto color, read_color_of(listing_, picture));
  if (color.width() != picture.camera.width || color.height() != picture.camera.height) {
    return fail("{}: has {}x{} pixels, the recording's other pictures {}x{}",
                picture.color.string(), color.width(), color.height(), picture.camera.width,
                picture.camera.height);
  }
  return image::encode_jpeg(turned(as_seen_by(color, picture.camera, common_camera_), turns_),
                            kResampledJpegQuality);
}

Expected<image::DepthImage> PhoneRecording::read_depth(const std::filesystem::path& file,
                                                       const PinholeCamera& camera) const {
  ROOMWISE_TRY(image::DepthImage depth, image::read_depth(file));
  if (listing_.no_depth != 0) std::ranges::replace(depth.pixels(), listing_.no_depth, 0);
  if (!listing_.depth_camera && !has_shape_of(camera, depth.width(), depth.height())) {
    return fail(
        "{}: has {}x{} pixels, which is another shape than its picture's {}x{}; depth must show "
        "what the picture shows",
        file.string(), depth.width(), depth.height(), camera.width, camera.height);
  }
  const PinholeCamera from =
      listing_.depth_camera.value_or(depth_camera(camera, depth.width(), depth.height()));
  if (from.width != depth.width() || from.height != depth.height()) {
    return fail("{}: has {}x{} pixels, expected {}x{}", file.string(), depth.width(),
                depth.height(), from.width, from.height);
  }
  return turned(as_seen_by(depth, from, common_camera_), turns_);
}

// One that cannot be read is passed over: the frame is whole without it.
std::vector<image::DepthView> PhoneRecording::read_depth_views(const PhonePicture& picture) const {
  const geometry::RigidTransform turned_frame = turned_from_camera(turns_);
  std::vector<image::DepthView> views;
  for (const PhoneDepthView& view : picture.depth_views) {
    PinholeCamera camera = view.camera;
    camera.width = picture.camera.width;
    camera.height = picture.camera.height;
    if (!camera.validate()) continue;
    const auto depth = read_depth(view.depth, camera);
    if (!depth) continue;
    views.push_back({view.timestamp_ns,
                     turned_frame * view.picture_from_view * turned_frame.inverse(),
                     image::encode_smooth_png(*depth)});
  }
  return views;
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
  ROOMWISE_TRY(frame.depth, read_depth(original(picture).depth, original(picture).camera));
  frame.encoded_depth = image::encode_smooth_png(frame.depth);
  frame.depth_views = read_depth_views(original(picture));
  return frame;
}

}  // namespace roomwise::recording
