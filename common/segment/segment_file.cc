#include "common/segment/segment_file.h"

#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <unordered_set>
#include <utility>

#include "common/base/byte_stream.h"
#include "common/base/check.h"
#include "common/base/digest.h"
#include "common/base/durable_file.h"
#include "common/record/ticket_set.h"
#include "common/segment/segment_columns.h"
#include "common/segment/segment_index.h"

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
SegmentIndex::Place WriteColumn(hid_t file, const char* name, const std::vector<T>& column,
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
  if (column.empty()) return {};
  Checked(H5Dwrite(array, type.native, H5S_ALL, H5S_ALL, H5P_DEFAULT, column.data()),
          StrCat("write ", name));
  return {.offset = H5Dget_offset(array), .rows = column.size()};
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
std::vector<std::uint8_t> Encode(const SegmentColumns& columns,
                                 std::vector<SegmentIndex::Place>& places) {
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "make access properties");
  Checked(H5Pset_fapl_core(access, /*increment=*/std::size_t{1} << 20, /*backing_store=*/0),
          "keep a file in memory");
  const Handle file(H5Fcreate("segment in memory", H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose,
                    "create a file in memory");
  WriteFormat(file);
  for (const char* group : {"games", "steps", "decisions"}) CreateGroup(file, group);
  ForEachColumn(columns, [&](const char* name, const auto& column, const char* description) {
    places.push_back(WriteColumn(file, name, column, description));
  });
  WriteStrings(file, kEvaluators, columns.evaluators);
  Checked(H5Fflush(file, H5F_SCOPE_GLOBAL), "flush a file in memory");
  const ssize_t size = Checked(H5Fget_file_image(file, nullptr, 0), "size a file in memory");
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(size));
  Checked(H5Fget_file_image(file, bytes.data(), bytes.size()), "copy a file in memory");
  return bytes;
}

// ---- Reading ------------------------------------------------------------------------------------

// Columns are as long as the file has them: a column that is cut short fits no other.
SegmentColumns ReadColumns(std::span<const std::uint8_t> file, const SegmentIndex& index) {
  SegmentColumns columns;
  columns.evaluators = index.evaluators;
  std::size_t next = 0;
  ForEachColumn(columns, [&](const char*, auto& column, const char*) {
    const auto [offset, rows] =
        next < index.places.size() ? index.places[next++] : SegmentIndex::Place{};
    const auto bytes = file.subspan(std::min<std::size_t>(offset, file.size()));
    column.resize(std::min<std::size_t>(rows, bytes.size() / sizeof(column[0])));
    if (!column.empty())
      std::memcpy(column.data(), bytes.data(), column.size() * sizeof(column[0]));
  });
  return columns;
}

// A file of HDF5, as long as its first bytes say.
bool IsWholeHdf5(std::span<const std::uint8_t> file) {
  constexpr std::array<std::uint8_t, 8> kSignature = {0x89, 'H', 'D', 'F', '\r', '\n', 0x1A, '\n'};
  constexpr std::size_t kEndOfFile = 40;  // in the superblock
  if (file.size() < kEndOfFile + sizeof(std::uint64_t)) return false;
  const auto size = ByteReader("segment", file.subspan(kEndOfFile)).Read<std::uint64_t>();
  return size == file.size() && std::ranges::equal(file.first(kSignature.size()), kSignature);
}

SegmentDamage Read(std::span<const std::uint8_t> bytes,
                   const std::function<void(GameRecord&&)>& visit) {
  const auto [index, as_written] = FindIndex(bytes);
  if (!index) {
    if (!IsWholeHdf5(bytes))
      return {.reason = "it is cut short, or no segment", .lost = std::nullopt};
    throw Error(
        StrCat("it is of another format, or another program has changed it; this program "
               "reads format ",
               kSegmentFormat));
  }
  std::unordered_set<std::uint64_t> whole;
  std::string damage = ForEachWholeGame(ReadColumns(bytes, *index), [&](GameRecord&& game) {
    whole.insert(game.ticket);
    visit(std::move(game));
  });
  if (damage.empty() && as_written) return {};
  std::vector<std::uint64_t> lost = index->tickets;
  std::erase_if(lost, [&](std::uint64_t ticket) { return whole.contains(ticket); });
  return {.reason = damage.empty() ? "its checksum is wrong" : damage, .lost = std::move(lost)};
}

}  // namespace

std::vector<std::uint8_t> EncodeSegment(std::span<const GameRecord> games) {
  SilenceLibrary();
  const SegmentColumns columns = ToColumns(games);
  SegmentIndex index{.tickets = columns.games.ticket, .evaluators = columns.evaluators};
  std::vector<std::uint8_t> bytes = Encode(columns, index.places);
  const std::vector<std::uint8_t> ending = EndingOf(index, bytes);
  bytes.insert(bytes.end(), ending.begin(), ending.end());
  return bytes;
}

std::string LostText(const SegmentDamage& damage) {
  return damage.lost ? TicketsText(*damage.lost) : "unknown";
}

SegmentDamage ReadSegment(const fs::path& path, const std::function<void(GameRecord&&)>& visit) {
  const std::vector<std::uint8_t> bytes = ReadFileBytes(path);
  try {
    return Read(bytes, visit);
  } catch (const Error& error) {
    throw Error(StrCat("segment ", path.string(), ": ", error.what()));
  }
}

std::optional<std::vector<std::uint64_t>> ReadTickets(const fs::path& path) {
  constexpr std::size_t kUsualIndexBytes = 4096;
  std::vector<std::uint8_t> end = ReadFileEnd(path, kUsualIndexBytes);
  const auto bytes = IndexBytes(end);
  if (!bytes) return std::nullopt;
  if (*bytes > end.size()) end = ReadFileEnd(path, *bytes);
  auto index = IndexAtEnd(end);
  return index ? std::optional(std::move(index->tickets)) : std::nullopt;
}

}  // namespace powderkeg
