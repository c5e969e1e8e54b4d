// Any bytes as a folder of ARKitScenes' files.

#include "fuzz_target.h"
#include "read_recording.h"
#include "roomwise/recording/phone/folders.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace roomwise::recording;
  read_folder(data, size, is_arkitscenes_folder, open_arkitscenes_folder);
  return 0;
}
