#pragma once

#include <fstream>
#include <limits>
#include <string>

namespace roomwise::bench {

// The most memory that this process has taken since reset_peak_memory() was called last, in MB of
// 2^20 bytes. NaN where the system does not say.
inline double peak_mb() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) return std::stod(line.substr(6)) / 1024;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

// As proc(5) has it; without effect where the system does not allow it.
inline void reset_peak_memory() {
  std::ofstream("/proc/self/clear_refs") << 5;
}

}  // namespace roomwise::bench
