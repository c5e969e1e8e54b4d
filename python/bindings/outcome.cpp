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
  }
  return "FAILED";
}

}  // namespace

void raise(const Error& error) {
  const py::module_ errors = py::module_::import("roomwise._errors");
  const py::object type = errors.attr("Error");
  const py::object raised = type(error.message, errors.attr("ErrorCode").attr(name_of(error.code)));
  PyErr_SetObject(type.ptr(), raised.ptr());
  throw py::error_already_set();
}

}  // namespace roomwise::python
