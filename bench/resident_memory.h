#pragma once

#include <unistd.h>

#include <fstream>
#include <limits>

namespace roomwise::bench {

// Memory of this process that lies in the machine's, in MB of 2^20 bytes as everywhere here; as
// proc(5) tells it. NaN where that is not to be had.
inline double resident_mb() {
  std::ifstream statm("/proc/self/statm");
  double pages = 0;
  double resident_pages = std::numeric_limits<double>::quiet_NaN();
  statm >> pages >> resident_pages;
  return resident_pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

}  // namespace roomwise::bench
