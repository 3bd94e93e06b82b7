// crowd: thousands of simulated actors at a real learner, and what they see of it.

#include <arpa/inet.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <string>
#include <vector>

#include "common/base/check.h"
#include "common/base/descriptors.h"
#include "common/base/number.h"
#include "common/base/run_main.h"
#include "tests/scale/crowd.h"

namespace powderkeg {
namespace {

sockaddr_in AddressOf(const std::string& learner) {
  const std::size_t colon = learner.rfind(':');
  const auto port = ParseNumber<std::uint16_t>(learner.substr(colon + 1));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  const std::string host = learner.starts_with("tcp://") ? learner.substr(6, colon - 6) : "";
  if (!port || inet_pton(AF_INET, host.c_str(), &address.sin_addr) != 1) {
    throw Error(StrCat("--learner ", learner, ": expected tcp://IPV4:PORT"));
  }
  address.sin_port = htons(*port);
  return address;
}

// 0 of none.
float Quantile(std::vector<float>& sorted, double share) {
  if (sorted.empty()) return 0;
  const auto last = static_cast<double>(sorted.size() - 1);
  return sorted[static_cast<std::size_t>(last * share)];
}

void Show(double seconds, const CrowdCounts& counts, CrowdTimes times) {
  std::ranges::sort(times.ack);
  std::printf("%6.0f s: %zu sessions, %llu games, %.0f in this span, ack p50 %.2f s, p99 %.2f s",
              seconds, counts.sessions, static_cast<unsigned long long>(counts.games),
              static_cast<double>(times.ack.size()), static_cast<double>(Quantile(times.ack, 0.5)),
              static_cast<double>(Quantile(times.ack, 0.99)));
  for (const auto& [version, weights] : times.weights) {
    std::printf("; weights %u with %zu after %.2f s", version, weights.actors, weights.last_s);
  }
  std::printf("; rejected %llu, refused %llu, hung up %llu%s%s\n",
              static_cast<unsigned long long>(counts.rejected),
              static_cast<unsigned long long>(counts.refused),
              static_cast<unsigned long long>(counts.hung_up),
              counts.last_refusal.empty() ? "" : ": ", counts.last_refusal.c_str());
  std::fflush(stdout);
}

int Simulate(CrowdSettings settings, const std::string& learner, int time_s, int span_s) {
  AllowManyDescriptors();
  settings.learner = AddressOf(learner);
  Crowd crowd(settings);
  int looks = 0;
  crowd.Run(std::chrono::seconds(time_s), [&](double seconds) {
    if (++looks % span_s == 0) Show(seconds, crowd.counts(), crowd.TakeTimes());
  });
  return kDone;
}

}  // namespace
}  // namespace powderkeg

int main(int argc, char** argv) {
  powderkeg::CrowdSettings settings;
  std::string learner;
  int time_s = 60;
  int span_s = 10;
  CLI::App app(
      "Simulated actors at a real learner (tcp, without keys, at least 220 simulations a decision "
      "in "
      "its settings): real sessions and true games, but seats that would search move at random. "
      "Prints each few seconds what the learner acknowledged and how fast.",
      "crowd");
  app.add_option("--learner", learner, "tcp://IPV4:PORT")->required();
  app.add_option("--actors", settings.actors, "sessions at once");
  app.add_option("--loops", settings.loops, "game loops that each says it has");
  app.add_option("--connects-per-s", settings.connects_per_s, "at most");
  app.add_option("--life", settings.life_s,
                 "mean seconds until an actor goes and another comes; 0: none goes");
  app.add_option("--games-per-s", settings.games_per_s,
                 "of all, at most; 0: as fast as they are played");
  app.add_option("--players", settings.players, "threads that play");
  app.add_option("--seconds", time_s, "until the end");
  app.add_option("--span", span_s, "seconds between two lines");
  return powderkeg::RunMain(app, argc, argv,
                            [&] { return powderkeg::Simulate(settings, learner, time_s, span_s); });
}
