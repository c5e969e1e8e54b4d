#include "roomwise/live/home/lens_memory.h"

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

Json to_json(const motion::IntrinsicsEstimate& lens) {
  const Eigen::Matrix2d& information = lens.information;
  return {{"log_focal", lens.mean[0]},
          {"k1", lens.mean[1]},
          {"information", {information(0, 0), information(0, 1), information(1, 1)}}};
}

motion::IntrinsicsEstimate lens_of(const Json& json) {
  motion::IntrinsicsEstimate lens;
  lens.mean << json.at("log_focal").get<double>(), json.at("k1").get<double>();
  const auto information = json.at("information").get<std::array<double, 3>>();
  lens.information << information[0], information[1], information[1], information[2];
  return lens;
}

// x, y, z, qx, qy, qz, qw, as in a trajectory, to a tenth of a millimetre: views that are told
// apart are much further apart.
double rounded(double value) {
  return std::round(value * 1e4) / 1e4;
}
Json to_json(const geometry::RigidTransform& pose) {
  Json numbers = Json::array();
  for (const double value : pose.translation) numbers.push_back(rounded(value));
  for (const double value : pose.rotation.coeffs()) numbers.push_back(rounded(value));
  return numbers;
}
geometry::RigidTransform view_of(const Json& json) {
  const auto n = json.get<std::array<double, 7>>();
  return {Eigen::Quaterniond(n[6], n[3], n[4], n[5]), {n[0], n[1], n[2]}};
}
bool is_usable_view(const geometry::RigidTransform& view) {
  constexpr double kRounding = 1e-3;
  return view.is_finite() && std::abs(view.rotation.norm() - 1) < kRounding;
}
// Files of earlier versions have none.
std::vector<geometry::RigidTransform> views_of(const Json& lens) {
  std::vector<geometry::RigidTransform> views;
  if (!lens.contains("views")) return views;
  for (const Json& view : lens.at("views")) views.push_back(view_of(view));
  return views;
}

bool is_usable(const motion::IntrinsicsEstimate& lens) {
  return std::abs(lens.mean[0]) < 3 && std::abs(lens.mean[1]) < 3 && lens.information.allFinite() &&
         lens.information(0, 0) > 0 && lens.information.determinant() > 0;
}

}  // namespace

Expected<std::unique_ptr<LensMemory>> LensMemory::open(std::filesystem::path file) {
  std::unique_ptr<LensMemory> memory(new LensMemory(std::move(file)));
  std::error_code ignored;
  if (!std::filesystem::exists(memory->file_, ignored)) return memory;
  if (const auto read = memory->read(); !read) {
    ROOMWISE_RETURN_IF_ERROR(memory->set_file_aside(read.error()));
  }
  return memory;
}

std::filesystem::path LensMemory::damaged_file() const {
  return file_.string() + ".damaged";
}

Expected<void> LensMemory::set_file_aside(const Error& why) {
  lenses_.clear();
  std::error_code error;
  std::filesystem::rename(file_, damaged_file(), error);
  if (error) {
    return fail("{}; it cannot be set aside either: {}; delete it", why.message, error.message());
  }
  set_aside_ = fmt::format("{}; it is now {}, and phones' lenses are learned anew", why.message,
                           damaged_file().string());
  return {};
}

Expected<void> LensMemory::read() {
  const auto damaged = [&](std::string_view what) {
    return fail("{}: is damaged: {}", file_.string(), what);
  };
  ROOMWISE_TRY(const std::string text, read_text_file(file_));
  try {
    const Json json = Json::parse(text);
    for (const Json& one : json.at("lenses")) {
      const motion::IntrinsicsEstimate lens = lens_of(one);
      std::vector<geometry::RigidTransform> views = views_of(one);
      if (!is_usable(lens) || !std::ranges::all_of(views, is_usable_view)) {
        return damaged("a lens has numbers that cannot be");
      }
      for (auto& view : views) view.rotation.normalize();
      lenses_[{one.at("device").get<std::int64_t>(), one.at("lens").get<std::string>()}] = {
          mapping::LensCalibration(lens, std::move(views)), ++learned_};
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
    lens["views"] = Json::array();
    for (const auto& view : one->second.calibration.counted()) {
      lens["views"].push_back(to_json(view));
    }
    json["lenses"].push_back(std::move(lens));
  }
  ROOMWISE_RETURN_IF_ERROR(write_file(file_, json.dump()));
  saved_ = learned_;
  return {};
}

Expected<void> LensMemory::forget() {
  const std::scoped_lock lock(mutex_);
  lenses_.clear();
  saved_ = learned_;
  for (const std::filesystem::path& file : {file_, damaged_file()}) {
    std::error_code error;
    std::filesystem::remove(file, error);
    if (error) return fail("{}: could not be removed: {}", file.string(), error.message());
  }
  return {};
}

}  // namespace roomwise::live
