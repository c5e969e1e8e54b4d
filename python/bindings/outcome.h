#pragma once

#include <pybind11/pybind11.h>

#include <type_traits>
#include <utility>

#include "roomwise/base/expected.h"

namespace roomwise::python {

namespace py = pybind11;

// Raises roomwise.Error with the message and the code. The GIL must be held.
[[noreturn]] void raise(const Error& error);

// The value, or roomwise.Error raised.
template <typename T>
T value_of(Expected<T> outcome) {
  if (!outcome) raise(outcome.error());
  if constexpr (!std::is_void_v<T>) return *std::move(outcome);
}

// What work() gives, an Expected<T>, without the GIL: for what takes milliseconds and no Python.
template <typename Work>
auto run_without_gil(const Work& work) {
  auto outcome = [&] {
    const py::gil_scoped_release released;
    return work();
  }();
  return value_of(std::move(outcome));
}

}  // namespace roomwise::python
