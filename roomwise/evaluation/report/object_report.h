#pragma once

#include <string>
#include <vector>

#include "roomwise/evaluation/errors/object_error.h"
#include "roomwise/evaluation/report/reliability.h"
#include "roomwise/evaluation/report/report_page.h"

namespace roomwise::evaluation {

// What a page about the objects of a home says.
struct ObjectReportContent {
  struct Way {
    std::string name;  // "joined from regions"
    ObjectErrors errors;
    std::size_t without_place = 0;
  };
  std::string title;
  std::vector<std::string> notes;  // how it was measured
  std::vector<Way> ways;
  std::string shown_way;                    // the one whose pictures follow
  std::vector<ReliabilityBin> reliability;  // of its probabilities
  std::vector<PictureNote> wrong, duplicates, missed, found;
};

// A page (report_page.h).
[[nodiscard]] std::string render_object_report(const ObjectReportContent& content);

}  // namespace roomwise::evaluation
