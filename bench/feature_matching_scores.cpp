// How well features find each other again after a known change of the picture:
//   feature_matching_scores [PICTURES_A_RECORDING] [METHOD ...]   for example: 4 surf sift
// Real pictures of ROOMWISE_DATA are turned, scaled, blurred, lit otherwise and tilted; features of
// picture and warp that both see are matched with the default options. Three numbers per change,
// medians over the pictures (and their range): the matching score (correct matches / features, of
// the side that has fewer), the precision (correct matches / matches), and how far off correct
// matches lie.

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "arguments.h"
#include "feature_methods.h"
#include "feature_pictures.h"
#include "roomwise/features/matcher.h"
#include "roomwise/features/testing/test_pictures.h"

namespace {

using namespace roomwise;
using features::Features;

constexpr int kMaxKeypoints = 1000;
constexpr double kCorrectPx = 3;

// A picture and where its places came from.
struct Warped {
  image::GrayImage picture;
  Eigen::Matrix3d warped_from_original;
};

struct Change {
  std::string kind;
  std::string amount;
  std::function<Warped(const image::GrayImage&)> apply;
};

Eigen::Vector2d apply(const Eigen::Matrix3d& homography, const Eigen::Vector2f& place_px) {
  return (homography * place_px.cast<double>().homogeneous()).hnormalized();
}

Warped warp(image::GrayImage original, const Eigen::Matrix3d& homography, int width, int height) {
  cv::Mat matrix(3, 3, CV_64F);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      matrix.at<double>(row, column) = homography(row, column);
    }
  }
  Warped warped{image::GrayImage(width, height), homography};
  cv::Mat target = features::testing::mat_view(warped.picture);
  cv::warpPerspective(features::testing::mat_view(original), target, matrix, target.size(),
                      cv::INTER_CUBIC, cv::BORDER_REFLECT);
  return warped;
}

image::GrayImage blur(image::GrayImage picture, double sigma_px) {
  cv::Mat pixels = features::testing::mat_view(picture);
  cv::GaussianBlur(pixels, pixels, {}, sigma_px);
  return picture;
}

Change turn(double degrees) {
  return {"turn", fmt::format("{:.0f} deg", degrees), [degrees](const image::GrayImage& picture) {
            const Eigen::Vector2d centre(0.5 * (picture.width() - 1), 0.5 * (picture.height() - 1));
            const Eigen::Affine2d turned = Eigen::Translation2d(centre) *
                                           Eigen::Rotation2Dd(degrees * std::numbers::pi / 180) *
                                           Eigen::Translation2d(-centre);
            return warp(picture, turned.matrix(), picture.width(), picture.height());
          }};
}

// The whole picture at another size; blurred before it is made smaller, as a lens would.
Change scale(double factor) {
  return {"scale", fmt::format("{:.2f}", factor), [factor](const image::GrayImage& picture) {
            Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
            matrix.topLeftCorner<2, 2>() *= factor;
            matrix.topRightCorner<2, 1>().setConstant(0.5 * factor - 0.5);
            const auto size = [&](int px) { return static_cast<int>(std::lround(px * factor)); };
            return warp(
                factor < 1 ? blur(picture, 0.5 * std::sqrt(1 / (factor * factor) - 1)) : picture,
                matrix, size(picture.width()), size(picture.height()));
          }};
}

Change blurred(double sigma_px) {
  return {"blur", fmt::format("{:.0f} px", sigma_px), [sigma_px](const image::GrayImage& picture) {
            return Warped{blur(picture, sigma_px), Eigen::Matrix3d::Identity()};
          }};
}

Change lit(double gain, double offset, double gamma) {
  return {"light", fmt::format("{:g} i^{:g} {:+g}", gain, gamma, offset),
          [=](image::GrayImage picture) {
            for (std::uint8_t& pixel : picture.pixels()) {
              const double value = gain * 255 * std::pow(pixel / 255.0, gamma) + offset;
              pixel = static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
            }
            return Warped{std::move(picture), Eigen::Matrix3d::Identity()};
          }};
}

// As if the picture hung on a wall that the camera looks at from the side.
Change tilted(double degrees) {
  return {"tilt", fmt::format("{:.0f} deg", degrees), [degrees](const image::GrayImage& picture) {
            const double focal_px = picture.width();
            Eigen::Matrix3d camera = Eigen::Matrix3d::Identity();
            camera(0, 0) = camera(1, 1) = focal_px;
            camera(0, 2) = 0.5 * (picture.width() - 1);
            camera(1, 2) = 0.5 * (picture.height() - 1);
            Eigen::Matrix3d turned =
                Eigen::AngleAxisd(degrees * std::numbers::pi / 180, Eigen::Vector3d::UnitY())
                    .toRotationMatrix();
            // The plane z = 1 turned about the point (0, 0, 1).
            turned.col(2) = Eigen::Vector3d::UnitZ();
            return warp(picture, camera * turned * camera.inverse(), picture.width(),
                        picture.height());
          }};
}

std::vector<Change> changes() {
  std::vector<Change> all;
  for (const double degrees : {15, 30, 45, 60, 90, 135, 180}) all.push_back(turn(degrees));
  for (const double factor : {0.5, 0.7, 0.85, 1.2, 1.5, 2.0}) all.push_back(scale(factor));
  for (const double sigma_px : {1, 2, 3, 4}) all.push_back(blurred(sigma_px));
  all.push_back(lit(0.5, 0, 1));
  all.push_back(lit(1.4, 0, 1));
  all.push_back(lit(1, 40, 1));
  all.push_back(lit(1, -40, 1));
  all.push_back(lit(1, 0, 0.5));
  all.push_back(lit(1, 0, 2));
  for (const double degrees : {20, 40}) all.push_back(tilted(degrees));
  return all;
}

// The features whose places also lie in the other picture.
Features seen_by_both(const Features& all, const Eigen::Matrix3d& other_from_this,
                      const image::GrayImage& other) {
  std::vector<Eigen::Index> kept;
  Features part;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Eigen::Vector2d place = apply(other_from_this, all.keypoints[i].position_px);
    if (place.x() < 0 || place.y() < 0 || place.x() > other.width() - 1 ||
        place.y() > other.height() - 1) {
      continue;
    }
    kept.push_back(static_cast<Eigen::Index>(i));
    part.keypoints.push_back(all.keypoints[i]);
  }
  std::visit(
      [&](const auto& rows) {
        part.descriptors = std::decay_t<decltype(rows)>(rows(kept, Eigen::all));
      },
      all.descriptors);
  return part;
}

struct Score {
  double matching = 0, precision = 0, error_px = 0;
};

Score compare(const features::FeatureExtractor& extractor, const image::GrayImage& original,
              const Features& of_original, const Warped& warped) {
  const Features a = seen_by_both(of_original, warped.warped_from_original, warped.picture);
  const Features b = seen_by_both(extractor.extract(warped.picture),
                                  warped.warped_from_original.inverse(), original);
  std::vector<double> errors_px;  // of the correct ones
  const auto matches = match_features(a, b);
  for (const features::Match& match : matches) {
    const Eigen::Vector2d expected =
        apply(warped.warped_from_original, a.keypoints[match.query].position_px);
    const double error = (b.keypoints[match.train].position_px.cast<double>() - expected).norm();
    if (error < kCorrectPx) errors_px.push_back(error);
  }
  if (errors_px.empty()) return {};
  std::ranges::nth_element(errors_px, errors_px.begin() + errors_px.size() / 2);
  const auto correct = static_cast<double>(errors_px.size());
  return {correct / static_cast<double>(std::min(a.size(), b.size())),
          correct / static_cast<double>(matches.size()), errors_px[errors_px.size() / 2]};
}

std::string median_and_range(const std::vector<Score>& scores, double Score::*field) {
  std::vector<double> values;
  for (const Score& score : scores) values.push_back(score.*field);
  std::ranges::sort(values);
  return fmt::format("{:.2f} ({:.2f} to {:.2f})", values[values.size() / 2], values.front(),
                     values.back());
}

void print_table(const std::vector<bench::FeatureMethod>& methods,
                 const std::vector<image::GrayImage>& pictures) {
  std::vector<std::vector<Features>> of_originals;  // by method, then picture
  fmt::print(
      "Matching score / precision / px off, medians over {} pictures (and range)\n\n| change |",
      pictures.size());
  for (const bench::FeatureMethod& method : methods) {
    fmt::print(" {} |", method.name);
    for (auto& features = of_originals.emplace_back(); const image::GrayImage& picture : pictures) {
      features.push_back(method.extractor->extract(picture));
    }
  }
  fmt::print("\n| --- |");
  for (std::size_t i = 0; i < methods.size(); ++i) fmt::print(" --- |");
  std::vector<std::vector<Score>> all(methods.size());
  for (const Change& change : changes()) {
    fmt::print("\n| {} {} |", change.kind, change.amount);
    std::vector<std::vector<Score>> scores(methods.size());
    for (std::size_t p = 0; p < pictures.size(); ++p) {
      const Warped warped = change.apply(pictures[p]);
      for (std::size_t m = 0; m < methods.size(); ++m) {
        scores[m].push_back(
            compare(*methods[m].extractor, pictures[p], of_originals[m][p], warped));
        all[m].push_back(scores[m].back());
      }
    }
    for (const auto& of_method : scores) {
      fmt::print(" {} / {} / {} |", median_and_range(of_method, &Score::matching),
                 median_and_range(of_method, &Score::precision),
                 median_and_range(of_method, &Score::error_px));
    }
    std::fflush(stdout);
  }
  fmt::print("\n| mean of all |");
  for (const auto& of_method : all) {
    Score sum;
    for (const Score& score : of_method) {
      sum.matching += score.matching;
      sum.precision += score.precision;
      sum.error_px += score.error_px;
    }
    const auto count = static_cast<double>(of_method.size());
    fmt::print(" {:.3f} / {:.3f} / {:.3f} |", sum.matching / count, sum.precision / count,
               sum.error_px / count);
  }
  fmt::print("\n");
}

}  // namespace

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  const auto a_recording =
      argc > 1 ? bench::parse_count(argv[1], "feature_matching_scores [PICTURES [METHOD ...]]")
               : Expected<int>(4);
  if (!a_recording) {
    fmt::print(stderr, "{}\n", a_recording.error().message);
    return 2;
  }
  const std::set<std::string> wanted(argv + std::min(argc, 2), argv + argc);
  auto methods = bench::feature_methods(kMaxKeypoints);
  for (const std::string& name : wanted) {
    if (std::ranges::none_of(methods, [&](const auto& method) { return method.name == name; })) {
      fmt::print(stderr, "'{}' is no method; give surf, surf-portable, dlib-surf, sift or orb\n",
                 name);
      return 2;
    }
  }
  std::erase_if(methods, [&](const auto& method) {
    // Both of ours give the same bits.
    return wanted.empty() ? method.name == "surf-portable" : !wanted.contains(method.name);
  });
  const auto pictures = bench::load_feature_pictures(*a_recording);
  if (!pictures) {
    fmt::print(stderr, "{}\n", pictures.error().message);
    return 1;
  }
  print_table(methods, *pictures);
  return 0;
}
