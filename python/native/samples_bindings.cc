#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <array>
#include <cstring>
#include <mutex>

#include "common/base/check.h"
#include "common/model/planes.h"
#include "common/pommerman/observation.h"
#include "python/native/arrays.h"
#include "python/native/bindings.h"
#include "python/native/sample_reader.h"

namespace powderkeg {
namespace {

constexpr std::int64_t kMaxBatch = 1'000'000;

// A reader that any thread may call. The interpreter's lock is held while a file is read, as HDF5
// allows one thread alone, and not while games are played again.
class Samples {
 public:
  explicit Samples(const std::string& path) : reader_(path) {}

  std::vector<TicketedSample> Next(std::size_t count) {
    const py::gil_scoped_release released;
    const std::scoped_lock lock(mutex_);
    return reader_.Next(count);
  }
  std::vector<std::string> damages() {
    const py::gil_scoped_release released;
    const std::scoped_lock lock(mutex_);
    return reader_.damages();
  }

 private:
  std::mutex mutex_;
  SampleReader reader_;
};

// An array with one row for each sample, filled by value_of(sample).
template <typename T, typename ValueOf>
Array<T> Column(const std::vector<TicketedSample>& samples, ValueOf&& value_of) {
  Array<T> array(static_cast<py::ssize_t>(samples.size()));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    array.mutable_data()[i] = static_cast<T>(value_of(samples[i].sample));
  }
  return array;
}

// The same with `width` values in a row, which member `values` of a sample holds.
template <typename T, typename Values>
Array<T> Table(const std::vector<TicketedSample>& samples, py::ssize_t width,
               Values Sample::*values) {
  static_assert(sizeof(Values) % sizeof(T) == 0);
  Array<T> array({static_cast<py::ssize_t>(samples.size()), width});
  T* row = array.mutable_data();
  for (const TicketedSample& entry : samples) {
    std::memcpy(row, &(entry.sample.*values), sizeof(Values));
    row += width;
  }
  return array;
}

Array<float> Planes(const std::vector<TicketedSample>& samples) {
  Array<float> planes({static_cast<py::ssize_t>(samples.size()), py::ssize_t{kPlaneCount},
                       py::ssize_t{kBoardSize}, py::ssize_t{kBoardSize}});
  float* row = planes.mutable_data();
  const py::gil_scoped_release released;
  for (const auto& [sample, ticket, settings] : samples) {
    const Cell cell = sample.state.agents[sample.viewer].cell;
    EncodePlanes(settings, {&sample.state, sample.viewer, VisibleCells(settings, cell)},
                 std::span<float, kPlanesSize>(row, kPlanesSize));
    row += kPlanesSize;
  }
  return planes;
}

py::dict ArraysOf(const std::vector<TicketedSample>& samples, bool with_planes) {
  py::dict arrays;
  Array<std::uint64_t> tickets(static_cast<py::ssize_t>(samples.size()));
  for (std::size_t i = 0; i < samples.size(); ++i) tickets.mutable_data()[i] = samples[i].ticket;
  arrays["ticket"] = tickets;
  arrays["viewer"] = Column<std::uint8_t>(samples, [](const Sample& s) { return s.viewer; });
  arrays["step"] = Column<std::uint16_t>(samples, [](const Sample& s) { return s.state.step; });
  arrays["end_step"] = Column<std::uint16_t>(samples, [](const Sample& s) { return s.end_step; });
  arrays["searched"] = Column<bool>(samples, [](const Sample& s) { return s.searched; });
  arrays["visits"] = Table<std::uint16_t>(samples, kActionCount, &Sample::visits);
  arrays["value"] = Column<float>(samples, [](const Sample& s) { return s.search_value; });
  arrays["outcome"] = Column<std::int8_t>(samples, [](const Sample& s) { return s.outcome; });
  arrays["others"] = Table<std::uint8_t>(samples, kAgentCount - 1, &Sample::others);
  if (with_planes) arrays["planes"] = Planes(samples);
  return arrays;
}

py::dict NextBatch(Samples& samples, std::int64_t count, bool with_planes) {
  if (count < 1 || count > kMaxBatch) {
    throw Error(StrCat("batch_size is ", count, ", expected 1 to ", kMaxBatch));
  }
  return ArraysOf(samples.Next(static_cast<std::size_t>(count)), with_planes);
}

}  // namespace

void BindSamples(py::module_& module) {
  using py::arg;
  py::class_<Samples>(module, "Samples")
      .def(py::init<const std::string&>(), arg("path"))
      .def("next", &NextBatch, arg("count"), arg("planes"))
      .def("damages", &Samples::damages);
}

}  // namespace powderkeg
