#pragma once

#include <algorithm>

#include "memory_file.h"
#include "roomwise/recording/recording.h"

// Opens a recording of one kind and reads its first frames.
template <typename Open>
void read_recording(const std::uint8_t* data, std::size_t size, Open open) {
  using namespace roomwise;
  constexpr std::size_t kMaxFileBytes = 1 << 16;
  constexpr std::size_t kFrames = 3;
  if (size > kMaxFileBytes) return;
  const MemoryFile file(data, size);
  const auto recording = open(file.path(), recording::RecordingOptions{});
  if (!recording) {
    if (recording.error().message.empty()) __builtin_trap();
    return;
  }
  const auto& frames = (*recording)->frames();
  for (std::size_t i = 0; i < std::min(frames.size(), kFrames); ++i) {
    const auto frame = (*recording)->frame(frames[i]);
    if (!frame) continue;
    // What is given has the camera's size.
    const auto& camera = (*recording)->info().camera;
    if ((*frame)->color.width() != camera.width || (*frame)->depth.height() != camera.height) {
      __builtin_trap();
    }
  }
}
