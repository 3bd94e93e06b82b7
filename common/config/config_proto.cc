#include "common/config/config_proto.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/text_format.h>

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

#include "common/base/check.h"

namespace powderkeg {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

// Bounds of a number; `above` excludes the lower one.
struct Range {
  double low;
  double high;
  bool above = false;
};

// Otherwise protobuf writes faults to standard error.
class Silent : public google::protobuf::io::ErrorCollector {
 public:
  void AddError(int, google::protobuf::io::ColumnNumber, const std::string&) override {}
};

const FieldDescriptor& FieldOf(const Message& message, const char* name) {
  const FieldDescriptor* field = message.GetDescriptor()->FindFieldByName(name);
  CHECK(field != nullptr, "proto/config.proto has no field ", name);
  return *field;
}

// Fields of a message into a struct. Keeps the first fault.
class Reader {
 public:
  Reader(const Message& message, std::string path) : message_(message), path_(std::move(path)) {}

  template <typename Value>
  void Number(const char* name, Value& value, Range range) {
    if (!Has(name)) return;
    const auto found = Get<Value>(FieldOf(message_, name));
    const auto number = static_cast<double>(found);
    const bool inside =
        number >= range.low && number <= range.high && !(range.above && number == range.low);
    if (!inside) {
      Fault(name, found,
            StrCat("a number ", range.above ? "above " : "from ", range.low, " to ", range.high));
      return;
    }
    value = found;
  }
  template <typename Value>
  void Number(const char* name, std::optional<Value>& value, Range range) {
    if (!Has(name)) return;
    Number(name, value.emplace(), range);
  }
  // Any value.
  template <typename Value>
  void Any(const char* name, Value& value) {
    if (Has(name)) value = Get<Value>(FieldOf(message_, name));
  }
  void Choice(const char* name, std::string& value, std::initializer_list<const char*> choices) {
    if (!Has(name)) return;
    std::string found = Get<std::string>(FieldOf(message_, name));
    if (std::find(choices.begin(), choices.end(), found) != choices.end()) {
      value = std::move(found);
      return;
    }
    std::string expected = "one of";
    for (const char* choice : choices) expected.append(" ").append(choice);
    Fault(name, found, expected);
  }
  void List(const char* name, std::span<std::string> values) {
    const FieldDescriptor& field = FieldOf(message_, name);
    const auto& reflection = *message_.GetReflection();
    const int size = reflection.FieldSize(message_, &field);
    if (size == 0) return;
    if (size != static_cast<int>(values.size())) {
      Fault(name, StrCat(size, " values"), StrCat("none or ", values.size()));
      return;
    }
    for (int i = 0; i < size; ++i) {
      values[static_cast<std::size_t>(i)] = reflection.GetRepeatedString(message_, &field, i);
    }
  }
  // What is set of a message of options, as names and texts.
  void AllSet(const char* name, Options& options) {
    const auto& reflection = *message_.GetReflection();
    const FieldDescriptor& field = FieldOf(message_, name);
    if (!reflection.HasField(message_, &field)) return;
    const Message& inner = reflection.GetMessage(message_, &field);
    std::vector<const FieldDescriptor*> fields;
    inner.GetReflection()->ListFields(inner, &fields);
    for (const FieldDescriptor* option : fields) SetOption(options, option->name(), inner, *option);
  }

  [[nodiscard]] const std::optional<std::string>& fault() const { return fault_; }

 private:
  [[nodiscard]] bool Has(const char* name) const {
    return message_.GetReflection()->HasField(message_, &FieldOf(message_, name));
  }
  template <typename Value>
  [[nodiscard]] Value Get(const FieldDescriptor& field) const {
    const auto& reflection = *message_.GetReflection();
    if constexpr (std::is_same_v<Value, std::string>) {
      return reflection.GetString(message_, &field);
    } else if constexpr (std::is_same_v<Value, bool>) {
      return reflection.GetBool(message_, &field);
    } else if constexpr (std::is_same_v<Value, double>) {
      return reflection.GetDouble(message_, &field);
    } else if constexpr (std::is_same_v<Value, std::uint64_t>) {
      return reflection.GetUInt64(message_, &field);
    } else {
      static_assert(std::is_same_v<Value, int>);
      return reflection.GetInt32(message_, &field);
    }
  }
  static void SetOption(Options& options, const std::string& name, const Message& message,
                        const FieldDescriptor& field) {
    std::string text;
    if (field.cpp_type() == FieldDescriptor::CPPTYPE_STRING) {
      text = message.GetReflection()->GetString(message, &field);
    } else {
      google::protobuf::TextFormat::PrintFieldValueToString(message, &field, -1, &text);
    }
    const auto known = std::find_if(options.begin(), options.end(),
                                    [&](const auto& option) { return option.first == name; });
    if (known != options.end()) {
      known->second = std::move(text);
    } else {
      options.emplace_back(name, std::move(text));
    }
  }
  template <typename Value>
  void Fault(const char* name, const Value& value, const std::string& expected) {
    if (!fault_) fault_ = StrCat(path_, name, " is ", value, "; expected ", expected);
  }

  const Message& message_;
  std::string path_;
  std::optional<std::string> fault_;
};

// Fields of a struct into a message, all of them.
class Writer {
 public:
  explicit Writer(Message& message) : message_(message) {}

  template <typename Value>
  void Number(const char* name, const Value& value, Range /*range*/) {
    Any(name, value);
  }
  template <typename Value>
  void Number(const char* name, const std::optional<Value>& value, Range /*range*/) {
    if (value) Any(name, *value);
  }
  void Choice(const char* name, const std::string& value, std::initializer_list<const char*>) {
    Any(name, value);
  }
  template <typename Value>
  void Any(const char* name, const Value& value) {
    const FieldDescriptor* field = &FieldOf(message_, name);
    const auto& reflection = *message_.GetReflection();
    if constexpr (std::is_same_v<Value, std::string>) {
      reflection.SetString(&message_, field, value);
    } else if constexpr (std::is_same_v<Value, bool>) {
      reflection.SetBool(&message_, field, value);
    } else if constexpr (std::is_same_v<Value, double>) {
      reflection.SetDouble(&message_, field, value);
    } else if constexpr (std::is_same_v<Value, std::uint64_t>) {
      reflection.SetUInt64(&message_, field, value);
    } else {
      static_assert(std::is_same_v<Value, int>);
      reflection.SetInt32(&message_, field, value);
    }
  }
  void List(const char* name, std::span<const std::string> values) {
    const FieldDescriptor* field = &FieldOf(message_, name);
    for (const std::string& value : values) {
      message_.GetReflection()->AddString(&message_, field, value);
    }
  }
  void AllSet(const char* name, const Options& options) {
    Message* inner = message_.GetReflection()->MutableMessage(&message_, &FieldOf(message_, name));
    for (const auto& [option, text] : options) SetOption(*inner, option, text);
  }

 private:
  static void SetOption(Message& message, const std::string& name, const std::string& text) {
    const FieldDescriptor* field = message.GetDescriptor()->FindFieldByName(name);
    if (field == nullptr) throw Error(StrCat("search option \"", name, "\" is unknown"));
    if (field->cpp_type() == FieldDescriptor::CPPTYPE_STRING) {
      message.GetReflection()->SetString(&message, field, text);
      return;
    }
    Silent faults;
    google::protobuf::TextFormat::Parser parser;
    parser.RecordErrorsTo(&faults);
    if (!parser.ParseFieldValueFromString(text, field, &message)) {
      throw Error(StrCat("search option ", name, " is \"", text, "\"; expected a value of type ",
                         field->cpp_type_name()));
    }
  }

  Message& message_;
};

// The fields, once for both directions: Binder is Reader or Writer.
template <typename Binder, typename Config>
void BindSelfPlay(Binder& binder, Config& config) {
  binder.Any("environment", config.environment);
  binder.Choice("board_generator", config.board_generator, {"official", "uniform"});
  binder.Choice("corners", config.corners, {"official", "permuted"});
  binder.List("opponents", config.opponents);
  binder.Any("seed", config.seed);
  binder.Number("games_in_flight", config.games_in_flight, {1, 4096});
  binder.Any("record_after_death", config.record_after_death);
  binder.Choice("weights_swap", config.weights_swap, {"at_game_start", "at_once"});
  binder.Choice("evaluator", config.evaluator, {"auto", "uniform", "torch", "onednn"});
  binder.Choice("precision", config.precision, {"auto", "fp32", "bf16", "fp16", "int8"});
  binder.AllSet("search", config.search);
}

template <typename Binder, typename Config>
void BindTraining(Binder& binder, Config& config) {
  binder.Choice("network", config.network, {"small", "paper"});
  binder.Number("iterations", config.iterations, {1, 1e6});
  binder.Number("decisions_per_iteration", config.decisions_per_iteration, {1, 1e9});
  binder.Number("window_datasets", config.window_datasets, {1, 1000});
  binder.Number("epochs", config.epochs, {0, 1000, /*above=*/true});
  binder.Number("batch_size", config.batch_size, {1, 1 << 20});
  binder.Number("learning_rate", config.learning_rate, {0, 10, /*above=*/true});
  binder.Number("final_learning_rate", config.final_learning_rate, {0, 10});
  binder.Number("weight_decay", config.weight_decay, {0, 1});
  binder.Number("value_weight", config.value_weight, {0, 1});
  binder.Number("target_argmax_weight", config.target_argmax_weight, {0, 1});
  binder.Number("draw_value", config.draw_value, {-1, 1});
  binder.Number("late_win_value", config.late_win_value, {-1, 1});
  binder.Number("target_search_value_weight", config.target_search_value_weight, {0, 1});
  binder.Number("threads", config.threads, {1, 1024});
  binder.Choice("device", config.device, {"auto", "cpu", "cuda"});
  binder.Number("checkpoints_kept", config.checkpoints_kept, {1, 1000});
}

}  // namespace

void ToProto(const SelfPlayConfig& config, proto::SelfPlay& message) {
  message.Clear();
  Writer writer(message);
  BindSelfPlay(writer, config);
}

void ToProto(const RunConfig& config, proto::Config& message) {
  message.Clear();
  ToProto(config.self_play, *message.mutable_self_play());
  Writer writer(*message.mutable_training());
  BindTraining(writer, config.training);
}

std::optional<std::string> FromProto(const proto::SelfPlay& message, SelfPlayConfig& config) {
  Reader reader(message, "self_play.");
  BindSelfPlay(reader, config);
  return reader.fault();
}

std::optional<std::string> FromProto(const proto::Config& message, RunConfig& config) {
  if (auto fault = FromProto(message.self_play(), config.self_play)) return fault;
  Reader reader(message.training(), "training.");
  BindTraining(reader, config.training);
  return reader.fault();
}

}  // namespace powderkeg
