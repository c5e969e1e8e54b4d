// Any bytes as a folder of 3D Scanner App's files.

#include "fuzz_target.h"
#include "read_recording.h"
#include "roomwise/recording/phone/scanner_app.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace roomwise::recording;
  read_folder(data, size, is_scanner_app_export, open_scanner_app_export);
  return 0;
}
