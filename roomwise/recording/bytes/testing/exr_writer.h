#pragma once

#include <zlib.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "roomwise/recording/messages/testing/byte_writer.h"

// Small OpenEXR files, for tests and as seeds of fuzzing.
namespace roomwise::recording::testing {

struct ExrPlan {
  int width = 12, height = 16;
  std::vector<std::string> channels{"R"};  // in the order of their names
  bool is_half = true;
  std::uint8_t packing = 3;  // ZIP; 2 ZIPS, 0 none
  std::int32_t left = 0, top = 0;
  std::uint32_t flags = 0;
  // A channel's number at a pixel, which 16 bits must hold.
  std::function<float(std::size_t channel, int x, int y)> value = [](std::size_t, int, int) {
    return 1.25F;
  };
};

// Of numbers that 16 bits hold, 0 or normal.
inline std::uint16_t half_of(float value) {
  if (value == 0) return 0;
  int exponent = 0;
  const float fraction = std::frexp(std::abs(value), &exponent);
  const auto mantissa = static_cast<std::uint32_t>((2 * fraction - 1) * 1024);
  const auto biased = static_cast<std::uint32_t>(exponent - 1 + 15);
  return static_cast<std::uint16_t>((value < 0 ? 0x8000U : 0U) | biased << 10U | mantissa);
}

inline Bytes pack_exr_lines(const Bytes& lines) {
  Bytes mixed;
  for (const std::size_t first : {0U, 1U}) {
    for (std::size_t i = first; i < lines.size(); i += 2) mixed.push_back(lines[i]);
  }
  for (std::size_t i = mixed.size(); i-- > 1;) {
    mixed[i] = static_cast<std::uint8_t>(mixed[i] - mixed[i - 1] + 128);
  }
  uLongf size = compressBound(static_cast<uLong>(mixed.size()));
  Bytes packed(size);
  compress(packed.data(), &size, mixed.data(), static_cast<uLong>(mixed.size()));
  packed.resize(size);
  return packed.size() < lines.size() ? packed : lines;
}

inline Bytes exr_line(const ExrPlan& plan, int y) {
  ByteWriter line;
  for (std::size_t channel = 0; channel < plan.channels.size(); ++channel) {
    for (int x = 0; x < plan.width; ++x) {
      const float value = plan.value(channel, x, y);
      plan.is_half ? line.number<std::uint16_t>(half_of(value)) : line.number<float>(value);
    }
  }
  return line.all();
}

inline Bytes exr_file(const ExrPlan& plan) {
  ByteWriter channels;
  for (const std::string& name : plan.channels) {
    channels.text(name).number<std::uint8_t>(0).number<std::uint32_t>(plan.is_half ? 1 : 2);
    channels.number<std::uint32_t>(0).number<std::int32_t>(1).number<std::int32_t>(1);
  }
  channels.number<std::uint8_t>(0);
  ByteWriter window;
  window.number<std::int32_t>(plan.left).number<std::int32_t>(plan.top);
  window.number<std::int32_t>(plan.left + plan.width - 1);
  window.number<std::int32_t>(plan.top + plan.height - 1);

  ByteWriter file;
  file.number<std::uint32_t>(20'000'630).number<std::uint32_t>(2 | plan.flags);
  const auto attribute = [&](const std::string& name, const std::string& type, const Bytes& value) {
    file.text(name).number<std::uint8_t>(0).text(type).number<std::uint8_t>(0);
    file.counted<std::uint32_t>(value);
  };
  attribute("channels", "chlist", channels.all());
  attribute("compression", "compression", {plan.packing});
  attribute("dataWindow", "box2i", window.all());
  attribute("displayWindow", "box2i", window.all());
  attribute("lineOrder", "lineOrder", {0});
  attribute("pixelAspectRatio", "float", ByteWriter().number<float>(1).all());
  attribute("screenWindowCenter", "v2f", Bytes(8));
  attribute("screenWindowWidth", "float", ByteWriter().number<float>(1).all());
  file.number<std::uint8_t>(0);

  const int lines = plan.packing == 3 ? 16 : 1;
  const int blocks = (plan.height + lines - 1) / lines;
  std::size_t offset = file.size() + 8 * static_cast<std::size_t>(blocks);
  ByteWriter pixels;
  for (int first = 0; first < plan.height; first += lines) {
    Bytes block;
    for (int y = first; y < std::min(first + lines, plan.height); ++y) {
      const Bytes line = exr_line(plan, y);
      block.insert(block.end(), line.begin(), line.end());
    }
    file.number<std::uint64_t>(offset + pixels.size());
    pixels.number<std::int32_t>(plan.top + first);
    pixels.counted<std::uint32_t>(plan.packing == 0 ? block : pack_exr_lines(block));
  }
  return file.bytes(pixels.all()).all();
}

}  // namespace roomwise::recording::testing
