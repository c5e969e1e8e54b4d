// Any bytes as a folder of Polycam's files.

#include "fuzz_target.h"
#include "read_recording.h"
#include "roomwise/recording/phone/folders.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace roomwise::recording;
  read_folder(data, size, is_polycam_folder, open_polycam_folder);
  return 0;
}
