#include "roomwise/network/executor/plain_kernels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "roomwise/network/graph/constant_math.h"

namespace roomwise::network {
namespace {

// Where one output channel of a gather comes from.
struct Source {
  std::size_t input = 0;
  std::size_t outer_stride = 0;
  std::size_t offset = 0;  // of its value at the first place of the first picture
};

void copy_plain(const float* from, float* to, std::size_t places) {
  std::memcpy(to, from, places * sizeof(float));
}

// Lanes of an output block that lie side by side in their source too.
struct Run {
  const float* from;
  std::size_t lane;
  std::size_t length;
};

// One output block at all places, a few places at a time, so that they stay in the nearest cache.
void gather_block(std::span<const Run> runs, float* to, std::size_t places, std::size_t block) {
  constexpr std::size_t kPlacesAtOnce = 64;
  for (std::size_t begin = 0; begin < places; begin += kPlacesAtOnce) {
    const std::size_t end = std::min(begin + kPlacesAtOnce, places);
    for (const Run& run : runs) {
      for (std::size_t place = begin; place < end; ++place) {
        const float* from = run.from + place * block;
        float* into = to + place * block + run.lane;
        for (std::size_t i = 0; i < run.length; ++i) into[i] = from[i];
      }
    }
  }
}

// An output's shape, and how far apart neighbours along its axes lie in each operand.
template <std::size_t kOperands>
struct Broadcast {
  Shape shape;
  std::array<std::vector<std::size_t>, kOperands> strides;
};

// Writes the slice of an output that begins at `to`, from one axis on; gives its end. function:
// of where the operands' numbers are.
template <std::size_t kOperands, typename Function>
float* apply_along(const Broadcast<kOperands>& along, std::size_t axis, const Function& function,
                   std::array<const float*, kOperands> from, float* to) {
  const bool is_last = axis + 1 == along.shape.size();
  for (std::int64_t i = 0; i < along.shape[axis]; ++i) {
    if (is_last) {
      *to++ = function(from);
    } else {
      to = apply_along(along, axis + 1, function, from, to);
    }
    for (std::size_t k = 0; k < kOperands; ++k) from[k] += along.strides[k][axis];
  }
  return to;
}

// One number of the output from one of each operand, all broadcast.
template <std::size_t kOperands, typename Function>
Kernel broadcast_kernel(const std::array<Shape, kOperands>& operands, const Shape& output,
                        const Function& function) {
  Broadcast<kOperands> along;
  along.shape = output.empty() ? Shape{1} : output;  // a single number is a row too
  for (std::size_t k = 0; k < kOperands; ++k)
    along.strides[k] = broadcast_strides(operands[k], along.shape);
  return [along, function](std::span<const float* const> inputs, float* to) -> Expected<void> {
    std::array<const float*, kOperands> from{};
    std::copy_n(inputs.begin(), kOperands, from.begin());
    apply_along(along, 0, function, from, to);
    return {};
  };
}

}  // namespace

BlockedShape BlockedShape::around(const Shape& shape, std::size_t axis, std::size_t block) {
  BlockedShape result;
  result.block = block;
  result.channels = static_cast<std::size_t>(shape[axis]);
  for (std::size_t i = 0; i < axis; ++i) result.outer *= static_cast<std::size_t>(shape[i]);
  for (std::size_t i = axis + 1; i < shape.size(); ++i)
    result.inner *= static_cast<std::size_t>(shape[i]);
  return result;
}

Kernel gather_kernel(const AxisSlices& gather, std::vector<BlockedShape> inputs,
                     const BlockedShape& output) {
  std::vector<Source> sources;
  for (const AxisSlices::Pick& pick : gather.slices) {
    if (pick.input == AxisSlices::kFill) {
      sources.push_back({AxisSlices::kFill, 0, 0});
      continue;
    }
    const BlockedShape& from = inputs[pick.input];
    sources.push_back(
        {pick.input, from.blocks() * from.block * from.inner,
         pick.index / from.block * from.block * from.inner + pick.index % from.block});
  }
  const std::size_t block = output.block, places = output.inner;
  return [sources, output, block, places, fill = gather.fill](std::span<const float* const> from,
                                                              float* to) -> Expected<void> {
    std::vector<Run> runs;
    for (std::size_t outer = 0; outer < output.outer; ++outer) {
      for (std::size_t begin = 0; begin < output.blocks() * block; begin += block) {
        if (begin + block > output.channels) std::fill(to, to + places * block, 0.F);
        runs.clear();
        for (std::size_t lane = 0; lane < block && begin + lane < output.channels; ++lane) {
          const Source& source = sources[begin + lane];
          if (source.input == AxisSlices::kFill) {
            for (std::size_t place = 0; place < places; ++place) to[place * block + lane] = fill;
            continue;
          }
          const float* first = from[source.input] + outer * source.outer_stride + source.offset;
          const bool follows = !runs.empty() && runs.back().lane + runs.back().length == lane &&
                               runs.back().from + runs.back().length == first &&
                               sources[begin + lane].offset % block != 0;
          if (follows) {
            ++runs.back().length;
          } else {
            runs.push_back({first, lane, 1});
          }
        }
        if (block == 1) {
          if (!runs.empty()) copy_plain(runs.front().from, to, places);
        } else {
          gather_block(runs, to, places, block);
        }
        to += places * block;
      }
    }
    return {};
  };
}

Kernel resampling_kernel(const Resampling& resampling, const Shape& shape, std::size_t block) {
  const BlockedShape input = BlockedShape::around(shape, 1, block);
  const auto width = static_cast<std::size_t>(shape[3]);
  const std::size_t planes = input.outer * input.blocks();
  return [resampling, input, width, planes, block](std::span<const float* const> inputs,
                                                   float* to) -> Expected<void> {
    for (std::size_t plane = 0; plane < planes; ++plane) {
      const float* from = inputs[0] + plane * input.inner * block;
      for (const Resampling::Tap& row : resampling.rows) {
        const float* upper = from + row.first * width * block;
        const float* lower = from + row.second * width * block;
        for (const Resampling::Tap& column : resampling.columns) {
          const float right = column.weight_of_second, down = row.weight_of_second;
          const float weights[] = {(1 - down) * (1 - right), (1 - down) * right, down * (1 - right),
                                   down * right};
          const float* corners[] = {upper + column.first * block, upper + column.second * block,
                                    lower + column.first * block, lower + column.second * block};
          for (std::size_t i = 0; i < block; ++i) {
            to[i] = (corners[0][i] * weights[0] + corners[1][i] * weights[1]) +
                    (corners[2][i] * weights[2] + corners[3][i] * weights[3]);
          }
          to += block;
        }
      }
    }
    return {};
  };
}

Kernel arithmetic_kernel(Arithmetic::Operator operation, const Shape& a, const Shape& b,
                         const Shape& output) {
  return broadcast_kernel<2>({a, b}, output, [operation](const auto& from) {
    return apply(operation, *from[0], *from[1]);
  });
}

Kernel mean_kernel(const Mean& mean, const Shape& shape) {
  Shape kept = shape, averaged(shape.size(), 1);
  for (const std::size_t axis : mean.axes) {
    kept[axis] = 1;
    averaged[axis] = shape[axis];
  }
  const std::vector<std::size_t> strides = broadcast_strides(shape, shape);
  return [starts = offsets(kept, strides), steps = offsets(averaged, strides)](
             std::span<const float* const> inputs, float* to) -> Expected<void> {
    for (const std::size_t start : starts) {
      double sum = 0;
      for (const std::size_t step : steps) sum += inputs[0][start + step];
      *to++ = static_cast<float>(sum / static_cast<double>(steps.size()));
    }
    return {};
  };
}

Kernel erf_kernel(const Shape& shape) {
  return [count = element_count(shape)](std::span<const float* const> inputs,
                                        float* to) -> Expected<void> {
    for (std::size_t i = 0; i < count; ++i) to[i] = std::erf(inputs[0][i]);
    return {};
  };
}

Kernel selection_kernel(const Shape& condition, const Shape& a, const Shape& b,
                        const Shape& output) {
  return broadcast_kernel<3>({condition, a, b}, output,
                             [](const auto& from) { return *from[0] != 0 ? *from[1] : *from[2]; });
}

Kernel lookup_kernel(const Gather& lookup, const Shape& shape, std::size_t count,
                     const std::string& node) {
  const BlockedShape table = BlockedShape::around(shape, lookup.axis);
  return [table, count, node](std::span<const float* const> inputs, float* to) -> Expected<void> {
    // With 53 bits, so that the sum of both is exact.
    const auto size = static_cast<double>(table.channels);
    for (std::size_t i = 0; i < table.outer * count; ++i) {
      const double index = inputs[1][i % count];
      if (!(index >= -size && index < size) || index != std::trunc(index))
        return fail("node \"{}\": there is no index {} among {}", node, index, table.channels);
      const auto row = static_cast<std::size_t>(index < 0 ? index + size : index);
      const float* from = inputs[0] + (i / count * table.channels + row) * table.inner;
      to = std::copy(from, from + table.inner, to);
    }
    return {};
  };
}

Kernel largest_index_kernel(const ArgMax& largest, const Shape& shape) {
  const BlockedShape around = BlockedShape::around(shape, largest.axis);
  return [around](std::span<const float* const> inputs, float* to) -> Expected<void> {
    for (std::size_t outer = 0; outer < around.outer; ++outer) {
      for (std::size_t inner = 0; inner < around.inner; ++inner) {
        const float* first = inputs[0] + outer * around.channels * around.inner + inner;
        std::size_t best = 0;
        for (std::size_t i = 1; i < around.channels; ++i) {
          if (first[i * around.inner] > first[best * around.inner]) best = i;
        }
        *to++ = static_cast<float>(best);
      }
    }
    return {};
  };
}

}  // namespace roomwise::network
