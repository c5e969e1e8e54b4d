#pragma once

#include <optional>
#include <span>
#include <vector>

#include "roomwise/guide/words/prompt.h"
#include "roomwise/guide/words/wording.h"

// What a picture tells of people and of light. Who somebody is it never says.
namespace roomwise::guide {

struct SeenPerson {
  enum class Side { kLeft, kAhead, kRight };
  Side side = Side::kAhead;
  std::optional<double> distance_m = std::nullopt;  // along the floor, where depth tells it
  bool is_sure = true;  // more likely there than not, by the detector's own score
};

// "is somebody here": how many, and where the nearest is; of none, that none is seen in front.
// Never empty.
[[nodiscard]] std::vector<Prompt> people_prompts(std::span<const SeenPerson> people,
                                                 const Wording& wording, TimestampNs now_ns);
// Where nothing is there that sees people.
[[nodiscard]] Prompt no_eyes_prompt(const Wording& wording, TimestampNs now_ns);
// "is it dark", "which lamp is on".
[[nodiscard]] std::vector<Prompt> light_prompts(bool is_dark, const Wording& wording,
                                                TimestampNs now_ns);

}  // namespace roomwise::guide
