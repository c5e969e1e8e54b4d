// Any bytes as a folder of Stray Scanner's files.

#include "fuzz_target.h"
#include "read_recording.h"
#include "roomwise/recording/phone/stray_scanner.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace roomwise::recording;
  read_folder(data, size, is_stray_scanner_folder, open_stray_scanner_folder);
  return 0;
}
