#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "roomwise/guide/way/route.h"
#include "roomwise/live/device/answers.h"

namespace roomwise::live {

// A question that a helper tries, as somebody would ask it who stands at a place of the map.
struct TrialQuestion {
  std::string text;                        // in one's own words
  std::optional<Eigen::Vector2d> place;    // where they stand; absent: no picture tells that
  double heading_degrees = 0;              // as they look, counter-clockwise from x
  service::SpeakingSettings settings;      // language and distances
  std::optional<CalendarTime> today = {};  // as far as it is known
  std::int64_t now_s = 0;                  // since 1970: how long ago a spot was marked
};

struct TrialAnswer {
  std::vector<guide::Prompt> prompts;  // what would be said, the most important first
  // What who is led hears after that, if they do as they are told at a steady pace.
  std::vector<guide::Prompt> along_way;
  guide::Route way;                     // where one would be led; empty: nowhere
  std::optional<Eigen::Vector2d> goal;  // what was asked for, nearest to the way's end
};

// What is said and where the way leads, by the same words and the same map as to who asks. A place
// is taken as a picture that is certain of it. What changes the home (naming, teaching) is not
// done.
[[nodiscard]] TrialAnswer try_question(const TrialQuestion& question,
                                       const std::shared_ptr<const HomeView>& home);
// The same of what was understood already; `question.text` does not count. Something is always
// said.
[[nodiscard]] TrialAnswer try_ask(const service::Ask& ask, const TrialQuestion& question,
                                  const std::shared_ptr<const HomeView>& home);

}  // namespace roomwise::live
