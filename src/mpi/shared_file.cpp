#include "shared_file.h"

#include <unistd.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "ccvt/io.h"
#include "io/npy.h"

namespace ccvt::mpi {
namespace {

/// Bytes that are written at once: MPI counts them in int.
constexpr std::size_t kPiece = std::size_t{1} << 28;

std::string text_of(int error) {
  std::string text(MPI_MAX_ERROR_STRING, ' ');
  int length = 0;
  MPI_Error_string(error, text.data(), &length);
  text.resize(static_cast<std::size_t>(length));
  return text;
}

}  // namespace

SharedFile::SharedFile(const Session& session, std::filesystem::path target,
                       const std::string& descr, std::uint64_t rows, std::uint64_t columns,
                       std::size_t row_bytes)
    : session_(session), target_(std::move(target)), row_bytes_(row_bytes) {
  std::vector<std::uint64_t> shape = {rows};
  if (columns > 0) shape.push_back(columns);
  const std::string header = io::format_npy_header(descr, shape);
  header_bytes_ = header.size();
  session_.together([&] {
    if (!session_.is_first()) return;
    unfinished_.emplace(target_);
    const int descriptor = unfinished_->take_descriptor();
    const bool written = ::write(descriptor, header.data(), header.size()) == std::ssize(header);
    const int error = errno;
    ::close(descriptor);
    if (!written) unfinished_->fail(error);
    path_ = unfinished_->path().string();
  });
  const std::vector<Ranks::Bytes> paths =
      session_.ranks().gather(std::as_bytes(std::span(std::as_const(path_))));
  path_.assign(reinterpret_cast<const char*>(paths[0].data()), paths[0].size());
}

void SharedFile::write(std::uint64_t first_row, std::span<const std::byte> rows) {
  MPI_File file = MPI_FILE_NULL;
  const auto require = [&](int error, const char* what) {
    session_.together([&] {
      if (error == MPI_SUCCESS) return;
      throw IoError(target_.string() + ": cannot " + what + ": " + text_of(error));
    });
  };
  require(MPI_File_open(MPI_COMM_WORLD, path_.c_str(), MPI_MODE_WRONLY, MPI_INFO_NULL, &file),
          "be opened by all ranks");
  const std::uint64_t first_byte = header_bytes_ + first_row * row_bytes_;
  auto at = static_cast<MPI_Offset>(first_byte);
  // Each rank writes as often as the one with the most.
  std::uint64_t pieces = (rows.size() + kPiece - 1) / kPiece;
  MPI_Allreduce(MPI_IN_PLACE, &pieces, 1, MPI_UINT64_T, MPI_MAX, MPI_COMM_WORLD);
  int error = MPI_SUCCESS;
  for (std::uint64_t k = 0; k < pieces; ++k) {
    const auto piece = rows.first(std::min(rows.size(), kPiece));
    MPI_Status status;
    const int now = MPI_File_write_at_all(file, at, piece.data(), static_cast<int>(piece.size()),
                                          MPI_BYTE, &status);
    error = error == MPI_SUCCESS ? now : error;
    at += static_cast<MPI_Offset>(piece.size());
    rows = rows.subspan(piece.size());
  }
  if (error == MPI_SUCCESS) error = MPI_File_sync(file);
  const int closed = MPI_File_close(&file);
  require(error == MPI_SUCCESS ? closed : error, "be written");
}

void SharedFile::publish() {
  session_.together([&] {
    if (unfinished_) unfinished_->publish();
  });
}

}  // namespace ccvt::mpi
