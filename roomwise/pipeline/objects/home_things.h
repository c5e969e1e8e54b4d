#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "roomwise/home/home.h"
#include "roomwise/objects/instances/instances.h"
#include "roomwise/pipeline/stored/stored_edits.h"

namespace roomwise::pipeline {

// A thing of the home: as programs found it, with what people said of it laid over.
struct HomeThing : objects::Instance {
  std::string note;  // to be spoken with it; may be empty
  // Where people put it; the floor, where it shows whose it is, tells it better.
  std::optional<std::string> room;
  home::EditId added_by_edit = 0;  // the change that added it; 0: programs found it
  bool is_confirmed = false;       // somebody who was there says so
  std::string found_as;            // what programs call it; empty of what people added
};

// What walks or visits found gone, and somebody changed when it was there.
struct GoneThing {
  objects::Instance found;  // as programs found it
  std::string name;         // what people called it; empty: they said that it was not there
};

struct HomeThings {
  // Those that programs found, in their order, without what people took out; then those that people
  // added.
  std::vector<HomeThing> things;
  // Changes that find nothing to change at present, and why. They are kept: what they are about may
  // come back.
  std::map<home::EditId, std::string> without_effect;
  // Numbers of the things that each change is about; equal numbers, same thing.
  std::map<home::EditId, std::set<std::size_t>> things_of_edit;
  std::vector<GoneThing> gone;  // in the order of changes

  // What people called a thing that programs found gone; nothing where they had said that it was
  // not there.
  [[nodiscard]] std::optional<std::string> name_of_gone(const objects::Instance& one) const;
};

// What programs found in the home (Home::instances()), with what people changed laid over it: a
// change finds its thing
//
// 1. by the picture that showed it best, where that is as it was;
// 2. else by the walks and visits: what they say moved from there;
// 3. else by its place: what programs call the same and stands there;
// 4. else by its place alone, for programs may call it otherwise now. Not to take it out: that a
//    laptop is not there says nothing of a book.
//
// A thing that people added or moved is one with what programs find there by its name. Reads only.
[[nodiscard]] Expected<HomeThings> find_home_things(const home::Home& home);

}  // namespace roomwise::pipeline
