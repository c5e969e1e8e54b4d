#pragma once

#include <filesystem>
#include <string>

#include "command.h"
#include "roomwise/home/home.h"

namespace roomwise::app {

// How commands open a home: with the passphrase of --passphrase-file, if one was given. Those that
// look at no picture need none.
[[nodiscard]] Expected<home::OpenOptions> open_options(const Context& context);
[[nodiscard]] Expected<home::Home> open_home(const std::filesystem::path& path,
                                             const Context& context);
[[nodiscard]] Expected<home::Home> open_home_read_only(const std::filesystem::path& path,
                                                       const Context& context);

// The walk of that name, or with "#2" or "NAME (#2)" the second that roomwise info lists; no text:
// the newest.
// Fails where there is none, or several of the name.
[[nodiscard]] Expected<home::RecordingId> find_walk(const home::Home& home,
                                                    const std::string& text);

// Asks at the terminal, which does not show what is typed. Fails where it is broken off (Ctrl-C,
// Ctrl-D).
[[nodiscard]] Expected<home::Passphrase> ask_passphrase(int terminal, const std::string& question);
// The same, asked twice, since nobody sees what was typed.
[[nodiscard]] Expected<home::Passphrase> ask_new_passphrase(int terminal);

}  // namespace roomwise::app
