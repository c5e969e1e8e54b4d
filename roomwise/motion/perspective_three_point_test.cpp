#include "roomwise/motion/perspective_three_point.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/calib3d.hpp>

#include "roomwise/base/random.h"

namespace roomwise::motion {
namespace {

using geometry::RigidTransform;

struct Problem {
  RigidTransform camera_from_points;
  std::array<Eigen::Vector3d, 3> points;
  std::array<Eigen::Vector3d, 3> rays;
};

Problem random_problem(RandomStream& random) {
  const auto vector = [&] {
    return Eigen::Vector3d(random.normal(), random.normal(), random.normal());
  };
  Problem problem;
  geometry::Vector6d twist;
  twist << vector(), vector();
  problem.camera_from_points = RigidTransform::exp(twist);
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3d point_camera(1.5 * random.normal(), random.normal(),
                                       1 + 4 * random.uniform());
    problem.rays[i] = point_camera.normalized();
    problem.points[i] = problem.camera_from_points.inverse() * point_camera;
  }
  return problem;
}

double distance(const RigidTransform& a, const RigidTransform& b) {
  const RigidTransform difference = a.inverse() * b;
  return difference.angle_rad() + difference.distance_m();
}

TEST(SolveP3p, FindsThePoseAmongItsSolutions) {
  RandomStream random(1);
  int found = 0;
  constexpr int kProblems = 2000;
  for (int i = 0; i < kProblems; ++i) {
    const Problem problem = random_problem(random);
    const auto solutions = solve_p3p(problem.points, problem.rays);
    EXPECT_LE(solutions.size(), 4U);
    found += std::ranges::any_of(solutions, [&](const RigidTransform& solution) {
      return distance(solution, problem.camera_from_points) < 1e-4;
    });
  }
  // Near a double root the quartic loses its digits; RANSAC then draws another three.
  EXPECT_GE(found, kProblems * 99 / 100);
}

TEST(SolveP3p, EverySolutionSeesThePointsAlongTheRays) {
  RandomStream random(2);
  int exact = 0;
  int all = 0;
  for (int i = 0; i < 500; ++i) {
    const Problem problem = random_problem(random);
    for (const RigidTransform& solution : solve_p3p(problem.points, problem.rays)) {
      ++all;
      exact += std::ranges::all_of(std::array{0U, 1U, 2U}, [&](std::size_t k) {
        return (solution * problem.points[k]).normalized().dot(problem.rays[k]) > 1 - 1e-6;
      });
    }
  }
  EXPECT_GE(exact, all * 98 / 100);
}

TEST(SolveP3p, HasTheSolutionsOfOpenCv) {
  RandomStream random(3);
  int same = 0;
  constexpr int kProblems = 300;
  for (int i = 0; i < kProblems; ++i) {
    const Problem problem = random_problem(random);
    std::vector<cv::Point3d> points;
    std::vector<cv::Point2d> pixels;
    for (std::size_t k = 0; k < 3; ++k) {
      points.emplace_back(problem.points[k].x(), problem.points[k].y(), problem.points[k].z());
      pixels.emplace_back(problem.rays[k].x() / problem.rays[k].z(),
                          problem.rays[k].y() / problem.rays[k].z());
    }
    std::vector<cv::Mat> rotations;
    std::vector<cv::Mat> translations;
    cv::solveP3P(points, pixels, cv::Mat::eye(3, 3, CV_64F), cv::noArray(), rotations, translations,
                 cv::SOLVEPNP_AP3P);
    const auto ours = solve_p3p(problem.points, problem.rays);
    bool all_found = true;
    for (std::size_t s = 0; s < rotations.size(); ++s) {
      const Eigen::Vector3d omega(rotations[s].at<double>(0), rotations[s].at<double>(1),
                                  rotations[s].at<double>(2));
      const RigidTransform theirs{
          Eigen::Quaterniond(Eigen::AngleAxisd(omega.norm(), omega.normalized())),
          {translations[s].at<double>(0), translations[s].at<double>(1),
           translations[s].at<double>(2)}};
      // OpenCV also gives poses with points behind the camera.
      const bool in_front = std::ranges::all_of(std::array{0U, 1U, 2U}, [&](std::size_t k) {
        return (theirs * problem.points[k]).normalized().dot(problem.rays[k]) > 1 - 1e-6;
      });
      if (!in_front) continue;
      all_found &= std::ranges::any_of(
          ours, [&](const auto& solution) { return distance(solution, theirs) < 1e-3; });
    }
    same += all_found;
  }
  EXPECT_GE(same, kProblems * 90 / 100);
}

TEST(SolveP3p, GivesNothingForPointsOnOneLine) {
  const std::array<Eigen::Vector3d, 3> points{Eigen::Vector3d{0, 0, 2}, {1, 0, 2}, {2, 0, 2}};
  std::array<Eigen::Vector3d, 3> rays = points;
  for (auto& ray : rays) ray.normalize();
  EXPECT_TRUE(solve_p3p(points, rays).empty());
  EXPECT_TRUE(solve_p3p({points[0], points[0], points[0]}, rays).empty());
}

}  // namespace
}  // namespace roomwise::motion
