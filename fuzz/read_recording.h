#pragma once

#include <algorithm>

#include "memory_file.h"
#include "memory_folder.h"
#include "roomwise/recording/recording.h"

constexpr std::size_t kMaxRecordingBytes = 1 << 16;

// Opens a recording of one kind and reads its first frames.
template <typename Open>
void read_frames(const std::filesystem::path& path, Open open) {
  using namespace roomwise;
  constexpr std::size_t kFrames = 3;
  const auto recording = open(path, recording::RecordingOptions{});
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

// The bytes are its file.
template <typename Open>
void read_recording(const std::uint8_t* data, std::size_t size, Open open) {
  if (size > kMaxRecordingBytes) return;
  read_frames(MemoryFile(data, size).path(), open);
}

// The bytes are its folder's files. Whether it is one of this kind is asked, too.
template <typename Is, typename Open>
void read_folder(const std::uint8_t* data, std::size_t size, Is is_of_kind, Open open) {
  if (size > kMaxRecordingBytes) return;
  const MemoryFolder folder(data, size);
  static_cast<void>(is_of_kind(folder.path()));
  read_frames(folder.path(), open);
}
