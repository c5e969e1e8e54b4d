#pragma once

#include <Eigen/Core>
#include <deque>
#include <functional>

namespace roomwise::rooms {

// Finds the minimum of a smooth convex function by L-BFGS (Liu and Nocedal, 1989) with steps that
// are halved until they lead down. It asks and is told, so that several minima can be looked for
// with one evaluation of all at a time:
//
//   Lbfgs minimizer(start, tolerance);
//   while (!minimizer.done()) minimizer.tell(f(minimizer.place()), gradient(minimizer.place()));
class Lbfgs {
 public:
  // Multiplies by a matrix, symmetric and positive definite.
  using Product = std::function<Eigen::VectorXd(const Eigen::VectorXd&)>;

  // Done when the largest element of the gradient is below the tolerance, or where no step leads
  // down any more, since the function is not more exact. `inverse_curvature`: what the inverse of
  // the second derivatives is about; the nearer, the fewer evaluations. Without it, and after a
  // step by it that led nowhere down, it is taken to be alike in all directions.
  Lbfgs(Eigen::VectorXd start, double gradient_tolerance, Product inverse_curvature = {})
      : place_(std::move(start)),
        gradient_tolerance_(gradient_tolerance),
        inverse_curvature_(std::move(inverse_curvature)) {}

  // Where the function is to be evaluated next.
  [[nodiscard]] const Eigen::VectorXd& place() const { return place_; }
  // The lowest place so far; the start before anything was told.
  [[nodiscard]] const Eigen::VectorXd& lowest() const { return begun_ ? best_ : place_; }
  [[nodiscard]] bool done() const { return done_; }
  // The function at place().
  void tell(double value, const Eigen::VectorXd& gradient);

 private:
  struct Change {
    Eigen::VectorXd place;
    Eigen::VectorXd gradient;
    double product = 0;  // of the two
  };
  // The gradient multiplied by what the changes say of the inverse of the second derivatives.
  [[nodiscard]] Eigen::VectorXd downwards() const;
  // The same by inverse_curvature_ alone, scaled so that it fits the last change.
  [[nodiscard]] Eigen::VectorXd downwards_by_guess(const Eigen::VectorXd& gradient) const;
  void begin_step(const Eigen::VectorXd& direction);

  Eigen::VectorXd place_;
  double gradient_tolerance_;
  Product inverse_curvature_;
  bool done_ = false;
  bool begun_ = false;
  // The lowest place, and the step from it that is being tried.
  Eigen::VectorXd best_;
  Eigen::VectorXd gradient_;
  double value_ = 0;
  Eigen::VectorXd step_;
  double share_ = 1;  // of the step
  std::deque<Change> changes_;
};

}  // namespace roomwise::rooms
