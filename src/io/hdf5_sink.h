#pragma once

#include <hdf5.h>

#include <cstddef>

#include "io/hdf5_handle.h"

namespace ccvt::io {

/// Where an HDF5 file that is written goes: a driver of ours, which keeps the first error to
/// itself. HDF5 cannot be closed when a write has failed, such as on a full disk, and would crash
/// at the end of the program; so it never hears of one, and what comes after it is dropped.
class Hdf5Sink {
 public:
  /// `descriptor` is open for reading and writing, and stays the caller's.
  explicit Hdf5Sink(int descriptor) : descriptor_(descriptor) {}
  Hdf5Sink(const Hdf5Sink&) = delete;
  Hdf5Sink& operator=(const Hdf5Sink&) = delete;

  /// A new file of HDF5's that goes here, which must live as long; not open when HDF5 fails.
  Hdf5Handle create();

  /// 0, or what errno was when a read or a write failed.
  [[nodiscard]] int error() const { return error_; }
  void synchronize();

  // For the driver.
  void read(haddr_t at, std::size_t count, void* data);
  void write(haddr_t at, std::size_t count, const void* data);
  void truncate(haddr_t size);

 private:
  int descriptor_;
  int error_ = 0;
  std::size_t unsynchronized_ = 0;
};

}  // namespace ccvt::io
