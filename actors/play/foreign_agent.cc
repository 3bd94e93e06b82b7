#include "actors/play/foreign_agent.h"

namespace powderkeg {

ForeignAgent::~ForeignAgent() {
  if (met_) client_.Shutdown();
}

void ForeignAgent::StartGame(const GameSettings& settings, AgentId self, Rng /*rng*/) {
  if (!met_) client_.Ping();
  met_ = true;
  settings_ = settings;
  client_.Initialise(self, settings.mode);
}

void ForeignAgent::Begin(const Observation& observation) {
  move_ = client_.Act(settings_, observation);
}

}  // namespace powderkeg
