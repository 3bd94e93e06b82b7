#include "common/pommerman/radio_code.h"

#include <algorithm>
#include <cstdlib>

namespace powderkeg {
namespace {

using Axis = RadioReport::Axis;
using Plan = RadioReport::Plan;

constexpr int kPlans = 4;
constexpr int kCodes = kBoardSize * kPlans;
constexpr int kWords = 7;

Axis AxisOf(int step) { return step % 2 == 0 ? Axis::kRow : Axis::kColumn; }

Plan PlanOf(Axis axis, Action action) {
  const bool rows = axis == Axis::kRow;
  switch (action) {
    case Action::kStop: return Plan::kStay;
    case Action::kUp: return rows ? Plan::kDecrease : Plan::kStay;
    case Action::kDown: return rows ? Plan::kIncrease : Plan::kStay;
    case Action::kLeft: return rows ? Plan::kStay : Plan::kDecrease;
    case Action::kRight: return rows ? Plan::kStay : Plan::kIncrease;
    case Action::kBomb: return Plan::kBomb;
  }
  return Plan::kStay;
}

std::size_t IndexOf(Axis axis) { return static_cast<std::size_t>(axis); }

int Expected(const RadioReport& report) {
  const int change = report.plan == Plan::kDecrease ? -1 : (report.plan == Plan::kIncrease ? 1 : 0);
  return std::clamp(report.coordinate + change, 0, kBoardSize - 1);
}

}  // namespace

Message EncodeReport(int step, Cell cell, Action action) {
  const Axis axis = AxisOf(step);
  const int coordinate = axis == Axis::kRow ? RowOf(cell) : ColumnOf(cell);
  const int code = kPlans * coordinate + static_cast<int>(PlanOf(axis, action));
  return {static_cast<std::uint8_t>(1 + code / kWords),
          static_cast<std::uint8_t>(1 + code % kWords)};
}

std::optional<RadioReport> DecodeReport(int step, const Message& message) {
  for (const int word : message) {
    if (word < 1 || word > kWords) return std::nullopt;
  }
  const int code = (message[0] - 1) * kWords + message[1] - 1;
  if (code >= kCodes) return std::nullopt;
  return RadioReport{
      .axis = AxisOf(step), .coordinate = code / kPlans, .plan = static_cast<Plan>(code % kPlans)};
}

void MateTracker::Hear(int step, const Message& message) {
  const auto report = DecodeReport(step - 1, message);
  if (!report) return;
  Take(report->axis, {.coordinate = report->coordinate, .step = step - 1});
  expected_[IndexOf(report->axis)] = Expected(*report);
}

void MateTracker::See(int step, Cell cell) {
  for (const Axis axis : {Axis::kRow, Axis::kColumn}) {
    const int coordinate = axis == Axis::kRow ? RowOf(cell) : ColumnOf(cell);
    Take(axis, {.coordinate = coordinate, .step = step});
    std::optional<int>& expected = expected_[IndexOf(axis)];
    if (expected) expected = coordinate;
  }
}

void MateTracker::Take(Axis axis, Fix fix) {
  std::optional<Fix>& last = last_[IndexOf(axis)];
  if (last && std::abs(fix.coordinate - last->coordinate) > fix.step - last->step) {
    believed_ = false;
  }
  last = fix;
}

std::optional<Cell> MateTracker::cell() const {
  const auto [row, column] = expected_;
  if (!believed_ || !row || !column) return std::nullopt;
  return CellAt(*row, *column);
}

}  // namespace powderkeg
