#pragma once

#include <Eigen/Core>
#include <optional>
#include <string_view>
#include <vector>

#include "roomwise/guide/questions/understand.h"

namespace roomwise::guide {

// Where one of several lies, seen by who is to choose: straight ahead and to their left, and how
// far they walk there, m.
struct ChoicePlace {
  Eigen::Vector2d ahead_left_m = Eigen::Vector2d::Zero();
  double way_m = 0;
};

// What was said before, and what somebody does meanwhile.
struct Dialogue {
  Understood offer = {};        // that still waits for an answer
  Understood last = {};         // the last question with a name, while it may be meant
  Understood chosen_from = {};  // the offer of which `last` was chosen
  // Of the choices of the offer, or else of chosen_from, in their order; fewer: not known.
  std::vector<std::optional<ChoicePlace>> places = {};
  std::optional<Noun> goal = {};  // of who is led
  bool is_led = false;
  bool follows_way = false;  // is led and neither paused, lost, by rooms nor on stairs
};

// Whether it is one of the choices of an offer.
[[nodiscard]] bool is_chosen_from(const Understood& heard, const Understood& offer);

// What somebody means by a text in a dialogue: understand(), in_answer_to(), following(),
// unless_stopped() and while_led(), and what takes back what was understood before by the grammar's
// corrections: "no, the kitchen", "not the kitchen, the bedroom", "the other one", "the left one".
//
// What is corrected is the offer that waits; else the last question; else the way on which somebody
// is led. Who is led is led elsewhere only by a name that is the home's own, to the letter, after
// words that say so, or by "the other one" of two; what else denies the way, or may be an
// instruction that they say again ("left"), is asked about or pauses it (doubts_way). A word for
// stop comes before any correction. An offer that waits is told again to words that choose nothing
// of it.
[[nodiscard]] Understood in_dialogue(std::string_view text, const Phrasebook& phrases,
                                     const HomeNames& home, const Dialogue& dialogue);

}  // namespace roomwise::guide
