#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/image/image.h"
#include "roomwise/network/executor/executor.h"
#include "roomwise/network/formats/clip_tokenizer.h"
#include "roomwise/network/formats/model_card.h"

namespace roomwise::network {

// Where a picture or a text lies among all: as many numbers for both, of length 1.
using Embedding = std::vector<float>;

// How well they fit each other, from -1 to 1. Only to be compared with that of other words.
[[nodiscard]] double similarity(const Embedding& a, const Embedding& b);

// A pair of networks of CLIP's kind (Radford 2021): one looks at pictures, one reads texts, and
// what fits each other lies together. So words can be looked for that no label names. Its functions
// may be called from several threads at once and give the same bits on every call.
class OpenVocabulary {
 public:
  // pictures: the ONNX file of the network of pictures, whose card (Task::kMatchWords) names the
  // rest, beside it. Fails where one of the files is missing, is not what it should be or cannot be
  // run, and where the two do not fit each other.
  [[nodiscard]] static Expected<std::unique_ptr<OpenVocabulary>> load(
      const std::filesystem::path& pictures);

  [[nodiscard]] const ModelCard& card() const { return card_; }
  // A SHA-256 digest of all that embeddings hang on: the files, and what the card says of them.
  [[nodiscard]] const std::string& fingerprint() const { return fingerprint_; }
  [[nodiscard]] std::size_t size() const { return size_; }  // numbers of an embedding

  [[nodiscard]] Expected<Embedding> embed(const image::ColorImage& picture) const;
  // The word in the card's phrases.
  [[nodiscard]] Expected<Embedding> embed(std::string_view word) const;

 private:
  OpenVocabulary(ModelCard card, ClipTokenizer tokenizer)
      : card_(std::move(card)), tokenizer_(std::move(tokenizer)) {}
  [[nodiscard]] Expected<Embedding> embed_text(std::string_view text) const;
  // Runs both once.
  [[nodiscard]] Expected<void> probe();

  ModelCard card_;
  ClipTokenizer tokenizer_;
  std::string fingerprint_;
  std::unique_ptr<Executor> pictures_, texts_;
  std::size_t size_ = 0;
};

}  // namespace roomwise::network
