#pragma once

// Sockets on loopback, for what a well-behaved client would not send.

#include <string>

namespace powderkeg {

// CHECKs that the system plays along.
[[nodiscard]] int ConnectTo(int port);
void SendAll(int socket, const std::string& bytes);  // stops where the peer has closed
// Everything the peer sends until it closes; closes the socket.
[[nodiscard]] std::string ReadToEnd(int socket);
// ConnectTo, send, end the sending side, read to the end.
[[nodiscard]] std::string ExchangeBytes(int port, const std::string& bytes);

}  // namespace powderkeg
