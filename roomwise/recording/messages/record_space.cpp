#include "roomwise/recording/messages/record_space.h"

#include <algorithm>

namespace roomwise::recording {
namespace {

constexpr std::uint64_t kWindowBytes = 4096;

}  // namespace

Expected<std::span<const std::uint8_t>> RecordSpace::at(std::uint64_t offset, std::uint64_t size) {
  if (file_ == nullptr) {
    return bytes_.subspan(static_cast<std::size_t>(offset), static_cast<std::size_t>(size));
  }
  const bool is_in_window = offset >= window_begin_ && offset - window_begin_ <= window_.size() &&
                            size <= window_.size() - (offset - window_begin_);
  if (!is_in_window) {
    const std::uint64_t wanted = std::min(std::max(size, kWindowBytes), size_ - offset);
    ROOMWISE_TRY(window_, file_->read(begin_ + offset, wanted));
    window_begin_ = offset;
  }
  return std::span<const std::uint8_t>(window_).subspan(
      static_cast<std::size_t>(offset - window_begin_), static_cast<std::size_t>(size));
}

}  // namespace roomwise::recording
