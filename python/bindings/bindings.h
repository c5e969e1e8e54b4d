#pragma once

#include <pybind11/pybind11.h>

// The Python module `roomwise`: the level of examples/ and of pipeline/, for researchers. What a
// function gives, and how it fails, is said in its docstring; types are told in
// python/roomwise/__init__.pyi, which a test compares with what is declared here.
namespace roomwise::python {

namespace py = pybind11;

// Each declares a part of the module; a later one uses the classes of those before.
void bind_trajectories(py::module_& module);
void bind_recordings(py::module_& module);
void bind_graphs(py::module_& module);
void bind_homes(py::module_& module);
void bind_mapping(py::module_& module);
void bind_questions(py::module_& module);

}  // namespace roomwise::python
