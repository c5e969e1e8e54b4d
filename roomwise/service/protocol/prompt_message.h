#pragma once

#include "roomwise/base/expected.h"
#include "roomwise/guide/words/prompt.h"
#include "roomwise/service/protocol/messages.h"

// What is said to somebody, on its way to their device. Both ends take it from here.
namespace roomwise::service {

// By the device's clock.
[[nodiscard]] PromptMessage message_of(const guide::Prompt& prompt);
// Fails on words that the protocol does not know.
[[nodiscard]] Expected<guide::Prompt> prompt_of(const PromptMessage& message);

}  // namespace roomwise::service
