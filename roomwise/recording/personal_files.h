#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>

#include "roomwise/base/expected.h"
#include "roomwise/base/file.h"
#include "roomwise/image/personal_data.h"

// Where somebody lives, and with what they recorded it, is nobody's business. Readers give nothing
// of it on, and say that it was there.
namespace roomwise::recording {

// Of a recording's pictures: its first, middle and last, since a phone may know where it is only
// after a while. What cannot be read says nothing.
[[nodiscard]] image::PersonalData personal_data_of_some(
    std::size_t pictures, const std::function<Expected<Bytes>(std::size_t)>& read);

// By the names of members, wherever they stand; one that is empty, zero or false says nothing.
[[nodiscard]] image::PersonalData personal_data_of_json(const nlohmann::json& value);
// Of a file; none where it is not there or no JSON.
[[nodiscard]] image::PersonalData personal_data_of_json_file(const std::filesystem::path& path);

// Takes all such out of the files of a folder that was unpacked: such members of JSON, and from
// JPEG, PNG and WebP, told by their content, what they say besides the picture. A JSON file that
// cannot be read, so that nobody knows what it says, is emptied; files that no reader takes by
// their names go, pictures that can be read apart. Fails where a file cannot be written.
[[nodiscard]] Expected<void> leave_out_personal_data(const std::filesystem::path& folder);

}  // namespace roomwise::recording
