#include "laboratory/studies/paper_published.h"

#include <array>

namespace roomwise::studies {
namespace {

enum PublishedBy : std::size_t { kPaper, kRgbdSlam, kOrbSlamPublished, kOrbSlam, kRtabMap };

constexpr std::array<Source, 5> kSources{
    {{"the paper",
      "Using Semantic Maps for Room Recognition to Aid Visually Impaired People: as published. Its "
      "rooms were its own recordings, decided on a GTX 980.",
      true},
     {"RGBDSLAM", "Endres et al.: as published.", true},
     {"ORB-SLAM2", "with RGB-D: as published.", true},
     {"ORB-SLAM2",
      "on the same files, three runs, on such a machine as Roomwise's benchmarks name "
      "(docs/experiments/mapping-methods.md).",
      false},
     {"RTAB-Map 0.23", "on the same files, five runs, on such a machine (the same).", false}}};

constexpr std::array<PublishedTrajectory, 15> kTrajectories{{
    {"fr1/desk", kPaper, "", "0.064", ""},
    {"fr1/desk", kRgbdSlam, "", "0.026", ""},
    {"fr1/desk", kOrbSlamPublished, "", "0.016", ""},
    {"fr1/xyz", kPaper, "", "0.013", ""},
    {"fr1/xyz", kRgbdSlam, "", "0.014", ""},
    {"fr1/xyz", kOrbSlamPublished, "", "0.010", ""},
    {"fr2/xyz", kPaper, "", "0.015", ""},
    {"fr2/xyz", kRgbdSlam, "", "0.008", ""},
    {"fr2/xyz", kOrbSlamPublished, "", "0.004", ""},
    {"fr3/long", kPaper, "", "0.028", ""},
    {"fr3/long", kRgbdSlam, "", "0.032", ""},
    {"fr3/long", kOrbSlamPublished, "", "0.010", ""},
    {"fr1/rpy", kOrbSlam, "", "0.0216 (0.0208 to 0.0230)", "52 to 58"},
    {"fr1/rpy", kRtabMap, "", "0.028 to 0.091", "72 to 79"},
    {"office_walk", kOrbSlam, "288 of 373", "0.25", ""},
}};

constexpr std::array<PublishedRooms, 4> kRooms{{
    {"light", "two pictures, no objects", kPaper, "0.9660", "8.8"},
    {"light", "two pictures", kPaper, "0.9780", "18.3"},
    {"things moved", "two pictures, no objects", kPaper, "0.9808", "8.8"},
    {"things moved", "two pictures", kPaper, "0.9864", "18.3"},
}};

}  // namespace

std::span<const Source> published_sources() {
  return kSources;
}
std::span<const PublishedTrajectory> published_trajectories() {
  return kTrajectories;
}
std::span<const PublishedRooms> published_rooms() {
  return kRooms;
}

}  // namespace roomwise::studies
