# libtorch with c10d and Gloo, imported as LibTorch::LibTorch. Its own CMake package asks for all that it was built
# with (protobuf, CUDA's modules) and turns its headers' warnings on.
include(FindPackageHandleStandardArgs)
find_path(LibTorch_INCLUDE_DIR ATen/ATen.h)
find_path(LibTorch_API_INCLUDE_DIR torch/optim.h PATH_SUFFIXES torch/csrc/api/include)
find_path(LibTorch_GLOO_INCLUDE_DIR gloo/context.h)
find_library(LibTorch_LIBRARY torch_cpu)
find_library(LibTorch_C10_LIBRARY c10)
find_library(LibTorch_CUDA_LIBRARY torch_cuda)
# Named here because Debian's default BLAS is 15 times slower than this one.
find_library(LibTorch_BLAS_LIBRARY NAMES openblas libopenblas.so.0)
if(LibTorch_API_INCLUDE_DIR)
  file(STRINGS ${LibTorch_API_INCLUDE_DIR}/torch/version.h _lines REGEX "#define TORCH_VERSION_(MAJOR|MINOR) ")
  string(REGEX REPLACE ".*MAJOR +([0-9]+).*MINOR +([0-9]+).*" "\\1.\\2" LibTorch_VERSION "${_lines}")
endif()
# The publisher's own build with CUDA has a BLAS inside, and NCCL in place of Gloo's headers.
if(NOT LibTorch_CUDA_LIBRARY)
  set(_of_debian LibTorch_BLAS_LIBRARY LibTorch_GLOO_INCLUDE_DIR)
endif()
find_package_handle_standard_args(LibTorch
  REQUIRED_VARS LibTorch_LIBRARY LibTorch_C10_LIBRARY LibTorch_INCLUDE_DIR LibTorch_API_INCLUDE_DIR ${_of_debian}
  VERSION_VAR LibTorch_VERSION HANDLE_VERSION_RANGE)
if(LibTorch_FOUND AND NOT TARGET LibTorch::LibTorch)
  # Imported targets' headers are the system's, whose warnings are not ours.
  add_library(LibTorch::LibTorch UNKNOWN IMPORTED)
  set_target_properties(LibTorch::LibTorch PROPERTIES
    IMPORTED_LOCATION ${LibTorch_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES "${LibTorch_INCLUDE_DIR};${LibTorch_API_INCLUDE_DIR}"
    INTERFACE_COMPILE_DEFINITIONS "USE_DISTRIBUTED")
  if(LibTorch_BLAS_LIBRARY)
    # BLAS before the rest: its symbols are found first, whichever BLAS libtorch asks for.
    set_property(TARGET LibTorch::LibTorch APPEND PROPERTY
      INTERFACE_LINK_LIBRARIES "-Wl,--no-as-needed;${LibTorch_BLAS_LIBRARY};-Wl,--as-needed")
    set_property(TARGET LibTorch::LibTorch APPEND PROPERTY INTERFACE_COMPILE_DEFINITIONS "ROOMWISE_OPENBLAS")
  endif()
  if(LibTorch_GLOO_INCLUDE_DIR)
    set_property(TARGET LibTorch::LibTorch APPEND PROPERTY
      INTERFACE_INCLUDE_DIRECTORIES "${LibTorch_GLOO_INCLUDE_DIR}")
    set_property(TARGET LibTorch::LibTorch APPEND PROPERTY INTERFACE_COMPILE_DEFINITIONS "USE_C10D_GLOO")
  endif()
  set_property(TARGET LibTorch::LibTorch APPEND PROPERTY INTERFACE_LINK_LIBRARIES "${LibTorch_C10_LIBRARY}")
  if(LibTorch_CUDA_LIBRARY)
    # Nobody calls into it by name; it makes itself known when it is loaded.
    set_property(TARGET LibTorch::LibTorch APPEND PROPERTY
      INTERFACE_LINK_LIBRARIES "-Wl,--no-as-needed;${LibTorch_CUDA_LIBRARY};-Wl,--as-needed")
    find_path(LibTorch_NCCL_INCLUDE_DIR nccl.h)
    find_path(LibTorch_CUDA_INCLUDE_DIR cuda_runtime.h PATH_SUFFIXES cuda/include)
    if(LibTorch_NCCL_INCLUDE_DIR AND LibTorch_CUDA_INCLUDE_DIR)
      set_property(TARGET LibTorch::LibTorch APPEND PROPERTY INTERFACE_COMPILE_DEFINITIONS "USE_C10D_NCCL")
      set_property(TARGET LibTorch::LibTorch APPEND PROPERTY
        INTERFACE_INCLUDE_DIRECTORIES "${LibTorch_NCCL_INCLUDE_DIR};${LibTorch_CUDA_INCLUDE_DIR}")
    endif()
  endif()
endif()
