#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "ccvt/io.h"
#include "ccvt/region.h"
#include "ccvt/summary.h"
#include "ccvt/volume.h"
#include "kept.h"
#include "session.h"
#include "shared_file.h"

namespace ccvt::mpi {

/// Throws InvalidInput unless what all ranks write together goes into .npy.
inline void require_npy(const std::string& option, const std::filesystem::path& path) {
  if (path.empty() || path.extension() == ".npy") return;
  throw InvalidInput(option + ": " + path.string() +
                     ": what several processes write together goes into .npy");
}

/// Throws InvalidInput unless each rank can read its part of such a file.
void require_parts(const std::filesystem::path& path);

/// Throws InvalidInput, on all ranks, where a file has not the same header on all of them.
void require_one_file(const Session& session, const std::filesystem::path& path,
                      const PointsHeader& header);
void require_one_file(const Session& session, const std::filesystem::path& path,
                      const VolumeHeader& header);

/// Throws InvalidInput unless points of so many dimensions start balanced, as several ranks can.
/// `source` is what has them.
void require_balanced(const cli::CommonArguments& arguments, const std::string& source,
                      int dimension);

/// The owners of each rank's points.
class OwnersFile {
 public:
  OwnersFile(const Session& session, const std::filesystem::path& path, std::int64_t points) {
    if (!path.empty()) {
      file_.emplace(session, path, "<i4", static_cast<std::uint64_t>(points), 0, sizeof(Index));
    }
  }
  void write(std::int64_t first, const std::vector<Index>& owners) {
    if (file_) file_->write(static_cast<std::uint64_t>(first), std::as_bytes(std::span(owners)));
  }
  /// As SharedFile::publish().
  void publish() {
    if (file_) file_->publish();
  }

 private:
  std::optional<SharedFile> file_;
};

/// A line on what ranks have sent each other.
std::string describe(const cli::RankFigures& figures);

/// The end of a command: the first rank writes sites and summary, publishes all outputs together,
/// and prints. `write`, which it calls, writes what goes beside the summary, -o last, and publishes
/// what all ranks have written. The status of all.
int finish(const Session& session, const cli::CommonArguments& arguments, const Kept& kept,
           const Summary& summary, const std::function<void()>& write,
           const std::optional<PutBack>& put_back = {});

}  // namespace ccvt::mpi
