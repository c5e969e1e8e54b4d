#pragma once

#include <optional>
#include <string>
#include <vector>

#include "roomwise/evaluation/report/html_report.h"
#include "roomwise/home/home.h"
#include "roomwise/pipeline/rooms/room_evaluation.h"
#include "roomwise/pipeline/run_context.h"
#include "roomwise/recording/trajectory_file.h"

namespace roomwise::pipeline {

// What a report may say besides what the home holds.
struct ReportExtras {
  std::string name;                            // of the home, for people
  std::optional<recording::Trajectory> truth;  // the true trajectory, if it is known
  std::vector<evaluation::ReportContent::Recognition> recognition;  // results of evaluate_rooms
};

// Gathers what a report says about a home.
[[nodiscard]] Expected<evaluation::ReportContent> report_content(const home::Home& home,
                                                                 const ReportExtras& extras,
                                                                 RunContext& run);

}  // namespace roomwise::pipeline
