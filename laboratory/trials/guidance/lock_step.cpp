#include "laboratory/trials/guidance/lock_step.h"

#include <cmath>

#include "roomwise/service/protocol/prompt_message.h"

namespace roomwise::trials {

Expected<LockStep> LockStep::begin(std::unique_ptr<service::ServerConnection> connection,
                                   const service::Hello& hello,
                                   std::chrono::milliseconds patience) {
  LockStep device(std::move(connection), patience);
  ROOMWISE_RETURN_IF_ERROR(
      device.connection_->send_text(service::write(service::DeviceMessage(hello))));
  for (;;) {
    ROOMWISE_TRY(const service::HomeMessage message, device.next());
    if (const auto* error = std::get_if<service::ErrorMessage>(&message)) {
      return fail("the computer refuses the device: {}", error->text);
    }
    const auto* welcome = std::get_if<service::Welcome>(&message);
    if (welcome == nullptr) continue;
    device.welcome_ = *welcome;
    return device;
  }
}

Expected<service::HomeMessage> LockStep::next() {
  ROOMWISE_TRY(const auto message, connection_->receive(patience_));
  if (!message) return fail("the computer said nothing for {} s", patience_.count() / 1000);
  return service::read_home_message(
      {reinterpret_cast<const char*>(message->bytes.data()), message->bytes.size()});
}

Expected<PictureAnswer> LockStep::show(double t_ms, const Bytes& color, const Bytes& depth) {
  constexpr double kSameTime_ms = 1e-3;
  ROOMWISE_RETURN_IF_ERROR(
      connection_->send_binary(service::write(service::FrameMessage{t_ms, color, depth})));
  PictureAnswer answer;
  for (;;) {
    ROOMWISE_TRY(const service::HomeMessage message, next());
    if (const auto* prompt = std::get_if<service::PromptMessage>(&message)) {
      ROOMWISE_TRY(guide::Prompt said, service::prompt_of(*prompt));
      answer.prompts.push_back(std::move(said));
    } else if (const auto* error = std::get_if<service::ErrorMessage>(&message)) {
      if (error->answer_to) continue;  // to a question before
      answer.failure = error->text;
      return answer;
    } else if (const auto* seen = std::get_if<service::Seen>(&message)) {
      if (std::abs(seen->t_ms - t_ms) > kSameTime_ms) continue;
      answer.place = seen->position;
      return answer;
    }
  }
}

Expected<std::vector<guide::Prompt>> LockStep::ask(service::Ask ask) {
  ask.id = ++asked_;
  ROOMWISE_RETURN_IF_ERROR(connection_->send_text(service::write(service::DeviceMessage(ask))));
  for (;;) {
    ROOMWISE_TRY(const service::HomeMessage message, next());
    if (const auto* prompt = std::get_if<service::PromptMessage>(&message)) {
      if (prompt->answer_to != ask.id) continue;
      ROOMWISE_TRY(guide::Prompt said, service::prompt_of(*prompt));
      return std::vector{std::move(said)};
    }
    const auto* error = std::get_if<service::ErrorMessage>(&message);
    if (error != nullptr && error->answer_to == ask.id) {
      return fail("the computer refuses the question: {}", error->text);
    }
  }
}

}  // namespace roomwise::trials
