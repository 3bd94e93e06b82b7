#include "common/wire/zmq_transport.h"

#include <netdb.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>
#include <zmq.hpp>
#include <zmq_addon.hpp>

#include "common/base/check.h"
#include "common/base/descriptors.h"
#include "common/base/log.h"
#include "common/base/log_budget.h"
#include "common/base/number.h"
#include "common/wire/connection_watch.h"
#include "common/wire/messages.h"

namespace powderkeg {
namespace {

using std::chrono::milliseconds;

constexpr int kLingerMs = 1000;
// Messages per peer and direction that each side may hold. A peer that lets so many lie is taken
// for one that does not read.
constexpr int kHighWaterMark = 256;
constexpr int kHandshakeMs = 10'000;
constexpr int kBacklog = 4096;  // connections that wait to be accepted
// A peer that vanished, or does not read, is given up by TCP after so long: that frees what its
// connection holds. Heartbeats of ZeroMQ itself must stay off: where they meet a connection that is
// stopped because its peer sends too much, libzmq 4.3 aborts (its issue 4364).
constexpr int kKeepAliveS = 15;  // and twice again
constexpr int kUnreadMs = 60'000;
constexpr int kReconnectMs = 200;
constexpr int kConnectMs = 3'000;  // to one address
constexpr const char* kZapEndpoint = "inproc://zeromq.zap.01";
constexpr const char* kMonitorEndpoint = "inproc://monitor";

void SetCommonOptions(zmq::socket_t& socket) {
  socket.set(zmq::sockopt::linger, kLingerMs);
  socket.set(zmq::sockopt::sndhwm, kHighWaterMark);
  socket.set(zmq::sockopt::rcvhwm, kHighWaterMark);
  socket.set(zmq::sockopt::maxmsgsize, kMaxMessageBytes);
  socket.set(zmq::sockopt::handshake_ivl, kHandshakeMs);
  socket.set(zmq::sockopt::tcp_keepalive, 1);
  socket.set(zmq::sockopt::tcp_keepalive_idle, kKeepAliveS);
  socket.set(zmq::sockopt::tcp_keepalive_intvl, kKeepAliveS);
  socket.set(zmq::sockopt::tcp_keepalive_cnt, 2);
  socket.set(zmq::sockopt::tcp_maxrt, kUnreadMs);
  socket.set(zmq::sockopt::ipv6, 1);
}

// ZeroMQ takes any number for a port and uses what is left of it in 16 bits.
void ExpectPort(const std::string& endpoint) {
  if (!endpoint.starts_with("tcp://")) return;
  const std::string port = endpoint.substr(endpoint.rfind(':') + 1);
  if (port == "*" || ParseNumber<std::uint16_t>(port)) return;
  throw Error(StrCat("the port of ", endpoint, " is \"", port, "\"; expected 0 to 65535"));
}

// ZeroMQ takes the path of an ipc address from whoever listens there.
void ExpectNobodyListens(const std::string& endpoint) {
  constexpr std::string_view kIpc = "ipc://";
  sockaddr_un address{.sun_family = AF_UNIX, .sun_path = {}};
  const std::string path = endpoint.substr(std::min(kIpc.size(), endpoint.size()));
  if (!endpoint.starts_with(kIpc) || path.size() >= sizeof address.sun_path) return;
  path.copy(address.sun_path, path.size());
  const int peer = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const auto* any = reinterpret_cast<const sockaddr*>(&address);
  const bool taken = connect(peer, any, sizeof address) == 0;
  close(peer);
  if (taken) throw Error(StrCat("cannot listen on ", endpoint, ": somebody else does"));
}

// Waits until the socket has a message. False: time is up or the waker was notified.
bool WaitForMessage(zmq::socket_t& socket, milliseconds timeout, const Waker& waker) {
  std::array<zmq::pollitem_t, 2> items = {
      zmq::pollitem_t{socket.handle(), 0, ZMQ_POLLIN, 0},
      zmq::pollitem_t{nullptr, waker.file_descriptor(), ZMQ_POLLIN, 0}};
  try {
    zmq::poll(items.data(), items.size(), timeout);
  } catch (const zmq::error_t& error) {
    if (error.num() != EINTR) throw Error(StrCat("cannot wait for messages: ", error.what()));
    return false;
  }
  if ((items[1].revents & ZMQ_POLLIN) != 0) waker.Clear();
  return (items[0].revents & ZMQ_POLLIN) != 0;
}

// Shares the bytes, which ZeroMQ only reads.
zmq::message_t MessageOf(const std::shared_ptr<const std::string>& bytes) {
  using Kept = std::shared_ptr<const std::string>;
  const auto release = [](void* /*data*/, void* kept) { delete static_cast<Kept*>(kept); };
  return {const_cast<char*>(bytes->data()), bytes->size(), release, new Kept(bytes)};
}

// Does not wait. False: no room, no connection, or the peer is gone. A signal does not count: half
// a message would put the socket out of step.
bool SendFrame(zmq::socket_t& socket, zmq::message_t message,
               zmq::send_flags flags = zmq::send_flags::none) {
  for (;;) {
    try {
      return socket.send(message, flags | zmq::send_flags::dontwait).has_value();
    } catch (const zmq::error_t& error) {
      if (error.num() == EHOSTUNREACH) return false;
      if (error.num() != EINTR) throw Error(StrCat("cannot send: ", error.what()));
    }
  }
}

std::optional<std::vector<zmq::message_t>> ReceiveFrames(zmq::socket_t& socket) {
  std::vector<zmq::message_t> frames;
  try {
    if (!zmq::recv_multipart(socket, std::back_inserter(frames), zmq::recv_flags::dontwait)) {
      return std::nullopt;
    }
  } catch (const zmq::error_t& error) {
    if (error.num() != EINTR) throw Error(StrCat("cannot receive a message: ", error.what()));
    return std::nullopt;
  }
  return frames;
}

// `monitor` tells of the events of `socket`, however many wait.
void Monitor(zmq::socket_t& socket, int events, zmq::socket_t& monitor) {
  monitor.set(zmq::sockopt::rcvhwm, 0);
  if (zmq_socket_monitor(socket.handle(), kMonitorEndpoint, events) != 0) {
    throw Error(StrCat("cannot watch connections: ", zmq_strerror(zmq_errno())));
  }
  monitor.connect(kMonitorEndpoint);
}

struct MonitorEvent {
  int number;
  int value;
};

// Does not wait.
std::optional<MonitorEvent> NextEvent(zmq::socket_t& monitor) {
  const auto frames = ReceiveFrames(monitor);
  std::uint16_t number = 0;
  std::int32_t value = 0;
  if (!frames || frames->front().size() < sizeof number + sizeof value) return std::nullopt;
  const auto* bytes = frames->front().data<std::uint8_t>();
  std::memcpy(&number, bytes, sizeof number);
  std::memcpy(&value, bytes + sizeof number, sizeof value);
  return MonitorEvent{number, value};
}

// The zeromq authentication protocol (ZeroMQ RFC 27): lets in whoever has a key in the folder.
class KeyChecker {
 public:
  KeyChecker(zmq::context_t& context, const std::filesystem::path& keys)
      : context_(context), keys_(keys), socket_(context, zmq::socket_type::rep) {
    socket_.bind(kZapEndpoint);
    thread_ = std::jthread([this] { Run(); });
  }
  // Shuts the context down: that ends the thread's wait.
  ~KeyChecker() { context_.shutdown(); }
  KeyChecker(const KeyChecker&) = delete;
  KeyChecker& operator=(const KeyChecker&) = delete;

 private:
  // Until the context is shut down.
  void Run() {
    try {
      for (;;) {
        std::vector<zmq::message_t> request;
        if (zmq::recv_multipart(socket_, std::back_inserter(request))) Answer(request);
      }
    } catch (const zmq::error_t& error) {
      if (error.num() != ETERM) log::Error("authentication failed", "error", error.what());
    }
    socket_.close();
  }

  // Request: version, id, domain, address, identity, mechanism, key.
  void Answer(const std::vector<zmq::message_t>& request) {
    constexpr std::size_t kFrames = 7;
    constexpr std::size_t kKeyBytes = 32;
    constexpr std::size_t kKeyCharacters = 40;
    std::optional<std::string> actor;
    if (request.size() == kFrames && request[5].to_string_view() == "CURVE" &&
        request[6].size() == kKeyBytes) {
      std::array<char, kKeyCharacters + 1> key{};
      zmq_z85_encode(key.data(), request[6].data<std::uint8_t>(), kKeyBytes);
      actor = keys_.ActorOf(key.data());
    }
    if (!actor && request.size() > 3 && log_budget_.Spend()) {
      log::Warn("refused a key that is not in the folder", "address", request[3].to_string_view());
    }
    const std::string id = request.size() > 1 ? request[1].to_string() : "";
    const std::array<std::string, 6> reply = {"1.0",
                                              id,
                                              actor ? "200" : "400",
                                              actor ? "OK" : "key not allowed",
                                              actor.value_or(""),  // the user id
                                              ""};
    for (std::size_t i = 0; i < reply.size(); ++i) {
      const auto more = i + 1 < reply.size() ? zmq::send_flags::sndmore : zmq::send_flags::none;
      socket_.send(zmq::buffer(reply[i]), more);
    }
  }

  zmq::context_t& context_;
  KeyFolder keys_;          // the thread's
  zmq::socket_t socket_;    // used by the thread alone once it runs
  log::Budget log_budget_;  // the thread's
  std::jthread thread_;
};

class ZmqServer final : public ServerChannel {
 public:
  explicit ZmqServer(const ListenSettings& settings)
      : context_(1),
        socket_(context_, zmq::socket_type::router),
        monitor_(context_, zmq::socket_type::pair),
        watch_(LimitsFor(settings.keys.has_value())) {
    SetCommonOptions(socket_);
    Monitor(socket_, ZMQ_EVENT_ACCEPTED | ZMQ_EVENT_DISCONNECTED, monitor_);
    socket_.set(zmq::sockopt::router_mandatory, 1);
    socket_.set(zmq::sockopt::backlog, kBacklog);
    if (settings.keys) UseKeys(*settings.keys);
    ExpectPort(settings.endpoint);
    ExpectNobodyListens(settings.endpoint);
    try {
      socket_.bind(settings.endpoint);
    } catch (const zmq::error_t& error) {
      throw Error(StrCat("cannot listen on ", settings.endpoint, ": ", error.what(),
                         "; expected tcp://ADDRESS:PORT or ipc://PATH that is free"));
    }
  }

  // An event that nobody takes would hold up the io thread.
  ~ZmqServer() override { zmq_socket_monitor(socket_.handle(), nullptr, 0); }
  ZmqServer(const ZmqServer&) = delete;
  ZmqServer& operator=(const ZmqServer&) = delete;

  bool Send(const PeerId& peer, const std::string& bytes) override {
    return SendFrame(socket_, zmq::message_t(peer), zmq::send_flags::sndmore) &&
           SendFrame(socket_, zmq::message_t(bytes));
  }

  bool SendShared(const PeerId& peer, const std::shared_ptr<const std::string>& bytes) override {
    return SendFrame(socket_, zmq::message_t(peer), zmq::send_flags::sndmore) &&
           SendFrame(socket_, MessageOf(bytes));
  }

  std::optional<Incoming> Receive(milliseconds timeout, const Waker& waker) override {
    WatchConnections();
    auto frames = ReceiveFrames(socket_);  // where many wait, none of them is waited for
    if (!frames && WaitForMessage(socket_, std::min(timeout, kLook), waker)) {
      frames = ReceiveFrames(socket_);
    }
    if (!frames || frames->empty()) {
      watch_.AllHeard();
      return std::nullopt;
    }
    watch_.Heard(zmq_msg_get(frames->back().handle(), ZMQ_SRCFD));
    // A message of more or fewer frames than our own has no bytes that could be read.
    Incoming incoming{.peer = frames->front().to_string()};
    if (frames->size() == 2) incoming.bytes = frames->back().to_string();
    const char* user = zmq_msg_gets(frames->back().handle(), "User-Id");
    if (user != nullptr) incoming.key_owner = user;
    return incoming;
  }

  [[nodiscard]] std::string endpoint() const override {
    // An IPv4 address on an IPv6 socket: as it was given.
    constexpr std::string_view kMapped = "tcp://[::ffff:";
    std::string endpoint = socket_.get(zmq::sockopt::last_endpoint);
    if (endpoint.starts_with(kMapped)) {
      endpoint.replace(0, kMapped.size(), "tcp://").erase(endpoint.find(']'), 1);
    }
    return endpoint;
  }

 private:
  static constexpr milliseconds kLook{20};
  static constexpr std::size_t kForFiles = 4096;  // descriptors, where there are so many

  // Nobody's message to a learner is longer than games. A frame of one byte takes 64 of memory; of
  // a message it takes 3, with keys 35.
  static ConnectionLimits LimitsFor(bool keys) {
    constexpr std::uint64_t kLongest = kMaxGamesBytes + (std::size_t{1} << 20);
    const std::size_t descriptors = DescriptorLimit();
    return {
        .connections = std::max(descriptors / 2, descriptors - std::min(descriptors, kForFiles)),
        .unfinished = kLongest,
        .unfinished_in_all = (keys ? 16 : 1) * kLongest};
  }

  void WatchConnections() {
    const auto now = std::chrono::steady_clock::now();
    if (now < next_look_) return;
    next_look_ = now + kLook;
    while (const auto event = NextEvent(monitor_)) {
      if (event->number == ZMQ_EVENT_ACCEPTED) watch_.Opened(event->value);
      if (event->number == ZMQ_EVENT_DISCONNECTED) watch_.Closed(event->value);
    }
    const std::size_t cut = watch_.CutExcess();
    if (cut > 0 && log_budget_.Spend()) {
      log::Warn("connections cut: too many, or a message without end", "cut", cut, "open",
                watch_.size());
    }
  }

  void UseKeys(const std::filesystem::path& keys) {
    socket_.set(zmq::sockopt::curve_server, true);
    socket_.set(zmq::sockopt::curve_secretkey, ReadKey(keys / "learner.secret"));
    socket_.set(zmq::sockopt::zap_domain, "powderkeg");
    key_checker_.emplace(context_, keys);
  }

  zmq::context_t context_;
  std::optional<KeyChecker> key_checker_;
  zmq::socket_t socket_;
  zmq::socket_t monitor_;  // tells of connections
  ConnectionWatch watch_;
  std::chrono::steady_clock::time_point next_look_;
  log::Budget log_budget_;
};

// "tcp://ADDRESS:PORT" for every address that the name in an endpoint has now, in the system's
// order; the endpoint itself if it holds an address, or a name that is not known.
std::vector<std::string> AddressesOf(const std::string& endpoint) {
  constexpr std::string_view kTcp = "tcp://";
  const std::size_t colon = endpoint.rfind(':');
  if (!endpoint.starts_with(kTcp) || colon < kTcp.size()) return {endpoint};
  const std::string host = endpoint.substr(kTcp.size(), colon - kTcp.size());
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (getaddrinfo(host.c_str(), nullptr, &hints, &found) != 0) return {endpoint};
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> list(found, freeaddrinfo);
  std::vector<std::string> addresses;
  for (const addrinfo* entry = found; entry != nullptr; entry = entry->ai_next) {
    std::array<char, NI_MAXHOST> text{};
    if (getnameinfo(entry->ai_addr, entry->ai_addrlen, text.data(), NI_MAXHOST, nullptr, 0,
                    NI_NUMERICHOST) != 0) {
      continue;
    }
    const std::string address =
        entry->ai_family == AF_INET6 ? StrCat('[', text.data(), ']') : text.data();
    addresses.push_back(StrCat(kTcp, address, endpoint.substr(colon)));
  }
  return addresses.empty() ? std::vector{endpoint} : addresses;
}

class ZmqClient final : public ClientChannel {
 public:
  ZmqClient(const std::string& endpoint, const std::optional<ClientKeys>& keys)
      : endpoint_(endpoint),
        context_(1),
        socket_(context_, zmq::socket_type::dealer),
        monitor_(context_, zmq::socket_type::pair) {
    SetCommonOptions(socket_);
    Monitor(socket_, kHandshakeFailed | ZMQ_EVENT_CONNECT_RETRIED, monitor_);
    socket_.set(zmq::sockopt::immediate, true);
    socket_.set(zmq::sockopt::reconnect_ivl, kReconnectMs);
    socket_.set(zmq::sockopt::reconnect_ivl_max, 5000);
    socket_.set(zmq::sockopt::connect_timeout, kConnectMs);
    if (keys) {
      socket_.set(zmq::sockopt::curve_serverkey, keys->learner_public);
      socket_.set(zmq::sockopt::curve_publickey, keys->own.public_key);
      socket_.set(zmq::sockopt::curve_secretkey, keys->own.secret_key);
    }
    ExpectPort(endpoint);
    addresses_ = AddressesOf(endpoint);
    ConnectTo(addresses_.front());
  }
  // An event that nobody takes would hold up the io thread.
  ~ZmqClient() override { zmq_socket_monitor(socket_.handle(), nullptr, 0); }
  ZmqClient(const ZmqClient&) = delete;
  ZmqClient& operator=(const ZmqClient&) = delete;

  bool Send(const std::string& bytes) override {
    HearMonitor();
    return SendFrame(socket_, zmq::message_t(bytes));
  }

  std::optional<std::string> Receive(milliseconds timeout, const Waker& waker) override {
    if (!WaitForMessage(socket_, timeout, waker)) return std::nullopt;
    auto frames = ReceiveFrames(socket_);
    if (!frames || frames->size() != 1) return std::nullopt;
    return frames->front().to_string();
  }

  [[nodiscard]] std::string Trouble() override {
    HearMonitor();
    return StrCat(endpoint_, ": ", trouble_);
  }

 private:
  static constexpr int kHandshakeFailed = ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL |
                                          ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL |
                                          ZMQ_EVENT_HANDSHAKE_FAILED_AUTH;

  void HearMonitor() {
    while (const auto event = NextEvent(monitor_)) {
      if (event->number == ZMQ_EVENT_CONNECT_RETRIED) {
        TryNextAddress();
      } else {
        trouble_ = Meaning(event->number);
      }
    }
  }

  // The learner may listen on one of the addresses of its name only.
  void TryNextAddress() {
    const auto now = std::chrono::steady_clock::now();
    if (addresses_.size() == 1 || now - switched_ < milliseconds(kReconnectMs)) return;
    switched_ = now;
    socket_.disconnect(addresses_.front());
    std::rotate(addresses_.begin(), addresses_.begin() + 1, addresses_.end());
    ConnectTo(addresses_.front());
  }

  void ConnectTo(const std::string& address) {
    try {
      socket_.connect(address);
    } catch (const zmq::error_t& error) {
      throw Error(StrCat("cannot connect to ", endpoint_, ": ", error.what(),
                         "; expected tcp://HOST:PORT or ipc://PATH"));
    }
  }

  // A learner that does not know a key says so; one that cannot read us hangs up.
  static std::string_view Meaning(int event) {
    return event == ZMQ_EVENT_HANDSHAKE_FAILED_AUTH
               ? "the learner does not know this actor's key; expected it in its keys/actors"
               : "it hung up; expected the learner that learner.public belongs to, and keys on "
                 "both sides or on none";
  }

  const std::string endpoint_;
  std::vector<std::string> addresses_;  // of the endpoint; the first one is connected to
  std::chrono::steady_clock::time_point switched_ = std::chrono::steady_clock::now();
  std::string_view trouble_ = "no answer";
  zmq::context_t context_;
  zmq::socket_t socket_;
  zmq::socket_t monitor_;  // tells of handshakes that fail
};

}  // namespace

bool IsLocal(const std::string& endpoint) {
  constexpr std::array<std::string_view, 4> kLocal = {"ipc://", "tcp://127.",
                                                      "tcp://localhost:", "tcp://[::1]:"};
  for (const std::string_view prefix : kLocal) {
    if (endpoint.starts_with(prefix)) return true;
  }
  return false;
}

std::unique_ptr<ServerChannel> ListenZmq(const ListenSettings& settings) {
  if (!settings.keys && !settings.allow_insecure && !IsLocal(settings.endpoint)) {
    throw Error(StrCat("not listening on ", settings.endpoint,
                       " without keys: make them with deploy/keys and give --keys, or say "
                       "--insecure"));
  }
  return std::make_unique<ZmqServer>(settings);
}

std::unique_ptr<ClientChannel> ConnectZmq(const std::string& endpoint,
                                          const std::optional<ClientKeys>& keys) {
  return std::make_unique<ZmqClient>(endpoint, keys);
}

}  // namespace powderkeg
