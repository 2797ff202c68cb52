// SPDX-License-Identifier: MIT
// What is done about a source that is lost, or not there yet.
#pragma once

namespace loopsift {

struct RetryOptions {
  int first_retry_limit = 0;   ///< tries more to open a camera at the start
  int retry_limit = 600;       ///< tries without a frame until a lost camera is given up; −1: any number
  double retry_first_ms = 50;  ///< before the first try; doubles with each …
  double retry_max_ms = 500;   ///< … up to this
  int stall_periods = 90;      ///< frame periods without a frame, then it is opened again; 0: never
};

}  // namespace loopsift
