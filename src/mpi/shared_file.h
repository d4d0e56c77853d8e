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

/// An .npy file that all ranks write together, each the rows of its own, by MPI's own files. It
/// appears under its name when the first rank publishes it.
class SharedFile {
 public:
  /// Rows of `columns` numbers of the dtype `descr` (0: one number without a second extent), each
  /// row of `row_bytes`. All ranks call this together, and what follows.
  SharedFile(const Session& session, std::filesystem::path target, const std::string& descr,
             std::uint64_t rows, std::uint64_t columns, std::size_t row_bytes);

  void write(std::uint64_t first_row, std::span<const std::byte> rows);
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
