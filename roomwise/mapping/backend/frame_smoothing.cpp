#include "roomwise/mapping/backend/frame_smoothing.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>

#include "roomwise/mapping/backend/frame_poses.h"

namespace roomwise::mapping {
namespace {

using geometry::RigidTransform;
using Rows3 = Eigen::Matrix<double, Eigen::Dynamic, 3>;

Eigen::Vector3d rotation_vector(const Eigen::Quaterniond& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return turn.angle() * turn.axis();
}

Eigen::Quaterniond rotation_of(const Eigen::Vector3d& vector) {
  const double angle = vector.norm();
  if (angle == 0) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, vector / angle));
}

// Three frames in a row: what the middle one is off the steady motion between the other two is
//   middle - before_share * before - after_share * after.
struct Triple {
  Eigen::Index middle;
  double before_share, after_share;
  double half_square_s2;  // this times the acceleration
};

// The median speeding up between held frames: m/s^2 and rad/s^2, by axis.
struct Accelerations {
  double translation = 0;
  double rotation = 0;
};

double seconds(const PlacedFrame& from, const PlacedFrame& to) {
  return seconds_between(from.timestamp_ns, to.timestamp_ns);
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::optional<Accelerations> usual_accelerations(std::span<const PlacedFrame> frames) {
  constexpr std::size_t kMin = 10;
  constexpr double kMedianNorm = 1.54;  // of a normal vector in space, in sigmas of an axis
  std::vector<double> translations, rotations;
  std::vector<const PlacedFrame*> held;  // of the last three without a gap
  for (const PlacedFrame& frame : frames) {
    if (!frame.world_from_camera) held.clear();
    if (!frame.world_from_camera || !frame.is_fixed) continue;
    held.push_back(&frame);
    if (held.size() > 3) held.erase(held.begin());
    if (held.size() < 3) continue;
    const double before_s = seconds(*held[0], *held[1]);
    const double after_s = seconds(*held[1], *held[2]);
    if (!(before_s > 0) || !(after_s > 0)) continue;
    const RigidTransform& a = *held[0]->world_from_camera;
    const RigidTransform& b = *held[1]->world_from_camera;
    const RigidTransform& c = *held[2]->world_from_camera;
    const double between_s = 0.5 * (before_s + after_s);
    translations.push_back(
        ((c.translation - b.translation) / after_s - (b.translation - a.translation) / before_s)
            .norm() /
        between_s);
    rotations.push_back((rotation_vector(b.rotation.conjugate() * c.rotation) / after_s -
                         rotation_vector(a.rotation.conjugate() * b.rotation) / before_s)
                            .norm() /
                        between_s);
  }
  if (translations.size() < kMin) return std::nullopt;
  return Accelerations{median(translations) / kMedianNorm, median(rotations) / kMedianNorm};
}

std::vector<Triple> find_triples(std::span<const PlacedFrame> frames) {
  std::vector<Triple> triples;
  for (std::size_t i = 1; i + 1 < frames.size(); ++i) {
    if (!frames[i - 1].world_from_camera || !frames[i].world_from_camera ||
        !frames[i + 1].world_from_camera) {
      continue;
    }
    const double before_s = seconds(frames[i - 1], frames[i]);
    const double after_s = seconds(frames[i], frames[i + 1]);
    if (!(before_s > 0) || !(after_s > 0) || before_s + after_s > kConstantVelocity_s) continue;
    triples.push_back({static_cast<Eigen::Index>(i), after_s / (before_s + after_s),
                       before_s / (before_s + after_s), 0.5 * before_s * after_s});
  }
  return triples;
}

// The corrections of all frames that minimise the costs of what they are off, of their places and
// of the accelerations; the axes are independent of each other.
class Smoother {
 public:
  Smoother(std::span<PlacedFrame> frames, const Accelerations& usual,
           const SmoothingOptions& options)
      : frames_(frames), usual_(usual), options_(options), triples_(find_triples(frames)) {
    for (const PlacedFrame& frame : frames)
      measured_.push_back(frame.world_from_camera.value_or(RigidTransform::identity()));
    now_ = measured_;
  }

  void run() {
    constexpr int kRounds = 10;
    for (int round = 0; round < kRounds; ++round) {
      const Rows3 shifts = solve(
          options_.place_sigma_m, usual_.translation,
          [&](std::size_t i) { return (measured_[i].translation - now_[i].translation).eval(); },
          [&](std::size_t a, std::size_t b) {
            return (now_[b].translation - now_[a].translation).eval();
          });
      const Rows3 turns = solve(
          options_.place_sigma_rad, usual_.rotation,
          [&](std::size_t i) {
            return rotation_vector(now_[i].rotation.conjugate() * measured_[i].rotation);
          },
          [&](std::size_t a, std::size_t b) {
            return rotation_vector(now_[a].rotation.conjugate() * now_[b].rotation);
          });
      for (std::size_t i = 0; i < now_.size(); ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        now_[i].translation += shifts.row(row).transpose();
        now_[i].rotation =
            (now_[i].rotation * rotation_of(turns.row(row).transpose())).normalized();
      }
    }
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      if (frames_[i].world_from_camera && !frames_[i].is_fixed)
        frames_[i].world_from_camera = now_[i];
    }
  }

 private:
  // One round for translations or rotations: `back` leads from a frame as it is now to its measured
  // place, `step` from one frame to another.
  template <typename Back, typename Step>
  Rows3 solve(double place_sigma, double acceleration_sigma, const Back& back,
              const Step& step) const {
    const auto count = static_cast<Eigen::Index>(frames_.size());
    Rows3 gradient = Rows3::Zero(count, 3);
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      if (!frames_[i].world_from_camera || frames_[i].is_fixed) {
        entries.emplace_back(row, row, 1);  // by itself, and stays
        continue;
      }
      const Eigen::Vector3d error = back(i);
      const double kernel = options_.kernel_sigmas * place_sigma;
      const double weight =
          1 / (place_sigma * place_sigma * (1 + error.squaredNorm() / (kernel * kernel)));
      entries.emplace_back(row, row, weight);
      gradient.row(row) += weight * error.transpose();
    }
    for (const Triple& triple : triples_) {
      const double sigma = options_.acceleration_share * acceleration_sigma * triple.half_square_s2;
      const double weight = 1 / (sigma * sigma);
      const auto middle = static_cast<std::size_t>(triple.middle);
      const Eigen::Vector3d off = triple.before_share * step(middle - 1, middle) -
                                  triple.after_share * step(middle, middle + 1);
      const std::array<double, 3> shares{-triple.before_share, 1, -triple.after_share};
      for (Eigen::Index a = 0; a < 3; ++a) {
        const Eigen::Index row = triple.middle - 1 + a;
        if (frames_[static_cast<std::size_t>(row)].is_fixed) continue;
        const double share = shares[static_cast<std::size_t>(a)];
        gradient.row(row) -= weight * share * off.transpose();
        for (Eigen::Index b = 0; b < 3; ++b) {
          const Eigen::Index column = triple.middle - 1 + b;
          if (frames_[static_cast<std::size_t>(column)].is_fixed) continue;
          entries.emplace_back(row, column, weight * share * shares[static_cast<std::size_t>(b)]);
        }
      }
    }
    Eigen::SparseMatrix<double> hessian(count, count);
    hessian.setFromTriplets(entries.begin(), entries.end());
    // The matrix has five diagonals: in the frames' own order nothing fills in.
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower,
                                Eigen::NaturalOrdering<int>>
        solver(hessian);
    return solver.solve(gradient);
  }

  std::span<PlacedFrame> frames_;
  Accelerations usual_;
  const SmoothingOptions& options_;
  std::vector<Triple> triples_;
  std::vector<RigidTransform> measured_, now_;  // by frame
};

}  // namespace

Expected<void> SmoothingOptions::validate() const {
  if (!(place_sigma_m > 0) || !(place_sigma_rad > 0))
    return fail("place_sigma_m = {} and place_sigma_rad = {} must be positive", place_sigma_m,
                place_sigma_rad);
  if (!(kernel_sigmas > 0)) return fail("kernel_sigmas = {} must be positive", kernel_sigmas);
  if (!(acceleration_share > 0))
    return fail("acceleration_share = {} must be positive", acceleration_share);
  return {};
}

void smooth_frames(std::span<PlacedFrame> frames, const SmoothingOptions& options) {
  const auto usual = usual_accelerations(frames);
  // A camera that stands still for good needs no smoothing, nor can it be had.
  if (!usual || !(usual->translation > 0) || !(usual->rotation > 0)) return;
  Smoother(frames, *usual, options).run();
}

}  // namespace roomwise::mapping
