#pragma once

#include <zlib.h>

#include <limits>
#include <vector>

#include "roomwise/image/codec.h"
#include "roomwise/recording/messages/testing/byte_writer.h"

// Small .sens files, for tests and as seeds of fuzzing.
namespace roomwise::recording::testing {

struct SensPlan {
  std::uint32_t version = 4;
  std::int32_t color_packing = 2, depth_packing = 1;
  std::uint64_t frame_count = 3;             // as claimed
  double color_offset_m = 0;                 // of the colour camera
  std::vector<std::uint64_t> times_us = {};  // the frames'; empty: 33 ms apart
  int color_width = 80, color_height = 60;
  double color_focal_ratio = 1.25;  // focal length over width
  std::uint16_t depth_mm = 1500;
  std::vector<Bytes> colors = {};  // the frames' JPEGs; empty: three grey ones
};

inline void put_matrix(ByteWriter& out, double f, double cx, double cy, double x) {
  const double numbers[16] = {f, 0, cx, x, 0, f, cy, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  for (const double number : numbers) out.number<float>(static_cast<float>(number));
}

inline Bytes zlib_packed(const Bytes& plain) {
  Bytes packed(plain.size() + 1000);
  auto size = static_cast<uLongf>(packed.size());
  compress(packed.data(), &size, plain.data(), static_cast<uLong>(plain.size()));
  packed.resize(size);
  return packed;
}

// Tracking is lost in the second frame. Depth is 40x30.
inline Bytes sens_file(const SensPlan& plan) {
  ByteWriter out;
  out.number<std::uint32_t>(plan.version).counted<std::uint64_t>("StructureSensor");
  put_matrix(out, plan.color_focal_ratio * plan.color_width, (plan.color_width - 1) / 2.0,
             (plan.color_height - 1) / 2.0, 0);
  put_matrix(out, 1, 0, 0, plan.color_offset_m);
  put_matrix(out, 50, 19.5, 14.5, 0);
  put_matrix(out, 1, 0, 0, 0);
  out.number<std::int32_t>(plan.color_packing).number<std::int32_t>(plan.depth_packing);
  for (const int side : {plan.color_width, plan.color_height, 40, 30}) {
    out.number<std::uint32_t>(static_cast<std::uint32_t>(side));
  }
  out.number<float>(1000).number<std::uint64_t>(plan.frame_count);
  const Bytes grey =
      image::encode_jpeg(image::ColorImage(plan.color_width, plan.color_height, {90, 90, 90}), 90);
  const std::vector<Bytes> colors = plan.colors.empty() ? std::vector(3, grey) : plan.colors;
  ByteWriter depth;
  for (int i = 0; i < 40 * 30; ++i) depth.number<std::uint16_t>(plan.depth_mm);
  const Bytes packed = plan.depth_packing == 1 ? zlib_packed(depth.all()) : depth.all();
  for (int i = 0; i < std::ssize(colors); ++i) {
    const Bytes& color = colors[static_cast<std::size_t>(i)];
    put_matrix(out, 1, 0, 0, i == 1 ? -std::numeric_limits<double>::infinity() : i);
    const auto time = plan.times_us.empty() ? static_cast<std::uint64_t>(1'000'000 + 33'000 * i)
                                            : plan.times_us[static_cast<std::size_t>(i)];
    out.number<std::uint64_t>(time).number<std::uint64_t>(time);
    out.number<std::uint64_t>(color.size()).number<std::uint64_t>(packed.size());
    out.bytes(color).bytes(packed);
  }
  out.number<std::uint64_t>(0);  // frames of the inertial unit
  return out.all();
}

}  // namespace roomwise::recording::testing
