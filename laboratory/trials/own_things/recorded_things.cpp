#include <algorithm>
#include <cmath>
#include <map>

#include "laboratory/labelling/reader_labels.h"
#include "laboratory/trials/own_things/trial_things.h"
#include "roomwise/base/file.h"
#include "roomwise/image/codec.h"
#include "roomwise/image/resample.h"
#include "roomwise/network/vision/augmentation.h"
#include "roomwise/recording/open_recording.h"

namespace roomwise::trials {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMinViews = 3;
constexpr float kMinSide_px = 24, kMinShownSide_px = 64;
constexpr int kQuality = 92;
constexpr int kWidth_px = 640;
constexpr std::uint64_t kRecordedStream = 0x0B1, kPhotoStream = 0x0B2;

network::PixelBox scaled(const network::PixelBox& box, float scale) {
  return {box.left * scale, box.top * scale, box.right * scale, box.bottom * scale};
}

// A picture of a recording, 640 px wide at most, with a box in pixels of its file.
struct BoxedPicture {
  image::ColorImage color;
  network::PixelBox box;
};
Expected<BoxedPicture> boxed(const recording::Recording& recording,
                             const labelling::LabelledView& view) {
  const recording::RecordedPicture* const picture = recording.find(view.frame);
  if (picture == nullptr) return fail("frame {}: the recording has no such picture", view.frame);
  ROOMWISE_TRY(image::ColorImage color, recording.read_color(view.frame));
  const geometry::PinholeCamera camera = recording.original_camera(*picture);
  const float scale = static_cast<float>(color.width()) / static_cast<float>(camera.width);
  return BoxedPicture{std::move(color), scaled(view.box, scale)};
}

float narrow_side(const network::PixelBox& box) {
  return std::min(box.right - box.left, box.bottom - box.top);
}

// Pictures a second of walking apart, in two halves.
Expected<void> add_walks(const LabelledRecording& of, const recording::Recording& recording,
                         TrialSet& set) {
  const auto& pictures = recording.pictures();
  if (pictures.size() < 2) return fail("{}: has no walk", of.folder.string());
  const double stamped_s =
      static_cast<double>(pictures.back().timestamp_ns - pictures.front().timestamp_ns) * 1e-9;
  const double duration_s = of.duration_s.value_or(stamped_s);
  const auto count = std::min(pictures.size(), static_cast<std::size_t>(duration_s) + 1);
  const std::string name = recording.info().name;
  std::array<TrialWalk, 2> halves{TrialWalk{name + ", first half", name, false, true, {}},
                                  TrialWalk{name + ", second half", name, true, true, {}}};
  for (std::size_t i = 0; i < count; ++i) {
    ROOMWISE_TRY(
        Bytes picture,
        recording.read_color_file(
            pictures[i * (pictures.size() - 1) / std::max<std::size_t>(1, count - 1)].index));
    halves[i < count / 2 ? 0 : 1].pictures.push_back(std::move(picture));
  }
  std::ranges::move(halves, std::back_inserter(set.walks));
  return {};
}

Expected<TrialThing> recorded_thing(const labelling::LabelledThing& labelled,
                                    const recording::Recording& recording, RandomStream& random) {
  TrialThing thing{labelled.name, TrialGroup::kRecorded, recording.info().name, {}, {}, {}, {}};
  std::vector<labelling::LabelledView> views = labelled.views;
  std::ranges::stable_sort(views, {}, &labelling::LabelledView::frame);
  const std::size_t shown = views.size() / 2;
  for (std::size_t i = 0; i < views.size(); ++i) {
    ROOMWISE_TRY(const BoxedPicture one, boxed(recording, views[i]));
    if (narrow_side(one.box) < (i < shown ? kMinShownSide_px : kMinSide_px)) continue;
    if (i < shown) {
      thing.shown.push_back(
          image::encode_jpeg(shown_before_camera(one.color, one.box, random), kQuality));
    } else {
      thing.tests.push_back({image::encode_jpeg(one.color, kQuality), one.box});
    }
  }
  return thing;
}

std::vector<std::size_t> walks_where(const TrialSet& set, auto&& is_wanted) {
  std::vector<std::size_t> walks;
  for (std::size_t i = 0; i < set.walks.size(); ++i) {
    if (is_wanted(set.walks[i])) walks.push_back(i);
  }
  return walks;
}

// A photo seen from another side, in other light, over a picture.
BoxedPicture photo_in(const image::ColorImage& photo, image::ColorImage picture,
                      const network::PixelBox& box, double pan_deg, double tilt_deg,
                      const network::AugmentationOptions& light, RandomStream& random) {
  network::PictureVariation variation = network::sample_variation(light, random);
  variation.pan_deg = pan_deg;
  variation.tilt_deg = tilt_deg;
  variation.side = 1;
  const image::ColorImage seen = network::vary(photo, variation);
  const int width = static_cast<int>(box.right - box.left);
  const int height = static_cast<int>(box.bottom - box.top);
  const image::ColorImage small = image::resize(seen, width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int to_x = static_cast<int>(box.left) + x, to_y = static_cast<int>(box.top) + y;
      if (picture.contains(to_x, to_y)) picture.at(to_x, to_y) = small.at(x, y);
    }
  }
  return {std::move(picture), box};
}

network::PixelBox drawn_box(const image::ColorImage& photo, const image::ColorImage& picture,
                            double longer_px, bool in_middle, RandomStream& random) {
  const double shape = static_cast<double>(photo.width()) / photo.height();
  const double width = std::floor(longer_px * std::min(1.0, shape));
  const double height = std::floor(longer_px * std::min(1.0, 1 / shape));
  const double free_x = picture.width() - width, free_y = picture.height() - height;
  const double left = std::floor(in_middle ? free_x / 2 : random.between(0, std::max(1.0, free_x)));
  const double top = std::floor(in_middle ? free_y / 2 : random.between(0, std::max(1.0, free_y)));
  return {static_cast<float>(left), static_cast<float>(top), static_cast<float>(left + width),
          static_cast<float>(top + height)};
}

Expected<TrialThing> photo_thing(const fs::path& file, std::size_t base, const TrialSet& set,
                                 RandomStream& random) {
  constexpr int kShown = 6, kTests = 8;
  ROOMWISE_TRY(const image::ColorImage photo, image::read_color(file));
  TrialThing thing{
      file.stem().string(), TrialGroup::kPhoto, set.walks[base].recording, {}, {}, {}, {}};
  const network::AugmentationOptions light;
  for (int i = 0; i < kShown + kTests; ++i) {
    const bool is_shown = i < kShown;
    // Shown in the first half of the walk, found again in the second.
    const auto& pictures = set.walks[base + (is_shown ? 0 : 1)].pictures;
    ROOMWISE_TRY(image::ColorImage picture,
                 image::decode_color(pictures[random.index(pictures.size())]));
    const int height = picture.height() * kWidth_px / picture.width();
    picture = image::resize(picture, kWidth_px, height);
    const double longer_px = is_shown ? 0.6 * picture.height() : random.between(60, 200);
    const auto box = drawn_box(photo, picture, longer_px, is_shown, random);
    const double turn_deg = is_shown ? 12 : 35;
    BoxedPicture made =
        photo_in(photo, std::move(picture), box, random.between(-turn_deg, turn_deg),
                 random.between(-turn_deg / 2, turn_deg / 2),
                 is_shown ? network::kNoAugmentation : light, random);
    Bytes encoded = image::encode_jpeg(made.color, kQuality);
    if (is_shown) {
      thing.shown.push_back(std::move(encoded));
    } else {
      thing.tests.push_back({std::move(encoded), made.box});
    }
  }
  thing.home = {base};
  thing.absent = walks_where(
      set, [&](const TrialWalk& walk) { return walk.is_real && &walk != &set.walks[base]; });
  return thing;
}

}  // namespace

image::ColorImage shown_before_camera(const image::ColorImage& picture,
                                      const network::PixelBox& box, RandomStream& random) {
  constexpr double kShare = 0.6, kAside = 0.05;
  constexpr double kLonger_px = 480;
  const double width = static_cast<double>(box.right - box.left) / kShare;
  const double height = static_cast<double>(box.bottom - box.top) / kShare;
  const double middle_x =
      static_cast<double>(box.left + box.right) / 2 + random.between(-kAside, kAside) * width;
  const double middle_y =
      static_cast<double>(box.top + box.bottom) / 2 + random.between(-kAside, kAside) * height;
  const double scale = kLonger_px / std::max(width, height);
  return image::resize(
      picture,
      {middle_x - width / 2, middle_y - height / 2, middle_x + width / 2, middle_y + height / 2},
      std::max(8, static_cast<int>(scale * width)), std::max(8, static_cast<int>(scale * height)));
}

Expected<void> add_recorded_things(const std::vector<LabelledRecording>& recordings,
                                   std::uint64_t seed, TrialSet& set) {
  std::vector<std::unique_ptr<recording::Recording>> opened;
  for (const LabelledRecording& one : recordings) {
    ROOMWISE_TRY(opened.emplace_back(), recording::open_recording(one.folder, {one.camera}));
    ROOMWISE_RETURN_IF_ERROR(add_walks(one, *opened.back(), set));
  }
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    if (recordings[i].labels.empty()) continue;
    ROOMWISE_TRY(const auto labels, labelling::read_reader_labels(recordings[i].labels));
    std::map<std::string, int> of_name;
    for (const labelling::LabelledThing& one : labels.things) ++of_name[one.name];
    for (const labelling::LabelledThing& one : labels.things) {
      if (of_name[one.name] > 1 || one.is_transient || one.views.size() < kMinViews) continue;
      RandomStream random(seed, {kRecordedStream, i, static_cast<std::uint64_t>(one.id)});
      ROOMWISE_TRY(TrialThing thing, recorded_thing(one, *opened[i], random));
      if (thing.shown.empty() || thing.tests.empty()) continue;
      const auto is_home = [&](const TrialWalk& walk) { return walk.recording == thing.recording; };
      thing.home = walks_where(set, is_home);
      thing.absent = walks_where(set, [&](const TrialWalk& walk) { return !is_home(walk); });
      set.things.push_back(std::move(thing));
    }
  }
  return {};
}

Expected<void> add_photo_things(const fs::path& photos, std::size_t count, std::uint64_t seed,
                                TrialSet& set) {
  std::vector<fs::path> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(photos, error)) files.push_back(entry.path());
  if (error) return fail("{}: cannot be read: {}", photos.string(), error.message());
  std::ranges::sort(files);
  RandomStream random(seed, {kPhotoStream});
  std::vector<std::size_t> first_halves;
  for (std::size_t i = 0; i + 1 < set.walks.size(); ++i) {
    if (set.walks[i].recording == set.walks[i + 1].recording) first_halves.push_back(i);
  }
  if (first_halves.empty()) return fail("photos need a recording in which they are shown");
  for (std::size_t i = 0; i < count && !files.empty(); ++i) {
    const auto file = files.begin() + static_cast<std::ptrdiff_t>(random.index(files.size()));
    const std::size_t base = first_halves[i % first_halves.size()];
    ROOMWISE_TRY(set.things.emplace_back(), photo_thing(*file, base, set, random));
    files.erase(file);
  }
  return {};
}

}  // namespace roomwise::trials
