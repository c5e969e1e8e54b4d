#include "python/bindings/outcome.h"

namespace roomwise::python {
namespace {

const char* name_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::kFailed:
      return "FAILED";
    case ErrorCode::kInterrupted:
      return "INTERRUPTED";
    case ErrorCode::kRefused:
      return "REFUSED";
    case ErrorCode::kDiskFull:
      return "DISK_FULL";
    case ErrorCode::kDamaged:
      return "DAMAGED";
  }
  return "FAILED";
}

// Names of files are bytes; those that are no UTF-8 are told as os.fsdecode() does.
py::str text_of(const std::string& bytes) {
  PyObject* const text =
      PyUnicode_DecodeUTF8(bytes.data(), static_cast<Py_ssize_t>(bytes.size()), "surrogateescape");
  if (text == nullptr) throw py::error_already_set();
  return py::reinterpret_steal<py::str>(text);
}

}  // namespace

void raise(const Error& error) {
  const py::module_ errors = py::module_::import("roomwise._errors");
  const py::object type = errors.attr("Error");
  const py::object raised =
      type(text_of(error.message), errors.attr("ErrorCode").attr(name_of(error.code)));
  PyErr_SetObject(type.ptr(), raised.ptr());
  throw py::error_already_set();
}

}  // namespace roomwise::python
