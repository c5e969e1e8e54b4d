#pragma once

#include <span>

#include "command.h"
#include "roomwise/evaluation/report/reliability.h"

namespace roomwise::app {

inline Json reliability_json(std::span<const evaluation::Forecast> forecasts) {
  Json json = Json::array();
  for (const evaluation::ReliabilityBin& bin : evaluation::reliability_curve(forecasts)) {
    json.push_back({{"from", bin.low},
                    {"to", bin.high},
                    {"mean", bin.mean},
                    {"right", bin.right.successes},
                    {"things", bin.right.n}});
  }
  return json;
}

}  // namespace roomwise::app
