#pragma once

namespace roomwise::app {

// From the first call on, Ctrl-C (SIGINT) or SIGTERM only asks the work to stop, which then saves
// what it has; a second one ends the program at once.
void catch_interrupts();

// Whether the user asked to stop. Catches interrupts, too: of work that neither asks nor catches
// them the first ends the program.
[[nodiscard]] bool interrupt_requested();

}  // namespace roomwise::app
