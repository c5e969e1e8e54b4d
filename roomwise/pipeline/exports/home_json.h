#pragma once

#include <string>

#include "roomwise/pipeline/exports/home_contents.h"

namespace roomwise::pipeline {

// The home as one JSON document, as docs/home.schema.json describes it. Bytes of names that are no
// UTF-8 become U+FFFD.
[[nodiscard]] std::string home_json(const HomeContents& contents);

}  // namespace roomwise::pipeline
