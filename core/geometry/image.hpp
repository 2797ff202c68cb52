// SPDX-License-Identifier: MIT
// A view of a row-major image; owns nothing, never allocates.
#pragma once
#include <cassert>
#include <cstddef>
#include <type_traits>

namespace loopsift {

/// width × height pixels of T, `stride` elements from row to row.
template <class T>
struct ImageView {
  T* data = nullptr;
  int width = 0;
  int height = 0;
  int stride = 0;

  ImageView() = default;
  ImageView(T* d, int w, int h) : data(d), width(w), height(h), stride(w) {}
  ImageView(T* d, int w, int h, int s) : data(d), width(w), height(h), stride(s) {}
  /// Views convert to views of const.
  template <class U, class = std::enable_if_t<std::is_same_v<const U, T>>>
  // NOLINTNEXTLINE(google-explicit-constructor): as a pointer converts
  ImageView(const ImageView<U>& o) : data(o.data), width(o.width), height(o.height), stride(o.stride) {}

  [[nodiscard]] T* row(int y) const { return data + static_cast<std::ptrdiff_t>(y) * stride; }
  T& operator()(int x, int y) const {
    assert(x >= 0 && y >= 0 && x < width && y < height);
    return row(y)[x];
  }
  [[nodiscard]] bool empty() const { return width == 0 || height == 0; }
  [[nodiscard]] std::size_t size() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
};

/// Interleaved 8-bit colour.
struct Rgb8 {
  unsigned char r = 0, g = 0, b = 0;
};

}  // namespace loopsift
