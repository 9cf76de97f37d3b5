#pragma once

#include "datasets/logs/log_format.h"

namespace credence::internal {

/// --input npz: arrays (array_log.h) that numpy.savez or numpy.savez_compressed wrote.
///
/// A zip file (APPNOTE.TXT of PKWARE, 4.3) of .npy files (numpy.lib.format, versions 1 to 3) of numbers in
/// float32 or float64, of either byte order, in C or Fortran order. Checksums are tested. Arrays that are
/// neither packed nor in Fortran order are read run by run; others are held in memory, up to 1 GiB each.
LogFormat npz_format();

}  // namespace credence::internal
