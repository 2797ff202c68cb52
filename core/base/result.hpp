// SPDX-License-Identifier: MIT
// A value or an error, for everything that can fail outside the frame path (files, settings, devices). The
// frame path returns status enums inside result structs instead and never builds a message.
#pragma once
#include <optional>
#include <string>
#include <utility>
#include <variant>

namespace loopsift {

/// What kind of thing went wrong; the programs map it to their exit codes.
enum class ErrorCode {
  kUsage,        ///< a wrong command line, setting or argument
  kNotFound,     ///< a file, folder or device does not exist
  kFormat,       ///< a file or message is there but malformed
  kIo,           ///< reading or writing failed (no rights, disk full)
  kCapacity,     ///< a fixed-size store is full, or a budget is exceeded
  kNumeric,      ///< a solve or registration did not come to a usable result
  kUnsupported,  ///< left out of this build, or not supported by the device
};

/// An error with a message that names the file, line or key and what to do. Building one allocates.
struct Error {
  ErrorCode code = ErrorCode::kUsage;
  std::string message;
};

/// Success, or an Error.
class [[nodiscard]] Status {
 public:
  Status() = default;
  Status(Error error) : error_(std::move(error)) {}  // NOLINT(google-explicit-constructor): returned as is
  [[nodiscard]] bool ok() const { return !error_.has_value(); }
  explicit operator bool() const { return ok(); }
  /// Only when !ok().
  [[nodiscard]] const Error& error() const { return *error_; }

 private:
  std::optional<Error> error_;
};

/// A T, or an Error.
template <class T>
class [[nodiscard]] Expected {
 public:
  Expected(T value) : state_(std::move(value)) {}      // NOLINT(google-explicit-constructor): returned as is
  Expected(Error error) : state_(std::move(error)) {}  // NOLINT(google-explicit-constructor): returned as is
  [[nodiscard]] bool ok() const { return std::holds_alternative<T>(state_); }
  explicit operator bool() const { return ok(); }
  /// Only when ok().
  T& value() { return std::get<T>(state_); }
  const T& value() const { return std::get<T>(state_); }
  T& operator*() { return value(); }
  const T& operator*() const { return value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }
  /// Only when !ok().
  [[nodiscard]] const Error& error() const { return std::get<Error>(state_); }

 private:
  std::variant<T, Error> state_;
};

}  // namespace loopsift
