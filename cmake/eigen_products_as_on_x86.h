// Eigen's plugin for dense expressions, on arm64: read after NEON's vectors and before the products
// of large matrices, which take rows by other numbers, and so add in another order, where they see
// this.
#undef EIGEN_HAS_SINGLE_INSTRUCTION_MADD
