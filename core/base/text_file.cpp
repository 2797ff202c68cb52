// SPDX-License-Identifier: MIT
#include "core/base/text_file.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>

namespace loopsift {
namespace {

constexpr const char* kWhiteSpace = " \t\r\v\f";

template <class T>
bool parse_whole(std::string_view word, T* value) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), *value);
  return problem == std::errc() && end == word.data() + word.size();
}

}  // namespace

Expected<TextFile> TextFile::open(const std::string& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
  if (!file) {
    const ErrorCode code = errno == ENOENT ? ErrorCode::kNotFound : ErrorCode::kIo;
    return Error{code, path + ": cannot be opened: " + std::strerror(errno)};
  }
  TextFile text;
  text.path_ = path;
  char block[1 << 16];
  std::size_t n = 0;
  while ((n = std::fread(block, 1, sizeof(block), file.get())) > 0) text.text_.append(block, n);
  if (std::ferror(file.get()) != 0) {
    return Error{ErrorCode::kIo, path + ": cannot be read: " + std::strerror(errno)};
  }
  return text;
}

bool TextFile::next() {
  while (position_ < text_.size()) {
    const std::size_t end = std::min(text_.find('\n', position_), text_.size());
    const std::string_view line(text_.data() + position_, end - position_);
    position_ = end + 1;
    ++line_;
    words_.clear();
    std::size_t begin = line.find_first_not_of(kWhiteSpace);
    if (begin == std::string_view::npos || line[begin] == '#') continue;
    while (begin != std::string_view::npos) {
      const std::size_t stop = std::min(line.find_first_of(kWhiteSpace, begin), line.size());
      words_.push_back(line.substr(begin, stop - begin));
      begin = line.find_first_not_of(kWhiteSpace, stop);
    }
    return true;
  }
  return false;
}

std::string TextFile::where() const { return path_ + ":" + std::to_string(line_); }

Error TextFile::error(const std::string& what) const {
  return Error{ErrorCode::kFormat, where() + ": " + what};
}

bool parse_number(std::string_view word, double* value) {
  return parse_whole(word, value) && std::isfinite(*value);
}

bool parse_number(std::string_view word, int* value) { return parse_whole(word, value); }

bool parse_seconds(std::string_view word, std::int64_t* nanoseconds) {
  const std::size_t point = std::min(word.find('.'), word.size());
  std::int64_t seconds = 0;
  if (!parse_whole(word.substr(0, point), &seconds) || std::abs(seconds) > 9'000'000'000) return false;
  std::int64_t fraction = 0;
  std::string_view decimals = point < word.size() ? word.substr(point + 1) : std::string_view();
  for (int i = 0; i < 9; ++i) {
    const char c =
        static_cast<std::size_t>(i) < decimals.size() ? decimals[static_cast<std::size_t>(i)] : '0';
    if (c < '0' || c > '9') return false;
    fraction = fraction * 10 + (c - '0');
  }
  if (decimals.find_first_not_of("0123456789") != std::string_view::npos) return false;
  *nanoseconds = seconds * 1'000'000'000 + (word.front() == '-' ? -fraction : fraction);
  return true;
}

}  // namespace loopsift
