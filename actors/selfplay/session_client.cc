#include "actors/selfplay/session_client.h"

#include <algorithm>
#include <utility>

#include "common/base/check.h"
#include "common/base/log.h"

namespace powderkeg {
namespace {

using std::chrono::milliseconds;

}  // namespace

SessionClient::SessionClient(SessionClientSettings settings, Connect connect, Outbox& outbox,
                             TicketBook& tickets, std::function<Heartbeat()> statistics)
    : settings_(std::move(settings)),
      connect_(std::move(connect)),
      outbox_(outbox),
      tickets_(tickets),
      statistics_(std::move(statistics)),
      weights_(settings_.weights_kept, waker_),
      rng_(settings_.incarnation) {
  tickets_.GrantPlayed(outbox_.Tickets());
  io_ = std::make_unique<Worker>("session", [this](const std::stop_token& stop) { Run(stop); });
}

SessionClient::~SessionClient() {
  try {
    Leave(milliseconds(0));
  } catch (const Error& error) {
    log::Error("session failed", "error", error.what());
  }
}

std::shared_ptr<const Welcome> SessionClient::welcome() const {
  const std::lock_guard lock(mutex_);
  return welcome_;
}

std::uint64_t SessionClient::version() const {
  const std::lock_guard lock(mutex_);
  return version_;
}

void SessionClient::WaitForChange(std::uint64_t version, milliseconds timeout) const {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, timeout, [&] { return version_ != version; });
}

void SessionClient::Leave(milliseconds patience) {
  {
    const std::lock_guard lock(mutex_);
    if (!deadline_) deadline_ = Clock::now() + patience;
  }
  io_->RequestStop();
  waker_.Notify();
  io_->Join();
}

std::optional<SessionClient::Clock::time_point> SessionClient::deadline() const {
  const std::lock_guard lock(mutex_);
  return deadline_;
}

void SessionClient::Changed() {
  {
    const std::lock_guard lock(mutex_);
    ++version_;
  }
  changed_.notify_all();
}

// --- The io thread -------------------------------------------------------------------------------

void SessionClient::Run(const std::stop_token& stop) {
  milliseconds backoff = settings_.first_backoff;
  Clock::time_point last_session = Clock::now();  // or when the search for one began
  const auto must_go = [&] {
    const auto last = deadline();
    return stop.stop_requested() && last && Clock::now() >= *last;
  };
  // Whatever ends this thread, nobody must wait for it in vain.
  const auto end = [this](void*) {
    ended_ = true;
    Changed();
  };
  const std::unique_ptr<void, decltype(end)> at_exit(this, end);
  do {
    {
      Connection connection(connect_(), {outbox_, tickets_, weights_, statistics_}, Greeting(),
                            settings_.dead_after);
      Serve(connection);
      if (connection.end() == Connection::End::kOver) return;
      if (connection.welcome()) {
        backoff = settings_.first_backoff;
        last_session = connection.last_heard();
      }
    }
    if (IsTooLong(Clock::now() - last_session)) {
      gave_up_ = true;
      return;
    }
    Pause(backoff);
    backoff = std::min(2 * backoff, settings_.last_backoff);
  } while (!must_go());
}

// Whether an actor that was for so long without a session gives up.
bool SessionClient::IsTooLong(Clock::duration absence) const {
  if (settings_.give_up <= milliseconds(0) || absence < settings_.give_up) return false;
  log::Warn("giving up: there was no session with the learner", "for_s",
            std::chrono::duration_cast<std::chrono::seconds>(absence).count());
  return true;
}

// Waits for the back-off, less up to half of it; not long when leaving.
void SessionClient::Pause(milliseconds backoff) {
  const Clock::time_point start = Clock::now();
  const auto jittered =
      std::chrono::duration_cast<milliseconds>(backoff * (1 - 0.5 * rng_.Uniform()));
  const auto left = [&] {
    const auto last = deadline();
    const Clock::time_point end =
        last ? std::min(start + settings_.first_backoff, *last) : start + jittered;
    return std::chrono::ceil<milliseconds>(end - Clock::now());
  };
  while (left() > milliseconds(0)) waker_.Wait(left());
}

Hello SessionClient::Greeting() const {
  return {.run_id = settings_.run_id,
          .build = settings_.build,
          .name = settings_.name,
          .incarnation = settings_.incarnation,
          .loops = settings_.loops};
}

void SessionClient::Serve(Connection& connection) {
  std::uint64_t changes = weights_.changes();
  while (!connection.end()) {
    connection.Round(waker_, deadline());
    if (connection.welcome()) Publish(*connection.welcome());
    if (std::exchange(changes, weights_.changes()) != changes) Changed();
  }
}

void SessionClient::Publish(const Welcome& welcome) {
  {
    const std::lock_guard lock(mutex_);
    if (welcome_ && *welcome_ == welcome) return;
    welcome_ = std::make_shared<const Welcome>(welcome);
  }
  Changed();
}

}  // namespace powderkeg
