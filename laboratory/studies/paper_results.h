#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/evaluation/report/training_report.h"
#include "roomwise/evaluation/statistics/proportion.h"

// What the tables of the paper say, as plain values.
namespace roomwise::studies {

enum class PaperPart { kMapping, kObjects, kRooms, kTraining };
struct PaperPartName {
  PaperPart part;
  std::string_view name;
};
inline constexpr std::array<PaperPartName, 4> kPaperParts{{{PaperPart::kMapping, "mapping"},
                                                           {PaperPart::kObjects, "objects"},
                                                           {PaperPart::kRooms, "rooms"},
                                                           {PaperPart::kTraining, "training"}}};

// Of what a figure was measured.
struct MeasuredData {
  std::string name;  // "fr1/rpy"
  bool is_simulated = false;
};

// One map of a recording. Times are of processors, all threads together, a frame.
struct MappingTrial {
  double frames = 0;
  double placed = 0;  // frames with a pose
  double ate_m = 0;
  std::optional<double> rpe_m;  // over 1 s
  double reading_ms = 0;
  double features_ms = 0;
  double views_ms = 0;
  double tracking_ms = 0;  // with loops; of the default with the features found on the way
  double solving_ms = 0;
  double floor_ms = 0;  // the surface that the floor is found on, and the floor
  double all_ms = 0;
};
struct MappingRow {
  MeasuredData data;
  std::string method;                // of `roomwise map`: paper, combined
  std::string features;              // surf, sift, orb
  std::vector<MappingTrial> trials;  // a seed each; at least one
};

// Objects against what is there.
struct ObjectsRow {
  MeasuredData data;
  std::string way;
  std::uint64_t found = 0, missed = 0, beyond = 0, twice = 0, wrong = 0;
  std::optional<double> from_middle_m;  // median of those found
};
// One that the paper's rules find.
struct RuledObject {
  MeasuredData data;
  std::string name;
  double score = 0;
  std::uint64_t keyframes = 0;
  bool has_place = false;
};

struct RoomsRow {
  std::string changed;  // since the rooms were learned: "light"
  MeasuredData data;
  std::string way;
  std::uint64_t decisions = 0;
  evaluation::Proportion right_of_named;
  evaluation::Interval interval;  // 95 %, of that
  double ms = 0;                  // a decision
};

struct PaperResults {
  int seeds = 1;
  std::vector<std::string> networks;  // files that looked at pictures
  std::vector<PaperPart> parts;       // that were asked for
  std::vector<MappingRow> mapping;
  std::vector<ObjectsRow> objects;
  std::vector<RuledObject> ruled_objects;
  std::vector<RoomsRow> rooms;
  std::optional<evaluation::TrainingReportContent> training;
  // What is missing in each part and why, a sentence each.
  std::map<PaperPart, std::vector<std::string>> missing;
};

}  // namespace roomwise::studies
