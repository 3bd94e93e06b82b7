#include "tests/scale/crowd.h"

#include <sys/epoll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <utility>
#include <variant>

#include "common/base/check.h"
#include "common/base/unique.h"
#include "common/wire/codec.h"
#include "tests/wire/played_tickets.h"

namespace powderkeg {
namespace {

using std::chrono::milliseconds;

double Seconds(std::chrono::steady_clock::duration time) {
  return std::chrono::duration<double>(time).count();
}

// Decisions are by the version before and by this one; both are known to the learner.
std::uint32_t FirstVersionOf(std::uint32_t version) { return version == 0 ? 0 : version - 1; }

}  // namespace

Crowd::Crowd(const CrowdSettings& settings)
    : settings_(settings),
      epoll_(epoll_create1(EPOLL_CLOEXEC)),
      rng_(UniqueNumber()),
      actors_(settings.actors) {
  CHECK(epoll_ >= 0);
  for (std::size_t i = 0; i < actors_.size(); ++i) absent_.push_back(i);
}

Crowd::~Crowd() {
  wishes_.Close();
  played_.Close();
  for (const auto& player : players_) player->RequestStop();
  players_.clear();
  close(epoll_);
}

CrowdTimes Crowd::TakeTimes() { return std::exchange(times_, {}); }

void Crowd::Run(std::chrono::seconds time, const std::function<void(double)>& look) {
  Clock::time_point next_look = Clock::now() + std::chrono::seconds(1);
  for (Clock::time_point now = began_; now - began_ < time; now = Clock::now()) {
    ConnectSome(now);
    HandleEvents();
    SendPlayed(now);
    Beat(now);
    if (now < next_look) continue;
    next_look += std::chrono::seconds(1);
    look(Seconds(now - began_));
  }
}

void Crowd::ConnectSome(Clock::time_point now) {
  const double allowed = 1 + Seconds(now - began_) * settings_.connects_per_s;
  while (!absent_.empty() && static_cast<double>(connects_) < allowed) {
    Connect(absent_.front(), now);
    absent_.pop_front();
    ++connects_;
  }
}

void Crowd::Connect(std::size_t index, Clock::time_point now) {
  Actor& actor = actors_[index];
  actor = {.incarnation = UniqueNumber()};
  actor.connection = std::make_unique<ZmtpConnection>(settings_.learner);
  if (!actor.connection->open()) return Disconnect(index, /*hung_up=*/true);
  // Lives are between half and one and a half of the mean.
  actor.leaves =
      settings_.life_s == 0
          ? Clock::time_point::max()
          : now + std::chrono::duration_cast<Clock::duration>(
                      std::chrono::duration<double>(settings_.life_s * (0.5 + rng_.Uniform())));
  actor.next_heartbeat = Clock::time_point::max();
  epoll_event event{.events = EPOLLIN | EPOLLOUT, .data = {.u64 = index}};
  CHECK(epoll_ctl(epoll_, EPOLL_CTL_ADD, actor.connection->socket(), &event) == 0);
  actor.writes = true;
  actor.connection->Send(Encode(Hello{.build = "crowd",
                                      .name = StrCat("crowd-", index),
                                      .incarnation = actor.incarnation,
                                      .loops = settings_.loops}));
}

void Crowd::Disconnect(std::size_t index, bool hung_up) {
  Actor& actor = actors_[index];
  if (actor.welcomed) --counts_.sessions;
  if (hung_up) ++counts_.hung_up;
  actor = {};
  absent_.push_back(index);
}

void Crowd::HandleEvents() {
  std::array<epoll_event, 512> events;
  const int count = epoll_wait(epoll_, events.data(), static_cast<int>(events.size()), 2);
  for (int i = 0; i < count; ++i) {
    const std::size_t index = events[static_cast<std::size_t>(i)].data.u64;
    Actor& actor = actors_[index];
    if (!actor.connection) continue;
    actor.connection->Read([&](std::string_view bytes) { Take(index, bytes); });
    if (actor.refused) {
      Disconnect(index, /*hung_up=*/false);  // and says Hello on a fresh connection
    } else {
      Flush(index);
    }
  }
}

void Crowd::Flush(std::size_t index) {
  Actor& actor = actors_[index];
  ZmtpConnection& connection = *actor.connection;
  connection.Write();
  if (!connection.open()) return Disconnect(index, /*hung_up=*/true);
  if (actor.writes == connection.wants_to_write()) return;
  actor.writes = connection.wants_to_write();
  epoll_event event{.events = actor.writes ? EPOLLIN | EPOLLOUT : std::uint32_t{EPOLLIN},
                    .data = {.u64 = index}};
  epoll_ctl(epoll_, EPOLL_CTL_MOD, connection.socket(), &event);
}

void Crowd::Send(Actor& actor, const WireMessage& message) {
  actor.connection->Send(Encode(message));
}

void Crowd::SendPlayed(Clock::time_point now) {
  while (auto played = played_.Pop(milliseconds(0))) to_send_.push_back(*std::move(played));
  const double allowed =
      settings_.games_per_s == 0 ? 1e18 : Seconds(now - began_) * settings_.games_per_s;
  while (!to_send_.empty() && static_cast<double>(games_sent_) < allowed) {
    Played played = std::move(to_send_.front());
    to_send_.pop_front();
    Actor& actor = actors_[played.wish.actor];
    if (!actor.welcomed || actor.incarnation != played.wish.incarnation) continue;
    ++games_sent_;
    actor.sent[played.wish.ticket] = now;
    Games games;
    games.games.push_back(std::move(played.game));
    Send(actor, games);
    Flush(played.wish.actor);
  }
}

void Crowd::Beat(Clock::time_point now) {
  for (std::size_t i = 0; i < actors_.size(); ++i) {
    Actor& actor = actors_[i];
    if (!actor.welcomed) continue;
    if (now >= actor.leaves) {
      Send(actor, Goodbye{.reason = "it goes"});
      actor.connection->Write();
      Disconnect(i, /*hung_up=*/false);
    } else if (now >= actor.next_heartbeat) {
      actor.next_heartbeat = now + actor.heartbeat;
      Send(actor, Heartbeat{.weights_version = actor.version});
      Flush(i);
    }
  }
}

void Crowd::Take(std::size_t index, std::string_view bytes) {
  Decoded<WireMessage> decoded = Decode(bytes);
  CHECK(std::holds_alternative<WireMessage>(decoded));
  Take(index, actors_[index], std::get<WireMessage>(decoded));
}

void Crowd::Take(std::size_t index, Actor& actor, const WireMessage& message) {
  if (const auto* welcome = std::get_if<Welcome>(&message)) {
    actor.welcomed = true;
    actor.heartbeat = welcome->heartbeat;
    actor.next_heartbeat = Clock::now() + welcome->heartbeat;
    ++counts_.sessions;
    if (welcome_) return;
    welcome_ = *welcome;
    for (int i = 0; i < settings_.players; ++i) {
      players_.push_back(
          std::make_unique<Worker>("player", [this](const std::stop_token& stop) { Play(stop); }));
    }
  } else if (const auto* ack = std::get_if<Ack>(&message)) {
    TakeAck(index, actor, *ack);
  } else if (const auto* offer = std::get_if<WeightsOffer>(&message)) {
    if (offer->version == 0) return;
    offered_.try_emplace(offer->version, Clock::now());
    actor.offer = *offer;
    actor.loaded_bytes = 0;
    AskForWeights(actor);
  } else if (const auto* chunk = std::get_if<WeightsChunk>(&message)) {
    TakeChunk(actor, *chunk);
  } else if (const auto* receipt = std::get_if<WeightsReceipt>(&message)) {
    actor.receipt = receipt->receipt;
    AskForWeights(actor);
  } else if (const auto* refused = std::get_if<Refused>(&message)) {
    actor.refused = true;
    ++counts_.refused;
    counts_.last_refusal = refused->reason;
  } else if (std::holds_alternative<Goodbye>(message)) {
    Send(actor, Goodbye{});
  }
}

void Crowd::TakeAck(std::size_t index, Actor& actor, const Ack& ack) {
  const Clock::time_point now = Clock::now();
  for (const std::uint64_t ticket : ack.durable) {
    const auto sent = actor.sent.find(ticket);
    if (sent == actor.sent.end()) continue;
    times_.ack.push_back(static_cast<float>(Seconds(now - sent->second)));
    actor.sent.erase(sent);
    ++counts_.games;
  }
  for (const RejectedGame& game : ack.rejected) {
    actor.sent.erase(game.ticket);
    counts_.last_refusal = game.reason;
    ++counts_.rejected;
  }
  for (const std::uint64_t ticket : ack.tickets) {
    wishes_.TryPush({index, actor.incarnation, ticket, actor.version});
  }
}

// One request at a time.
void Crowd::AskForWeights(Actor& actor) {
  if (actor.asked_with == actor.receipt || actor.version == actor.offer.version) return;
  actor.asked_with = actor.receipt;
  Send(actor, WeightsRequest{actor.offer.version, actor.loaded_bytes, actor.receipt});
}

void Crowd::TakeChunk(Actor& actor, const WeightsChunk& chunk) {
  // Otherwise it was asked for before these weights were offered.
  const bool newest = chunk.offer == actor.offer && chunk.offset_bytes == actor.loaded_bytes;
  if (newest) actor.loaded_bytes += chunk.data.size();
  if (!newest || actor.loaded_bytes != actor.offer.size_bytes) return;
  actor.version = actor.offer.version;
  CrowdTimes::Weights& weights = times_.weights[actor.version];
  weights.last_s = Seconds(Clock::now() - offered_[actor.version]);
  ++weights.actors;
}

void Crowd::Play(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    const auto wish = wishes_.Pop(milliseconds(100));
    if (!wish) continue;
    SealedGame game =
        Seal(PlayTicket(welcome_->self_play, wish->ticket, FirstVersionOf(wish->version)),
             welcome_->settings_digest);
    Played played{*wish, std::move(game)};
    while (!stop.stop_requested() &&
           played_.Push(std::move(played), milliseconds(100)) == QueueResult::kTimedOut) {
    }
  }
}

}  // namespace powderkeg
