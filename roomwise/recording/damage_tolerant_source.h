#pragma once

#include <string>
#include <vector>

#include "roomwise/recording/frame_source.h"

namespace roomwise::recording {

// The frames of another source that can be read. The others are left out, so that one picture that
// is damaged does not cost the walk; what was wrong with each is kept. Or the first such ends it.
class DamageTolerantSource final : public FrameSource {
 public:
  // `source` must outlive it.
  DamageTolerantSource(FrameSource& source, bool skip_damaged)
      : source_(source), skip_damaged_(skip_damaged) {}

  [[nodiscard]] const SourceInfo& info() const override { return source_.info(); }
  // Fails where the source ends and none of its frames could be read, where it was interrupted, and
  // at the first that cannot be read where none is to be left out.
  [[nodiscard]] Expected<std::optional<image::RgbdFrame>> next() override;
  void skip_before(std::uint64_t index) override { source_.skip_before(index); }

  // The errors of the frames that were left out so far, each naming its file.
  [[nodiscard]] const std::vector<std::string>& damage() const { return damage_; }
  // Whether it failed at a frame that could be left out: who asked may be told how.
  [[nodiscard]] bool is_stopped() const { return is_stopped_; }

 private:
  FrameSource& source_;
  bool skip_damaged_;
  std::vector<std::string> damage_;
  bool gave_any_ = false;
  bool is_stopped_ = false;
};

}  // namespace roomwise::recording
