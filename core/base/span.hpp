// SPDX-License-Identifier: MIT
// A pointer and a length (C++17 has no std::span).
#pragma once
#include <cassert>
#include <cstddef>
#include <type_traits>

namespace loopsift {

/// A view of `size` consecutive T; owns nothing, never allocates.
template <class T>
class Span {
 public:
  Span() = default;
  Span(T* data, std::size_t size) : data_(data), size_(size) {}
  /// A view of anything contiguous with data() and size(), or of the same elements as const.
  template <class Container,
            class = std::enable_if_t<std::is_convertible_v<decltype(std::declval<Container&>().data()), T*>>>
  // NOLINTNEXTLINE(google-explicit-constructor): as std::span
  Span(Container& c) : data_(c.data()), size_(c.size()) {}
  [[nodiscard]] T* data() const { return data_; }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  T& operator[](std::size_t i) const {
    assert(i < size_);
    return data_[i];
  }
  [[nodiscard]] T* begin() const { return data_; }
  [[nodiscard]] T* end() const { return data_ + size_; }
  [[nodiscard]] Span first(std::size_t n) const {
    assert(n <= size_);
    return Span(data_, n);
  }

 private:
  T* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace loopsift
