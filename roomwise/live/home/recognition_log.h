#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "roomwise/base/file.h"
#include "roomwise/service/credentials/identity.h"
#include "roomwise/service/protocol/messages.h"

namespace roomwise::live {

// A look that changed what was said of a device's room.
struct Recognition {
  std::uint64_t number = 0;
  service::Identity who;
  std::int64_t time_s = 0;  // since 1970
  service::Seen seen;
  Bytes picture;  // as the device sent it
};

// The last recognitions, with their pictures, in memory alone. Thread-safe.
class RecognitionLog {
 public:
  static constexpr std::size_t kMax = 50;

  // Kept only if the device's verdict or room is another than at its last one.
  void add(const service::Identity& who, std::int64_t time_s, const service::Seen& seen,
           const Bytes& picture);
  [[nodiscard]] std::vector<Recognition> newest_first() const;  // without pictures
  [[nodiscard]] std::optional<Bytes> picture(std::uint64_t number) const;
  void clear();

 private:
  mutable std::mutex mutex_;
  std::deque<Recognition> entries_;
  std::map<std::int64_t, std::string> last_;  // of each device: verdict and room
  std::uint64_t next_ = 1;
};

}  // namespace roomwise::live
