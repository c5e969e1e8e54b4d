// Any bytes as an .r3d file of Record3D.

#include "fuzz_target.h"
#include "read_recording.h"
#include "roomwise/recording/phone/record3d.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  read_recording(data, size, roomwise::recording::open_record3d);
  return 0;
}
