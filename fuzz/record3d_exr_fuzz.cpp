// Any bytes as a folder that Record3D exported as EXR and JPG.

#include "fuzz_target.h"
#include "read_recording.h"
#include "roomwise/recording/phone/record3d.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace roomwise::recording;
  read_folder(data, size, is_record3d_exr_folder, open_record3d_exr_folder);
  return 0;
}
