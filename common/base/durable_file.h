#pragma once

// Files that appear whole or not at all, whatever dies when.

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

namespace powderkeg {

// Ending of names under which files are written before they are complete. What has it after a
// crash was never acknowledged and may be deleted.
inline constexpr std::string_view kTemporaryEnding = ".tmp";

// Writes `path` + kTemporaryEnding (two writers of one path must not meet), flushes it to the
// device, renames it to `path` and flushes the folder. When it returns the file is durable; if it
// throws Error (disk full, unwritable folder) whatever `path` held before is untouched.
void WriteFileDurably(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);

// Throws Error if there is no such file or it cannot be removed; SyncFolder makes it durable.
void RemoveFile(const std::filesystem::path& path);

// Replaces `to`, if there is such a file. SyncFolder makes it durable. Throws Error.
void RenameFile(const std::filesystem::path& from, const std::filesystem::path& to);

// Makes the removal or renaming of files in `folder` durable. On a file system that cannot do so
// it says that once in the log and trusts it. Throws Error.
void SyncFolder(const std::filesystem::path& folder);

// Creates the folder and its parents if missing. Throws Error.
void CreateFolder(const std::filesystem::path& folder);

// The same, and deletes temporaries in it. Throws Error.
void PrepareFolder(const std::filesystem::path& folder);

// Everything in `folder`, by name. Throws Error.
[[nodiscard]] std::vector<std::filesystem::path> FilesIn(const std::filesystem::path& folder);

// Throws Error if it cannot be read.
[[nodiscard]] std::vector<std::uint8_t> ReadFileBytes(const std::filesystem::path& path);

// Its last `size` bytes, or all if they are fewer. Throws Error as ReadFileBytes.
[[nodiscard]] std::vector<std::uint8_t> ReadFileEnd(const std::filesystem::path& path,
                                                    std::size_t size);

}  // namespace powderkeg
