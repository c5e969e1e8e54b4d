// Any bytes as a .sens file of ScanNet.

#include "fuzz_target.h"
#include "read_recording.h"
#include "roomwise/recording/sens/sens_recording.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  read_recording(data, size, roomwise::recording::open_sens_recording);
  return 0;
}
