#include "roomwise/network/graph/constant_math.h"

#include <algorithm>

namespace roomwise::network {
namespace {

std::size_t to_size(std::int64_t value) {
  return static_cast<std::size_t>(value);
}

// shape as outer x axis x inner.
struct AroundAxis {
  std::size_t outer = 1, size = 1, inner = 1;

  AroundAxis(const Shape& shape, std::size_t axis) : size(to_size(shape[axis])) {
    for (std::size_t i = 0; i < axis; ++i) outer *= to_size(shape[i]);
    for (std::size_t i = axis + 1; i < shape.size(); ++i) inner *= to_size(shape[i]);
  }
};

// Does the same with the floats or the integers of a constant, whichever it has.
template <typename Function>
void with_numbers(const Constant& from, Constant& to, const Function& function) {
  to.is_integer = from.is_integer;
  if (from.is_integer) {
    function(from.integers, to.integers);
  } else {
    function(from.floats, to.floats);
  }
}

// As whole numbers of two's complement do, without undefined overflow.
std::int64_t apply(Arithmetic::Operator operation, std::int64_t a, std::int64_t b) {
  const auto x = static_cast<std::uint64_t>(a);
  const auto y = static_cast<std::uint64_t>(b);
  switch (operation) {
    case Arithmetic::Operator::kAdd:
      return static_cast<std::int64_t>(x + y);
    case Arithmetic::Operator::kSubtract:
      return static_cast<std::int64_t>(x - y);
    case Arithmetic::Operator::kMultiply:
      return static_cast<std::int64_t>(x * y);
    case Arithmetic::Operator::kDivide:
      return b == -1 ? static_cast<std::int64_t>(0 - x) : a / b;
    case Arithmetic::Operator::kMaximum:
      return std::max(a, b);
    case Arithmetic::Operator::kMinimum:
      return std::min(a, b);
    case Arithmetic::Operator::kEqual:
      return a == b ? 1 : 0;
    case Arithmetic::Operator::kLess:
      return a < b ? 1 : 0;
  }
  return 0;
}

}  // namespace

Constant pick(const Constant& constant, std::size_t axis, std::span<const std::size_t> indices) {
  const AroundAxis around(constant.shape, axis);
  Constant result;
  result.shape = constant.shape;
  result.shape[axis] = static_cast<std::int64_t>(indices.size());
  with_numbers(constant, result, [&](const auto& from, auto& to) {
    to.reserve(around.outer * indices.size() * around.inner);
    for (std::size_t outer = 0; outer < around.outer; ++outer) {
      for (const std::size_t index : indices) {
        const auto begin = from.begin() + static_cast<std::ptrdiff_t>(
                                              (outer * around.size + index) * around.inner);
        to.insert(to.end(), begin, begin + static_cast<std::ptrdiff_t>(around.inner));
      }
    }
  });
  return result;
}

Constant join(std::span<const ConstantPointer> parts, std::size_t axis) {
  Constant result;
  result.shape = parts.front()->shape;
  result.shape[axis] = 0;
  for (const ConstantPointer& part : parts) result.shape[axis] += part->shape[axis];
  const std::size_t outer_count = AroundAxis(parts.front()->shape, axis).outer;
  for (std::size_t outer = 0; outer < outer_count; ++outer) {
    for (const ConstantPointer& part : parts) {
      const AroundAxis around(part->shape, axis);
      const std::size_t run = around.size * around.inner;
      with_numbers(*part, result, [&](const auto& from, auto& to) {
        const auto begin = from.begin() + static_cast<std::ptrdiff_t>(outer * run);
        to.insert(to.end(), begin, begin + static_cast<std::ptrdiff_t>(run));
      });
    }
  }
  return result;
}

std::vector<std::size_t> offsets(const Shape& shape, std::span<const std::size_t> strides) {
  std::vector<std::size_t> result{0};
  for (std::size_t axis = 0; axis < shape.size(); ++axis) {
    std::vector<std::size_t> next;
    next.reserve(result.size() * to_size(shape[axis]));
    for (const std::size_t offset : result) {
      for (std::size_t i = 0; i < to_size(shape[axis]); ++i)
        next.push_back(offset + i * strides[axis]);
    }
    result = std::move(next);
  }
  return result;
}

std::vector<std::size_t> broadcast_strides(const Shape& shape, const Shape& target) {
  std::vector<std::size_t> strides(target.size(), 0);
  const std::size_t lead = target.size() - shape.size();
  std::size_t stride = 1;
  for (std::size_t axis = shape.size(); axis-- > 0;) {
    if (shape[axis] != 1) strides[lead + axis] = stride;
    stride *= to_size(shape[axis]);
  }
  return strides;
}

Constant permute(const Constant& constant, std::span<const std::size_t> axes) {
  const std::vector<std::size_t> strides = broadcast_strides(constant.shape, constant.shape);
  Constant result;
  std::vector<std::size_t> moved;
  for (const std::size_t axis : axes) {
    result.shape.push_back(constant.shape[axis]);
    moved.push_back(strides[axis]);
  }
  with_numbers(constant, result, [&](const auto& from, auto& to) {
    for (const std::size_t offset : offsets(result.shape, moved)) to.push_back(from[offset]);
  });
  return result;
}

Expected<Constant> compute(Arithmetic::Operator operation, const Constant& a, const Constant& b) {
  if (a.is_integer != b.is_integer) return fail("mixes whole and floating-point numbers");
  if (a.is_integer && operation == Arithmetic::Operator::kDivide &&
      std::ranges::find(b.integers, 0) != b.integers.end()) {
    return fail("divides by zero");
  }
  Constant result;
  ROOMWISE_TRY(result.shape, broadcast(a.shape, b.shape));
  const auto of_a = offsets(result.shape, broadcast_strides(a.shape, result.shape));
  const auto of_b = offsets(result.shape, broadcast_strides(b.shape, result.shape));
  result.is_integer = a.is_integer || Arithmetic{operation}.compares();
  for (std::size_t i = 0; i < of_a.size(); ++i) {
    if (a.is_integer) {
      result.integers.push_back(apply(operation, a.integers[of_a[i]], b.integers[of_b[i]]));
      continue;
    }
    const float computed = apply(operation, a.floats[of_a[i]], b.floats[of_b[i]]);
    if (result.is_integer) {
      result.integers.push_back(static_cast<std::int64_t>(computed));
    } else {
      result.floats.push_back(computed);
    }
  }
  return result;
}

Expected<Constant> select(const Constant& condition, const Constant& a, const Constant& b) {
  if (a.is_integer != b.is_integer) return fail("mixes whole and floating-point numbers");
  Constant result;
  ROOMWISE_TRY(const Shape of_both, broadcast(a.shape, b.shape));
  ROOMWISE_TRY(result.shape, broadcast(condition.shape, of_both));
  const auto chosen = offsets(result.shape, broadcast_strides(condition.shape, result.shape));
  const auto of_a = offsets(result.shape, broadcast_strides(a.shape, result.shape));
  const auto of_b = offsets(result.shape, broadcast_strides(b.shape, result.shape));
  const auto take = [&](const auto& from_a, const auto& from_b, auto& to) {
    for (std::size_t i = 0; i < chosen.size(); ++i)
      to.push_back(condition.integers[chosen[i]] != 0 ? from_a[of_a[i]] : from_b[of_b[i]]);
  };
  result.is_integer = a.is_integer;
  if (a.is_integer) take(a.integers, b.integers, result.integers);
  if (!a.is_integer) take(a.floats, b.floats, result.floats);
  return result;
}

}  // namespace roomwise::network
