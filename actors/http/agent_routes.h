#pragma once

// An agent service behind HTTP.

#include <vector>

#include "actors/http/agent_service.h"
#include "common/http/http_server.h"

namespace powderkeg {

// GET /ping, POST /init_agent, /action, /episode_end and /shutdown. The service must outlive them.
[[nodiscard]] std::vector<HttpRoute> AgentRoutes(AgentService& service);

}  // namespace powderkeg
