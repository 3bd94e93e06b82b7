#pragma once

// Who may talk to whom: CURVE key pairs as files of one line, 40 characters of Z85.
//
//   KEYS/learner.secret        the learner's; nobody else needs it
//   KEYS/learner.public        every actor needs it
//   KEYS/actors/NAME.secret    the actor's own
//   KEYS/actors/NAME.public    the learner lets in whom it has this file of

#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

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

// Whose a key is. Actors can be added and removed while the learner runs: what was found is looked
// at again each time, and for a key that is not known the whole folder is read anew, which takes at
// most a tenth of the time however often it is asked. One thread.
class KeyFolder {
 public:
  // A folder as above.
  explicit KeyFolder(const std::filesystem::path& folder) : actors_(folder / "actors") {}

  // NAME of the file actors/NAME.public that holds this key; nullopt: there is none. What is no
  // file or holds no key is passed over.
  [[nodiscard]] std::optional<std::string> ActorOf(const std::string& public_key);

 private:
  void Read();
  [[nodiscard]] std::optional<std::string> Known(const std::string& public_key) const;

  const std::filesystem::path actors_;
  std::map<std::string, std::string> names_;  // by public key, when the folder was read
  std::chrono::steady_clock::time_point next_read_;
};

}  // namespace powderkeg
