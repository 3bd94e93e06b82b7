#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cstring>

#include "common/base/check.h"
#include "common/model/planes.h"
#include "common/model/weights_format.h"
#include "common/model/weights_snapshot.h"
#include "python/native/arrays.h"
#include "python/native/bindings.h"

namespace powderkeg {
namespace {

constexpr auto kOthers = py::ssize_t{kAgentCount - 1};
constexpr auto kActions = py::ssize_t{kActionCount};

py::ssize_t Count(const Canary& canary) { return static_cast<py::ssize_t>(canary.states.size()); }

Array<float> CanaryPlanes(const Canary& canary) {
  Array<float> planes(
      {Count(canary), py::ssize_t{kPlaneCount}, py::ssize_t{kBoardSize}, py::ssize_t{kBoardSize}});
  for (std::size_t i = 0; i < canary.states.size(); ++i) {
    EncodePlanes(
        GameSettings{}, {&canary.states[i], canary.viewers[i]},
        std::span<float, kPlanesSize>(planes.mutable_data() + i * kPlanesSize, kPlanesSize));
  }
  return planes;
}

// What `value_of` an evaluation is, in rows of `shape`.
template <typename T, typename ValueOf>
Array<T> Answers(const Canary& canary, Shape shape, ValueOf&& value_of) {
  shape.insert(shape.begin(), Count(canary));
  Array<T> array(shape);
  T* row = array.mutable_data();
  for (const Evaluation& evaluation : canary.evaluations) {
    const auto& value = value_of(evaluation);
    std::memcpy(row, &value, sizeof(value));
    row += sizeof(value) / sizeof(T);
  }
  return array;
}

// The same questions with other answers.
Canary Answered(const Canary& canary, const py::array& policy, const py::array& value,
                const py::object& others) {
  const auto floats = [](const char* what, const py::array& array, const Shape& shape) {
    RequireShape(what, array, shape);
    return Array<float>(array);
  };
  const auto policies = floats("policy", policy, {Count(canary), kActions});
  const auto values = floats("value", value, {Count(canary)});
  Array<std::uint8_t> foretold({Count(canary), kOthers, kActions});
  std::ranges::fill(Values(foretold), std::uint8_t{0});
  if (!others.is_none()) {
    foretold =
        Integers<std::uint8_t>("others", py::array(others), {Count(canary), kOthers, kActions});
  }
  Canary result = canary;
  for (std::size_t i = 0; i < result.evaluations.size(); ++i) {
    Evaluation& evaluation = result.evaluations[i];
    std::memcpy(&evaluation.policy, policies.data() + i * evaluation.policy.size(),
                sizeof(evaluation.policy));
    evaluation.value = values.data()[i];
    std::memcpy(&evaluation.others, foretold.data() + i * sizeof(evaluation.others),
                sizeof(evaluation.others));
  }
  return result;
}

constexpr std::array<const char*, 2> kBlockKinds = {"inverted_residual", "residual"};

py::dict ToDictionary(const NetworkDescription& description) {
  py::list blocks;
  for (const BlockDescription& block : description.blocks) {
    blocks.append(py::dict(py::arg("kind") = kBlockKinds[static_cast<std::size_t>(block.kind)],
                           py::arg("expanded") = block.expanded,
                           py::arg("channels") = block.channels, py::arg("stride") = block.stride));
  }
  return py::dict(py::arg("planes") = description.planes,
                  py::arg("stem_channels") = description.stem_channels,
                  py::arg("stem_stride") = description.stem_stride, py::arg("blocks") = blocks,
                  py::arg("value_channels") = description.value_channels,
                  py::arg("value_hidden") = description.value_hidden,
                  py::arg("policy_channels") = description.policy_channels,
                  py::arg("own_hidden") = description.own_hidden,
                  py::arg("others_hidden") = description.others_hidden,
                  py::arg("leaky_slope") = description.leaky_slope);
}

// The entry `key`. Throws Error unless it is there and of type T.
template <typename T>
T Entry(const py::dict& dictionary, const char* key) {
  if (!dictionary.contains(key)) throw Error(StrCat("description has no '", key, "'"));
  const py::object value = dictionary[key];
  try {
    return value.cast<T>();
  } catch (const py::cast_error&) {
    const py::object type = py::type::of(py::cast(T{}));
    throw Error(StrCat("description: ", key, " is ", std::string(py::repr(value)), ", expected ",
                       std::string(py::str(type.attr("__name__")))));
  }
}

BlockDescription BlockFrom(const py::dict& given) {
  const auto name = Entry<std::string>(given, "kind");
  const auto kind = std::ranges::find(kBlockKinds, name);
  if (kind == kBlockKinds.end()) {
    throw Error(
        StrCat("description: kind is '", name, "', expected inverted_residual or residual"));
  }
  return {.kind = static_cast<BlockDescription::Kind>(kind - kBlockKinds.begin()),
          .expanded = Entry<int>(given, "expanded"),
          .channels = Entry<int>(given, "channels"),
          .stride = Entry<int>(given, "stride")};
}

NetworkDescription FromDictionary(const py::dict& given) {
  NetworkDescription description{.planes = Entry<int>(given, "planes"),
                                 .stem_channels = Entry<int>(given, "stem_channels"),
                                 .stem_stride = Entry<int>(given, "stem_stride"),
                                 .blocks = {},
                                 .value_channels = Entry<int>(given, "value_channels"),
                                 .value_hidden = Entry<int>(given, "value_hidden"),
                                 .policy_channels = Entry<int>(given, "policy_channels"),
                                 .own_hidden = Entry<int>(given, "own_hidden"),
                                 .others_hidden = Entry<int>(given, "others_hidden"),
                                 .leaky_slope = Entry<float>(given, "leaky_slope")};
  for (const auto& block : Entry<std::vector<py::dict>>(given, "blocks")) {
    description.blocks.push_back(BlockFrom(block));
  }
  Validate(description);
  return description;
}

py::tuple Load(const std::string& name) {
  const Snapshot snapshot = LoadModel(name);
  py::dict arrays;
  for (const NamedArray& array : snapshot->arrays) {
    Array<float> values(Shape(array.shape.begin(), array.shape.end()));
    std::ranges::copy(array.values, values.mutable_data());
    arrays[py::str(array.name)] = values;
  }
  return py::make_tuple(snapshot->version, ToDictionary(snapshot->description), arrays,
                        snapshot->canary);
}

NamedArray ArrayFrom(const py::dict& arrays, const ArrayShape& expected) {
  if (!arrays.contains(expected.name)) {
    throw Error(StrCat("arrays has no '", expected.name, "'"));
  }
  const auto given = py::array::ensure(arrays[py::str(expected.name)]);
  if (!given || given.dtype().kind() != 'f') {
    throw Error(StrCat("array ", expected.name, " is no array of floats"));
  }
  RequireShape("array " + expected.name, given,
               Shape(expected.shape.begin(), expected.shape.end()));
  const Array<float> values(given);
  return {expected.name, expected.shape, {values.data(), values.data() + values.size()}};
}

py::dict Dictionary(const char* what, const py::object& given) {
  if (py::isinstance<py::dict>(given)) return given;
  throw Error(StrCat(what, " is of type ",
                     std::string(py::str(py::type::of(given).attr("__name__"))),
                     ", expected dict"));
}

// Throws Error unless the arrays are those of the description, and finite.
WeightsSnapshot SnapshotFrom(const py::object& description, const py::object& given) {
  WeightsSnapshot snapshot{0, FromDictionary(Dictionary("description", description)), {}, {}};
  const py::dict arrays = Dictionary("arrays", given);
  const std::vector<ArrayShape> shapes = ArraysOf(snapshot.description);
  for (const ArrayShape& shape : shapes) snapshot.arrays.push_back(ArrayFrom(arrays, shape));
  if (arrays.size() != shapes.size()) {
    throw Error(StrCat("arrays has ", arrays.size(), " entries, expected ", shapes.size()));
  }
  Validate(snapshot);
  return snapshot;
}

void Save(const std::string& path, std::uint32_t version, const py::object& description,
          const py::object& arrays, const Canary& canary) {
  WeightsSnapshot snapshot = SnapshotFrom(description, arrays);
  snapshot.version = version;
  snapshot.canary = canary;
  SaveSnapshot(snapshot, path);
}

py::bytes ToBytes(const Canary& canary) {
  const std::vector<std::uint8_t> bytes = SerializeCanary(canary);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

Canary FromBytes(const py::bytes& given) {
  const auto bytes = given.cast<std::string_view>();
  return DeserializeCanary({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
}

}  // namespace

void BindWeights(py::module_& module) {
  using py::arg;
  py::class_<Canary>(module, "Canary")
      .def(py::init<>())
      .def("__len__", &Count)
      .def_property_readonly("planes", &CanaryPlanes)
      .def_property_readonly("viewer", [](const Canary& canary) { return canary.viewers; })
      .def_property_readonly("policy",
                             [](const Canary& canary) {
                               return Answers<float>(
                                   canary, {kActions},
                                   [](const Evaluation& e) -> const auto& { return e.policy; });
                             })
      .def_property_readonly("value",
                             [](const Canary& canary) {
                               return Answers<float>(
                                   canary, {},
                                   [](const Evaluation& e) -> const auto& { return e.value; });
                             })
      .def_property_readonly("others",
                             [](const Canary& canary) {
                               return Answers<std::uint8_t>(
                                   canary, {kOthers, kActions},
                                   [](const Evaluation& e) -> const auto& { return e.others; });
                             })
      .def("answered", &Answered, arg("policy"), arg("value"), arg("others") = py::none())
      .def("__eq__", [](const Canary& a, const Canary& b) { return a == b; })
      .def("to_bytes", &ToBytes)
      .def_static("from_bytes", &FromBytes, arg("data"))
      .def(py::pickle(&ToBytes, &FromBytes));
  module.def("load_weights", &Load, arg("name"));
  module.def(
      "check_description",
      [](const py::object& given) { (void)FromDictionary(Dictionary("description", given)); },
      arg("description"));
  module.def(
      "check_weights",
      [](const py::object& description, const py::object& arrays) {
        (void)SnapshotFrom(description, arrays);
      },
      arg("description"), arg("arrays"));
  module.def("save_weights", &Save, arg("path"), arg("version"), arg("description"), arg("arrays"),
             arg("canary"));
}

}  // namespace powderkeg
