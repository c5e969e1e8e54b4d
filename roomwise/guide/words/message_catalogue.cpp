#include "roomwise/guide/words/message_catalogue.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <stdexcept>

namespace roomwise::guide {
namespace {

// Names what only one of both has: ""no" in "en", not in "de"".
Expected<void> check_same(const std::set<std::string>& a, const std::set<std::string>& b,
                          std::string_view what, const Phrasebook& book_a,
                          const Phrasebook& book_b) {
  std::vector<std::string> different;
  std::ranges::set_symmetric_difference(a, b, std::back_inserter(different));
  if (different.empty()) return {};
  const std::string& name = different.front();
  const bool is_in_a = a.contains(name);
  return fail("{} \"{}\" is in language \"{}\", but not in \"{}\"; add it there", what, name,
              (is_in_a ? book_a : book_b).language(), (is_in_a ? book_b : book_a).language());
}

Expected<void> check_same(const Phrasebook& a, const Phrasebook& b) {
  ROOMWISE_RETURN_IF_ERROR(check_same(a.messages(), b.messages(), "message", a, b));
  for (const std::string& message : a.messages()) {
    ROOMWISE_RETURN_IF_ERROR(check_same(a.values_of(message), b.values_of(message),
                                        fmt::format("the value of message \"{}\"", message), a, b));
  }
  return check_same(a.words(Noun::Kind::kRoom), b.words(Noun::Kind::kRoom), "the word", a, b);
}

}  // namespace

MessageCatalogue MessageCatalogue::built_in() {
  auto catalogue = parse(built_in_messages(), objects::standard_kinds());
  if (!catalogue) throw std::logic_error(catalogue.error().message);
  return *std::move(catalogue);
}

Expected<MessageCatalogue> MessageCatalogue::parse(std::span<const std::string_view> files,
                                                   std::span<const objects::Kind> kinds) {
  MessageCatalogue catalogue;
  for (const std::string_view file : files) {
    ROOMWISE_TRY(Phrasebook book, Phrasebook::parse(file, kinds));
    const std::string language = book.language();
    if (!catalogue.books_.emplace(language, std::move(book)).second) {
      return fail("the messages of language \"{}\" come twice", language);
    }
  }
  if (catalogue.books_.empty()) return fail("there are no messages in any language");
  const Phrasebook& first = catalogue.books_.begin()->second;
  for (const auto& [language, book] : catalogue.books_) {
    ROOMWISE_RETURN_IF_ERROR(check_same(first, book));
  }
  return catalogue;
}

std::vector<std::string> MessageCatalogue::languages() const {
  std::vector<std::string> languages;
  for (const auto& [language, book] : books_) languages.push_back(language);
  return languages;
}

bool MessageCatalogue::speaks(const std::string& language) const {
  return books_.contains(language);
}

const Phrasebook& MessageCatalogue::in(const std::string& language) const {
  const auto found = books_.find(language);
  if (found == books_.end()) throw std::invalid_argument("no messages in language " + language);
  return found->second;
}

}  // namespace roomwise::guide
