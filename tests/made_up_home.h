#pragma once

#include <filesystem>

#include "roomwise/base/expected.h"
#include "roomwise/geometry/pinhole_camera.h"

namespace roomwise::testing {

// What make_made_up_home() makes. Names have what breaks formats: quotes, spaces, letters beyond
// ASCII, a line end.
inline constexpr const char* kMadeUpLiving = "Séjour \"du bas\"";
inline constexpr const char* kMadeUpKitchen = "kitchen, new";
inline constexpr const char* kMadeUpWalk = "monday\n\"first\" walk";
inline constexpr const char* kMadeUpLaterWalk = "tuesday";

struct MadeUpHome {
  bool has_rooms = true;
  bool has_things = true;
  bool has_depth = true;  // otherwise no pixel of any depth image was measured
};

// A home file, mapped without an error and without pictures being looked at: a room of 3 m by 3 m
// and another behind a door in y, patterned, with a box in each. Two walks, by a camera with a lens
// and depth of 5000 a metre, and by one without and of 1000, whose pictures are JPEG, the first one
// turned by its Exif; two key-frames of the second hang together with nothing else and see a thing.
[[nodiscard]] Expected<void> make_made_up_home(const std::filesystem::path& file,
                                               const MadeUpHome& options = {});

// The cameras of its walks.
[[nodiscard]] geometry::PinholeCamera made_up_lens_camera();
[[nodiscard]] geometry::PinholeCamera made_up_phone_camera();

}  // namespace roomwise::testing
