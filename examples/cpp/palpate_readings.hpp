// The newest reading of `palpate sensor serve`, over HTTP, by POSIX sockets alone. C++17.
//
//   palpate::Reading reading = palpate::newest("127.0.0.1", 8760);
//   if (reading.there) std::cout << reading.number("rx_deg") << "\n";
#pragma once

#include <netdb.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <string>

namespace palpate {

struct Reading {
  bool there = false;  // false before the first image
  std::string json;

  // A number by its name; NaN where there is none.
  double number(const std::string& name) const {
    const std::string key = "\"" + name + "\":";
    const auto at = json.find(key);
    const char* text = at == std::string::npos ? "" : json.c_str() + at + key.size();
    char* end = nullptr;
    const double value = std::strtod(text, &end);
    return end == text ? std::numeric_limits<double>::quiet_NaN() : value;
  }
};

// Ask a server for its newest reading; `token` is what it printed, if any. Throws where nothing answers.
inline Reading newest(const std::string& host, int port, const std::string& token = "") {
  addrinfo hints{}, *found = nullptr;
  hints.ai_socktype = SOCK_STREAM;
  const std::string service = std::to_string(port);
  if (getaddrinfo(host.c_str(), service.c_str(), &hints, &found) != 0) throw std::runtime_error("no such host");
  const int handle = socket(found->ai_family, found->ai_socktype, 0);
  const bool open = handle >= 0 && connect(handle, found->ai_addr, found->ai_addrlen) == 0;
  freeaddrinfo(found);
  if (!open) {
    if (handle >= 0) close(handle);
    throw std::runtime_error("nothing answers");
  }
  std::string ask = "GET /reading HTTP/1.1\r\nHost: " + host + ":" + service + "\r\nConnection: close\r\n";
  if (!token.empty()) ask += "Cookie: palpate_" + service + "=" + token + "\r\n";
  ask += "\r\n";
  std::string answer;
  char part[4096];
  ssize_t size = send(handle, ask.data(), ask.size(), 0);
  while (size > 0 && (size = recv(handle, part, sizeof part, 0)) > 0) answer.append(part, static_cast<size_t>(size));
  close(handle);
  const auto body = answer.find("\r\n\r\n");
  if (answer.rfind("HTTP/1.1 204", 0) == 0) return {};
  if (answer.rfind("HTTP/1.1 200", 0) != 0 || body == std::string::npos)
    throw std::runtime_error("refused: " + answer.substr(0, answer.find("\r\n")));
  return {true, answer.substr(body + 4)};
}

}  // namespace palpate
