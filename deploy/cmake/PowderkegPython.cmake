# What the Python package is built with (deploy/packages-python.txt). Sets POWDERKEG_PYTHON, unless
# it is given: whether all of that is there and the build is one for users.

# The system's Python has the system's packages, whichever comes first in PATH.
if(NOT Python_EXECUTABLE AND EXISTS /usr/bin/python3)
  set(Python_EXECUTABLE /usr/bin/python3)
endif()
find_package(Python 3.9 QUIET COMPONENTS Interpreter Development.Module NumPy)
find_package(pybind11 2.10 QUIET)
set(found OFF)
if(Python_FOUND AND pybind11_FOUND)
  set(found ON)
endif()
if(NOT DEFINED POWDERKEG_PYTHON)
  set(POWDERKEG_PYTHON ${found})
  if(POWDERKEG_SANITIZE OR POWDERKEG_FUZZ)
    set(POWDERKEG_PYTHON OFF)
  endif()
elseif(POWDERKEG_PYTHON AND NOT found)
  message(FATAL_ERROR "POWDERKEG_PYTHON is ON, but there is no Python with headers and numpy, or no "
                      "pybind11; install what deploy/packages-python.txt lists")
endif()
if(POWDERKEG_PYTHON)
  message(STATUS "Python: ${Python_VERSION} (${Python_EXECUTABLE})")
else()
  message(STATUS "Python: left out")
endif()
