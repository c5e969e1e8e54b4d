#pragma once

#include <string_view>

// The data files of objects/, compiled in so that a program knows them wherever it stands.
namespace roomwise::objects {

extern const std::string_view kKindsJson;          // kinds/kinds.json
extern const std::string_view kInstanceModelJson;  // instances/instance_model.json
extern const std::string_view kOwnThingModelJson;  // own_things/own_thing_model.json

}  // namespace roomwise::objects
