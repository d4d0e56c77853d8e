#include "io/hdf5_file.h"

#include <unistd.h>

#include <cerrno>

#include "io/publication.h"

namespace ccvt::io {

namespace {

std::mutex& session_mutex() {
  static std::mutex mutex;
  return mutex;
}

}  // namespace

Hdf5Session::Hdf5Session() : lock_(session_mutex()) {
  H5Eget_auto2(H5E_DEFAULT, &printer_, &client_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

Hdf5Session::~Hdf5Session() { H5Eset_auto2(H5E_DEFAULT, printer_, client_); }

Hdf5Output::Hdf5Output(std::filesystem::path target)
    : unfinished_(std::move(target)), sink_(unfinished_.descriptor()), file_(sink_.create()) {
  check(static_cast<bool>(file_));
}

void Hdf5Output::check(bool good) const {
  if (!good || sink_.error() != 0) unfinished_.fail(sink_.error() != 0 ? sink_.error() : ENOMEM);
}

Hdf5Handle Hdf5Output::checked(hid_t id, herr_t (*closer)(hid_t)) const {
  check(id >= 0);
  return {id, closer};
}

Hdf5Handle Hdf5Output::group(const char* name) {
  return checked(H5Gcreate2(file_.id(), name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
}

void Hdf5Output::attribute(const Hdf5Handle& group, const char* name, hid_t type,
                           const std::vector<hsize_t>& shape, const void* values) {
  const Hdf5Handle space =
      shape.empty()
          ? checked(H5Screate(H5S_SCALAR), H5Sclose)
          : checked(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr),
                    H5Sclose);
  const Hdf5Handle attribute =
      checked(H5Acreate2(group.id(), name, type, space.id(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  check(H5Awrite(attribute.id(), type, values) >= 0);
}

Hdf5Handle Hdf5Output::dataset(const Hdf5Handle& group, const char* name, hid_t type,
                               const std::vector<hsize_t>& shape, const void* fill) {
  const Hdf5Handle space =
      checked(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose);
  const Hdf5Handle creation = checked(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  // The times would make other bytes of the same particles.
  check(H5Pset_obj_track_times(creation.id(), false) >= 0);
  check(H5Pset_fill_value(creation.id(), type, fill) >= 0);
  check(H5Pset_alloc_time(creation.id(), H5D_ALLOC_TIME_LATE) >= 0);
  check(H5Pset_fill_time(creation.id(), H5D_FILL_TIME_IFSET) >= 0);
  return checked(
      H5Dcreate2(group.id(), name, type, space.id(), H5P_DEFAULT, creation.id(), H5P_DEFAULT),
      H5Dclose);
}

void Hdf5Output::rows(const Hdf5Handle& dataset, hid_t type, std::uint64_t first, hsize_t width,
                      std::size_t count, const void* values) {
  const hsize_t start[] = {first, 0};
  const hsize_t size[] = {width > 0 ? count / width : count, width};
  const Hdf5Handle there = checked(H5Dget_space(dataset.id()), H5Sclose);
  const Hdf5Handle here = checked(H5Screate_simple(width > 0 ? 2 : 1, size, nullptr), H5Sclose);
  check(H5Sselect_hyperslab(there.id(), H5S_SELECT_SET, start, nullptr, size, nullptr) >= 0);
  check(H5Dwrite(dataset.id(), type, here.id(), there.id(), H5P_DEFAULT, values) >= 0);
}

void Hdf5Output::commit() {
  const bool closed = file_.close();
  sink_.synchronize();
  check(closed);
  if (::close(unfinished_.take_descriptor()) != 0) unfinished_.fail(errno);
  publish(std::move(unfinished_));
}

}  // namespace ccvt::io
