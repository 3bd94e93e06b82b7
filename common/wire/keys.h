#pragma once

// Who may talk to whom: CURVE key pairs as files of one line, 40 characters of Z85.
//
//   KEYS/learner.secret        the learner's; nobody else needs it
//   KEYS/learner.public        every actor needs it
//   KEYS/actors/NAME.secret    the actor's own
//   KEYS/actors/NAME.public    the learner lets in whom it has this file of

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace powderkeg {

struct CurveKeyPair {
  std::string public_key;
  std::string secret_key;
};

// What an actor needs to connect.
struct ClientKeys {
  std::string learner_public;
  CurveKeyPair own;
};

[[nodiscard]] CurveKeyPair MakeKeyPair();

// Writes the pair as FILE.public and FILE.secret (readable by the owner alone) and makes the
// folder. Throws Error if one of them exists already or cannot be written.
void WriteKeyPair(const CurveKeyPair& pair, const std::filesystem::path& file);

// Throws Error if the file is missing or no key.
[[nodiscard]] std::string ReadKey(const std::filesystem::path& file);

// The keys of actor NAME in a folder as above. Throws Error.
[[nodiscard]] ClientKeys ReadClientKeys(const std::filesystem::path& folder,
                                        const std::string& name);

// NAME of the file KEYS/actors/NAME.public that holds this key; nullopt: there is none. Looks anew
// each time: actors can be added and removed while the learner runs. What is no file or holds no
// key is passed over.
[[nodiscard]] std::optional<std::string> ActorOfKey(const std::filesystem::path& folder,
                                                    std::string_view public_key);

}  // namespace powderkeg
