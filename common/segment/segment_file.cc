#include "common/segment/segment_file.h"

#include <hdf5.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

#include "common/base/check.h"
#include "common/segment/segment_columns.h"

namespace powderkeg {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFormatAttribute = "powderkeg_format";
constexpr const char* kEvaluators = "evaluators";

// ---- HDF5 objects -------------------------------------------------------------------------------

// The library's own messages would go to standard error.
void SilenceLibrary() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

// Where the library's last failure began, in its words: "file signature not found".
std::string Reason() {
  std::string reason;
  H5Ewalk2(
      H5E_DEFAULT, H5E_WALK_UPWARD,
      [](unsigned depth, const H5E_error2_t* error, void* text) -> herr_t {
        if (depth == 0 && error->desc != nullptr) *static_cast<std::string*>(text) = error->desc;
        return 0;
      },
      &reason);
  return reason;
}

// Turns the library's negative results into an Error.
template <typename Value>
Value Checked(Value result, std::string_view what) {
  if (result < 0) throw Error(StrCat("HDF5 cannot ", what, ": ", Reason()));
  return result;
}

// Owns an object of the library.
class Handle {
 public:
  using CloseFunction = herr_t (*)(hid_t);
  Handle(hid_t id, CloseFunction close, std::string_view what)
      : id_(Checked(id, what)), close_(close) {}
  ~Handle() { close_(id_); }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return id_; }  // NOLINT: stands for the id everywhere

 private:
  hid_t id_;
  CloseFunction close_;
};

// A row of a column is one number or a fixed number of them.
template <typename T>
struct Row {
  using Number = T;
  static constexpr hsize_t kWidth = 0;  // the array has one dimension
};
template <typename T, std::size_t width>
struct Row<std::array<T, width>> {
  using Number = T;
  static constexpr hsize_t kWidth = width;
};

struct NumberType {
  hid_t native;
  hid_t stored;  // little-endian
};

template <typename Number>
NumberType TypeOf() {
  if constexpr (std::is_same_v<Number, float>) return {H5T_NATIVE_FLOAT, H5T_IEEE_F32LE};
  if constexpr (std::is_same_v<Number, std::int8_t>) return {H5T_NATIVE_INT8, H5T_STD_I8LE};
  if constexpr (std::is_same_v<Number, std::uint8_t>) return {H5T_NATIVE_UINT8, H5T_STD_U8LE};
  if constexpr (std::is_same_v<Number, std::uint16_t>) return {H5T_NATIVE_UINT16, H5T_STD_U16LE};
  if constexpr (std::is_same_v<Number, std::uint32_t>) return {H5T_NATIVE_UINT32, H5T_STD_U32LE};
  if constexpr (std::is_same_v<Number, std::uint64_t>) return {H5T_NATIVE_UINT64, H5T_STD_U64LE};
}

Handle StringType(std::size_t length) {
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, length);
  H5Tset_strpad(type, H5T_STR_NULLPAD);
  return {type, H5Tclose, "make a string type"};
}

// ---- Writing ------------------------------------------------------------------------------------

void WriteText(hid_t object, const char* name, std::string_view text) {
  const Handle type = StringType(text.size());
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose, "make a scalar");
  const Handle attribute(H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
                         "create an attribute");
  Checked(H5Awrite(attribute, type, text.data()), "write an attribute");
}

void WriteFormat(hid_t file) {
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose, "make a scalar");
  const Handle attribute(
      H5Acreate2(file, kFormatAttribute, H5T_STD_U32LE, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
      "create an attribute");
  Checked(H5Awrite(attribute, H5T_NATIVE_UINT32, &kSegmentFormat), "write an attribute");
}

template <typename T>
void WriteColumn(hid_t file, const char* name, const std::vector<T>& column,
                 const char* description) {
  constexpr hsize_t kWidth = Row<T>::kWidth;
  const NumberType type = TypeOf<typename Row<T>::Number>();
  const std::array<hsize_t, 2> shape = {column.size(), kWidth};
  const Handle space(H5Screate_simple(kWidth == 0 ? 1 : 2, shape.data(), nullptr), H5Sclose,
                     "make a shape");
  const Handle array(
      H5Dcreate2(file, name, type.stored, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Dclose,
      StrCat("create ", name));
  WriteText(array, "description", description);
  if (column.empty()) return;
  Checked(H5Dwrite(array, type.native, H5S_ALL, H5S_ALL, H5P_DEFAULT, column.data()),
          StrCat("write ", name));
}

void WriteStrings(hid_t file, const char* name, const std::vector<std::string>& strings) {
  std::size_t length = 1;
  for (const std::string& string : strings) length = std::max(length, string.size());
  std::string padded;
  for (const std::string& string : strings) {
    padded.append(string).append(length - string.size(), '\0');
  }
  const Handle type = StringType(length);
  const hsize_t count = strings.size();
  const Handle space(H5Screate_simple(1, &count, nullptr), H5Sclose, "make a shape");
  const Handle array(H5Dcreate2(file, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                     H5Dclose, StrCat("create ", name));
  if (strings.empty()) return;
  Checked(H5Dwrite(array, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, padded.data()),
          StrCat("write ", name));
}

void CreateGroup(hid_t file, const char* name) {
  const Handle group(H5Gcreate2(file, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose,
                     StrCat("create ", name));
}

// The segment as the bytes of a file. The library writes into memory only: errors of the disk are
// then met by our own code, one place and no half-closed library objects.
std::vector<std::uint8_t> Encode(const SegmentColumns& columns) {
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "make access properties");
  Checked(H5Pset_fapl_core(access, /*increment=*/std::size_t{1} << 20, /*backing_store=*/0),
          "keep a file in memory");
  const Handle file(H5Fcreate("segment in memory", H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose,
                    "create a file in memory");
  WriteFormat(file);
  for (const char* group : {"games", "steps", "decisions"}) CreateGroup(file, group);
  ForEachColumn(columns, [&](const char* name, const auto& column, const char* description) {
    WriteColumn(file, name, column, description);
  });
  WriteStrings(file, kEvaluators, columns.evaluators);
  Checked(H5Fflush(file, H5F_SCOPE_GLOBAL), "flush a file in memory");
  const ssize_t size = Checked(H5Fget_file_image(file, nullptr, 0), "size a file in memory");
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(size));
  Checked(H5Fget_file_image(file, bytes.data(), bytes.size()), "copy a file in memory");
  return bytes;
}

// ---- Reading ------------------------------------------------------------------------------------

void ExpectFormat(hid_t file) {
  const Handle attribute(H5Aopen(file, kFormatAttribute, H5P_DEFAULT), H5Aclose,
                         StrCat("find the attribute ", kFormatAttribute));
  std::uint32_t format = 0;
  Checked(H5Aread(attribute, H5T_NATIVE_UINT32, &format), "read the format");
  if (format != kSegmentFormat) {
    throw Error(StrCat("its format is ", format, ", this program reads ", kSegmentFormat));
  }
}

// Rows of an array with `width` numbers a row (0: one dimension) that must fit into a file of
// `file_bytes`.
std::size_t RowCount(hid_t array, const char* name, hsize_t width, std::size_t row_bytes,
                     std::uint64_t file_bytes) {
  const Handle space(H5Dget_space(array), H5Sclose, StrCat("read the shape of ", name));
  const int rank = H5Sget_simple_extent_ndims(space);
  std::array<hsize_t, 2> shape{};
  if (rank != (width == 0 ? 1 : 2)) throw Error(StrCat(name, " has ", rank, " dimensions"));
  Checked(H5Sget_simple_extent_dims(space, shape.data(), nullptr),
          StrCat("read the shape of ", name));
  if (shape[1] != width) throw Error(StrCat(name, " has rows of ", shape[1]));
  if (shape[0] > file_bytes / row_bytes) throw Error(StrCat(name, " is longer than its file"));
  return shape[0];
}

template <typename T>
void ReadColumn(hid_t file, const char* name, std::uint64_t file_bytes, std::vector<T>& column) {
  const Handle array(H5Dopen2(file, name, H5P_DEFAULT), H5Dclose, StrCat("find ", name));
  column.resize(RowCount(array, name, Row<T>::kWidth, sizeof(T), file_bytes));
  if (column.empty()) return;
  const NumberType type = TypeOf<typename Row<T>::Number>();
  Checked(H5Dread(array, type.native, H5S_ALL, H5S_ALL, H5P_DEFAULT, column.data()),
          StrCat("read ", name));
}

std::vector<std::string> ReadStrings(hid_t file, const char* name, std::uint64_t file_bytes) {
  const Handle array(H5Dopen2(file, name, H5P_DEFAULT), H5Dclose, StrCat("find ", name));
  const Handle type(H5Dget_type(array), H5Tclose, StrCat("read the type of ", name));
  const std::size_t length = H5Tget_size(type);
  if (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) > 0 || length == 0) {
    throw Error(StrCat(name, " does not hold strings of a fixed length"));
  }
  std::string padded(RowCount(array, name, 0, length, file_bytes) * length, '\0');
  if (padded.empty()) return {};
  Checked(H5Dread(array, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, padded.data()),
          StrCat("read ", name));
  std::vector<std::string> strings;
  for (std::size_t start = 0; start < padded.size(); start += length) {
    std::string string = padded.substr(start, length);
    string.erase(string.find_last_not_of('\0') + 1);
    strings.push_back(std::move(string));
  }
  return strings;
}

// Opens a file without the library's lock: segments never change, some file systems have no locks,
// and on others whoever looks at a file in another program may hold one.
hid_t Open(const fs::path& path, std::uint64_t bytes) {
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "make access properties");
  Checked(H5Pset_file_locking(access, /*use_file_locking=*/0, /*ignore_when_disabled=*/1),
          "do without locks");
  return Checked(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access),
                 StrCat("open it (", bytes, " bytes)"));
}

// A segment opened for reading. Throws Error if it is none of ours.
class SegmentReader {
 public:
  explicit SegmentReader(const fs::path& path)
      : bytes_(ReadableBytes(path)), file_(Open(path, bytes_), H5Fclose, "open it") {
    ExpectFormat(file_);
  }

  [[nodiscard]] SegmentColumns Columns() const {
    SegmentColumns columns;
    ForEachColumn(columns, [&](const char* name, auto& column, const char*) {
      ReadColumn(file_, name, bytes_, column);
    });
    columns.evaluators = ReadStrings(file_, kEvaluators, bytes_);
    return columns;
  }
  [[nodiscard]] std::vector<std::uint64_t> Tickets() const {
    std::vector<std::uint64_t> tickets;
    ReadColumn(file_, "games/ticket", bytes_, tickets);
    return tickets;
  }

 private:
  static std::uint64_t ReadableBytes(const fs::path& path) {
    if (access(path.c_str(), R_OK) != 0) throw Error(std::strerror(errno));
    return fs::file_size(path);
  }

  std::uint64_t bytes_;
  Handle file_;
};

// Calls `read`; an error then names the segment.
template <typename Read>
auto Named(const fs::path& path, Read&& read) {
  SilenceLibrary();
  try {
    return read();
  } catch (const Error& error) {
    throw Error(StrCat("segment ", path.string(), ": ", error.what()));
  } catch (const fs::filesystem_error& error) {
    throw Error(StrCat("segment ", path.string(), ": ", error.code().message()));
  }
}

}  // namespace

std::vector<std::uint8_t> EncodeSegment(std::span<const GameRecord> games) {
  SilenceLibrary();
  return Encode(ToColumns(games));
}

void ReadSegment(const fs::path& path, const std::function<void(GameRecord&&)>& visit) {
  Named(path, [&] { ForEachGame(SegmentReader(path).Columns(), visit); });
}

std::vector<std::uint64_t> ReadTickets(const fs::path& path) {
  return Named(path, [&] { return SegmentReader(path).Tickets(); });
}

}  // namespace powderkeg
