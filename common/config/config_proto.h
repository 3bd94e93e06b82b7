#pragma once

// Settings between plain values and messages; only for common/wire/codec.cc and this folder.

#include <optional>
#include <string>

#include "common/config/run_config.h"
#include "proto/config.pb.h"

namespace powderkeg {

// Sets every field. Throws Error if `config.search` names an option that proto/config.proto does
// not have.
void ToProto(const SelfPlayConfig& config, proto::SelfPlay& message);
void ToProto(const RunConfig& config, proto::Config& message);

// Changes what is set in the message, after checking every range. Returns what is wrong (path,
// value, what is allowed), or nullopt. Safe on messages from peers.
[[nodiscard]] std::optional<std::string> FromProto(const proto::SelfPlay& message,
                                                   SelfPlayConfig& config);
[[nodiscard]] std::optional<std::string> FromProto(const proto::Config& message, RunConfig& config);

}  // namespace powderkeg
