#include "interrupt.h"

#include <atomic>
#include <csignal>

namespace roomwise::app {
namespace {

// A signal handler reaches nothing but global state, and only what is free of locks.
std::atomic<bool> requested{false};
static_assert(std::atomic<bool>::is_always_lock_free);

extern "C" void request_interrupt(int) {
  requested.store(true);
}

void install_handlers() {
  struct sigaction action {};
  action.sa_handler = request_interrupt;
  // SA_RESETHAND: the second signal meets the default handler, which ends the program.
  // SA_RESTART: reading and writing of files goes on through the first.
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

}  // namespace

void catch_interrupts() {
  [[maybe_unused]] static const bool catching = (install_handlers(), true);
}

bool interrupt_requested() {
  catch_interrupts();
  return requested.load();
}

}  // namespace roomwise::app
