#include "roomwise/network/graph/program.h"

#include <algorithm>

namespace roomwise::network {

std::size_t element_count(const Shape& shape) {
  std::size_t count = 1;
  for (const std::int64_t size : shape) count *= static_cast<std::size_t>(size);
  return count;
}

Expected<void> check_size(const Shape& shape) {
  constexpr std::int64_t kMaxValues = std::int64_t{1} << 26;
  std::int64_t count = 1;
  for (const std::int64_t size : shape) {
    if (size < 0 || size > kMaxValues || (count *= std::max<std::int64_t>(size, 1)) > kMaxValues) {
      return fail("gives a value of the impossible shape {}", shape_text(shape));
    }
  }
  return {};
}

Expected<Shape> broadcast(const Shape& a, const Shape& b) {
  Shape result(std::max(a.size(), b.size()), 1);
  for (std::size_t i = 0; i < result.size(); ++i) {
    const std::int64_t of_a = i < a.size() ? a[a.size() - 1 - i] : 1;
    const std::int64_t of_b = i < b.size() ? b[b.size() - 1 - i] : 1;
    if (of_a != of_b && of_a != 1 && of_b != 1) {
      return fail("its inputs {} and {} do not fit each other", shape_text(a), shape_text(b));
    }
    result[result.size() - 1 - i] = of_a == 1 ? of_b : of_a;
  }
  ROOMWISE_RETURN_IF_ERROR(check_size(result));
  return result;
}

std::vector<std::size_t> count_uses(const Program& program) {
  std::vector<std::size_t> uses(program.values.size(), 0);
  for (const Layer& layer : program.layers) {
    for (const ValueId input : layer.inputs) ++uses[input];
  }
  for (const ValueId output : program.outputs) ++uses[output];
  return uses;
}

}  // namespace roomwise::network
