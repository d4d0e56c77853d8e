#include "io/hdf5_sink.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>

#if H5_VERSION_GE(1, 14, 0)
#include <H5FDdevelop.h>
#endif

namespace ccvt::io {

namespace {

/// So much is on its way to the disk at most: nobody can stop a process that waits for it.
constexpr std::size_t kMostUnsynchronized = std::size_t{1} << 24;
constexpr haddr_t kMostBytes = haddr_t{1} << 62U;

/// What HDF5 hands to the driver.
struct Target {
  Hdf5Sink* sink = nullptr;
};

/// HDF5 knows it by its first member.
struct DriverFile {
  H5FD_t shown{};
  Hdf5Sink* sink = nullptr;
  haddr_t allocated = 0;
  haddr_t written = 0;
};

DriverFile& of(H5FD_t* file) { return *reinterpret_cast<DriverFile*>(file); }
const DriverFile& of(const H5FD_t* file) { return *reinterpret_cast<const DriverFile*>(file); }

H5FD_t* open_file(const char*, unsigned, hid_t access, haddr_t) {
  const auto* const target = static_cast<const Target*>(H5Pget_driver_info(access));
  if (target == nullptr) return nullptr;
  auto file = std::make_unique<DriverFile>();
  file->sink = target->sink;
  return &file.release()->shown;
}

herr_t close_file(H5FD_t* file) {
  delete &of(file);
  return 0;
}

/// As HDF5's own driver of plain files has it.
herr_t query(const H5FD_t*, unsigned long* flags) {
  *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
           H5FD_FEAT_AGGREGATE_SMALLDATA;
  return 0;
}

haddr_t allocated(const H5FD_t* file, H5FD_mem_t) { return of(file).allocated; }

herr_t set_allocated(H5FD_t* file, H5FD_mem_t, haddr_t end) {
  of(file).allocated = end;
  return 0;
}

haddr_t written(const H5FD_t* file, H5FD_mem_t) { return of(file).written; }

herr_t read(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t count, void* data) {
  of(file).sink->read(at, count, data);
  return 0;
}

herr_t write(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t count, const void* data) {
  of(file).sink->write(at, count, data);
  of(file).written = std::max(of(file).written, at + count);
  return 0;
}

herr_t truncate(H5FD_t* file, hid_t, hbool_t) {
  of(file).sink->truncate(of(file).allocated);
  of(file).written = of(file).allocated;
  return 0;
}

H5FD_class_t driver_class() {
  H5FD_class_t driver{};
#if H5_VERSION_GE(1, 14, 0)
  driver.version = H5FD_CLASS_VERSION;
  driver.value = static_cast<H5FD_class_value_t>(512);  // from 512 on for drivers of one's own
#endif
  driver.name = "ccvt";
  driver.maxaddr = kMostBytes;
  driver.fc_degree = H5F_CLOSE_WEAK;
  driver.fapl_size = sizeof(Target);
  driver.open = open_file;
  driver.close = close_file;
  driver.query = query;
  driver.get_eoa = allocated;
  driver.set_eoa = set_allocated;
  driver.get_eof = written;
  driver.read = read;
  driver.write = write;
  driver.truncate = truncate;
  const H5FD_mem_t kinds[] = H5FD_FLMAP_DICHOTOMY;
  std::copy(std::begin(kinds), std::end(kinds), std::begin(driver.fl_map));
  return driver;
}

}  // namespace

Hdf5Handle Hdf5Sink::create() {
  const H5FD_class_t driver_of_ours = driver_class();
  // What uses it keeps it alive.
  const Hdf5Handle driver(H5FDregister(&driver_of_ours), H5FDunregister);
  const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  const Target target{this};
  if (!driver || !access || H5Pset_driver(access.id(), driver.id(), &target) < 0) return {};
  return {H5Fcreate("ccvt", H5F_ACC_TRUNC, H5P_DEFAULT, access.id()), H5Fclose};
}

void Hdf5Sink::synchronize() {
  // Some file systems have nothing to synchronize with.
  if (error_ == 0 && ::fsync(descriptor_) != 0 && errno != EINVAL && errno != ENOSYS) {
    error_ = errno;
  }
  unsynchronized_ = 0;
}

void Hdf5Sink::read(haddr_t at, std::size_t count, void* data) {
  char* bytes = static_cast<char*>(data);
  while (count > 0 && error_ == 0) {
    const ssize_t got = ::pread(descriptor_, bytes, count, static_cast<off_t>(at));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) error_ = errno;
    if (got <= 0) break;
    bytes += got;
    at += static_cast<haddr_t>(got);
    count -= static_cast<std::size_t>(got);
  }
  std::memset(bytes, 0, count);  // behind the end
}

void Hdf5Sink::write(haddr_t at, std::size_t count, const void* data) {
  const char* bytes = static_cast<const char*>(data);
  while (count > 0 && error_ == 0) {
    const std::size_t part = std::min(count, kMostUnsynchronized - unsynchronized_);
    const ssize_t put = ::pwrite(descriptor_, bytes, part, static_cast<off_t>(at));
    if (put < 0 && errno == EINTR) continue;
    if (put <= 0) {
      error_ = put < 0 ? errno : EIO;
      return;
    }
    bytes += put;
    at += static_cast<haddr_t>(put);
    count -= static_cast<std::size_t>(put);
    unsynchronized_ += static_cast<std::size_t>(put);
    if (unsynchronized_ == kMostUnsynchronized) synchronize();
  }
}

void Hdf5Sink::truncate(haddr_t size) {
  if (error_ == 0 && ::ftruncate(descriptor_, static_cast<off_t>(size)) != 0) error_ = errno;
}

}  // namespace ccvt::io
