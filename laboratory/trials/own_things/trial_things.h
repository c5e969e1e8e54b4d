#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "laboratory/simulation/furniture/furniture_catalogue.h"
#include "roomwise/base/file.h"
#include "roomwise/base/progress.h"
#include "roomwise/base/random.h"
#include "roomwise/base/thread_pool.h"
#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/image/image.h"
#include "roomwise/network/vision/detector.h"

// Things that are taught, and pictures in which they are to be found again, with the truth.
namespace roomwise::trials {

// A picture in which a thing is to be found.
struct TrialPicture {
  Bytes picture;  // JPEG
  network::PixelBox box;
};

// Half of a walk through a place: pictures a second of walking apart.
struct TrialWalk {
  std::string name;
  std::string recording;        // its halves are left out together
  bool is_second_half = false;  // in which alarms are counted; what is fitted sees first halves
  bool is_real = false;
  std::vector<Bytes> pictures;
};

enum class TrialGroup { kRecorded, kPhoto, kRendered };

struct TrialThing {
  std::string name;
  TrialGroup group = TrialGroup::kRecorded;
  std::string recording;     // in whose pictures it is found again
  std::vector<Bytes> shown;  // as somebody shows it: in the middle
  std::vector<TrialPicture> tests;
  std::vector<std::size_t> home;    // walks that calibrate it: its home's
  std::vector<std::size_t> absent;  // walks that do not show it
};

struct TrialSet {
  std::vector<TrialThing> things;
  std::vector<TrialWalk> walks;
};

// A recording, and what a reader marked in it.
struct LabelledRecording {
  std::filesystem::path folder, labels;
  // How long it took to walk, s; absent: as its stamps say.
  std::optional<double> duration_s;
  std::optional<geometry::PinholeCamera> camera = {};  // where the recording does not tell it
};

// Adds the recordings' walks, and their things: those that a reader marked in three pictures or
// more, with a name that no other thing of the recording has. The first half of a thing's pictures
// shows it, where it is 64 px or more wide and high there, cut so that it takes three fifths of the
// picture, off the middle by up to a twentieth; in the others it is to be found, if it is 24 px or
// more.
[[nodiscard]] Expected<void> add_recorded_things(const std::vector<LabelledRecording>& recordings,
                                                 std::uint64_t seed, TrialSet& set);

// Adds things of which there is one photo each, drawn by the seed. They are shown before one half
// of a recording's pictures, and stand in those of the other half: from other sides (by perspective
// alone), in other light, 60 to 200 px large.
[[nodiscard]] Expected<void> add_photo_things(const std::filesystem::path& photos,
                                              std::size_t count, std::uint64_t seed, TrialSet& set);

struct RenderedThingsOptions {
  std::vector<std::uint64_t> homes{301, 302};  // seeds
  std::size_t things = 10;                     // of each
  std::size_t shown = 6, tests = 6;            // pictures of each
  std::uint64_t seed = 0;
  double bake_effort = 0.2;
};
// Adds furniture and things of made-up homes: small ones first, then what is moved, each of another
// model. They are shown by day, and to be found from other sides in the evening and at night.
[[nodiscard]] Expected<void> add_rendered_things(const RenderedThingsOptions& options,
                                                 const simulation::FurnitureCatalogue& catalogue,
                                                 ThreadPool& pool, Progress& progress,
                                                 TrialSet& set);

// The picture that somebody takes who has the box's thing before the camera.
[[nodiscard]] image::ColorImage shown_before_camera(const image::ColorImage& picture,
                                                    const network::PixelBox& box,
                                                    RandomStream& random);

}  // namespace roomwise::trials
