#pragma once

#include <filesystem>
#include <string>

#include "roomwise/home/home.h"
#include "roomwise/recording/room_labels.h"

// The home that a walk is mapped into, before and after.
namespace roomwise::pipeline {

struct WalkIntoHome {
  std::filesystem::path home, recording;
  home::OpenOptions open = {};
  bool resume = false;
  std::string resume_option;  // what the user writes for it, for errors: "--resume"
};

// A home that is there takes a further walk, or goes on with the one that it was left in; else a
// new one. Fails where `resume` asks for the other of the two.
[[nodiscard]] Expected<home::Home> make_or_open_home(const WalkIntoHome& request);

// Names the newest walk's rooms, where nobody named any of them since.
[[nodiscard]] Expected<void> name_rooms_if_unnamed(home::Home& home,
                                                   const recording::RoomLabels& labels);

// Removes a home without a key-frame, which a run that failed left.
void remove_empty_home(const std::filesystem::path& path);

}  // namespace roomwise::pipeline
