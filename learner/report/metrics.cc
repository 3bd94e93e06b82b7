#include "learner/report/metrics.h"

#include <cmath>
#include <iomanip>
#include <span>
#include <sstream>
#include <string_view>
#include <vector>

#include "common/base/check.h"
#include "learner/report/figures.h"

namespace powderkeg {
namespace {

constexpr const char* kCounter = "counter";
constexpr const char* kGauge = "gauge";

std::string Escaped(std::string_view label) {
  std::string text;
  for (const char c : label) {
    if (c == '\\' || c == '"') text += '\\';
    if (c == '\n') {
      text += "\\n";
    } else {
      text += c;
    }
  }
  return text;
}

// The text as it grows: families, each with its samples.
class Exposition {
 public:
  void Family(std::string_view name, std::string_view type, std::string_view help) {
    name_ = name;
    text_ << "# HELP powderkeg_" << name << ' ' << help << '\n'
          << "# TYPE powderkeg_" << name << ' ' << type << '\n';
  }
  void Sample(double value) {
    text_ << "powderkeg_" << name_;
    WriteValue(value);
  }
  void Sample(std::string_view label, std::string_view label_value, double value) {
    text_ << "powderkeg_" << name_ << '{' << label << "=\"" << Escaped(label_value) << "\"}";
    WriteValue(value);
  }
  void Single(std::string_view name, std::string_view type, std::string_view help, double value) {
    Family(name, type, help);
    Sample(value);
  }

  [[nodiscard]] std::string text() const { return text_.str(); }

 private:
  void WriteValue(double value) {
    text_ << ' ';
    if (std::isnan(value)) {
      text_ << "NaN";
    } else if (std::isinf(value)) {
      text_ << (value > 0 ? "+Inf" : "-Inf");
    } else {
      text_ << std::setprecision(15) << value;
    }
    text_ << '\n';
  }

  std::ostringstream text_;
  std::string name_;  // of the family
};

void AddRun(const RunView& view, Exposition& out) {
  out.Family("run_info", kGauge, "Always 1; the label is the name of the run.");
  out.Sample("run", view.run, 1);
  out.Single("start_time_seconds", kGauge, "When the learner started, in seconds since 1970.",
             static_cast<double>(view.started_unix_s));
}

template <typename Source>
void AddFamily(std::string_view prefix, const LiveFigure<Source>& figure, Exposition& out) {
  const bool counter = figure.kind == FigureKind::kCounter;
  out.Family(StrCat(prefix, figure.name, counter ? "_total" : ""), counter ? kCounter : kGauge,
             figure.help);
}

template <typename Source>
void AddFigures(std::string_view prefix, std::span<const LiveFigure<Source>> figures,
                const Source& source, Exposition& out) {
  for (const auto& figure : figures) {
    AddFamily(prefix, figure, out);
    out.Sample(figure.value(source));
  }
}

void AddActors(const std::vector<ActorStatistics>& actors, Exposition& out) {
  if (actors.empty()) return;
  for (const auto& figure : ActorFigures()) {
    AddFamily("actor_", figure, out);
    for (const ActorStatistics& actor : actors) {
      out.Sample("actor", actor.name, figure.value(actor));
    }
  }
}

void AddIteration(const std::vector<double>& values, Exposition& out) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Figure& figure = IterationFigures()[i];
    if (!std::isfinite(values[i])) continue;
    out.Single(StrCat(i == 0 ? "" : "iteration_", figure.name), kGauge, figure.help, values[i]);
  }
}

}  // namespace

std::string MetricsText(const RunView& view) {
  Exposition out;
  AddRun(view, out);
  AddFigures("run_", RunFigures(), view.status, out);
  AddFigures("", IntakeFigures(), view.intake, out);
  AddActors(view.intake.actors, out);
  if (view.last_iteration) AddIteration(*view.last_iteration, out);
  return out.text();
}

}  // namespace powderkeg
