#include "common/config/options.h"

#include <charconv>
#include <cmath>
#include <numeric>
#include <system_error>

namespace powderkeg {
namespace {

constexpr std::array<std::string_view, 2> kFlagNames = {"false", "true"};

template <typename Number>
bool ReadNumber(std::string_view text, const Allowed& allowed, Number& value) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return false;
  const auto real = static_cast<double>(number);
  const bool inside = real >= allowed.low && real <= allowed.high;
  if (!inside || (allowed.above && real == allowed.low)) return false;
  value = number;
  return true;
}

std::string Shortest(double value) {
  std::array<char, 32> text;
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general).ptr;
  return {text.data(), end};
}

// "from LOW to HIGH" of a type's own values.
template <typename Number>
std::string RangeOf(const Allowed& allowed) {
  using Limits = std::numeric_limits<Number>;
  const auto bound = [](double value) {
    if (value <= static_cast<double>(Limits::lowest())) return StrCat(Limits::lowest());
    if (value >= static_cast<double>(Limits::max())) return StrCat(Limits::max());
    return StrCat(static_cast<Number>(value));
  };
  return StrCat(allowed.above ? "above " : "from ", bound(allowed.low), " to ",
                bound(allowed.high));
}

// Changes of one character that make one text the other.
std::size_t EditDistance(std::string_view from, std::string_view to) {
  std::vector<std::size_t> row(to.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < from.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < to.size(); ++j) {
      const std::size_t replaced = diagonal + (from[i] == to[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, diagonal + 1, row[j] + 1});
    }
  }
  return row.back();
}

}  // namespace

std::string Joined(Names names, std::string_view separator) {
  std::string text;
  for (const std::string_view name : names) {
    if (!text.empty()) text += separator;
    text += name;
  }
  return text;
}

bool ReadValue(std::string_view text, const Allowed& allowed, int& value) {
  return ReadNumber(text, allowed, value);
}
bool ReadValue(std::string_view text, const Allowed& allowed, double& value) {
  return ReadNumber(text, allowed, value);
}
bool ReadValue(std::string_view text, const Allowed& allowed, std::uint64_t& value) {
  return ReadNumber(text, allowed, value);
}
bool ReadValue(std::string_view text, const Allowed& /*allowed*/, bool& value) {
  if (std::ranges::find(kFlagNames, text) == kFlagNames.end()) return false;
  value = text == kFlagNames[1];
  return true;
}
bool ReadValue(std::string_view text, const Allowed& allowed, std::string& value) {
  const Names& names = allowed.names;
  if (!names.empty() && std::ranges::find(names, text) == names.end()) return false;
  value = text;
  return true;
}
bool ReadValue(std::string_view text, const Allowed& /*allowed*/, std::vector<std::string>& value) {
  value.clear();
  while (!text.empty()) {
    const std::string_view word = text.substr(0, text.find_first_of(" ,"));
    if (!word.empty()) value.emplace_back(word);
    text.remove_prefix(std::min(text.size(), word.size() + 1));
  }
  return true;
}

std::string WriteValue(double value, const Allowed& /*allowed*/) { return Shortest(value); }
std::string WriteValue(std::uint64_t value, const Allowed& /*allowed*/) { return StrCat(value); }
std::string WriteValue(int value, const Allowed& /*allowed*/) { return StrCat(value); }
std::string WriteValue(bool value, const Allowed& /*allowed*/) {
  return std::string(kFlagNames[value ? 1 : 0]);
}
std::string WriteValue(const std::string& value, const Allowed& /*allowed*/) { return value; }
std::string WriteValue(const std::vector<std::string>& value, const Allowed& /*allowed*/) {
  const std::vector<std::string_view> words(value.begin(), value.end());
  return Joined(words, " ");
}

std::string Expected(const Allowed& allowed, const int*) {
  return "a whole number " + RangeOf<int>(allowed);
}
std::string Expected(const Allowed& allowed, const double*) {
  return "a number " + RangeOf<double>(allowed);
}
std::string Expected(const Allowed& allowed, const std::uint64_t*) {
  return "a whole number " + RangeOf<std::uint64_t>(allowed);
}
std::string Expected(const Allowed& /*allowed*/, const bool*) { return Joined(kFlagNames, " or "); }
std::string Expected(const Allowed& allowed, const std::string*) {
  return allowed.names.empty() ? "a text" : "one of " + Joined(allowed.names, ", ");
}
std::string Expected(const Allowed& /*allowed*/, const std::vector<std::string>*) {
  return "words separated by spaces or commas";
}

void RefuseName(const TextField& field, std::string_view path,
                const std::vector<std::string_view>& known) {
  constexpr std::size_t kLongest = 64;  // of a name that could be meant
  const std::string_view name = std::string_view(field.name).substr(0, kLongest);
  const auto nearest = std::ranges::min_element(
      known, {}, [name](std::string_view other) { return EditDistance(name, other); });
  throw Error(StrCat(field.place, "there is no setting ", path, Quoted(name), "; did you mean ",
                     path, *nearest, "? --help-options lists all"));
}

void CheckNames(std::span<const TextField> fields, std::string_view path,
                const std::vector<std::string_view>& options, Names sections) {
  std::vector<std::string_view> known = options;
  known.insert(known.end(), sections.begin(), sections.end());
  for (const TextField& field : fields) {
    const auto found = std::ranges::find(known, field.name);
    if (found == known.end()) RefuseName(field, path, known);
    const bool is_section = found - known.begin() >= std::ssize(options);
    if (field.is_section == is_section) continue;
    throw Error(StrCat(field.place, path, field.name,
                       is_section ? " is a section, not a setting" : " has no settings in it"));
  }
}

std::optional<GivenValue> ValueOf(std::span<const TextField> fields, std::string_view path,
                                  std::string_view name, bool is_list) {
  std::optional<GivenValue> value;
  for (const TextField& field : fields) {
    if (field.name != name) continue;
    if (value && !is_list) throw Error(StrCat(field.place, path, name, " is given twice"));
    if (value) {
      value->text += " " + field.value;
    } else {
      value = {.field = &field, .text = field.value};
    }
  }
  return value;
}

}  // namespace powderkeg
