#pragma once

namespace roomwise::app {

// From now on the first Ctrl-C (SIGINT) or SIGTERM only asks the work to stop, which then saves
// what it has; a second one ends the program at once.
void catch_interrupts();

// True once the user asked to stop.
[[nodiscard]] bool interrupt_requested();

}  // namespace roomwise::app
