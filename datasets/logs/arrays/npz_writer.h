#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace credence::internal {

/// An array of float64, the last index running fastest, or of texts in UTF-8.
struct NamedArray {
  std::string name;
  std::vector<std::uint64_t> dims;
  std::vector<double> values;
  std::vector<std::string> texts = {};  ///< instead of values
};

/// The bytes of an .npz file as numpy.savez writes it: not packed, in C order, version 1 of .npy. Throws
/// std::invalid_argument for values or texts that do not fill the dimensions, and beyond 4 GiB.
std::string npz_bytes(std::span<const NamedArray> arrays);

}  // namespace credence::internal
