#include "python/bindings/arrays.h"

#include <cmath>
#include <cstring>

#include "roomwise/image/codec.h"

namespace roomwise::python {
namespace {

std::string shape_text(const py::array& array) {
  std::string text = "(";
  for (py::ssize_t i = 0; i < array.ndim(); ++i) {
    text += fmt::format("{}{}", i > 0 ? ", " : "", array.shape(i));
  }
  return text + (array.ndim() == 1 ? ",)" : ")");
}

std::string dtype_text(const py::array& array) {
  return py::str(array.dtype());
}

// Where expected is said as "a NumPy array of shape (height, width, 3) and dtype uint8, or a path".
py::array array_of(const py::object& object, const std::string& expected, const std::string& name) {
  if (py::isinstance<py::array>(object)) return py::reinterpret_borrow<py::array>(object);
  throw py::type_error(fmt::format("{}: expected {}; got {}", name, expected,
                                   std::string(py::str(py::type::of(object).attr("__name__")))));
}

[[noreturn]] void refuse_dtype(const py::array& array, const std::string& expected,
                               const std::string& name) {
  throw py::type_error(
      fmt::format("{}: expected {}; got dtype {}", name, expected, dtype_text(array)));
}

[[noreturn]] void refuse_shape(const py::array& array, const std::string& expected,
                               const std::string& name) {
  throw py::value_error(
      fmt::format("{}: expected {}; got shape {}", name, expected, shape_text(array)));
}

template <typename T>
bool is_of(const py::array& array) {
  return array.dtype().equal(py::dtype::of<T>());
}

// What an image's sides must be.
void check_sides(const py::array& array, const std::string& expected, const std::string& name) {
  constexpr py::ssize_t kMaxSide = 65'500;
  if (array.shape(0) == 0 || array.shape(1) == 0) {
    throw py::value_error(fmt::format("{}: the array of shape {} is empty; a picture has pixels",
                                      name, shape_text(array)));
  }
  if (array.shape(0) > kMaxSide || array.shape(1) > kMaxSide) refuse_shape(array, expected, name);
}

template <typename T>
image::DepthImage depth_from_metres(const py::array_t<T>& metres, double units_per_metre,
                                    const std::string& name) {
  const auto from = metres.template unchecked<2>();
  image::DepthImage depth(static_cast<int>(from.shape(1)), static_cast<int>(from.shape(0)));
  for (py::ssize_t y = 0; y < from.shape(0); ++y) {
    const auto row = depth.row(static_cast<int>(y));
    for (py::ssize_t x = 0; x < from.shape(1); ++x) {
      const double depth_m = static_cast<double>(from(y, x));
      if (std::isnan(depth_m)) continue;
      const double units = std::round(depth_m * units_per_metre);
      if (!(units >= 0 && units <= 65'535)) {
        throw py::value_error(
            fmt::format("{}[{}, {}] is {} m; expected 0 to {:g} m (the camera has {:g} units a "
                        "metre), or NaN where nothing was measured",
                        name, y, x, depth_m, 65'535 / units_per_metre, units_per_metre));
      }
      row[static_cast<std::size_t>(x)] = static_cast<std::uint16_t>(units);
    }
  }
  return depth;
}

void check_shape(const py::array& array, const std::vector<py::ssize_t>& shape,
                 const std::string& expected, const std::string& name) {
  bool fits = array.ndim() == static_cast<py::ssize_t>(shape.size());
  for (std::size_t i = 0; fits && i < shape.size(); ++i) {
    fits = shape[i] < 0 || array.shape(static_cast<py::ssize_t>(i)) == shape[i];
  }
  if (!fits) refuse_shape(array, expected, name);
}

geometry::RigidTransform transform_at(const py::detail::unchecked_reference<double, 3>& all,
                                      py::ssize_t i, const std::string& name) {
  Eigen::Matrix4d matrix;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) matrix(row, column) = all(i, row, column);
  }
  const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
  const bool is_rigid =
      matrix.allFinite() && matrix.row(3) == Eigen::RowVector4d(0, 0, 0, 1) &&
      (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-4 &&
      rotation.determinant() > 0;
  if (!is_rigid) {
    throw py::value_error(
        fmt::format("{}[{}] is no rigid transform; expected a rotation in the upper left 3 x 3, a "
                    "translation in m beside it, and 0 0 0 1 as the last row",
                    name, i));
  }
  return geometry::RigidTransform::from_matrix(rotation, matrix.topRightCorner<3, 1>());
}

}  // namespace

py::array view(const image::ColorImage& image, const py::handle& owner) {
  static_assert(sizeof(Rgb8) == 3);
  const py::ssize_t row = 3 * image.width();
  return view(reinterpret_cast<const std::uint8_t*>(image.pixels().data()),
              {image.height(), image.width(), 3}, {row, 3, 1}, owner);
}

py::array view(const image::DepthImage& image, const py::handle& owner) {
  const py::ssize_t row = 2 * image.width();
  return view(image.pixels().data(), {image.height(), image.width()}, {row, 2}, owner);
}

py::array_t<float> depth_in_metres(const image::DepthImage& depth, double units_per_metre) {
  py::array_t<float> metres({depth.height(), depth.width()});
  float* to = metres.mutable_data();
  for (const std::uint16_t units : depth.pixels()) {
    *to++ = units == 0 ? std::numeric_limits<float>::quiet_NaN()
                       : static_cast<float>(units / units_per_metre);
  }
  return metres;
}

image::ColorImage color_image(const py::object& picture, const std::string& name) {
  const std::string expected =
      "a NumPy array of shape (height, width, 3) and dtype uint8, or the path of a picture";
  if (is_path(picture)) return value_of(image::read_color(path_of(picture, name)));
  const py::array array = array_of(picture, expected, name);
  if (!is_of<std::uint8_t>(array)) refuse_dtype(array, expected, name);
  if (array.ndim() != 3 || array.shape(2) != 3) refuse_shape(array, expected, name);
  check_sides(array, expected, name);
  const auto packed = py::array_t<std::uint8_t, py::array::c_style>::ensure(array);
  image::ColorImage image(static_cast<int>(array.shape(1)), static_cast<int>(array.shape(0)));
  std::memcpy(image.pixels().data(), packed.data(), image.pixels().size_bytes());
  return image;
}

image::DepthImage depth_image(const py::object& picture, const geometry::PinholeCamera& camera,
                              const std::string& name) {
  const std::string expected =
      "a NumPy array of shape (height, width), dtype uint16 in the camera's units or float32 or "
      "float64 in metres, or the path of a 16-bit PNG";
  if (is_path(picture)) return value_of(image::read_depth(path_of(picture, name)));
  const py::array array = array_of(picture, expected, name);
  const bool is_single = is_of<float>(array);
  const bool is_native = is_of<std::uint16_t>(array);
  if (!is_single && !is_native && !is_of<double>(array)) refuse_dtype(array, expected, name);
  if (array.ndim() != 2) refuse_shape(array, expected, name);
  check_sides(array, expected, name);
  if (is_single) {
    return depth_from_metres(py::array_t<float>(array), camera.depth_units_per_metre, name);
  }
  if (!is_native) {
    return depth_from_metres(py::array_t<double>(array), camera.depth_units_per_metre, name);
  }
  const auto packed = py::array_t<std::uint16_t, py::array::c_style>::ensure(array);
  image::DepthImage image(static_cast<int>(array.shape(1)), static_cast<int>(array.shape(0)));
  std::memcpy(image.pixels().data(), packed.data(), image.pixels().size_bytes());
  return image;
}

py::array_t<double> real_array(const py::object& numbers, const std::vector<py::ssize_t>& shape,
                               const std::string& shape_text, const std::string& name) {
  const std::string expected =
      fmt::format("a NumPy array of shape {} and a dtype of real numbers", shape_text);
  const py::array array = array_of(numbers, expected, name);
  const char kind = array.dtype().kind();
  if (kind != 'f' && kind != 'i' && kind != 'u') refuse_dtype(array, expected, name);
  check_shape(array, shape, expected, name);
  return py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(array);
}

py::array_t<std::int64_t> whole_array(const py::object& numbers,
                                      const std::vector<py::ssize_t>& shape,
                                      const std::string& shape_text, const std::string& name) {
  const std::string expected =
      fmt::format("a NumPy array of shape {} and a dtype of whole numbers", shape_text);
  const py::array array = array_of(numbers, expected, name);
  const char kind = array.dtype().kind();
  if (kind != 'i' && kind != 'u') refuse_dtype(array, expected, name);
  check_shape(array, shape, expected, name);
  return py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>::ensure(array);
}

py::array_t<double> matrix_of(const geometry::RigidTransform& a_from_b) {
  py::array_t<double> matrix({4, 4});
  Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> to(matrix.mutable_data());
  to.setIdentity();
  to.topLeftCorner<3, 3>() = a_from_b.rotation_matrix();
  to.topRightCorner<3, 1>() = a_from_b.translation;
  return matrix;
}

py::array_t<double> matrices_of(const std::vector<geometry::RigidTransform>& all) {
  py::array_t<double> matrices(
      {static_cast<py::ssize_t>(all.size()), py::ssize_t{4}, py::ssize_t{4}});
  double* at = matrices.mutable_data();
  for (const geometry::RigidTransform& one : all) {
    Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> to(at);
    to.setIdentity();
    to.topLeftCorner<3, 3>() = one.rotation_matrix();
    to.topRightCorner<3, 1>() = one.translation;
    at += 16;
  }
  return matrices;
}

std::vector<geometry::RigidTransform> transforms_of(const py::object& matrices,
                                                    const std::string& name) {
  const py::array_t<double> array = real_array(matrices, {-1, 4, 4}, "(N, 4, 4)", name);
  const auto all = array.unchecked<3>();
  std::vector<geometry::RigidTransform> transforms;
  for (py::ssize_t i = 0; i < all.shape(0); ++i) transforms.push_back(transform_at(all, i, name));
  return transforms;
}

py::array_t<double> vector_of(const Eigen::Vector3d& v) {
  return py::array_t<double>(3, v.data());
}

bool is_path(const py::object& object) {
  return py::isinstance<py::str>(object) || py::hasattr(object, "__fspath__");
}

std::filesystem::path path_of(const py::object& path, const std::string& name) {
  if (!is_path(path)) {
    throw py::type_error(fmt::format("{}: expected a path (str or os.PathLike); got {}", name,
                                     std::string(py::str(py::type::of(path).attr("__name__")))));
  }
  return std::string(py::bytes(py::module_::import("os").attr("fsencode")(path)));
}

void require_positive(double number, const std::string& name) {
  if (number > 0 && std::isfinite(number)) return;
  throw py::value_error(fmt::format("{} = {} must be positive", name, number));
}

}  // namespace roomwise::python
