#include "actors/http/json_reader.h"

#include <algorithm>
#include <cmath>

namespace powderkeg {
namespace {

const Json kNull;

// A value as it may stand in a one-line reason.
std::string Excerpt(const Json& value) {
  constexpr std::size_t kLongest = 40;
  if (value.is_structured()) return value.type_name();
  std::string text = value.dump(-1, ' ', /*ensure_ascii=*/true, Json::error_handler_t::replace);
  if (text.size() > kLongest) text.replace(kLongest, std::string::npos, "...");
  return text;
}

}  // namespace

Json JsonReader::Parse(std::string_view text, std::string_view name, int max_depth) {
  const auto keep = [max_depth](int depth, Json::parse_event_t, const Json&) {
    return depth <= max_depth;
  };
  Json value = Json::parse(text, keep, /*allow_exceptions=*/false);
  if (!value.is_discarded()) return value;
  Refuse(name, " is no JSON text");
  return nullptr;
}

const Json& JsonReader::Member(const Json& object, std::string_view key) {
  if (!object.is_object()) {
    Refuse("expected an object with the key ", key, ", got ", Excerpt(object));
    return kNull;
  }
  const auto found = object.find(key);
  if (found != object.end()) return *found;
  Refuse("the key ", key, " is missing");
  return kNull;
}

const Json* JsonReader::Find(const Json& object, std::string_view key) {
  if (!object.is_object()) return nullptr;
  const auto found = object.find(key);
  return found == object.end() || found->is_null() ? nullptr : &*found;
}

const Json& JsonReader::List(const Json& list, std::string_view name, std::size_t size) {
  if (!list.is_array()) {
    Refuse(name, " is ", Excerpt(list), ", expected a list");
  } else if (list.size() != size) {
    Refuse(name, " has ", list.size(), " elements, expected ", size);
  }
  return list;
}

const Json& JsonReader::Element(const Json& list, std::size_t index) {
  return list.is_array() && index < list.size() ? list[index] : kNull;
}

int JsonReader::Integer(const Json& value, std::string_view name, int minimum, int maximum) {
  const double number = value.is_number() ? value.get<double>() : minimum - 1.0;
  // The order matters: only a number in range may be converted.
  if (number >= minimum && number <= maximum && number == static_cast<int>(number)) {
    return static_cast<int>(number);
  }
  Refuse(name, " is ", Excerpt(value), ", expected a whole number ", minimum, "..", maximum);
  return minimum;
}

int JsonReader::Nearest(const Json& value, std::string_view name, int minimum, int maximum) {
  if (value.is_number()) {
    return static_cast<int>(
        std::clamp(std::round(value.get<double>()), minimum * 1.0, maximum * 1.0));
  }
  Refuse(name, " is ", Excerpt(value), ", expected a number");
  return minimum;
}

bool JsonReader::Boolean(const Json& value, std::string_view name) {
  if (value.is_boolean()) return value.get<bool>();
  if (value.is_number()) return value.get<double>() != 0;
  Refuse(name, " is ", Excerpt(value), ", expected true or false");
  return false;
}

std::string JsonReader::Text(const Json& value, std::string_view name) {
  if (value.is_string()) return value.get<std::string>();
  Refuse(name, " is ", Excerpt(value), ", expected a string");
  return {};
}

}  // namespace powderkeg
