// NumPy files, put together from the format's description independently of the tested reader.
#pragma once

#include <string>
#include <string_view>

#include "support/files/foreign_files.h"

namespace kiln::test {

struct NpyLayout {
  int major_version = 1;
  bool big_endian = false, fortran_order = false;
};

/// Returns magic, version, length and the dictionary, padded to 64 bytes as NumPy writes it.
std::string npyHeader(std::string_view dictionary, int major_version = 1);
/// Returns the dictionary of an array whose axes are z, y, x: {'descr': '<u2', 'fortran_order': False, 'shape': …, }.
std::string npyDictionary(const ForeignVolume& volume, const NpyLayout& layout = {});
std::string npyFile(const ForeignVolume& volume, const NpyLayout& layout = {});

}  // namespace kiln::test
