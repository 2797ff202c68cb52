// SPDX-License-Identifier: MIT
// What is kept of the frames that a run sees.
#pragma once
#include <string>

namespace loopsift {

struct RecordOptions {
  std::string folder;     ///< empty: nothing is recorded
  int max_mib = 4096;     ///< on disk, at most
  int jpeg_quality = 90;  ///< of colour, 1 … 100
};

}  // namespace loopsift
