#include "roomwise/evaluation/errors/floor_error.h"

#include <cstddef>

namespace roomwise::evaluation {
namespace {

bool is_free_near(const StandingRoom& free, int column, int row) {
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if (free.contains(column + dx, row + dy) && free.at(column + dx, row + dy) != 0) return true;
    }
  }
  return false;
}

double share(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace

Expected<FloorError> floor_error(const StandingRoom& truth, const StandingRoom& found,
                                 double cell_m) {
  if (truth.width() != found.width() || truth.height() != found.height()) {
    return fail("the truth has {}x{} cells and what was found {}x{}; expected the same",
                truth.width(), truth.height(), found.width(), found.height());
  }
  std::size_t in_truth = 0, in_found = 0, in_both = 0, found_near_truth = 0, truth_near_found = 0;
  for (int row = 0; row < truth.height(); ++row) {
    for (int column = 0; column < truth.width(); ++column) {
      const bool is_true = truth.at(column, row) != 0, is_found = found.at(column, row) != 0;
      in_truth += is_true ? 1 : 0;
      in_found += is_found ? 1 : 0;
      in_both += is_true && is_found ? 1 : 0;
      found_near_truth += is_found && is_free_near(truth, column, row) ? 1 : 0;
      truth_near_found += is_true && is_free_near(found, column, row) ? 1 : 0;
    }
  }
  const double cell_m2 = cell_m * cell_m;
  return FloorError{.true_m2 = static_cast<double>(in_truth) * cell_m2,
                    .found_m2 = static_cast<double>(in_found) * cell_m2,
                    .both_m2 = static_cast<double>(in_both) * cell_m2,
                    .precision = share(in_both, in_found),
                    .recall = share(in_both, in_truth),
                    .precision_within_cell = share(found_near_truth, in_found),
                    .recall_within_cell = share(truth_near_found, in_truth)};
}

}  // namespace roomwise::evaluation
