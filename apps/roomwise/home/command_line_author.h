#pragma once

#include "roomwise/pipeline/edits/edit_things.h"

namespace roomwise::app {

// Who changes a home by hand from the command line, now.
[[nodiscard]] pipeline::EditAuthor command_line_author();

}  // namespace roomwise::app
