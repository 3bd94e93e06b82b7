#include "actors/http/agent_routes.h"

#include <utility>

namespace powderkeg {
namespace {

HttpReply AsReply(ServiceReply&& reply) {
  return {.status = reply.status, .body = std::move(reply.body)};
}

}  // namespace

std::vector<HttpRoute> AgentRoutes(AgentService& service) {
  return {
      {"GET", "/ping", [&](const HttpRequest&) { return AsReply(service.Ping()); }},
      {"POST", "/init_agent",
       [&](const HttpRequest& request) { return AsReply(service.InitAgent(request.body)); }},
      {"POST", "/action",
       [&](const HttpRequest& request) {
         return AsReply(service.Act(request.body, request.arrival));
       }},
      {"POST", "/episode_end",
       [&](const HttpRequest& request) { return AsReply(service.EndEpisode(request.body)); }},
      {"POST", "/shutdown", [&](const HttpRequest&) { return AsReply(service.Shutdown()); }},
  };
}

}  // namespace powderkeg
