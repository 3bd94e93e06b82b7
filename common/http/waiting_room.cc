#include "common/http/waiting_room.h"

#include <strings.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "common/base/check.h"

namespace powderkeg {
namespace {

// A request of so many bytes may have filled what the system keeps for a connection.
constexpr std::size_t kMostPeeked = std::size_t{32} << 10;
constexpr std::string_view kHeadersEnd = "\r\n\r\n";

// The value of a header; empty if there is none.
std::string_view HeaderIn(std::string_view headers, std::string_view name) {
  for (std::size_t at = headers.find('\n'); at != std::string_view::npos;
       at = headers.find('\n', at + 1)) {
    const std::string_view line = headers.substr(at + 1);
    if (line.size() <= name.size() || line[name.size()] != ':') continue;
    if (strncasecmp(line.data(), name.data(), name.size()) != 0) continue;
    const std::size_t begin = std::min(line.find_first_not_of(' ', name.size() + 1), line.size());
    return line.substr(begin, line.find_first_of("\r\n", begin) - begin);
  }
  return {};
}

// Whether a request is there, or will be refused for its length; `most` bytes are all that are
// waited for.
bool IsWhole(std::string_view bytes, std::size_t most, std::size_t longest) {
  const std::size_t end = bytes.find(kHeadersEnd);
  if (end == std::string_view::npos) return bytes.size() >= most;
  const std::size_t body = end + kHeadersEnd.size();
  const std::string_view headers = bytes.substr(0, body);
  if (!HeaderIn(headers, "Transfer-Encoding").empty()) {
    return bytes.ends_with("0\r\n\r\n") || bytes.size() >= most;
  }
  const std::string_view length = HeaderIn(headers, "Content-Length");
  if (length.empty()) return true;
  std::size_t left = most;  // if it is no number
  std::from_chars(length.begin(), length.end(), left);
  return left > longest || bytes.size() >= std::min(body + left, most);
}

int Checked(int descriptor, const char* what) {
  if (descriptor < 0) throw Error(StrCat("cannot make ", what, ": ", std::strerror(errno)));
  return descriptor;
}

}  // namespace

WaitingRoom::WaitingRoom(const WaitingRoomSettings& settings, Ready ready)
    : settings_(settings), ready_(std::move(ready)) {
  poll_ = Checked(epoll_create1(EPOLL_CLOEXEC), "an epoll");
  stop_ = Checked(eventfd(0, EFD_CLOEXEC), "an eventfd");
  epoll_event event{.events = EPOLLIN, .data = {.fd = stop_}};
  epoll_ctl(poll_, EPOLL_CTL_ADD, stop_, &event);
  worker_.emplace("http wait", [this](const std::stop_token& stop) { Run(stop); });
}

void WaitingRoom::Close() {
  if (!worker_) return;
  worker_->RequestStop();
  eventfd_write(stop_, 1);
  worker_.reset();
}

WaitingRoom::~WaitingRoom() {
  Close();
  for (const auto& [socket, visitor] : visitors_) close(socket);
  close(stop_);
  close(poll_);
}

void WaitingRoom::Admit(int socket) {
  Enter(socket, {.deadline = Clock::now() + settings_.timeout, .answered = false, .bytes_left = 0});
}

void WaitingRoom::Dismiss(int socket) {
  shutdown(socket, SHUT_WR);
  Enter(socket, {.deadline = Clock::now() + settings_.timeout,
                 .answered = true,
                 .bytes_left = settings_.max_bytes});
}

void WaitingRoom::Enter(int socket, const Visitor& visitor) {
  const std::lock_guard lock(mutex_);
  if (visitors_.size() >= settings_.max_connections) {
    const auto longest = std::ranges::min_element(
        visitors_, {}, [](const auto& entry) { return entry.second.deadline; });
    close(longest->first);
    visitors_.erase(longest);
  }
  visitors_.emplace(socket, visitor);
  epoll_event event{.events = EPOLLIN | EPOLLRDHUP | EPOLLET, .data = {.fd = socket}};
  if (epoll_ctl(poll_, EPOLL_CTL_ADD, socket, &event) == 0) return;
  visitors_.erase(socket);
  close(socket);
}

void WaitingRoom::Run(const std::stop_token& stop) {
  constexpr int kEvents = 64;
  std::array<epoll_event, kEvents> events{};
  const auto tick = std::max(static_cast<int>(settings_.timeout.count() / 4), 1);
  for (int count = 0; !stop.stop_requested() || count == kEvents;) {
    count = std::max(epoll_wait(poll_, events.data(), kEvents, tick), 0);
    for (const epoll_event& event : std::span(events).first(static_cast<std::size_t>(count))) {
      if (event.data.fd != stop_) {
        Attend(event.data.fd, (event.events & (EPOLLRDHUP | EPOLLHUP | EPOLLERR)) != 0);
      }
    }
    CloseLate(Clock::now());
  }
}

void WaitingRoom::Attend(int socket, bool ended) {
  {
    const std::lock_guard lock(mutex_);
    const auto found = visitors_.find(socket);
    if (found == visitors_.end()) return;  // closed since
    const bool answered = found->second.answered;
    if (answered ? !HasLeft(socket, found->second) : !ended && !IsRequestThere(socket)) return;
    epoll_ctl(poll_, EPOLL_CTL_DEL, socket, nullptr);
    visitors_.erase(found);
    if (answered) {
      close(socket);
      return;
    }
  }
  ready_(socket);
}

bool WaitingRoom::HasLeft(int socket, Visitor& visitor) {
  std::array<char, 4096> dropped;
  while (visitor.bytes_left > 0) {
    const ssize_t size = recv(socket, dropped.data(), dropped.size(), MSG_DONTWAIT);
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) return size == 0 || errno != EAGAIN;
    visitor.bytes_left -= std::min(visitor.bytes_left, static_cast<std::size_t>(size));
  }
  return true;
}

bool WaitingRoom::IsRequestThere(int socket) const {
  const std::size_t most = std::min(settings_.max_bytes, kMostPeeked);
  std::string bytes(most, '\0');
  const ssize_t size = recv(socket, bytes.data(), bytes.size(), MSG_PEEK | MSG_DONTWAIT);
  if (size < 0) return errno != EAGAIN && errno != EINTR;
  bytes.resize(static_cast<std::size_t>(size));
  return IsWhole(bytes, most, settings_.max_bytes);
}

void WaitingRoom::CloseLate(Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  std::erase_if(visitors_, [now](const auto& entry) {
    const bool late = entry.second.deadline <= now;
    if (late) close(entry.first);
    return late;
  });
}

}  // namespace powderkeg
