#include "roomwise/network/formats/safetensors.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "roomwise/network/formats/number_formats.h"

namespace roomwise::network {
namespace {

using Json = nlohmann::json;
using Span = std::span<const std::uint8_t>;

constexpr std::size_t kSizeBytes = 8;
// Some hundred thousand tensors.
constexpr std::uint64_t kMaxHeaderBytes = std::uint64_t{1} << 24;
constexpr const char* kMetadata = "__metadata__";

std::uint64_t header_size(Span bytes) {
  std::uint64_t size = 0;
  for (std::size_t i = 0; i < kSizeBytes; ++i) size |= std::uint64_t{bytes[i]} << (8 * i);
  return size;
}

std::optional<std::vector<std::int64_t>> integers_in(const Json& tensor, const char* key) {
  if (!tensor.contains(key) || !tensor.at(key).is_array()) return std::nullopt;
  std::vector<std::int64_t> integers;
  for (const Json& element : tensor.at(key)) {
    // A number beyond 2^63 is none of these.
    if (!element.is_number_integer() || element.get<std::int64_t>() < 0) return std::nullopt;
    integers.push_back(element.get<std::int64_t>());
  }
  return integers;
}

struct Entry {
  std::string name;
  NumberFormat format = NumberFormat::kFloat;
  Shape shape;
  std::size_t begin = 0;
  std::size_t end = 0;
};

Expected<Entry> entry_of(const std::string& name, const Json& tensor, std::size_t data_size) {
  const auto shape = tensor.is_object() ? integers_in(tensor, "shape") : std::nullopt;
  const auto places = tensor.is_object() ? integers_in(tensor, "data_offsets") : std::nullopt;
  if (!shape || !places || places->size() != 2 || !tensor.contains("dtype") ||
      !tensor.at("dtype").is_string()) {
    return fail("its tensor \"{}\" lacks its dtype, shape or data_offsets", name);
  }
  const std::string type = tensor.at("dtype").get<std::string>();
  const auto known = std::ranges::find(number_formats(), type, &NumberFormatNames::safetensors);
  if (type.empty() || known == number_formats().end()) {
    return fail("its tensor \"{}\" is of the type {}; F32, F16, BF16, F64, I64, I32 are understood",
                name, type);
  }
  Entry entry{name, known->format, *shape, static_cast<std::size_t>((*places)[0]),
              static_cast<std::size_t>((*places)[1])};
  if (entry.begin > entry.end || entry.end > data_size) {
    return fail("its tensor \"{}\" lies from byte {} to {} of {}: the file is cut off or damaged",
                name, entry.begin, entry.end, data_size);
  }
  const auto count = values_of(*shape);
  if (!count || *count * known->bytes != entry.end - entry.begin) {
    return fail("its tensor \"{}\" has {} bytes, not those of {} of the shape {}", name,
                entry.end - entry.begin, type, shape_text(*shape));
  }
  return entry;
}

}  // namespace

bool is_safetensors(Span bytes) {
  return bytes.size() > kSizeBytes && bytes[kSizeBytes] == '{' &&
         header_size(bytes) <= kMaxHeaderBytes;
}

Expected<Weights> read_safetensors(Span bytes) {
  if (!is_safetensors(bytes)) return fail("is no safetensors file");
  const std::uint64_t size = header_size(bytes);
  if (size > bytes.size() - kSizeBytes) return fail("is a safetensors file that was cut off");
  const Span header = bytes.subspan(kSizeBytes, size);
  const Span data = bytes.subspan(kSizeBytes + size);
  const Json root = Json::parse(header.begin(), header.end(), nullptr, /*allow_exceptions=*/false);
  if (!root.is_object()) return fail("is a safetensors file whose header is no JSON");
  std::vector<Entry> entries;
  for (const auto& [name, tensor] : root.items()) {
    if (name == kMetadata) continue;
    ROOMWISE_TRY(Entry entry, entry_of(name, tensor, data.size()));
    entries.push_back(std::move(entry));
  }
  // The format allows no overlaps; with them a small file could ask for much memory.
  std::ranges::sort(entries, {},
                    [](const Entry& entry) { return std::pair(entry.begin, entry.end); });
  for (std::size_t i = 1; i < entries.size(); ++i) {
    if (entries[i].begin < entries[i - 1].end) {
      return fail("its tensors \"{}\" and \"{}\" overlap", entries[i - 1].name, entries[i].name);
    }
  }
  Weights weights;
  for (const Entry& entry : entries) {
    Constant constant =
        numbers_from(entry.format, data.subspan(entry.begin, entry.end - entry.begin));
    constant.shape = entry.shape;
    weights[entry.name] = std::make_shared<const Constant>(std::move(constant));
  }
  return weights;
}

Bytes write_safetensors(const Weights& weights) {
  const auto numbers_of = [](const Constant& constant) {
    return constant.is_integer
               ? Span(reinterpret_cast<const std::uint8_t*>(constant.integers.data()),
                      constant.integers.size() * sizeof(std::int64_t))
               : Span(reinterpret_cast<const std::uint8_t*>(constant.floats.data()),
                      constant.floats.size() * sizeof(float));
  };
  Json header = Json::object();
  std::size_t end = 0;
  for (const auto& [name, constant] : weights) {
    const std::size_t begin = end;
    end += numbers_of(*constant).size();
    header[name] = {{"dtype", constant->is_integer ? "I64" : "F32"},
                    {"shape", constant->shape},
                    {"data_offsets", {begin, end}}};
  }
  std::string text = header.dump();
  // So that the numbers begin at a multiple of eight bytes.
  text.resize((text.size() + kSizeBytes - 1) / kSizeBytes * kSizeBytes, ' ');
  Bytes bytes;
  bytes.reserve(kSizeBytes + text.size() + end);
  for (std::size_t i = 0; i < kSizeBytes; ++i)
    bytes.push_back(static_cast<std::uint8_t>(text.size() >> (8 * i)));
  bytes.insert(bytes.end(), text.begin(), text.end());
  for (const auto& [name, constant] : weights) {
    const Span numbers = numbers_of(*constant);
    bytes.insert(bytes.end(), numbers.begin(), numbers.end());
  }
  return bytes;
}

}  // namespace roomwise::network
