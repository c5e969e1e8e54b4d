#include "roomwise/motion/view_alignment.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "roomwise/motion/view_linearization.h"

namespace roomwise::motion {
namespace {

using geometry::Matrix6d;
using geometry::RigidTransform;
using geometry::Vector6d;

// The error of a pose against the prior as a twist of the current frame.
Vector6d prior_error(const RigidTransform& current_from_reference, const PosePrior& prior) {
  // exp(error) * predicted = pose.
  const RigidTransform difference = current_from_reference * prior.reference_from_current;
  const Eigen::AngleAxisd turn(difference.rotation);
  Vector6d error;
  error << turn.angle() * turn.axis(), difference.translation;
  return error;
}

// A pose on its way.
struct SearchState {
  RigidTransform current_from_reference;
  Exposure exposure;
  NormalEquations equations;  // at the pose before the last step
};

// The search at one level: its points, and how far apart surfaces may be there.
class LevelAlignment {
 public:
  LevelAlignment(const PyramidLevel& reference, const PyramidLevel& current, int stride,
                 double max_correspondence_m, const PosePrior& prior,
                 const ViewAlignmentOptions& options)
      : points_(surface_points(reference, stride)),
        current_(current),
        max_step_m_(max_correspondence_m),
        prior_(prior),
        prior_information_(twist_information(prior.information)),
        options_(options) {}

  // Gauss and Newton's method from where the state is; false where it has no solution.
  bool refine(SearchState& state, int max_iterations, double min_step) const {
    state.exposure =
        find_exposure(points_, current_, state.current_from_reference, max_step_m_, options_);
    for (int iteration = 0; iteration < max_iterations; ++iteration) {
      state.equations = linearize_at(state);
      state.exposure = state.equations.exposure;
      const Matrix6d hessian = state.equations.hessian + prior_information_;
      const Vector6d gradient =
          state.equations.gradient +
          prior_information_ * prior_error(state.current_from_reference, prior_);
      const Vector6d step = -hessian.ldlt().solve(gradient);
      if (!step.allFinite()) return false;
      state.current_from_reference = RigidTransform::exp(step) * state.current_from_reference;
      if (step.norm() < min_step) break;
    }
    return true;
  }
  [[nodiscard]] NormalEquations linearize_at(const SearchState& state) const {
    return linearize(points_, current_, state.current_from_reference, state.exposure, max_step_m_,
                     options_);
  }

 private:
  std::vector<SurfacePoint> points_;
  const PyramidLevel& current_;
  double max_step_m_;
  const PosePrior& prior_;
  Matrix6d prior_information_;
  const ViewAlignmentOptions& options_;
};

bool is_same_pose(const RigidTransform& a, const RigidTransform& b) {
  constexpr double kTranslation_m = 0.03;
  constexpr double kRotation_rad = 0.02;
  const RigidTransform difference = a.inverse() * b;
  return difference.distance_m() < kTranslation_m && difference.angle_rad() < kRotation_rad;
}

}  // namespace

PosePrior PosePrior::around(const RigidTransform& reference_from_current,
                            double translation_sigma_m, double rotation_sigma_rad) {
  PosePrior prior{reference_from_current, Matrix6d::Zero()};
  prior.information.diagonal().head<3>().setConstant(1 /
                                                     (translation_sigma_m * translation_sigma_m));
  prior.information.diagonal().tail<3>().setConstant(4 / (rotation_sigma_rad * rotation_sigma_rad));
  return prior;
}

Expected<void> ViewAlignmentOptions::validate() const {
  if (!(gray_sigma > 0)) return fail("gray_sigma = {} must be positive", gray_sigma);
  if (!(place_sigma_px >= 0)) {
    return fail("place_sigma_px = {} must not be negative", place_sigma_px);
  }
  if (!(depth_sigma_m > 0)) return fail("depth_sigma_m = {} must be positive", depth_sigma_m);
  if (!(min_gray_slope >= 0)) {
    return fail("min_gray_slope = {} must not be negative", min_gray_slope);
  }
  for (const auto& [name, share] :
       {std::pair("min_overlap", min_overlap), std::pair("min_agreeing", min_agreeing),
        std::pair("max_seen_through", max_seen_through)}) {
    if (!(share >= 0 && share <= 1)) return fail("{} = {} must be between 0 and 1", name, share);
  }
  return {};
}

double squared_mahalanobis(const RigidTransform& reference_from_current, const PosePrior& prior) {
  const Vector6d error = prior_error(reference_from_current.inverse(), prior);
  return error.dot(twist_information(prior.information) * error);
}

ViewAlignment align_views(const RgbdPyramid& reference, const RgbdPyramid& current,
                          const PosePrior& prior, const ViewAlignmentOptions& options) {
  ViewAlignment alignment;
  const std::size_t levels = std::min(reference.levels.size(), current.levels.size());
  std::vector<SearchState> starts(1);
  starts[0].current_from_reference = prior.reference_from_current.inverse();
  if (prior.other_start) {
    starts.emplace_back().current_from_reference = prior.other_start->inverse();
  }
  // The finer, the more pixels say the same.
  constexpr std::array kStrides{4, 2, 1};
  for (std::size_t i = levels; i-- > 0;) {
    const bool is_finest = i == 0;
    // Surfaces may be further apart while the pose is still rough.
    const LevelAlignment level(reference.levels[i], current.levels[i],
                               kStrides[std::min(i, kStrides.size() - 1)],
                               0.05 * static_cast<double>(1U << i), prior, options);
    std::erase_if(starts, [&](SearchState& state) {
      return !level.refine(state, is_finest ? 5 : 10, is_finest ? 2e-5 : 1e-4);
    });
    if (starts.empty()) return alignment;
    if (starts.size() == 2 && i <= 1) {
      // What the middle level says decides.
      for (SearchState& state : starts) state.equations = level.linearize_at(state);
      std::ranges::stable_sort(starts, {},
                               [](const SearchState& state) { return state.equations.cost; });
      constexpr double kClearlyBetter = 1.3;
      alignment.is_ambiguous =
          !is_same_pose(starts[0].current_from_reference, starts[1].current_from_reference) &&
          starts[1].equations.cost < kClearlyBetter * starts[0].equations.cost;
      starts.pop_back();
    }
  }
  const NormalEquations& equations = starts[0].equations;
  if (equations.measured == 0) return alignment;
  alignment.measured_information = edge_information(equations.hessian);
  alignment.pose = {starts[0].current_from_reference.inverse(),
                    edge_information(equations.hessian + twist_information(prior.information)),
                    std::sqrt(equations.squares / static_cast<double>(equations.measured))};
  alignment.agreement = compare_views(reference, current, alignment.pose.reference_from_current);
  alignment.found = alignment.agreement.overlap >= options.min_overlap &&
                    alignment.agreement.agreeing >= options.min_agreeing &&
                    alignment.agreement.seen_through <= options.max_seen_through;
  return alignment;
}

}  // namespace roomwise::motion
