#pragma once

#include <unistd.h>

#include <fstream>
#include <limits>

namespace roomwise::bench {

// How much of the machine's memory this process takes, as proc(5) tells it, in MB of 2^20 bytes
// like the commands' working sets. NaN where the system does not say.
inline double resident_mb() {
  std::ifstream statm("/proc/self/statm");
  double pages = 0;
  double resident_pages = std::numeric_limits<double>::quiet_NaN();
  statm >> pages >> resident_pages;
  return resident_pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

}  // namespace roomwise::bench
