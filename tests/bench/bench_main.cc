// bench: the speed of this build on this machine, as figures with names that stay.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "actors/search/tree.h"
#include "common/base/check.h"
#include "common/base/nearest_name.h"
#include "common/base/run_main.h"
#include "common/config/options.h"
#include "common/pommerman/state.h"
#include "tests/bench/bench_policies.h"
#include "tests/bench/bench_search.h"
#include "tests/bench/bench_step.h"
#include "tests/bench/bench_wire.h"
#include "tests/bench/figure.h"
#ifdef POWDERKEG_HAS_ONEDNN
#include "tests/bench/bench_clock.h"
#include "tests/bench/bench_model.h"
#include "tests/bench/bench_selfplay.h"
#endif
#ifdef POWDERKEG_HAS_TORCH
#include "tests/bench/bench_cuda.h"
#endif

namespace powderkeg {
namespace {

struct Suite {
  std::string name;
  std::string help;
  std::function<std::vector<BenchFigure>()> run;
};

std::vector<BenchFigure> BenchSizes() {
  return {{"state", sizeof(State), "bytes"}, {"tree_node", sizeof(Node), "bytes"}};
}

std::vector<Suite> Suites() {
  return {
      {"size", "bytes of a position and of a tree node", BenchSizes},
      {"step", "rules, observations, legal actions, start positions", BenchStep},
      {"policies", "rule-based games, decisions and verification", BenchPolicies},
      {"wire", "size of games as sent, the learner's intake (with HDF5 on disk)", BenchWire},
      {"search", "simulations of both trees, their parts, the signature of the search",
       BenchSearch},
#ifdef POWDERKEG_HAS_ONEDNN
      {"model", "planes and network evaluations", BenchModel},
      {"selfplay", "a game loop of an actor: simulations, evaluations, where the time goes",
       BenchSelfPlay},
      {"clock", "one search under a clock, on one core and on two", BenchClock},
#endif
#ifdef POWDERKEG_HAS_TORCH
      {"cuda", "network evaluations on a CUDA device, by wall time", BenchCuda},
#endif
  };
}

// "<suite>.<name>"; some providers give their figures such names themselves.
std::string FullName(const Suite& suite, const std::string& name) {
  const std::string prefix = suite.name + ".";
  return name.starts_with(prefix) ? name : prefix + name;
}

bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

// Runs what the filter asks for: suites whose name contains it, or "SUITE.PART", figures. Throws
// Error where nothing fits.
std::vector<BenchFigure> RunSuites(const std::string& filter) {
  const bool names_figures = Contains(filter, ".");
  std::vector<Suite> suites = Suites();
  std::vector<std::string> names;
  for (const Suite& suite : suites) names.push_back(suite.name);
  const std::vector<std::string_view> known(names.begin(), names.end());
  std::erase_if(suites, [&](const Suite& suite) {
    return names_figures ? !filter.starts_with(suite.name + ".") : !Contains(suite.name, filter);
  });
  std::vector<BenchFigure> figures;
  for (const Suite& suite : suites) {
    for (BenchFigure& figure : suite.run()) {
      figure.name = FullName(suite, figure.name);
      if (!names_figures || Contains(figure.name, filter)) figures.push_back(std::move(figure));
    }
  }
  if (!figures.empty()) return figures;
  throw Error(StrCat("--filter ", filter, ": no such ", suites.empty() ? "suite" : "figure",
                     "; suites: ", Joined(known, ", "), DidYouMean(filter, known)));
}

void PrintTable(const std::vector<BenchFigure>& figures) {
  for (const BenchFigure& figure : figures) {
    std::printf("%-44s %16.1f %s\n", figure.name.c_str(), figure.value, figure.unit.c_str());
  }
}

void PrintJson(const std::vector<BenchFigure>& figures) {
  std::printf("{");
  for (std::size_t i = 0; i < figures.size(); ++i) {
    std::printf("%s\n  \"%s\": {\"value\": %.6g, \"unit\": \"%s\"}", i == 0 ? "" : ",",
                figures[i].name.c_str(), figures[i].value, figures[i].unit.c_str());
  }
  std::printf("\n}\n");
}

std::string Footer() {
  std::string text = "Suites (a figure is named SUITE.NAME):\n";
  for (const Suite& suite : Suites()) text += "  " + suite.name + ": " + suite.help + "\n";
  return text;
}

int Run(const std::string& filter, bool json) {
  const std::vector<BenchFigure> figures = RunSuites(filter);
  json ? PrintJson(figures) : PrintTable(figures);
  return kDone;
}

}  // namespace
}  // namespace powderkeg

int main(int argc, char** argv) {
  CLI::App app("Measures the speed of rules, policies, search and networks.", "bench");
  std::string filter;
  bool json = false;
  app.add_option("--filter", filter,
                 "only suites whose name contains this, or figures: SUITE.PART");
  app.add_flag("--json", json, R"(print {"NAME": {"value": ..., "unit": ...}, ...})");
  app.footer(powderkeg::Footer());
  return powderkeg::RunMain(app, argc, argv, [&] { return powderkeg::Run(filter, json); });
}
