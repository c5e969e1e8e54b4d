#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <vector>

#include "roomwise/guide/words/prompt.h"
#include "roomwise/service/client/client.h"
#include "roomwise/service/protocol/messages.h"

namespace roomwise::trials {

// What came back of a picture: where it was taken, as far as that is known, and all that is to be
// said because of it.
struct PictureAnswer {
  std::optional<service::SeenPosition> place;
  std::vector<guide::Prompt> prompts;
  std::string failure;  // why it could not be looked at; empty: it could
};

// A device that waits for each answer before it goes on: what it is told does not depend on how
// long the computer takes. Times are those of the device, as it says them itself. It rests on the
// protocol: `seen` comes behind all that is to be said because of a picture, and a question that
// no picture is needed for is answered before anything that is sent after it.
class LockStep {
 public:
  // Says hello and waits for the welcome. A computer that says nothing for `patience` fails.
  [[nodiscard]] static Expected<LockStep> begin(
      std::unique_ptr<service::ServerConnection> connection, const service::Hello& hello,
      std::chrono::milliseconds patience = std::chrono::minutes(2));

  // `depth`: may be empty. Fails where the connection is lost.
  [[nodiscard]] Expected<PictureAnswer> show(double t_ms, const Bytes& color, const Bytes& depth);
  // Its number is given here. Returns the first prompt of the answer; others come with the next
  // picture's. Fails where the connection is lost, or the computer refuses the question.
  [[nodiscard]] Expected<std::vector<guide::Prompt>> ask(service::Ask ask);

  [[nodiscard]] const service::Welcome& welcome() const { return welcome_; }

 private:
  LockStep(std::unique_ptr<service::ServerConnection> connection,
           std::chrono::milliseconds patience)
      : connection_(std::move(connection)), patience_(patience) {}
  [[nodiscard]] Expected<service::HomeMessage> next();

  std::unique_ptr<service::ServerConnection> connection_;
  std::chrono::milliseconds patience_;
  service::Welcome welcome_;
  std::int64_t asked_ = 0;
};

}  // namespace roomwise::trials
