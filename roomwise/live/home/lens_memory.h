#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "roomwise/base/expected.h"
#include "roomwise/mapping/localization/lens_calibration.h"

namespace roomwise::live {

// What was learned of the lenses of devices whose cameras nobody calibrated, and from which views,
// kept in a file beside the home: a phone that comes back need not be learned anew, and its old
// views are not counted again. Thread-safe.
class LensMemory {
 public:
  // Nothing is known where there is no file. One that is damaged is set aside, as FILE.damaged, and
  // lenses are learned anew. Fails where it can be neither read nor set aside.
  [[nodiscard]] static Expected<std::unique_ptr<LensMemory>> open(std::filesystem::path file);

  // What was wrong with a file that was set aside, and where it is now.
  [[nodiscard]] const std::optional<std::string>& set_aside() const { return set_aside_; }

  // Of a device's lens by the name that the device gives it; that of phones where none is known.
  [[nodiscard]] mapping::LensCalibration recall(std::int64_t device, const std::string& lens) const;
  // Of a device the latest lenses are kept, some eight.
  void learn(std::int64_t device, const std::string& lens,
             const mapping::LensCalibration& calibration);
  // Writes what was learned since it was last written.
  [[nodiscard]] Expected<void> save();
  // All of it, the files too.
  [[nodiscard]] Expected<void> forget();

 private:
  struct Known {
    mapping::LensCalibration calibration;
    std::uint64_t learned_at = 0;  // counts what was learned
  };
  using Lenses = std::map<std::pair<std::int64_t, std::string>, Known>;

  explicit LensMemory(std::filesystem::path file) : file_(std::move(file)) {}
  [[nodiscard]] Expected<void> read();
  [[nodiscard]] std::filesystem::path damaged_file() const;
  [[nodiscard]] Expected<void> set_file_aside(const Error& why);

  const std::filesystem::path file_;
  std::optional<std::string> set_aside_;
  mutable std::mutex mutex_;
  Lenses lenses_;
  std::uint64_t learned_ = 0, saved_ = 0;
};

}  // namespace roomwise::live
