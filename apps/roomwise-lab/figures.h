#pragma once

#include <optional>
#include <string>
#include <vector>

#include "command.h"
#include "roomwise/evaluation/statistics/quantile.h"

// Figures of what may not be there: of nothing they are absent, and not 0, which would be no error.
namespace roomwise::app {

inline std::optional<double> quantile_of(std::vector<double> values, double share) {
  if (values.empty()) return std::nullopt;
  return evaluation::quantile(std::move(values), share);
}
inline Json json_or_null(const std::optional<double>& figure) {
  return figure ? Json(*figure) : Json(nullptr);
}
inline std::string text_or_none(const std::optional<double>& figure, int decimals = 2) {
  return figure ? fmt::format("{:.{}f}", *figure, decimals) : "–";
}

}  // namespace roomwise::app
