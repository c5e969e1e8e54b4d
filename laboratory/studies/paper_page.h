#pragma once

#include <string>

#include "laboratory/studies/paper_results.h"

namespace roomwise::studies {

// The tables as one page (evaluation/report_page.h), with what others published beside each and
// what is missing below it. The same results give the same page.
[[nodiscard]] std::string paper_page(const PaperResults& results);

}  // namespace roomwise::studies
