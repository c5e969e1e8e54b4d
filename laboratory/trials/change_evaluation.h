#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "roomwise/pipeline/visits/update_home.h"

namespace roomwise::trials {

// A thing that is not where it was, of those that the home has a word for.
struct TrueChange {
  std::string name, label;  // as in objects.json
  // Moved or gone; absent: new.
  std::optional<objects::ChangeState> state;
  double shift_m = 0;  // of its middle
  // Both walks showed it well, as far as it was there: half a percent of the picture or more in
  // four frames of the walk that was mapped and in three of the visit, which has fewer.
  bool is_expected = false;
  bool was_known = false;  // the home had found it: a thing of its name at its old place
  std::vector<std::string> noticed_as;  // "moved chair"; none: not noticed by name
  bool is_noticed_unnamed = false;      // as something new or gone
};

struct ChangeEvaluation {
  std::vector<TrueChange> changes;  // by name
  std::size_t right = 0;            // alarms: where a thing was or is that truly changed
  std::vector<std::string> wrong;   // others
  std::size_t unchanged = 0;        // things that the home knew and that no alarm is about
  // Of what is said to be new or gone without a name: what is about a thing that truly changed,
  // what is about a door's leaf that was turned, and others.
  std::size_t unnamed_right = 0, unnamed_doors = 0;
  std::vector<std::string> unnamed_wrong;  // "new 0.30 x 0.20 x 0.40 m at 1.20 0.50 0.80 m"

  // Of the expected changes; of those whose old state the home knew.
  [[nodiscard]] std::size_t expected() const;
  [[nodiscard]] std::size_t noticed() const;  // by name
  [[nodiscard]] std::size_t noticed_with_unnamed() const;
  [[nodiscard]] std::size_t known() const;
  [[nodiscard]] std::size_t known_noticed() const;
};

// What pipeline::compare_with_visit() says of a home and a simulated walk, against the objects.json
// of the simulated recording that the home was mapped from and of the walk. What is said to be
// moved, gone or new is an alarm. It is right where it says that something stood, or stands, within
// 0.2 m of a thing that moved by `min_shift_m` or more, went or came, whatever either calls it.
// That thing was noticed: of several the nearest, one of the alarm's name before others. What is
// said to be new or gone without a name is judged alike; else it is about a door where it lies
// within 0.2 m of the leaf of one that stands at another angle (floorplan.json).
[[nodiscard]] Expected<ChangeEvaluation> evaluate_changes(const home::Home& home,
                                                          const std::filesystem::path& mapped,
                                                          const std::filesystem::path& visit,
                                                          const pipeline::HomeUpdate& update,
                                                          double min_shift_m);

}  // namespace roomwise::trials
