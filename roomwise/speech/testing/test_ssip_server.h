#pragma once

#include <strings.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

// Only for tests.
namespace roomwise::speech::testing {

// Stands in for speech-dispatcher: answers one client on a Unix socket as SSIP, the Speech
// Synthesis Interface Protocol, has it, and speaks nothing. The test says when a message has ended.
class SsipServer {
 public:
  explicit SsipServer(const std::filesystem::path& path) : path_(path) {
    listener_ = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path.c_str(), sizeof(address.sun_path) - 1);
    if (bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0 ||
        listen(listener_, 1) != 0) {
      throw std::runtime_error("no socket at " + path.string());
    }
    thread_ = std::thread([this] { serve(); });
  }
  ~SsipServer() {
    hang_up();
    shutdown(listener_, SHUT_RDWR);
    thread_.join();
    close(listener_);
  }
  SsipServer(const SsipServer&) = delete;
  SsipServer& operator=(const SsipServer&) = delete;

  [[nodiscard]] std::string address() const { return "unix_socket:" + path_.string(); }
  // Lines from the client, texts of messages among them.
  [[nodiscard]] std::vector<std::string> lines() {
    const std::lock_guard lock(mutex_);
    return lines_;
  }
  void end(int message) { notify(702, message, "END"); }
  void hang_up() {
    const std::lock_guard lock(mutex_);
    if (client_ >= 0) shutdown(client_, SHUT_RDWR);
  }

 private:
  void serve() {
    const int client = accept(listener_, nullptr, nullptr);
    if (client < 0) return;
    {
      const std::lock_guard lock(mutex_);
      client_ = client;
    }
    std::string received;
    char bytes[512];
    for (ssize_t count = 0; (count = read(client, bytes, sizeof(bytes))) > 0;) {
      received.append(bytes, static_cast<std::size_t>(count));
      for (std::size_t end = 0; (end = received.find("\r\n")) != std::string::npos;) {
        const std::string line = received.substr(0, end);
        received.erase(0, end + 2);
        answer(line);
      }
    }
    const std::lock_guard lock(mutex_);
    close(client_);
    client_ = -1;
  }

  void answer(const std::string& line) {
    {
      const std::lock_guard lock(mutex_);
      lines_.push_back(line);
    }
    if (is_receiving_) {
      if (line != ".") return;
      is_receiving_ = false;
      ++messages_;
      send("225-" + std::to_string(messages_) + "\r\n225 OK MESSAGE QUEUED\r\n");
    } else if (is_command(line, "speak")) {
      is_receiving_ = true;
      send("230 OK RECEIVING DATA\r\n");
    } else if (is_command(line, "history get client_id")) {
      send("245-1\r\n245 OK CLIENT ID SENT\r\n");
    } else if (is_command(line, "cancel self")) {
      send("210 OK CANCELED\r\n");
      notify(703, messages_, "CANCELED");
    } else if (is_command(line, "set self language xx")) {
      send("302 ERR LANGUAGE NOT SET\r\n");
    } else {
      send("200 OK\r\n");
    }
  }

  // Commands are the same in capitals and in small letters.
  static bool is_command(const std::string& line, const char* command) {
    return strcasecmp(line.c_str(), command) == 0;
  }

  void notify(int code, int message, const std::string& text) {
    const std::string number = std::to_string(code);
    send(number + "-" + std::to_string(message) + "\r\n" + number + "-1\r\n" + number + " " + text +
         "\r\n");
  }
  void send(const std::string& text) {
    const std::lock_guard lock(mutex_);
    if (client_ >= 0) ::send(client_, text.data(), text.size(), MSG_NOSIGNAL);
  }

  std::filesystem::path path_;
  int listener_ = -1;
  std::thread thread_;
  std::mutex mutex_;
  int client_ = -1;
  std::vector<std::string> lines_;
  bool is_receiving_ = false;
  int messages_ = 0;
};

}  // namespace roomwise::speech::testing
