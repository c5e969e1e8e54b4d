#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "roomwise/base/random.h"
#include "roomwise/image/image.h"

// Pictures with known content for the tests and benchmarks of features. Not part of the product.
namespace roomwise::features::testing {

inline cv::Mat mat_view(image::GrayImage& picture) {
  return {picture.height(), picture.width(), CV_8UC1, picture.pixels().data()};
}

// One Gaussian blob of standard deviation sigma_px on even ground.
inline image::GrayImage blob_picture(int width, int height, Eigen::Vector2d centre_px,
                                     double sigma_px, double ground, double amplitude) {
  image::GrayImage picture(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double squared = (Eigen::Vector2d(x, y) - centre_px).squaredNorm();
      const double value = ground + amplitude * std::exp(-squared / (2 * sigma_px * sigma_px));
      picture.at(x, y) = static_cast<std::uint8_t>(std::lround(value));
    }
  }
  return picture;
}

// Overlapping discs and slanted boxes of many sizes and greys, slightly blurred: corners, edges and
// blobs at every scale, as a room has them.
inline image::GrayImage textured_picture(int width, int height, std::uint64_t seed) {
  RandomStream random(seed);
  image::GrayImage picture(width, height, 128);
  cv::Mat canvas = mat_view(picture);
  const int shapes = width * height / 400;
  for (int i = 0; i < shapes; ++i) {
    const cv::Point2f centre(static_cast<float>(random.uniform() * width),
                             static_cast<float>(random.uniform() * height));
    // Few large ones first, many small ones over them.
    const double size_px = 4 + 60 * std::exp(-4.0 * i / shapes) * random.uniform();
    const cv::Scalar grey(30 + 195 * random.uniform());
    if (random.uniform() < 0.5) {
      cv::circle(canvas, centre, static_cast<int>(size_px / 2), grey, cv::FILLED, cv::LINE_AA);
    } else {
      const cv::Size2f sides(static_cast<float>(size_px),
                             static_cast<float>(size_px * (0.4 + random.uniform())));
      cv::Point2f corners[4];
      cv::RotatedRect(centre, sides, static_cast<float>(360 * random.uniform())).points(corners);
      std::vector<cv::Point> polygon(std::begin(corners), std::end(corners));
      cv::fillConvexPoly(canvas, polygon, grey, cv::LINE_AA);
    }
  }
  cv::GaussianBlur(canvas, canvas, {}, 0.8);
  return picture;
}

// Turned clockwise on the screen by a quarter: pixel (x, y) goes to (height - 1 - y, x).
inline image::GrayImage turned_by_quarter(const image::GrayImage& picture) {
  image::GrayImage turned(picture.height(), picture.width());
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      turned.at(picture.height() - 1 - y, x) = picture.at(x, y);
    }
  }
  return turned;
}

inline image::GrayImage turned_by_half(const image::GrayImage& picture) {
  return turned_by_quarter(turned_by_quarter(picture));
}

struct WarpedPicture {
  image::GrayImage picture;
  Eigen::Affine2d warped_from_original;  // px to px
};

// Turned and scaled about the centre, then blurred by a Gaussian (0: not), same size.
inline WarpedPicture warp(image::GrayImage picture, double angle_deg, double scale,
                          double blur_sigma_px) {
  const cv::Point2f centre(static_cast<float>(picture.width() - 1) / 2,
                           static_cast<float>(picture.height() - 1) / 2);
  const cv::Mat matrix = cv::getRotationMatrix2D(centre, angle_deg, scale);
  WarpedPicture warped{image::GrayImage(picture.width(), picture.height()), {}};
  cv::Mat target = mat_view(warped.picture);
  cv::warpAffine(mat_view(picture), target, matrix, target.size(), cv::INTER_CUBIC,
                 cv::BORDER_REFLECT);
  if (blur_sigma_px > 0) cv::GaussianBlur(target, target, {}, blur_sigma_px);
  for (int row = 0; row < 2; ++row) {
    for (int column = 0; column < 3; ++column) {
      warped.warped_from_original(row, column) = matrix.at<double>(row, column);
    }
  }
  return warped;
}

}  // namespace roomwise::features::testing
