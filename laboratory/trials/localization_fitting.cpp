#include "laboratory/trials/localization_fitting.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "laboratory/trials/logistic_regression.h"

namespace roomwise::trials {
namespace {

// A pose within this of the truth is right.
constexpr double kRightPose_m = 0.5, kRightPose_rad = 0.17;
// Ridge penalty of standardised evidence, in poses.
constexpr double kPosePenalty = 1;
constexpr std::size_t kNumbers = std::tuple_size_v<mapping::PoseEvidence>;

// All poses of some cases with their weights: real cases half, simulated ones half, as far as there
// are both.
struct PoseRows {
  Eigen::MatrixXd evidence;
  Eigen::VectorXd is_right, weights;
};

PoseRows rows_of(const std::vector<PoseCase>& cases) {
  std::array<double, 2> counts{};
  for (const PoseCase& one : cases) {
    counts.at(one.is_real) += static_cast<double>(one.evidence.size());
  }
  const double all = counts[0] + counts[1];
  PoseRows rows{Eigen::MatrixXd(static_cast<Eigen::Index>(all), kNumbers),
                Eigen::VectorXd(static_cast<Eigen::Index>(all)),
                Eigen::VectorXd(static_cast<Eigen::Index>(all))};
  Eigen::Index row = 0;
  for (const PoseCase& one : cases) {
    for (std::size_t i = 0; i < one.evidence.size(); ++i, ++row) {
      rows.evidence.row(row) =
          Eigen::Map<const Eigen::RowVectorXd>(one.evidence[i].data(), kNumbers);
      rows.is_right[row] = one.is_right[i] ? 1 : 0;
      rows.weights[row] = 0.5 * all / counts.at(one.is_real);
    }
  }
  return rows;
}

mapping::PoseModel regression(const std::vector<PoseCase>& cases) {
  const PoseRows rows = rows_of(cases);
  const double total = rows.weights.sum();
  const Eigen::RowVectorXd mean = rows.weights.transpose() * rows.evidence / total;
  const Eigen::MatrixXd centred = rows.evidence.rowwise() - mean;
  const Eigen::RowVectorXd deviation =
      (rows.weights.transpose() * centred.array().square().matrix() / total)
          .cwiseMax(1e-12)
          .cwiseSqrt();
  Eigen::MatrixXd design(rows.evidence.rows(), kNumbers + 1);
  design << Eigen::VectorXd::Ones(design.rows()), centred.array().rowwise() / deviation.array();
  Eigen::VectorXd penalty = Eigen::VectorXd::Constant(kNumbers + 1, kPosePenalty);
  penalty[0] = 1e-9;
  const Eigen::VectorXd fitted = logistic_regression(design, rows.is_right, rows.weights, penalty);
  mapping::PoseModel model;
  model.bias = fitted[0];
  for (std::size_t i = 0; i < kNumbers; ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    model.weights[i] = fitted[column + 1] / deviation[column];
    model.bias -= model.weights[i] * mean[column];
  }
  return model;
}

bool share_a_source(const PoseCase& a, const PoseCase& b) {
  return std::ranges::any_of(a.sources,
                             [&](const std::string& source) { return b.sources.contains(source); });
}

struct JudgedPose {
  double probability = 0;
  bool is_right = false;
};

// Each by the model of the cases of other sources, the most probable first.
std::vector<JudgedPose> judge_left_out(const std::vector<PoseCase>& cases) {
  std::vector<JudgedPose> poses;
  for (const PoseCase& own : cases) {
    const mapping::PoseModel model = regression(of_other_sources(cases, own));
    for (std::size_t i = 0; i < own.evidence.size(); ++i) {
      poses.push_back({model.probability(own.evidence[i]), own.is_right[i]});
    }
  }
  std::ranges::sort(poses, std::greater(), &JudgedPose::probability);
  return poses;
}

double naive_share_of_wrong(const std::vector<PoseCase>& cases) {
  double right = 0, wrong = 0;
  for (const PoseCase& one : cases) {
    const PoseCounts counts = naive_counts(one);
    right += static_cast<double>(counts.right);
    wrong += static_cast<double>(counts.wrong);
  }
  return wrong / std::max(1.0, right + wrong);
}

double lowest_threshold(const std::vector<JudgedPose>& poses, double max_wrong) {
  double threshold = 1, answers = 0, wrong = 0;
  for (const JudgedPose& pose : poses) {
    ++answers;
    wrong += pose.is_right ? 0 : 1;
    if (wrong <= max_wrong * answers) threshold = pose.probability;
  }
  return threshold;
}

}  // namespace

PoseCase pose_case(std::string name, std::set<std::string> sources, bool is_real, bool elsewhere,
                   const std::vector<LocalizationTrial>& trials) {
  PoseCase result{std::move(name), std::move(sources), is_real, {}, {}, trials.size()};
  for (const LocalizationTrial& trial : trials) {
    if (trial.answer.status <= mapping::LocalizationStatus::kNoMotion) continue;
    result.evidence.push_back(trial.answer.evidence());
    result.is_right.push_back(!elsewhere && trial.error_m <= kRightPose_m &&
                              trial.error_rad <= kRightPose_rad);
  }
  return result;
}

PoseCounts counts_of(const PoseCase& of, const mapping::PoseModel& model) {
  PoseCounts counts{of.pictures, 0, 0};
  for (std::size_t i = 0; i < of.evidence.size(); ++i) {
    if (model.probability(of.evidence[i]) >= model.min_probability)
      ++(of.is_right[i] ? counts.right : counts.wrong);
  }
  return counts;
}

PoseCounts naive_counts(const PoseCase& of) {
  constexpr double kMinInliers = 40, kMaxRivalRatio = 1 / 1.5;
  PoseCounts counts{of.pictures, 0, 0};
  for (std::size_t i = 0; i < of.evidence.size(); ++i) {
    const auto& [inliers, ratio, coverage, rival] = of.evidence[i];
    if (std::exp(inliers) >= kMinInliers - 0.5 && std::exp(rival) <= kMaxRivalRatio)
      ++(of.is_right[i] ? counts.right : counts.wrong);
  }
  return counts;
}

std::vector<PoseCase> of_other_sources(const std::vector<PoseCase>& cases, const PoseCase& one) {
  std::vector<PoseCase> others;
  std::ranges::remove_copy_if(cases, std::back_inserter(others),
                              [&](const PoseCase& other) { return share_a_source(other, one); });
  return others;
}

Expected<mapping::PoseModel> fit_poses(const std::vector<PoseCase>& cases) {
  std::size_t right = 0, all = 0;
  for (const PoseCase& one : cases) {
    right += static_cast<std::size_t>(std::ranges::count(one.is_right, true));
    all += one.is_right.size();
  }
  if (right == 0 || right == all) {
    return fail("of {} poses {} are right; a fit needs right ones and wrong ones", all, right);
  }
  for (const PoseCase& one : cases) {
    if (!of_other_sources(cases, one).empty()) continue;
    return fail("{}: all cases share a source with it; a fit needs others, to leave it out",
                one.name);
  }
  mapping::PoseModel model = regression(cases);
  model.min_probability = lowest_threshold(judge_left_out(cases), naive_share_of_wrong(cases));
  return model;
}

}  // namespace roomwise::trials
