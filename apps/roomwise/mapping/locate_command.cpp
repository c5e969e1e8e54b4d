#include <algorithm>
#include <cmath>
#include <filesystem>
#include <opencv2/core/utility.hpp>
#include <vector>

#include "camera_option.h"
#include "command_run.h"
#include "commands.h"
#include "open_home.h"
#include "pose_json.h"
#include "roomwise/base/in_context.h"
#include "roomwise/image/codec.h"
#include "roomwise/mapping/localization/lens_calibration.h"
#include "roomwise/pipeline/mapping/home_localizer.h"
#include "roomwise/recording/open_recording.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

struct LocateOptions {
  fs::path home;
  std::vector<fs::path> pictures;
  std::vector<fs::path> depths;
  std::vector<std::uint64_t> frames;  // of a recording
  std::string camera;

  [[nodiscard]] bool has_unknown_camera() const { return camera == "unknown"; }
};

Expected<pipeline::PictureToLocate> read_picture(const LocateOptions& options, std::size_t i,
                                                 const geometry::PinholeCamera& camera) {
  pipeline::PictureToLocate picture;
  picture.camera = camera;
  ROOMWISE_TRY(picture.color, image::read_color(options.pictures[i]));
  if (i < options.depths.size()) {
    ROOMWISE_TRY(picture.depth, image::read_depth(options.depths[i]));
  }
  return picture;
}

// Frames of a recording: it knows their depth and camera itself. `camera`: given in its place.
Expected<std::vector<pipeline::PictureToLocate>> read_frames(
    const LocateOptions& options, const std::optional<geometry::PinholeCamera>& camera) {
  const fs::path& path = options.pictures.front();
  if (options.has_unknown_camera()) {
    return fail("{}: is a recording, and says its camera; leave --camera unknown out",
                path.string());
  }
  ROOMWISE_TRY(const auto recording, recording::open_recording(path, {.camera = camera}));
  if (options.frames.empty()) {
    return fail("{}: is a recording; say by --frame which of its pictures, {} to {}", path.string(),
                recording->frames().front(), recording->frames().back());
  }
  std::vector<pipeline::PictureToLocate> pictures;
  for (const std::uint64_t index : options.frames) {
    const auto& damaged = recording->damaged();
    const auto lost = std::ranges::find(damaged, index, &recording::DamagedFrame::index);
    if (lost != damaged.end()) return fail("{}", lost->why);
    ROOMWISE_TRY(auto frame, recording->frame(index));
    if (!frame) return fail("{}: has no frame {} with depth", path.string(), index);
    pictures.push_back(
        {std::move(frame->color), std::move(frame->depth), recording->info().camera});
  }
  return pictures;
}

Expected<std::vector<pipeline::PictureToLocate>> read_pictures(const LocateOptions& options,
                                                               const home::Home& home) {
  std::optional<geometry::PinholeCamera> camera;
  if (!options.has_unknown_camera()) {
    ROOMWISE_TRY(camera, given_camera(options.camera));
  }
  const bool is_recording = options.pictures.size() == 1 &&
                            recording::find_recording_kind(options.pictures.front()) != nullptr;
  if (is_recording) return read_frames(options, camera);
  if (!options.frames.empty()) {
    return fail("{}: is no recording, so it has no --frame", options.pictures.front().string());
  }
  ROOMWISE_TRY(const auto recordings, home.recordings());
  std::vector<pipeline::PictureToLocate> pictures;
  for (std::size_t i = 0; i < options.pictures.size(); ++i) {
    ROOMWISE_TRY(pipeline::PictureToLocate picture,
                 read_picture(options, i, camera.value_or(recordings.front().recording.camera)));
    pictures.push_back(std::move(picture));
  }
  return pictures;
}

// The room as the helper named it where the key-frame was taken; empty where that is not known.
Expected<std::string> room_of(const home::Home& home, home::KeyframeId id) {
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  const home::Keyframe& keyframe = keyframes.at(id);
  ROOMWISE_TRY(const recording::RoomLabels labels, home.room_ranges(keyframe.recording));
  const recording::RoomRange* const range = labels.find(keyframe.frame_index);
  return range == nullptr ? std::string() : range->room;
}

Expected<Answer> describe(const home::Home& home, const mapping::Localization& found) {
  Answer answer;
  answer.json = {{"found", found.found()}, {"status", to_string(found.status)}};
  if (found.lens) {
    answer.json["focal_length"] = std::exp(found.lens->mean[0]);
    answer.json["focal_length_sigma"] = found.lens->relative_focal_sigma();
  }
  if (!found.found()) {
    answer.text = fmt::format("not known: {}\n", to_string(found.status));
    return answer;
  }
  ROOMWISE_TRY(const std::string room, room_of(home, found.keyframe));
  constexpr double kDegreesPerRadian = 180 / static_cast<double>(EIGEN_PI);
  const Eigen::Vector3d& position = found.world_from_camera.translation;
  const double sigma_m = found.position_sigma_m();
  const double sigma_degrees = kDegreesPerRadian * found.rotation_sigma_rad();
  const std::string how =
      found.supporting_keyframes > 0
          ? fmt::format("by the shape of {} key-frames", found.supporting_keyframes)
          : fmt::format("by {} features", found.inliers);
  answer.text = fmt::format(
      "at {:.2f} {:.2f} {:.2f} m, give or take {:.2f} m and {:.1f} degrees{}\n"
      "{}, like key-frame {}\n",
      position.x(), position.y(), position.z(), sigma_m, sigma_degrees,
      room.empty() ? "" : ", where the map shows the " + room, how, found.keyframe);
  if (found.lens) {
    answer.text +=
        fmt::format("focal length {:.3f} of the picture's longer side, give or take {:.1f} %\n",
                    std::exp(found.lens->mean[0]), 100 * found.lens->relative_focal_sigma());
  }
  answer.json["position_m"] = xyz(position);
  answer.json["rotation_xyzw"] = xyzw(found.world_from_camera.rotation);
  answer.json["position_sigma_m"] = sigma_m;
  answer.json["rotation_sigma_degrees"] = sigma_degrees;
  answer.json["inliers"] = found.inliers;
  answer.json["witnesses"] = found.supporting_keyframes;
  answer.json["keyframe"] = found.keyframe;
  answer.json["room"] = word_or_null(room);
  return answer;
}

// Whether a picture's points tell of another lens than was said: further away from it than one in a
// hundred would be by chance (chi-square of two numbers).
bool is_another_lens(const motion::IntrinsicsEstimate& said,
                     const motion::IntrinsicsEstimate& found) {
  constexpr double kOneInAHundred = 9.21;
  const Eigen::Vector2d off = found.mean - said.mean;
  return off.dot(said.information * off) > kOneInAHundred;
}

// Which of two answers about one picture is to be believed: the one that is one, or that explains
// more of the picture.
bool explains_more(const mapping::Localization& a, const mapping::Localization& b) {
  return a.found() != b.found() ? a.found() : a.found() && a.inliers > b.inliers;
}

// Places photos of a lens of which only they tell something, each of what the next is asked with.
// A photo that was cropped may have kept the words of the whole: a place found by them can be a
// wrong one. So what it says of its lens has to explain the picture at least as well as nothing.
class PhotoLocator {
 public:
  explicit PhotoLocator(const pipeline::HomeLocalizer& localizing) : localizing_(localizing) {}

  Expected<mapping::Localization> locate(const image::Photo& photo) {
    if (photo.lens != says_) begin_with(photo);
    const motion::IntrinsicsEstimate asked = lens_.estimate();
    ROOMWISE_TRY(mapping::Localization found, localizing_.locate_uncalibrated(photo.color, asked));
    if (is_told_) {
      mapping::LensCalibration untold;
      ROOMWISE_TRY(mapping::Localization otherwise,
                   localizing_.locate_uncalibrated(photo.color, untold.estimate()));
      const bool contradicts_itself =
          found.found() && found.lens && is_another_lens(asked, *found.lens);
      if (contradicts_itself || explains_more(otherwise, found)) {
        is_told_ = false;
        lens_ = untold;
        found = std::move(otherwise);
      }
    }
    lens_.add(found);
    return found;
  }

 private:
  // Another photo's word is of another lens.
  void begin_with(const image::Photo& photo) {
    says_ = photo.lens;
    const auto said = says_ ? motion::IntrinsicsEstimate::from_exif(*says_, photo.color.width(),
                                                                    photo.color.height())
                            : std::nullopt;
    is_told_ = said.has_value();
    lens_ = said ? mapping::LensCalibration(*said) : mapping::LensCalibration();
  }

  const pipeline::HomeLocalizer& localizing_;
  std::optional<image::ExifLens> says_;
  bool is_told_ = false;  // by the photo, and nothing spoke against it
  mapping::LensCalibration lens_;
};

// The last picture's place.
Expected<mapping::Localization> locate_uncalibrated(const LocateOptions& options,
                                                    const pipeline::HomeLocalizer& localizing) {
  PhotoLocator locator(localizing);
  mapping::Localization last;
  for (const fs::path& picture : options.pictures) {
    ROOMWISE_TRY(const image::Photo photo, image::read_photo(picture));
    ROOMWISE_TRY(last, locator.locate(photo));
  }
  return last;
}

Expected<mapping::Localization> locate_calibrated(
    const std::vector<pipeline::PictureToLocate>& pictures, const LocateOptions& options,
    const pipeline::HomeLocalizer& localizing) {
  std::vector<motion::FrameMeasurements> measured;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const fs::path& file = options.pictures[std::min(i, options.pictures.size() - 1)];
    ROOMWISE_TRY(auto one, in_context(file.string(), localizing.measure(pictures[i])));
    measured.push_back(std::move(one));
  }
  const mapping::Localizer& where = localizing.localizer();
  const geometry::PinholeCamera& camera = pictures.front().camera;  // of both
  return measured.size() == 1 ? where.locate({measured[0], camera})
                              : where.locate({measured[0], camera}, {measured[1], camera}).second;
}

Expected<Answer> locate(const LocateOptions& options, Context& context) {
  cv::setNumThreads(1);
  if (!options.depths.empty() && options.depths.size() != options.pictures.size()) {
    return fail("{} pictures and {} depth images; give a depth image for every picture or none",
                options.pictures.size(), options.depths.size());
  }
  if (options.has_unknown_camera() && !options.depths.empty()) {
    return fail("--depth needs a camera that is known; leave it out, or give --camera");
  }
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  ROOMWISE_TRY(const auto recordings, home.recordings());
  if (recordings.empty()) return fail("{}: the home holds no recording", home.file());
  // Before the map is loaded, which takes a moment.
  ROOMWISE_TRY(const std::vector<pipeline::PictureToLocate> pictures, read_pictures(options, home));
  CommandRun run(context);
  mapping::LocalizerOptions localizer;
  localizer.seed = context.seed;
  ROOMWISE_TRY(const auto localizing, pipeline::HomeLocalizer::create(home, localizer, run));
  ROOMWISE_TRY(const mapping::Localization found,
               options.has_unknown_camera() ? locate_uncalibrated(options, localizing)
                                            : locate_calibrated(pictures, options, localizing));
  if (auto failed = localizing.take_failure()) return Unexpected(*std::move(failed));
  return describe(home, found);
}

}  // namespace

void add_locate_command(CLI::App& app, Context& context) {
  const auto [command, options] = add_command<LocateOptions>(
      app, context, "locate", "Where on a home's map one picture, or two, were taken",
      "roomwise locate --home my.home now.jpg --depth now-depth.png", locate);
  command->add_option("--home", options.home, "Home with a map")->required();
  command
      ->add_option("picture", options.pictures,
                   "A picture, or two taken shortly after one another: the second's place; or a "
                   "recording of any kind that is read (docs/recordings.md), with --frame")
      ->required()
      ->expected(1, 2);
  command
      ->add_option("--depth", options.depths,
                   "The picture's depth image (16-bit PNG, registered to it), one for each; "
                   "without it far fewer pictures have an answer")
      ->expected(1, 2);
  command
      ->add_option("--frame", options.frames,
                   "Which picture of a recording, or which two; it says their depth and camera")
      ->expected(1, 2)
      ->excludes("--depth");
  add_camera_option(*command, options.camera,
                    "the recording's own, of pictures that of the home's; unknown: its focal "
                    "length is found, too, beginning with what "
                    "the photo's Exif says of it");
}

}  // namespace roomwise::app
