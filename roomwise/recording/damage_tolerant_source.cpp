#include "roomwise/recording/damage_tolerant_source.h"

namespace roomwise::recording {

Expected<std::optional<image::RgbdFrame>> DamageTolerantSource::next() {
  for (;;) {
    // An error leaves the source at the frame after it, so this ends.
    Expected<std::optional<image::RgbdFrame>> frame = source_.next();
    if (frame && !*frame && !gave_any_ && !damage_.empty()) {
      return fail("{}: none of its {} frames can be read; the first: {}", source_.info().name,
                  damage_.size(), damage_.front());
    }
    if (frame || frame.error().code == ErrorCode::kInterrupted) {
      gave_any_ = gave_any_ || frame.has_value();
      return frame;
    }
    if (!skip_damaged_) {
      is_stopped_ = true;
      return frame;
    }
    damage_.push_back(frame.error().message);
  }
}

}  // namespace roomwise::recording
