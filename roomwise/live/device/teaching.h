#pragma once

#include <atomic>
#include <optional>
#include <vector>

#include "roomwise/guide/answers/teaching_prompts.h"
#include "roomwise/live/recording/frame_images.h"
#include "roomwise/objects/own_things/shown_thing.h"

namespace roomwise::live {

// A thing that a person shows to a device's camera: takes its pictures, and says what to do. One
// thread takes; others may ask whether that is enough, and read what was shown once it is.
class Teaching {
 public:
  // As many as ten seconds at a picture a second bring; more are not needed.
  static constexpr std::size_t kEnough = 10;

  // What there is to say after a picture; nothing where it was said a short while ago, or where
  // enough was shown before. kStopped where no picture was taken for a minute, since
  // hazards are not looked for meanwhile.
  struct Reply {
    std::optional<guide::TeachingStep> step;
    std::optional<objects::ShowFault> fault;
  };
  // `t_ms`: of the picture, by the device's clock.
  Reply take(const FrameImages& images, double depth_units_per_metre, double t_ms);

  [[nodiscard]] bool has_enough() const { return has_enough_; }
  // Changes no more once that is enough.
  [[nodiscard]] const std::vector<objects::ShownThing>& shown() const { return shown_; }

 private:
  std::vector<objects::ShownThing> shown_;
  std::atomic<bool> has_enough_ = false;  // after the last of them was taken
  std::optional<double> last_fault_t_ms_;
  std::optional<double> went_on_t_ms_;  // of the last that was taken, else of the first that came
};

}  // namespace roomwise::live
