#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <string_view>

namespace roomwise::geometry {

enum class Termination {
  kConverged,
  kMaxIterations,
  kNoStepFound,  // the damping grew without end, and no step lowered the cost
  kInterrupted,
};

[[nodiscard]] inline std::string_view to_string(Termination termination) {
  switch (termination) {
    case Termination::kConverged:
      return "converged";
    case Termination::kMaxIterations:
      return "stopped at the limit of iterations";
    case Termination::kNoStepFound:
      return "no step lowers the cost";
    case Termination::kInterrupted:
      return "interrupted";
  }
  return "unknown";
}

// D: what of a Hessian's diagonal the damping adds. Directions about which nothing is known are
// held by a small part of the largest weight.
template <typename Diagonal>
[[nodiscard]] typename Diagonal::PlainObject damping_weights(
    const Eigen::MatrixBase<Diagonal>& diagonal) {
  return diagonal.cwiseMax(1e-9 * diagonal.maxCoeff());
}

// A step along the search direction of the damped normal equations (H + damping D) step = rhs.
struct DampedStep {
  // By how much the cost's quadratic model, cost - 2 rhs . step + step . H step, is lower after it:
  // rhs . step + damping step . D step.
  double predicted_reduction = 0;
  double length = 0;
};

struct MinimizerOptions {
  int max_iterations = 100;
  // Converged when an iteration that is hardly damped lowers the cost, or promises to, by less than
  // this part of it.
  double relative_tolerance = 0;
  double min_step_length = 0;  // a shorter step is none
  double initial_damping = 1e-6;
  double min_damping = 1e-9;
  double max_damping = 1e9;
};

struct MinimizerSummary {
  double initial_cost = 0;
  double final_cost = 0;
  int iterations = 0;
  Termination termination = Termination::kConverged;

  [[nodiscard]] bool converged() const { return termination == Termination::kConverged; }
};

// Levenberg and Marquardt's damped least squares with Nielsen's choice of the damping (Madsen,
// Nielsen and Tingleff, "Methods for non-linear least squares problems", 2004, section 3.2; here
// the damping falls by up to 10 at a time, and scales with the diagonal). A problem holds the
// variables and has
//   double cost();                                    at the variables as they are
//   void linearize();                                 there, too
//   std::optional<DampedStep> solve(double damping);  nothing: no solution in double precision
//   void take_step(); void undo_step();               move the variables by what solve() found
// `should_continue` is asked before each iteration, and the first no ends the work where it is.
template <typename Problem>
MinimizerSummary minimize(
    Problem& problem, const MinimizerOptions& options,
    const std::function<bool()>& should_continue = [] { return true; }) {
  MinimizerSummary summary;
  double cost = summary.initial_cost = problem.cost();
  double damping = options.initial_damping;
  double growth = 2;
  bool needs_linearization = true;
  bool converged = false;
  const auto end = [&](Termination termination) {
    summary.final_cost = cost;
    summary.termination = termination;
    return summary;
  };
  while (!converged) {
    if (summary.iterations == options.max_iterations) return end(Termination::kMaxIterations);
    if (!(damping <= options.max_damping)) return end(Termination::kNoStepFound);
    if (!should_continue()) return end(Termination::kInterrupted);
    ++summary.iterations;
    if (needs_linearization) problem.linearize();
    needs_linearization = false;
    if (const std::optional<DampedStep> step = problem.solve(damping)) {
      problem.take_step();
      const double new_cost = problem.cost();
      const double reduction = cost - new_cost;
      const double gain_ratio = reduction / step->predicted_reduction;
      // A short step of a heavily damped problem says nothing.
      const bool is_damped = damping > options.initial_damping;
      const double min_reduction = options.relative_tolerance * cost;
      converged = step->length <= options.min_step_length ||
                  (!is_damped && step->predicted_reduction <= min_reduction);
      if (new_cost <= cost) {
        converged |= !is_damped && gain_ratio > 0.5 && reduction <= min_reduction;
        damping *= std::max(1 - std::pow(2 * gain_ratio - 1, 3), 0.1);
        damping = std::max(damping, options.min_damping);
        growth = 2;
        cost = new_cost;
        needs_linearization = true;
        continue;
      }
      problem.undo_step();
    }
    damping *= growth;
    growth *= 2;
  }
  return end(Termination::kConverged);
}

}  // namespace roomwise::geometry
