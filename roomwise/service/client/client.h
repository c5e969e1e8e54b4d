#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "roomwise/base/expected.h"
#include "roomwise/base/file.h"
#include "roomwise/base/progress.h"
#include "roomwise/service/credentials/identity.h"

namespace roomwise::service {

struct ServerAddress {
  std::string host;  // name or address, without brackets
  std::uint16_t port = 0;
  std::string base = {};  // "/homes/flat-7", where the computer serves many homes
};
// "flat.local:8443", "192.168.1.5:8443", "[fe80::1]:8443", "flat.local:8443/homes/flat-7".
[[nodiscard]] Expected<ServerAddress> parse_server_address(std::string_view text);

// What a device keeps of the computer that it is paired with.
struct ServerCredentials {
  // Of the computer's certificate, or of the authority that signs it; trusted for nothing else.
  std::string fingerprint;
  std::string token;
};

struct PairedWith {
  ServerCredentials credentials;
  Identity who;
};

// How long to wait for the computer, and whether to give up before.
struct ClientWait {
  std::chrono::milliseconds timeout{5000};
  // A connection on which nothing came for so long, not even an answer to a ping, and of a large
  // message that is being sent not even an acknowledgement, is lost.
  std::chrono::milliseconds silence{2200};
  const Interruption* interruption = nullptr;  // asked ten times a second; null: never
};

// Of pairing: its answer uses the code up, so it is waited for longer. Proving the code takes the
// computer a second, and far more where it is busy, as while a map is made ready.
inline constexpr std::chrono::milliseconds kPairingTimeout{30'000};

// Why a computer does not pair.
enum class PairingRefusal {
  kNone,      // it was not asked, or gives no answer
  kCode,      // it refuses the code, or does not know it itself
  kName,      // the device's
  kMustWait,  // too many wrong codes came
};
struct PairingError : Error {
  PairingError(Error error, PairingRefusal why = PairingRefusal::kNone)  // NOLINT: from any error
      : Error(std::move(error)), refusal(why) {}
  PairingRefusal refusal;
};

// Pairs with a computer that was never seen by the six digits (blanks and hyphens between them do
// not count), the secret, or the link that it shows ("https://flat.local:8443/pair#SECRET"): shows
// that the code is known without sending it, and believes the computer only where it knows the code
// too (pairing_proof.h).
[[nodiscard]] tl::expected<PairedWith, PairingError> pair_with(
    const ServerAddress& server, const std::string& code, const std::string& name,
    const ClientWait& wait = {.timeout = kPairingTimeout});

// A WebSocket to the computer. Thread-safe. It closes where it goes.
class ServerConnection {
 public:
  virtual ~ServerConnection() = default;
  struct Message {
    bool is_text = true;
    Bytes bytes;
  };

  // ErrorCode::kRefused where the computer takes this device for none of the home's: it was
  // removed. Trying again does not help, being paired again does.
  [[nodiscard]] static Expected<std::unique_ptr<ServerConnection>> open(
      const ServerAddress& server, const ServerCredentials& credentials,
      const ClientWait& wait = {});

  // Queue a message. Fail where the connection is lost, or too much waits to be sent.
  [[nodiscard]] Expected<void> send_text(std::string_view text) {
    return send({true, Bytes(text.begin(), text.end())});
  }
  [[nodiscard]] Expected<void> send_binary(Bytes bytes) { return send({false, std::move(bytes)}); }

  // The next message; nothing where none came in time. Fails where the connection is lost.
  [[nodiscard]] virtual Expected<std::optional<Message>> receive(
      std::chrono::milliseconds timeout) = 0;

  // Says goodbye and waits for what was queued to be sent, a second at most.
  virtual void close() = 0;

 private:
  [[nodiscard]] virtual Expected<void> send(Message message) = 0;
};

}  // namespace roomwise::service
