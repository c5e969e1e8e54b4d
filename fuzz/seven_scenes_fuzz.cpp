// Any bytes as a folder of 7-Scenes' files.

#include "fuzz_target.h"
#include "read_recording.h"
#include "roomwise/recording/phone/folders.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace roomwise::recording;
  read_folder(data, size, is_seven_scenes_folder, open_seven_scenes_folder);
  return 0;
}
