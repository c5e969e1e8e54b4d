# Debian ships OpenCV's CMake package only with the whole of libopencv-dev. The single modules that Roomwise
# uses are found here and imported as OpenCV::core, OpenCV::imgproc, OpenCV::features2d, and, where
# they are installed, OpenCV::calib3d and OpenCV::dnn, which only tests and benchmarks want.
include(FindPackageHandleStandardArgs)

find_path(OpenCVModules_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4)
set(_modules core imgproc features2d calib3d dnn)
set(_needs_core "")
set(_needs_imgproc core)
set(_needs_features2d imgproc)
set(_needs_calib3d features2d)
set(_needs_dnn imgproc)
set(_libraries "")
foreach(_module ${_modules})
  find_library(OpenCVModules_${_module}_LIBRARY opencv_${_module})
  if(NOT _module MATCHES "^(calib3d|dnn)$")
    list(APPEND _libraries OpenCVModules_${_module}_LIBRARY)
  endif()
endforeach()
if(OpenCVModules_INCLUDE_DIR)
  file(STRINGS ${OpenCVModules_INCLUDE_DIR}/opencv2/core/version.hpp _lines REGEX "#define CV_VERSION_(MAJOR|MINOR)")
  string(REGEX REPLACE ".*MAJOR +([0-9]+).*MINOR +([0-9]+).*" "\\1.\\2" OpenCVModules_VERSION "${_lines}")
endif()
find_package_handle_standard_args(OpenCVModules
  REQUIRED_VARS OpenCVModules_INCLUDE_DIR ${_libraries} VERSION_VAR OpenCVModules_VERSION)
if(OpenCVModules_FOUND)
  foreach(_module ${_modules})
    if(NOT TARGET OpenCV::${_module} AND OpenCVModules_${_module}_LIBRARY)
      add_library(OpenCV::${_module} UNKNOWN IMPORTED)
      set_target_properties(OpenCV::${_module} PROPERTIES
        IMPORTED_LOCATION ${OpenCVModules_${_module}_LIBRARY}
        INTERFACE_INCLUDE_DIRECTORIES ${OpenCVModules_INCLUDE_DIR})
      foreach(_need ${_needs_${_module}})
        set_property(TARGET OpenCV::${_module} APPEND PROPERTY INTERFACE_LINK_LIBRARIES OpenCV::${_need})
      endforeach()
    endif()
  endforeach()
endif()
