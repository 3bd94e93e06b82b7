#include "tests/wire/in_process_transport.h"

#include <poll.h>

#include <array>
#include <cstddef>
#include <deque>
#include <map>
#include <mutex>
#include <utility>

namespace powderkeg {
namespace {

using std::chrono::milliseconds;

constexpr std::size_t kCapacity = 1024;  // messages per inbox

template <typename Message>
struct Inbox {
  std::deque<Message> messages;
  Waker filled;
};

// Waits until the inbox or the waker was notified.
void Wait(const Waker& filled, milliseconds timeout, const Waker& waker) {
  std::array<pollfd, 2> files = {pollfd{filled.file_descriptor(), POLLIN, 0},
                                 pollfd{waker.file_descriptor(), POLLIN, 0}};
  poll(files.data(), files.size(), static_cast<int>(timeout.count()));
  filled.Clear();
  waker.Clear();
}

}  // namespace

struct InProcessNetwork::Shared {
  std::mutex mutex;  // guards everything below
  std::shared_ptr<Inbox<Incoming>> server;
  std::map<PeerId, std::shared_ptr<Inbox<std::string>>> clients;
  int connections = 0;
  Filter to_server = [](const std::string&) { return true; };
  Filter to_clients = [](const std::string&) { return true; };

  template <typename Message>
  std::optional<Message> Take(Inbox<Message>& inbox) {
    const std::lock_guard lock(mutex);
    if (inbox.messages.empty()) return std::nullopt;
    std::optional<Message> message(std::move(inbox.messages.front()));
    inbox.messages.pop_front();
    return message;
  }

  template <typename Message>
  std::optional<Message> TakeWithin(Inbox<Message>& inbox, milliseconds timeout,
                                    const Waker& waker) {
    if (auto message = Take(inbox)) return message;
    Wait(inbox.filled, timeout, waker);
    return Take(inbox);
  }
};

namespace {

class InProcessServer final : public ServerChannel {
 public:
  explicit InProcessServer(std::shared_ptr<InProcessNetwork::Shared> shared)
      : shared_(std::move(shared)), inbox_(std::make_shared<Inbox<Incoming>>()) {
    const std::lock_guard lock(shared_->mutex);
    shared_->server = inbox_;
  }
  ~InProcessServer() override {
    const std::lock_guard lock(shared_->mutex);
    if (shared_->server != inbox_) return;
    shared_->server = nullptr;
    for (const auto& [peer, inbox] : shared_->clients) inbox->messages.clear();
  }

  bool SendShared(const PeerId& peer, const std::shared_ptr<const std::string>& bytes) override {
    return Send(peer, *bytes);
  }
  bool Send(const PeerId& peer, const std::string& bytes) override {
    const std::lock_guard lock(shared_->mutex);
    const auto client = shared_->clients.find(peer);
    if (client == shared_->clients.end()) return false;
    if (client->second->messages.size() >= kCapacity) return false;
    std::string passed = bytes;
    if (!shared_->to_clients(passed)) return true;
    client->second->messages.push_back(std::move(passed));
    client->second->filled.Notify();
    return true;
  }
  std::optional<Incoming> Receive(milliseconds timeout, const Waker& waker) override {
    return shared_->TakeWithin(*inbox_, timeout, waker);
  }
  [[nodiscard]] std::string endpoint() const override { return "in-process"; }

 private:
  std::shared_ptr<InProcessNetwork::Shared> shared_;
  std::shared_ptr<Inbox<Incoming>> inbox_;
};

class InProcessClient final : public ClientChannel {
 public:
  explicit InProcessClient(std::shared_ptr<InProcessNetwork::Shared> shared)
      : shared_(std::move(shared)), inbox_(std::make_shared<Inbox<std::string>>()) {
    const std::lock_guard lock(shared_->mutex);
    peer_ = "peer" + std::to_string(++shared_->connections);
    shared_->clients[peer_] = inbox_;
  }
  ~InProcessClient() override {
    const std::lock_guard lock(shared_->mutex);
    shared_->clients.erase(peer_);
  }

  bool Send(const std::string& bytes) override {
    const std::lock_guard lock(shared_->mutex);
    if (shared_->server == nullptr || shared_->server->messages.size() >= kCapacity) return false;
    std::string passed = bytes;
    if (!shared_->to_server(passed)) return true;
    shared_->server->messages.push_back({.peer = peer_, .bytes = std::move(passed)});
    shared_->server->filled.Notify();
    return true;
  }
  std::optional<std::string> Receive(milliseconds timeout, const Waker& waker) override {
    return shared_->TakeWithin(*inbox_, timeout, waker);
  }

 private:
  std::shared_ptr<InProcessNetwork::Shared> shared_;
  std::shared_ptr<Inbox<std::string>> inbox_;
  PeerId peer_;
};

}  // namespace

InProcessNetwork::InProcessNetwork() : shared_(std::make_shared<Shared>()) {}

std::unique_ptr<ServerChannel> InProcessNetwork::Listen() {
  return std::make_unique<InProcessServer>(shared_);
}

std::unique_ptr<ClientChannel> InProcessNetwork::Connect() {
  return std::make_unique<InProcessClient>(shared_);
}

void InProcessNetwork::FilterToServer(Filter filter) {
  const std::lock_guard lock(shared_->mutex);
  shared_->to_server = std::move(filter);
}

void InProcessNetwork::FilterToClients(Filter filter) {
  const std::lock_guard lock(shared_->mutex);
  shared_->to_clients = std::move(filter);
}

}  // namespace powderkeg
