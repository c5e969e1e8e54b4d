// Any bytes as the Exif of a JPEG: what it tells of the lens is a camera that can be, or nothing.

#include "fuzz_target.h"
#include "roomwise/image/exif.h"
#include "roomwise/motion/lens_estimate.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace roomwise;
  const int orientation = image::exif_orientation({data, size});
  if (orientation < 1 || orientation > 8) __builtin_trap();
  const auto exif = image::exif_lens({data, size});
  if (!exif) return 0;
  const auto lens = motion::IntrinsicsEstimate::from_exif(*exif, 640, 480);
  if (lens && (!lens->camera(640, 480).validate() || !(lens->relative_focal_sigma() > 0)))
    __builtin_trap();
  return 0;
}
