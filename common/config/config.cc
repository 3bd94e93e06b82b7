#include "common/config/config.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/text_format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <sstream>

#include "common/base/check.h"
#include "common/config/config_proto.h"

namespace powderkeg {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::TextFormat;

// Keeps the first fault with its line and column (from 1).
class FirstFault : public google::protobuf::io::ErrorCollector {
 public:
  explicit FirstFault(std::string place) : place_(std::move(place)) {}
  void AddError(int line, google::protobuf::io::ColumnNumber column,
                const std::string& message) override {
    if (text_.empty()) text_ = StrCat(place_, ":", line + 1, ":", column + 1, ": ", message);
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string place_;
  std::string text_;
};

void Merge(const std::string& text, const std::string& place, proto::Config& message) {
  FirstFault fault(place);
  TextFormat::Parser parser;
  parser.RecordErrorsTo(&fault);
  if (!parser.ParseFromString(text, &message)) throw Error(fault.text());
}

[[noreturn]] void RefuseChange(const std::string& change, const std::string& why) {
  throw Error(StrCat("--set ", change, ": ", why));
}

void SetValue(const std::string& change, const std::string& value, const FieldDescriptor& field,
              Message& message) {
  const auto& reflection = *message.GetReflection();
  if (field.is_repeated()) {
    reflection.ClearField(&message, &field);
    std::istringstream values(value);
    for (std::string one; std::getline(values, one, ',');) {
      reflection.AddString(&message, &field, one);
    }
  } else if (field.cpp_type() == FieldDescriptor::CPPTYPE_STRING) {
    reflection.SetString(&message, &field, value);
  } else if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
    RefuseChange(change, StrCat("\"", field.name(), "\" is a section, not a setting"));
  } else {
    FirstFault fault("value");
    TextFormat::Parser parser;
    parser.RecordErrorsTo(&fault);
    if (!parser.ParseFieldValueFromString(value, &field, &message)) {
      RefuseChange(change, StrCat("\"", value, "\" is not of type ", field.cpp_type_name()));
    }
  }
}

// Applies "section.section.setting=value".
void Apply(const std::string& change, proto::Config& config) {
  const std::size_t equals = change.find('=');
  if (equals == std::string::npos) RefuseChange(change, "expected path=value");
  std::istringstream path(change.substr(0, equals));
  Message* message = &config;
  const FieldDescriptor* field = nullptr;
  for (std::string name; std::getline(path, name, '.');) {
    if (field != nullptr) {
      if (field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) {
        RefuseChange(change, StrCat("\"", field->name(), "\" has no settings in it"));
      }
      message = message->GetReflection()->MutableMessage(message, field);
    }
    field = message->GetDescriptor()->FindFieldByName(name);
    if (field == nullptr) RefuseChange(change, StrCat("there is no setting \"", name, "\""));
  }
  if (field == nullptr) RefuseChange(change, "expected path=value");
  SetValue(change, change.substr(equals + 1), *field, *message);
}

std::string Print(const Message& message) {
  std::string text;
  CHECK(TextFormat::PrintToString(message, &text));
  return text;
}

// The option of the search, a value from -1 to +1; nullopt if it is not set. Throws Error.
std::optional<double> ValueInSearch(const Options& search, const std::string& name) {
  const auto option = std::ranges::find(search, name, &Options::value_type::first);
  if (option == search.end()) return std::nullopt;
  const std::string& text = option->second;
  double value = 2;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || rest != text.data() + text.size() || !(std::abs(value) <= 1)) {
    throw Error(
        StrCat("self_play.search.", name, " is ", text, "; expected a number from -1 to 1"));
  }
  return value;
}

}  // namespace

RunConfig ParseConfig(const std::string& text, const std::string& place,
                      std::span<const std::string> changes) {
  proto::Config message;
  Merge(text, place, message);
  for (const std::string& change : changes) Apply(change, message);
  RunConfig config;
  if (const auto fault = FromProto(message, config)) throw Error(StrCat(place, ": ", *fault));
  return config;
}

RunConfig LoadConfig(const std::string& path, std::span<const std::string> changes) {
  if (path.empty()) return ParseConfig("", "settings", changes);
  std::ifstream file(path);
  std::string text(std::istreambuf_iterator<char>(file), {});
  if (!file) throw Error(StrCat("cannot read settings \"", path, "\"; expected a text file"));
  return ParseConfig(text, path, changes);
}

std::string ToText(const RunConfig& config) {
  proto::Config message;
  ToProto(config, message);
  return Print(message);
}

std::string ToText(const SelfPlayConfig& config) {
  proto::SelfPlay message;
  ToProto(config, message);
  return Print(message);
}

void TieOutcomesToSearch(RunConfig& config) {
  const auto tie = [&](const std::string& name, std::optional<double>& value) {
    if (!value) value = ValueInSearch(config.self_play.search, name);
  };
  tie("draw_value", config.training.draw_value);
  tie("late_win_value", config.training.late_win_value);
}

Sha256Digest SettingsDigest(const SelfPlayConfig& config) {
  const std::string text = ToText(config);
  return Sha256(BytesOf(text));
}

}  // namespace powderkeg
