#pragma once

namespace roomwise::app {

// Whether the user asked to stop. From the first call on, Ctrl-C (SIGINT) or SIGTERM only asks the
// work to stop, which then saves what it has; a second one ends the program at once. Work that
// never asks is ended by the first.
[[nodiscard]] bool interrupt_requested();

}  // namespace roomwise::app
