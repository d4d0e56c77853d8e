#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "io/unfinished_file.h"
#include "session.h"

namespace ccvt::mpi {

/// An .npy file that all ranks write together, each the rows of its own, on a file system that all
/// see. It appears under its name when it is published. Not by MPI's own files: where a disk is
/// full, Open MPI's write less than they should, and say that all is well.
class SharedFile {
 public:
  /// Rows of `columns` numbers of the dtype `descr` (0: one number without a second extent), each
  /// row of `row_bytes`. All ranks call this together, and write().
  SharedFile(const Session& session, std::filesystem::path target, const std::string& descr,
             std::uint64_t rows, std::uint64_t columns, std::size_t row_bytes);

  void write(std::uint64_t first_row, std::span<const std::byte> rows);
  /// On the first rank, once: as ccvt::io::publish(). On others it does nothing.
  void publish();

 private:
  const Session& session_;
  std::filesystem::path target_;
  std::size_t row_bytes_;
  std::size_t header_bytes_ = 0;
  std::optional<io::UnfinishedFile> unfinished_;  ///< of the first rank
  std::string path_;
};

}  // namespace ccvt::mpi
