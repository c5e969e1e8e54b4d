#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>

#include "roomwise/home/home.h"
#include "roomwise/pipeline/objects/home_things.h"

// What people change of things. Each is kept as a row of its own (stored_edits.h) and can be undone
// (undo_edit.h). All fail, changing nothing, where a name or a note cannot be spoken, or the change
// would change nothing.
namespace roomwise::pipeline {

// Who changes something, and when.
struct EditAuthor {
  std::string name;
  std::int64_t time_s = 0;  // seconds since 1970
};

// Where somebody puts a thing.
struct ThingTarget {
  Eigen::Vector3d middle_world = Eigen::Vector3d::Zero();  // of the largest component
  std::string room;  // that it stands in, where the floor does not tell; may be empty
};

// A thing that programs did not find. It is as large as its kind usually is.
[[nodiscard]] Expected<home::EditId> add_thing(home::Home& home, const EditAuthor& author,
                                               const std::string& name, const ThingTarget& where,
                                               const std::string& note = {});
[[nodiscard]] Expected<home::EditId> rename_thing(home::Home& home, const EditAuthor& author,
                                                  const HomeThing& thing, const std::string& name);
// An empty note takes the one before away.
[[nodiscard]] Expected<home::EditId> note_thing(home::Home& home, const EditAuthor& author,
                                                const HomeThing& thing, const std::string& note);
[[nodiscard]] Expected<home::EditId> move_thing(home::Home& home, const EditAuthor& author,
                                                const HomeThing& thing, const ThingTarget& where);
// That one thing is listed twice: `kept` stays.
[[nodiscard]] Expected<home::EditId> merge_things(home::Home& home, const EditAuthor& author,
                                                  const HomeThing& kept, const HomeThing& twin);
// That it is not there.
[[nodiscard]] Expected<home::EditId> remove_thing(home::Home& home, const EditAuthor& author,
                                                  const HomeThing& thing);

}  // namespace roomwise::pipeline
