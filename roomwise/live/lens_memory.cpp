#include "roomwise/live/lens_memory.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "roomwise/base/file.h"

namespace roomwise::live {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMaxLensesOfDevice = 8;

Json to_json(const motion::LensEstimate& lens) {
  const Eigen::Matrix2d& information = lens.information;
  return {{"log_focal", lens.mean[0]},
          {"k1", lens.mean[1]},
          {"information", {information(0, 0), information(0, 1), information(1, 1)}}};
}

motion::LensEstimate lens_of(const Json& json) {
  motion::LensEstimate lens;
  lens.mean << json.at("log_focal").get<double>(), json.at("k1").get<double>();
  const auto information = json.at("information").get<std::array<double, 3>>();
  lens.information << information[0], information[1], information[1], information[2];
  return lens;
}

bool is_usable(const motion::LensEstimate& lens) {
  return std::abs(lens.mean[0]) < 3 && std::abs(lens.mean[1]) < 3 && lens.information.allFinite() &&
         lens.information(0, 0) > 0 && lens.information.determinant() > 0;
}

}  // namespace

Expected<std::unique_ptr<LensMemory>> LensMemory::open(std::filesystem::path file) {
  std::unique_ptr<LensMemory> memory(new LensMemory(std::move(file)));
  if (std::filesystem::exists(memory->file_)) ROOMWISE_CHECK_OK(memory->read());
  return memory;
}

Expected<void> LensMemory::read() {
  const auto damaged = [&](std::string_view what) {
    return fail("{}: {}; delete the file, and phones' lenses are learned anew", file_.string(),
                what);
  };
  ROOMWISE_TRY(const std::string text, read_text_file(file_));
  try {
    const Json json = Json::parse(text);
    for (const Json& one : json.at("lenses")) {
      const motion::LensEstimate lens = lens_of(one);
      if (!is_usable(lens)) return damaged("a lens has numbers that cannot be");
      lenses_[{one.at("device").get<std::int64_t>(), one.at("lens").get<std::string>()}] = {
          mapping::LensCalibration(lens), ++learned_};
    }
  } catch (const Json::exception& error) {
    return damaged(error.what());
  }
  saved_ = learned_;
  return {};
}

mapping::LensCalibration LensMemory::recall(std::int64_t device, const std::string& lens) const {
  const std::scoped_lock lock(mutex_);
  const auto known = lenses_.find({device, lens});
  return known == lenses_.end() ? mapping::LensCalibration() : known->second.calibration;
}

void LensMemory::learn(std::int64_t device, const std::string& lens,
                       const mapping::LensCalibration& calibration) {
  const std::scoped_lock lock(mutex_);
  lenses_[{device, lens}] = {calibration, ++learned_};
  const auto first = lenses_.lower_bound({device, ""});
  const auto last = lenses_.lower_bound({device + 1, ""});
  if (static_cast<std::size_t>(std::distance(first, last)) <= kMaxLensesOfDevice) return;
  lenses_.erase(std::min_element(first, last, [](const auto& a, const auto& b) {
    return a.second.learned_at < b.second.learned_at;
  }));
}

Expected<void> LensMemory::save() {
  const std::scoped_lock lock(mutex_);
  if (saved_ == learned_) return {};
  // The latest last, as they are learned when they are read.
  std::vector<Lenses::const_iterator> latest;
  for (auto one = lenses_.cbegin(); one != lenses_.cend(); ++one) latest.push_back(one);
  std::ranges::sort(latest, {}, [](const auto& one) { return one->second.learned_at; });
  Json json{{"lenses", Json::array()}};
  for (const auto& one : latest) {
    Json lens = to_json(one->second.calibration.known());
    lens["device"] = one->first.first;
    lens["lens"] = one->first.second;
    json["lenses"].push_back(std::move(lens));
  }
  ROOMWISE_CHECK_OK(write_file(file_, json.dump(1)));
  saved_ = learned_;
  return {};
}

Expected<void> LensMemory::forget() {
  const std::scoped_lock lock(mutex_);
  lenses_.clear();
  saved_ = learned_;
  std::error_code error;
  std::filesystem::remove(file_, error);
  if (error) return fail("{}: could not be removed: {}", file_.string(), error.message());
  return {};
}

}  // namespace roomwise::live
