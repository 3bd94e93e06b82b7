#include "common/model/model_name.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>
#include <system_error>
#include <vector>

#include "common/base/check.h"
#include "common/base/durable_file.h"
#include "common/base/nearest_name.h"
#include "common/base/number.h"

namespace powderkeg {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kUntrained = "untrained:";
constexpr std::string_view kLatest = "latest";
constexpr std::string_view kLatestOf = "latest:";
constexpr std::string_view kEnding = ".weights";

// The folder with models/ and runs/.
fs::path Home() {
  if (const char* home = std::getenv("POWDERKEG_HOME"); home != nullptr) return home;
  std::error_code error;  // where it is not known, the working directory's
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  for (fs::path folder = program.parent_path(); folder.has_relative_path();
       folder = folder.parent_path()) {
    if (fs::is_directory(folder / "models", error)) return folder;
  }
  return ".";
}

// By name; none where there is no such folder.
std::vector<fs::path> WeightsIn(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) return {};
  std::vector<fs::path> files = FilesIn(folder);
  std::erase_if(files, [](const fs::path& file) { return file.extension() != kEnding; });
  return files;
}

// The newest weights of a run, if it has some: their names are numbered.
std::optional<fs::path> NewestOf(const fs::path& run) {
  const std::vector<fs::path> files = WeightsIn(run / "weights");
  if (files.empty()) return std::nullopt;
  return files.back();
}

// Those of the runs with weights; that which wrote last comes last.
std::vector<fs::path> NewestOfRuns(const fs::path& runs) {
  std::error_code error;
  std::vector<fs::path> newest;
  if (!fs::is_directory(runs, error)) return newest;
  for (const fs::path& run : FilesIn(runs)) {
    if (const std::optional<fs::path> file = NewestOf(run)) newest.push_back(*file);
  }
  std::ranges::stable_sort(newest, {},
                           [&](const fs::path& file) { return fs::last_write_time(file, error); });
  return newest;
}

std::string LatestOf(std::string_view run) {
  const fs::path runs = Home() / "runs";
  const std::vector<fs::path> newest = NewestOfRuns(runs);
  std::string there;
  for (const fs::path& file : newest) {
    const std::string name = file.parent_path().parent_path().filename();
    if (name == run) return file;
    there += (there.empty() ? "" : ", ") + name;
  }
  if (run.empty() && !newest.empty()) return newest.back();
  throw Error(StrCat("model ", kLatest, run.empty() ? "" : ":", run, ": no such weights in ",
                     runs.string(), "; runs with weights: ", there.empty() ? "none" : there));
}

std::string ShortlyNamed(const std::string& name) {
  const fs::path models = Home() / "models";
  std::vector<std::string> stems;
  for (const fs::path& file : WeightsIn(models)) {
    if (file.stem() == name) return file;
    stems.push_back(file.stem());
  }
  const std::vector<std::string_view> known(stems.begin(), stems.end());
  std::string there;
  for (const std::string_view stem : known) there += StrCat(stem, ", ");
  throw Error(StrCat("there is no model \"", name, "\"; in ", models.string(), ": ",
                     there.empty() ? "none, " : there,
                     "and always latest, latest:RUN, "
                     "untrained:NETWORK[:SEED], or a file with a '/' or '.' in its name",
                     DidYouMean(name, known)));
}

// `text` is NETWORK[:SEED].
Snapshot Untrained(std::string_view text) {
  const std::string_view network = text.substr(0, text.find(':'));
  std::optional<std::uint64_t> seed = 1;
  if (network.size() < text.size()) {
    const std::string_view digits = text.substr(network.size() + 1);
    seed = ParseNumber<std::uint64_t>(digits);
    if (!seed) {
      throw Error(StrCat("model ", kUntrained, text, ": the seed is \"", digits,
                         "\"; expected a whole number from 0"));
    }
  }
  return std::make_shared<const WeightsSnapshot>(
      InitialWeights(NetworkByName(network), Rng(*seed)));
}

}  // namespace

std::string ResolvedModel(const std::string& name) {
  std::error_code error;
  const bool is_path = name.find_first_of("/.") != std::string::npos;
  if (is_path && (fs::exists(name, error) || !name.starts_with(kLatestOf))) return name;
  if (name.starts_with(kUntrained)) return name;
  if (name == kLatest) return LatestOf("");
  if (name.starts_with(kLatestOf)) return LatestOf(name.substr(kLatestOf.size()));
  return ShortlyNamed(name);
}

Snapshot LoadModel(const std::string& name) {
  const std::string model = ResolvedModel(name);
  if (!model.starts_with(kUntrained)) return LoadSnapshot(model);
  return Untrained(std::string_view(model).substr(kUntrained.size()));
}

}  // namespace powderkeg
