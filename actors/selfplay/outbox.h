#pragma once

// Finished games that the learner has not acknowledged, kept on disk: they survive the actor.

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <vector>

#include "common/base/worker.h"
#include "common/wire/messages.h"

namespace powderkeg {

// A spool: one append-only file of checksummed entries, locked by its owner, emptied when
// everything in it is acknowledged and rewritten when most of it is. Acknowledgements are not
// written, so a game may be sent again after a crash, which the learner recognises by its ticket.
// What of the file is damaged, or was cut off by a crash, is dropped when it is read back; the
// entries around it stay.
//
// What is promised when: once Add has returned, the game survives this process, whatever ends it.
// Within kSyncInterval (a thread of its own syncs the file, nobody waits for it) it survives the
// machine, too. Once it is acknowledged, it is on the learner's disk.
//
// Thread-safe; but Remove and ServeRun are one thread's.
//
// The file: "PKSPOOL1", then per game, little-endian: u32 size of the payload, u32 its CRC-32C, the
// payload: u64 ticket, u32 checksum of the record, 32 bytes settings digest, the record.
class Outbox {
 public:
  static constexpr std::chrono::milliseconds kSyncInterval{500};

  // Opens or makes `folder`/outbox.spool and reads the games in it. `limit_bytes` is what full()
  // goes by. Throws Error if the file cannot be written, is no spool, or another actor uses it.
  Outbox(const std::filesystem::path& folder, std::size_t limit_bytes);
  ~Outbox();
  Outbox(const Outbox&) = delete;
  Outbox& operator=(const Outbox&) = delete;

  // The learner's run is this one. Games of another run, whose tickets mean other games, must not
  // be sent to it: if there are some they are set aside as outbox-RUN.spool in the folder, and the
  // outbox is empty. Says whose tickets were set aside. Throws Error.
  std::vector<std::uint64_t> ServeRun(const std::string& run_id);

  // A ticket that is in it already is dropped. Throws Error if the disk is full, or has failed
  // since; the file is then as before.
  void Add(SealedGame game);

  // Removes a game; one that is not in it is passed over. Throws Error if the file cannot be
  // rewritten.
  void Remove(std::uint64_t ticket);

  // Games in order of Add, from the one after `cursor` (0: from the first), as many as fit into
  // `max_bytes` of records but at least one if there is one; moves the cursor behind them.
  [[nodiscard]] std::vector<SealedGame> Batch(std::uint64_t& cursor, std::size_t max_bytes) const;

  // Of all games in it, ascending.
  [[nodiscard]] std::vector<std::uint64_t> Tickets() const;
  [[nodiscard]] std::size_t size() const;
  // Of the records in it.
  [[nodiscard]] std::size_t bytes() const;
  // Whether no new games should be started until some were acknowledged.
  [[nodiscard]] bool full() const { return bytes() >= limit_bytes_; }
  // Returns when it is not full or time is up.
  void WaitForRoom(std::chrono::milliseconds timeout) const;

 private:
  void Load();
  void Append(const std::string& entry);
  void Rewrite();
  std::vector<std::uint64_t> SetAside();
  void RunSync(const std::stop_token& stop);

  const std::filesystem::path path_;
  const std::filesystem::path run_path_;  // a file that holds run_id_
  const std::size_t limit_bytes_;
  std::string run_id_;        // of the games; empty: nobody has said
  mutable std::mutex mutex_;  // guards what follows
  mutable std::condition_variable removed_;
  int file_ = -1;
  std::size_t file_bytes_ = 0;
  std::map<std::uint64_t, SealedGame> games_;       // by number of Add, from 1
  std::map<std::uint64_t, std::uint64_t> numbers_;  // by ticket
  std::uint64_t last_number_ = 0;
  std::size_t record_bytes_ = 0;
  bool unsynced_ = false;  // something was added
  bool sync_failed_ = false;
  std::condition_variable_any stopped_;
  std::unique_ptr<Worker> syncer_;
};

}  // namespace powderkeg
