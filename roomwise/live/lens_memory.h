#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <string>
#include <utility>

#include "roomwise/base/expected.h"
#include "roomwise/mapping/localization/lens_calibration.h"

namespace roomwise::live {

// What was learned of the lenses of devices whose cameras nobody calibrated, kept in a file beside
// the home: a phone that comes back need not be learned anew. Thread-safe.
class LensMemory {
 public:
  // Nothing is known where there is no file. Fails, naming the file, where it cannot be read.
  [[nodiscard]] static Expected<std::unique_ptr<LensMemory>> open(std::filesystem::path file);

  // Of a device's lens by the name that the device gives it; that of phones where none is known.
  [[nodiscard]] mapping::LensCalibration recall(std::int64_t device, const std::string& lens) const;
  // Of a device the latest lenses are kept, some eight.
  void learn(std::int64_t device, const std::string& lens,
             const mapping::LensCalibration& calibration);
  // Writes what was learned since it was last written.
  [[nodiscard]] Expected<void> save();
  // All of it, the file too.
  [[nodiscard]] Expected<void> forget();

 private:
  struct Known {
    mapping::LensCalibration calibration;
    std::uint64_t learned_at = 0;  // counts what was learned
  };
  using Lenses = std::map<std::pair<std::int64_t, std::string>, Known>;

  explicit LensMemory(std::filesystem::path file) : file_(std::move(file)) {}
  [[nodiscard]] Expected<void> read();

  const std::filesystem::path file_;
  mutable std::mutex mutex_;
  Lenses lenses_;
  std::uint64_t learned_ = 0, saved_ = 0;
};

}  // namespace roomwise::live
