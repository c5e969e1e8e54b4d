#include <opencv2/core/utility.hpp>

#include "python/bindings/bindings.h"

PYBIND11_MODULE(_roomwise, module) {
  using namespace roomwise::python;
  cv::setNumThreads(1);  // the threads are ours
  module.attr("__version__") = ROOMWISE_VERSION;
  bind_trajectories(module);
  bind_recordings(module);
  bind_graphs(module);
  bind_homes(module);
  bind_mapping(module);
  bind_questions(module);
  // Users know them by the package.
  for (const auto& [name, value] : module.attr("__dict__").cast<py::dict>()) {
    if (py::isinstance<py::type>(value)) py::setattr(value, "__module__", py::str("roomwise"));
  }
}
