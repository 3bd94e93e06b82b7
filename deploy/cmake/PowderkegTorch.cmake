# LibTorch, and lines that say which one was found: they begin with "LibTorch:", and deploy/build
# shows them.

# The TorchConfig.cmake that the settings name, before it is read: a broken one may end CMake with
# words of its own.
function(powderkeg_named_torch result)
  string(REPLACE ":" ";" from_environment "$ENV{CMAKE_PREFIX_PATH}")
  foreach(prefix ${Torch_DIR} ${CMAKE_PREFIX_PATH} ${from_environment})
    foreach(suffix "" /Torch /share/cmake/Torch /lib/cmake/Torch)
      if(EXISTS "${prefix}${suffix}/TorchConfig.cmake")
        set(${result} "${prefix}${suffix}/TorchConfig.cmake" PARENT_SCOPE)
        return()
      endif()
    endforeach()
  endforeach()
  set(${result} "" PARENT_SCOPE)
endfunction()

# "CUDA 12.4, for NVIDIA H200, 9.0 (name, compute capability)" or "without CUDA, for the processor"
function(powderkeg_torch_devices result)
  if(NOT TORCH_CUDA_LIBRARIES)
    set(${result} "without CUDA, for the processor" PARENT_SCOPE)
    return()
  endif()
  find_program(NVIDIA_SMI nvidia-smi)
  set(devices "")
  if(NVIDIA_SMI)
    execute_process(
      COMMAND ${NVIDIA_SMI} --query-gpu=name,compute_cap --format=csv,noheader
      OUTPUT_VARIABLE devices ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
    string(REGEX REPLACE "\n.*" "" devices "${devices}")
  endif()
  if(devices)
    set(devices "for ${devices} (name, compute capability)")
  else()
    set(devices "no device on this machine")
  endif()
  set(${result} "CUDA ${CUDA_VERSION}, ${devices}" PARENT_SCOPE)
endfunction()

powderkeg_named_torch(named)
if(named)
  message(STATUS "LibTorch: reading ${named}")
endif()
find_package(Torch 1.13 QUIET)
if(NOT Torch_FOUND)
  if(Torch_CONSIDERED_CONFIGS)
    list(JOIN Torch_CONSIDERED_CONFIGS " " considered)
    list(JOIN Torch_CONSIDERED_VERSIONS " " versions)
    message(STATUS "LibTorch: ${considered} (version ${versions}) is of no use; expected a whole "
                   "LibTorch of version 1.13 or newer")
  else()
    message(STATUS "LibTorch: not found; expected version 1.13 or newer: install libtorch-dev or "
                   "set CMAKE_PREFIX_PATH to its folder")
  endif()
  message(STATUS "LibTorch: -DPOWDERKEG_TORCH=OFF builds everything but the learner without it")
  message(FATAL_ERROR "There is no LibTorch; the lines above say more.")
endif()

add_library(powderkeg_torch_library INTERFACE)
target_link_libraries(powderkeg_torch_library INTERFACE torch)
target_include_directories(powderkeg_torch_library SYSTEM INTERFACE ${TORCH_INCLUDE_DIRS})
powderkeg_torch_devices(devices)
message(STATUS "LibTorch: version ${Torch_VERSION} in ${TORCH_INSTALL_PREFIX}, ${devices}")
if(named AND NOT "${Torch_CONFIG}" STREQUAL "${named}")
  message(STATUS "LibTorch: that is another one: ${named} is older than 1.13 or broken")
elseif(NOT named AND (CMAKE_PREFIX_PATH OR NOT "$ENV{CMAKE_PREFIX_PATH}" STREQUAL ""))
  message(STATUS "LibTorch: that is the system's; there is none in CMAKE_PREFIX_PATH "
                 "(${CMAKE_PREFIX_PATH}$ENV{CMAKE_PREFIX_PATH})")
endif()
