#pragma once

// Every figure of a run, each once. The file iterations.csv, the table on the terminal, the log,
// /metrics, /status.json, the page and the plot all show what stands in these tables, so that a new
// figure is one entry here (and its value).

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "learner/intake/session_server.h"
#include "learner/report/live_status.h"
#include "learner/train/iteration_report.h"

namespace powderkeg {

inline constexpr double kAbsent = std::numeric_limits<double>::quiet_NaN();

struct Chart {
  const char* title;
  bool stacked = false;  // the figures add up
};

// Of an iteration. Texts hold neither tabs nor line ends.
struct Figure {
  const char* name;  // everywhere but for people; ends in its unit, if it has one
  double (*value)(const IterationReport&);  // kAbsent or no number: there is none
  const char* unit;                         // "", "s", or "%" of what goes from 0 to 1
  const char* format;  // of printf, for one double; in percent if that is the unit
  const char* label;   // for people; "": told with the figure before it
  const char* help;
  // On the terminal: the head of its column, nullptr if it has none. Neighbours with equal heads
  // share a column, each with its own format.
  const char* heading = nullptr;
  const Chart* chart = nullptr;
};

// In the order of the columns of iterations.csv. The first is the number of the iteration. Where
// NAME_low95 and NAME_high95 follow NAME they are its interval.
[[nodiscard]] std::span<const Figure> IterationFigures();

enum class FigureKind : std::uint8_t { kGauge, kCounter };  // counters only grow

// Of what goes on. A metric is PREFIX_name, and of a counter PREFIX_name_total.
template <typename Source>
struct LiveFigure {
  const char* name;
  FigureKind kind;
  double (*value)(const Source&);  // no number: there is none
  const char* unit;                // "", "s" or "B"
  const char* label;  // on the page; a counter of an actor is shown as rate; "": not shown
  const char* help;
  double alarm = std::numeric_limits<double>::infinity();  // above it somebody should look
};

[[nodiscard]] std::span<const LiveFigure<LiveStatus>> RunFigures();
[[nodiscard]] std::span<const LiveFigure<IntakeStatistics>> IntakeFigures();
[[nodiscard]] std::span<const LiveFigure<ActorStatistics>> ActorFigures();

// Of every figure of an iteration, in their order.
[[nodiscard]] std::vector<double> ValuesOf(const IterationReport& report);

// The tables as text: a header, then a line for each figure, cells separated by tabs.
//   of      iteration, run, intake or actor
//   name, unit, label
//   digits  shown after the point, of an iteration's
//   chart   "": none
//   style   line, area (on the areas before it), gauge or counter
//   alarm   "": none
//   help
[[nodiscard]] std::string FiguresText();

}  // namespace powderkeg
