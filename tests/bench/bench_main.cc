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
#include "common/base/run_main.h"
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

// Runs what the filter asks for: the suites whose name contains it, or else the figures whose full
// name does (which means running every suite).
std::vector<BenchFigure> RunSuites(const std::string& filter) {
  const std::vector<Suite> suites = Suites();
  const bool names_suite = std::ranges::any_of(
      suites, [&filter](const Suite& suite) { return Contains(suite.name, filter); });
  std::vector<BenchFigure> figures;
  for (const Suite& suite : suites) {
    if (names_suite && !Contains(suite.name, filter)) continue;
    for (BenchFigure& figure : suite.run()) {
      figure.name = FullName(suite, figure.name);
      if (names_suite || Contains(figure.name, filter)) figures.push_back(std::move(figure));
    }
  }
  return figures;
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

void Run(const std::string& filter, bool json) {
  const std::vector<BenchFigure> figures = RunSuites(filter);
  if (figures.empty()) throw Error(StrCat("no figure's name contains \"", filter, "\""));
  json ? PrintJson(figures) : PrintTable(figures);
}

}  // namespace
}  // namespace powderkeg

int main(int argc, char** argv) {
  CLI::App app("Measures the speed of rules, policies, search and networks.", "bench");
  std::string filter;
  bool json = false;
  app.add_option("--filter", filter, "only suites, or else figures, whose name contains this");
  app.add_flag("--json", json, R"(print {"NAME": {"value": ..., "unit": ...}, ...})");
  app.footer(powderkeg::Footer());
  CLI11_PARSE(app, argc, argv);
  return powderkeg::RunMain("bench", [&] { powderkeg::Run(filter, json); });
}
