#include "common/config/options.h"

#include "common/base/nearest_name.h"

namespace powderkeg {
namespace {

constexpr std::array<std::string_view, 2> kFlagNames = {"false", "true"};

[[noreturn]] void RefuseName(const TextField& field, std::string_view path, Names known) {
  constexpr std::size_t kShown = 64;
  const std::string_view nearest = NearestName(field.name, known);
  throw Error(StrCat(field.place, "there is no setting ", path,
                     Quoted(std::string_view(field.name).substr(0, kShown)),
                     nearest.empty() ? "" : StrCat("; did you mean ", path, nearest, "?"),
                     nearest.empty() ? "; " : " ", "--help-options lists all"));
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

Names NamesOf(bool) { return kFlagNames; }

bool ReadValue(std::string_view text, const Allowed& allowed, std::string& value) {
  const Names& names = allowed.names;
  if (!names.empty() && std::ranges::find(names, text) == names.end()) return false;
  value = text;
  return true;
}
bool ReadValue(std::string_view text, const Allowed& /*allowed*/, Words& value) {
  value.clear();
  while (!text.empty()) {
    const std::string_view word = text.substr(0, text.find_first_of(" ,"));
    if (!word.empty()) value.emplace_back(word);
    text.remove_prefix(std::min(text.size(), word.size() + 1));
  }
  return true;
}

std::string WriteValue(const std::string& value, const Allowed& /*allowed*/) { return value; }
std::string WriteValue(const std::vector<std::string>& value, const Allowed& /*allowed*/) {
  const std::vector<std::string_view> words(value.begin(), value.end());
  return Joined(words, " ");
}

std::string Expected(const Allowed& allowed, const std::string* /*type*/) {
  return allowed.names.empty() ? "a text" : "one of " + Joined(allowed.names, ", ");
}
std::string Expected(const Allowed& /*allowed*/, const Words* /*type*/) {
  return "words separated by spaces or commas";
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
