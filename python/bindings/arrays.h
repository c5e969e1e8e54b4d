#pragma once

#include <pybind11/numpy.h>

#include <filesystem>
#include <string>
#include <vector>

#include "python/bindings/outcome.h"
#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/image/image.h"

// NumPy arrays of what the library holds, and back. A wrong type or dtype raises TypeError, a wrong
// shape or value ValueError; both name the argument, what was expected and what came.
namespace roomwise::python {

// An array that shows memory of `owner`, which it keeps alive: nothing is copied, and nothing can
// be written. `strides` in bytes.
template <typename T>
py::array view(const T* data, std::vector<py::ssize_t> shape, std::vector<py::ssize_t> strides,
               const py::handle& owner) {
  py::array array(py::dtype::of<T>(), std::move(shape), std::move(strides), data, owner);
  array.attr("flags").attr("writeable") = false;
  return array;
}
[[nodiscard]] py::array view(const image::ColorImage& image, const py::handle& owner);
[[nodiscard]] py::array view(const image::DepthImage& image, const py::handle& owner);

// Float32 metres, NaN where nothing was measured: new memory.
[[nodiscard]] py::array_t<float> depth_in_metres(const image::DepthImage& depth,
                                                 double units_per_metre);

// A picture's own copy. `name`: of the argument, in errors. Shape (height, width, 3), uint8; or the
// path of a picture.
[[nodiscard]] image::ColorImage color_image(const py::object& picture, const std::string& name);
// Shape (height, width): uint16 in the camera's units, or float32 or float64 metres; 0 and NaN mean
// that nothing was measured. Or the path of a 16-bit PNG.
[[nodiscard]] image::DepthImage depth_image(const py::object& picture,
                                            const geometry::PinholeCamera& camera,
                                            const std::string& name);

// Real numbers of any dtype as contiguous doubles. `shape`: -1 stands for any length, the same for
// all -1 of a call; `shape_text` says it for people: "(N, 3)".
[[nodiscard]] py::array_t<double> real_array(const py::object& numbers,
                                             const std::vector<py::ssize_t>& shape,
                                             const std::string& shape_text,
                                             const std::string& name);
// Whole numbers (int64 after it).
[[nodiscard]] py::array_t<std::int64_t> whole_array(const py::object& numbers,
                                                    const std::vector<py::ssize_t>& shape,
                                                    const std::string& shape_text,
                                                    const std::string& name);

// A 4 x 4 matrix, and many of them, shape (N, 4, 4).
[[nodiscard]] py::array_t<double> matrix_of(const geometry::RigidTransform& a_from_b);
[[nodiscard]] py::array_t<double> matrices_of(const std::vector<geometry::RigidTransform>& all);
[[nodiscard]] std::vector<geometry::RigidTransform> transforms_of(const py::object& matrices,
                                                                  const std::string& name);
[[nodiscard]] py::array_t<double> vector_of(const Eigen::Vector3d& v);

// Whether it is a str or has __fspath__.
[[nodiscard]] bool is_path(const py::object& object);
[[nodiscard]] std::filesystem::path path_of(const py::object& path, const std::string& name);

// Raises ValueError where something is no positive number of things.
void require_positive(double number, const std::string& name);

}  // namespace roomwise::python
