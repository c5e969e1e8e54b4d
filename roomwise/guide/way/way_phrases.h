#pragma once

#include <optional>
#include <string>

#include "roomwise/guide/way/plan.h"
#include "roomwise/guide/words/wording.h"

namespace roomwise::guide {

// What there is to do by turning so far, positive to the left; nothing where that is straight on.
[[nodiscard]] Phrase turn_phrase(double turn_rad);
// The same, announced: after so far, at a place where one is known.
[[nodiscard]] Phrase soon_turn_phrase(double turn_rad, const std::string& distance,
                                      const std::optional<Noun>& place);
// "Stairs up, 14 steps, rail on the right."
[[nodiscard]] Phrase stairs_phrase(const StairsOnWay& way, const Phrasebook& phrases);
// "stairs.soon" and stairs that one climbs: "stairs.soon_up".
[[nodiscard]] std::string stairs_message(const std::string& message, const StairsOnWay& way);
// "Straight on, 4 steps to the door."; `side` of the place, of who is there: "_left", "_right", "".
[[nodiscard]] Phrase walk_phrase(const std::string& distance, const std::optional<Noun>& place,
                                 const std::string& side = "");
// "Good. 3 steps to the door."
[[nodiscard]] Phrase more_phrase(const std::string& distance, const std::optional<Noun>& place,
                                 const std::string& side = "");

// Doors of homes have leaves of 735, 860 or 985 mm (DIN 18101) that leave 0.69, 0.81 or 0.94 m to
// go through: between the first two a door becomes narrow, beyond the last one wide.
enum class DoorWidth { kUsual, kNarrow, kWide };
[[nodiscard]] DoorWidth width_of(const rooms::Doorway& door);  // kUsual, too, where none is known
// "80 centimetres": as exact as a floor's cells.
[[nodiscard]] std::string width_text(double width_m, const Phrasebook& phrases);
// "door", "narrow door", "wide door", as languages know them.
[[nodiscard]] Noun door_noun(const rooms::Doorway& door);

// "guide.place" and a point behind one: "guide.place_behind".
[[nodiscard]] std::string with_side(const std::string& message, const Eigen::Vector2d& point_plan,
                                    const Pose& pose);
// How high a hand has to reach: "guide.height_knee".
[[nodiscard]] std::string height_message(double height_m);

// Where it takes a direction that nobody knows, the rooms on the way: "The bed is in the bedroom,
// through the hall." Nothing where the goal's room is not known.
[[nodiscard]] std::optional<Phrase> rooms_phrase(const Goal& goal,
                                                 const std::vector<std::string>& rooms);

}  // namespace roomwise::guide
