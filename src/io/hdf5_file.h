#pragma once

#include <hdf5.h>

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "io/hdf5_handle.h"
#include "io/hdf5_sink.h"
#include "io/unfinished_file.h"

namespace ccvt::io {

/// While one lives, HDF5 prints no errors in this thread, and no other thread of ours is in HDF5,
/// which need not be built for several.
class Hdf5Session {
 public:
  Hdf5Session();
  Hdf5Session(const Hdf5Session&) = delete;
  Hdf5Session& operator=(const Hdf5Session&) = delete;
  ~Hdf5Session();

 private:
  std::lock_guard<std::mutex> lock_;
  H5E_auto2_t printer_ = nullptr;
  void* client_ = nullptr;
};

template <class Number>
hid_t hdf5_type() {
  if constexpr (std::same_as<Number, float>) return H5T_NATIVE_FLOAT;
  if constexpr (std::same_as<Number, double>) return H5T_NATIVE_DOUBLE;
  if constexpr (std::same_as<Number, std::int32_t>) return H5T_NATIVE_INT32;
  if constexpr (std::same_as<Number, std::uint32_t>) return H5T_NATIVE_UINT32;
  if constexpr (std::same_as<Number, std::uint64_t>) return H5T_NATIVE_UINT64;
}

/// An HDF5 file that appears under its name when it is complete and on its disk, as an OutputFile
/// does. The same calls make the same bytes at any time. All members throw IoError.
class Hdf5Output {
 public:
  explicit Hdf5Output(std::filesystem::path target);

  Hdf5Handle group(const char* name);

  /// An attribute that is one number.
  template <class Number>
  void attribute(const Hdf5Handle& group, const char* name, Number value) {
    attribute(group, name, hdf5_type<Number>(), {}, &value);
  }
  /// One that is a vector.
  template <class Number, std::size_t Count>
  void attribute(const Hdf5Handle& group, const char* name,
                 const std::array<Number, Count>& values) {
    attribute(group, name, hdf5_type<Number>(), {Count}, values.data());
  }

  /// A dataset, all of whose numbers are `fill`, and take no space, until they are written.
  template <class Number>
  Hdf5Handle dataset(const Hdf5Handle& group, const char* name, std::vector<hsize_t> shape,
                     Number fill) {
    return dataset(group, name, hdf5_type<Number>(), shape, &fill);
  }
  /// Writes the rows from `first` on of a dataset of `width` columns; 0: of a vector.
  template <class Number>
  void rows(const Hdf5Handle& dataset, std::uint64_t first, hsize_t width,
            std::span<const Number> values) {
    rows(dataset, hdf5_type<Number>(), first, width, values.size(), values.data());
  }

  /// Closes the file, and publishes it; what is open of it must have been closed.
  void commit();

 private:
  void attribute(const Hdf5Handle& group, const char* name, hid_t type,
                 const std::vector<hsize_t>& shape, const void* values);
  Hdf5Handle dataset(const Hdf5Handle& group, const char* name, hid_t type,
                     const std::vector<hsize_t>& shape, const void* fill);
  void rows(const Hdf5Handle& dataset, hid_t type, std::uint64_t first, hsize_t width,
            std::size_t count, const void* values);
  /// Throws unless what HDF5 has done is good, and has come to the disk as far as is known.
  void check(bool good) const;
  Hdf5Handle checked(hid_t id, herr_t (*closer)(hid_t)) const;

  UnfinishedFile unfinished_;
  Hdf5Session session_;
  Hdf5Sink sink_;
  Hdf5Handle file_;
};

}  // namespace ccvt::io
