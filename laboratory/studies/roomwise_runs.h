#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <string_view>

#include "laboratory/studies/kept_run.h"

// The command lines that studies of several homes share.
namespace roomwise::studies {

// A walk through a simulated home.
struct SimulatedWalk {
  std::string_view name, scenario, condition;
  int seed;
};
// By day, to map and to learn from.
inline constexpr SimulatedWalk kDayWalk{"day", "day", "", 1};
// What changed since: the light, or where things stand.
inline constexpr std::array kVisits{
    SimulatedWalk{"evening", "evening", "light", 2}, SimulatedWalk{"night", "night", "light", 3},
    SimulatedWalk{"moved-1", "moved", "moved", 4}, SimulatedWalk{"moved-2", "moved", "moved", 5}};

// `home`: which one is walked through (--home-seed ...); empty: the reference flat.
[[nodiscard]] Words simulate_words(const Words& home, const SimulatedWalk& walk,
                                   const std::filesystem::path& output);

// Adds --network FILE for each.
[[nodiscard]] Words with_networks(Words words, std::span<const std::filesystem::path> networks);

// "rooms eval" of a home by recordings, with the simple methods but the vote of features, which
// takes most of the time and finds little (docs/experiments/rooms-first-homes.md). `margin`: frames
// that are left out on both sides of a room's boundary.
[[nodiscard]] Words room_trial_words(const std::filesystem::path& home, int margin);

// Keys of what "rooms eval" prints, and how a table calls them.
struct RoomWay {
  const char* key;
  const char* title;
};
inline constexpr std::array<RoomWay, 11> kRoomWays{
    {{"baseline_colors", "baseline: most alike colours (HSV)"},
     {"baseline_nearest", "baseline: nearest features"},
     {"paper_single", "the paper's way, one picture"},
     {"paper_pair_without_objects", "the paper's way, two pictures, no objects"},
     {"paper_pair", "the paper's way, two pictures"},
     {"single", "one picture"},
     {"pair", "two pictures"},
     {"stream", "every picture of a walk"},
     {"single_place", "one picture, with its place"},
     {"pair_place", "two pictures, with their place"},
     {"stream_place", "every picture of a walk, with its place"}}};

}  // namespace roomwise::studies
