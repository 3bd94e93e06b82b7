#pragma once

// numpy arrays in and out, checked. Needs the interpreter's lock.

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <initializer_list>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "common/base/check.h"

namespace powderkeg {

namespace py = pybind11;

template <typename T>
using Array = py::array_t<T, py::array::c_style>;

using Shape = std::vector<py::ssize_t>;

// "(3, 4)"
inline std::string ShapeText(const Shape& shape) {
  return py::repr(py::tuple(py::cast(shape))).cast<std::string>();
}

inline void RequireShape(const std::string& what, const py::array& array, const Shape& expected) {
  const Shape shape(array.shape(), array.shape() + array.ndim());
  if (shape == expected) return;
  throw Error(StrCat(what, " has shape ", ShapeText(shape), ", expected ", ShapeText(expected)));
}

inline std::string DtypeText(const py::array& array) {
  return py::str(array.dtype()).cast<std::string>();
}

// The array with values of integer type T, copied if it has another integer type. Throws Error
// unless it holds integers that T holds, in this shape; `what` it is, for the message.
template <typename T>
Array<T> Integers(const std::string& what, const py::array& array, const Shape& shape) {
  RequireShape(what, array, shape);
  if (py::isinstance<Array<T>>(array)) return array;
  if (array.dtype().kind() != 'i' && array.dtype().kind() != 'u') {
    throw Error(StrCat(what, " has dtype ", DtypeText(array), ", expected integers"));
  }
  const auto wide = Array<std::int64_t>::ensure(array.attr("astype")("int64"));
  Array<T> result(shape);
  for (py::ssize_t i = 0; i < wide.size(); ++i) {
    const std::int64_t value = wide.data()[i];
    if (value < std::numeric_limits<T>::min() || value > std::numeric_limits<T>::max()) {
      throw Error(StrCat(what, " holds ", value, ", expected ", +std::numeric_limits<T>::min(),
                         " to ", +std::numeric_limits<T>::max()));
    }
    result.mutable_data()[i] = static_cast<T>(value);
  }
  return result;
}

// The array itself, to write to. Throws Error unless it is a writable C-contiguous one of this type
// and shape. None gives a new one.
template <typename T>
Array<T> Room(const std::string& what, const py::object& array, const Shape& shape) {
  if (array.is_none()) return Array<T>(shape);
  if (!py::isinstance<Array<T>>(array) || !py::array(array).writeable()) {
    throw Error(StrCat(what, " is no writable C-contiguous array of ",
                       py::str(py::dtype::of<T>()).cast<std::string>()));
  }
  RequireShape(what, array, shape);
  return array;
}

template <typename T>
std::span<T> Values(Array<T>& array) {
  return {array.mutable_data(), static_cast<std::size_t>(array.size())};
}
template <typename T>
std::span<const T> Values(const Array<T>& array) {
  return {array.data(), static_cast<std::size_t>(array.size())};
}

}  // namespace powderkeg
